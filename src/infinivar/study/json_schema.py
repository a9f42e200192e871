"""JSON Schema of study files, for editors; from the same keys as the parsers of `infinivar.study.schema`.

Nothing is required of a table, as a base may supply it. Editors check words and ranges while the file is written.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from infinivar._core.fields import in_kinds
from infinivar.drivetrain.envelope import Envelope
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.machine_tasks import MachinePath, MachineTask
from infinivar.motion.scenario import Scenario
from infinivar.study import extensions
from infinivar.study.extend import FORMAT
from infinivar.study.requirement import JointRequirement, Requirement
from infinivar.study.rig import Rig
from infinivar.study.schema import (
    CHOICES,
    DRIVES,
    KINDS,
    SPREAD,
    shape_key,
    stocked,
    table_keys,
    value_schema,
)
from infinivar.study.sessions import SessionTask

Schema = dict[str, Any]

_EXAMPLES = {Requirement: "faulring2006", Scenario: "faulring2006.shake", DutyCycle: "faulring2006.shake"}
"""Tables that may start from a shipped one, with an example of its name; those of drives may as well."""


def _text(description: str) -> Schema:
    return {"type": "string", "description": description}


_TEXT: Schema = {"type": "string"}
_BASE = _text("Shipped parameter set to start from, such as faulring2006.cobotic")
_LIKE = _text("Drive of this study to start from; values here override its")
_PART = _text("Catalogue part to start from, KEY or SET:KEY; `infinivar catalogue` lists them")
_ORIGIN: Schema = {
    "kind": {"enum": list(KINDS), "description": "Default kind of the values in this table"},
    "where": _text("Default source of the values in this table"),
}


def _object(description: str, properties: Schema, others: Any = False) -> Schema:
    """Schema of a table; `others` is that of keys with other names, False for none."""
    return {"type": "object", "description": description, "properties": properties, "additionalProperties": others}


def _named(description: str, schema: Schema) -> Schema:
    """Schema of tables of one schema, by name."""
    names = {"pattern": "^[A-Za-z0-9_-]+$"}
    return {"type": "object", "description": description, "propertyNames": names, "additionalProperties": schema}


def _reference(name: str) -> Schema:
    return {"$ref": f"#/$defs/{name}"}


@dataclass(frozen=True, slots=True)
class _Tables:
    """Schemas of the tables of parts, each defined where it is first referred to."""

    drives: Mapping[str, type]
    """Types of drives, by word."""
    kinds: Callable[[dataclasses.Field[Any]], Mapping[str, type]]
    """Kinds of a field, by word."""
    laws: Sequence[str]
    """Words for creep laws."""
    definitions: Schema

    def of(self, part: type) -> Schema:
        """Reference to the schema of the table of a part."""
        name = part.__name__
        if name not in self.definitions:
            properties: Schema = {}
            summary = (part.__doc__ or "").strip().split("\n")[0]
            self.definitions[name] = {"title": name, **_object(summary, properties)}
            properties |= self.properties(part)
        return _reference(name)

    def properties(self, part: type) -> Schema:
        """Schemas of the keys of a part, by key."""
        made: Schema = {}
        for name, key in table_keys(part).items():
            if key.part is not None:
                made[name] = self.of(key.part) | {"description": key.meaning}
                continue
            value = value_schema({"enum": list(self.laws)}) if name in CHOICES else key.schema
            made[name] = {**(value or {}), "description": key.meaning, "title": name.replace("_", " ").title()}
        for field in in_kinds(part):
            inner = self._of_kinds(field)
            if field.metadata["flat"]:
                made |= inner
                continue
            title = field.name.capitalize()
            self.definitions[title] = {"title": title, **_object(field.metadata["meaning"], inner | _ORIGIN)}
            made[field.name] = _reference(title)
        if part is Requirement:  # one table, along a line or about a joint; loading refuses a mixture
            made |= self.properties(JointRequirement)
        if part in _EXAMPLES:
            made["base"] = {**_BASE, "examples": [_EXAMPLES[part]]}
        if stocked(part):
            made["part"] = _PART
        for word in (word for word, kind in self.drives.items() if kind is part):
            made |= {"base": _BASE, "like": _LIKE} if word in DRIVES else {}
            made |= {"type": {"const": word}, "title": _text("Name for reports")}
        return made | _ORIGIN

    def _of_kinds(self, field: dataclasses.Field[Any]) -> Schema:
        """Schemas of the key that selects the kind of a field, such as `shape`, and of every key of its kinds."""
        kinds = self.kinds(field)
        shape = shape_key(tuple(kinds))
        made: Schema = {field.metadata["key"]: {**(shape.schema or {}), "description": shape.meaning}}
        for word, kind in kinds.items():
            for name, key in table_keys(kind).items():
                before = f"{made[name]['description']}; " if name in made else ""
                made[name] = {**(key.schema or {}), "description": f"{before}{word}: {key.meaning}"}
            for inner in in_kinds(kind):
                description = f"{word}: {inner.metadata['meaning']}"
                made[inner.name] = _object(description, self._of_kinds(inner) | _ORIGIN)
        return made


def json_schema() -> Schema:
    """Return the JSON Schema (draft 2020-12) of a study file, for editors."""
    return _schema(_Tables(DRIVES, lambda field: field.metadata["kinds"], list(CHOICES["creep_law"]), {}))


def extended_schema(skip: extensions.Skip | None = None) -> Schema:
    """Return the JSON Schema of study files on this machine: that of `json_schema`, and what installed packages add.

    Parameters
    ----------
    skip : callable   Called, once each, with what is wrong with extensions that are left out as they cannot be used.
    """
    reported: set[str] = set()

    def tell(fault: str) -> None:
        if skip is not None and fault not in reported:
            skip(fault)
        reported.add(fault)

    tables = _Tables(
        extensions.drive_types(DRIVES, tell),
        lambda field: extensions.kinds(field, tell),
        list(extensions.creep_laws(CHOICES["creep_law"], tell)),
        {},
    )
    made = _schema(tables)
    for word, part in extensions.parts(tell).items():
        own = tables.properties(part)
        for base in part.__mro__[1:]:
            if base.__name__ in tables.definitions:
                known = tables.definitions[base.__name__]["properties"]
                variants = known.get(extensions.VARIANT, {"enum": [], "description": "Part of an installed package"})
                tables.definitions[base.__name__]["properties"] = {
                    **own,
                    **known,
                    extensions.VARIANT: {**variants, "enum": [*variants["enum"], word]},
                }
    return made


def _schema(tables: _Tables) -> Schema:
    """The schema of a whole study file."""
    # A spread has the same path as the value in the drive: text, a table of one spread, or a table of further spreads.
    size = {"anyOf": [_TEXT, {"type": "number"}]}
    spreads = {key: {**size, "description": meaning} for key, meaning in SPREAD.items()}
    tables.definitions["Spreads"] = {
        "type": "object",
        "properties": spreads | _ORIGIN,
        "additionalProperties": {"anyOf": [size, _reference("Spreads")]},
    }
    correlation = {
        "drive": _TEXT,
        "between": {"type": "array", "items": _TEXT, "minItems": 2, "maxItems": 2},
        "value": {"type": "number", "exclusiveMinimum": -1, "exclusiveMaximum": 1},
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "infinivar study",
        "type": "object",
        "anyOf": [
            *({"required": [one, "drives"]} for one in ("requirement", "duty", "tasks", "paths")),
            {"required": ["extends"]},
        ],
        "additionalProperties": False,
        "properties": {
            "extends": _text("Study file, or name of a shipped study, to start from; values in this file override it"),
            "parts": {
                "anyOf": [_TEXT, {"type": "array", "items": _TEXT}],
                "description": "Files or folders with sets of parts; by default the folder parts beside the study",
            },
            "format": {"const": FORMAT, "description": "Format of the file; by default 1"},
            "title": _text("Headline of the report"),
            "name": _text("Name of the study; defaults to that of the file"),
            "reconstruction": {
                "type": "array",
                "items": _TEXT,
                "description": "What is reconstructed, for reports",
            },
            "description": _text("What is compared and why"),
            "requirement": tables.of(Requirement),
            "drives": {
                **_named("Drive-trains to compare, by name", {"anyOf": [*map(tables.of, tables.drives.values())]}),
                "minProperties": 1,
            },
            "scenarios": _named("Runs to simulate, by name", tables.of(Scenario)),
            "duty": _named(
                "Repeated motions, by name, over which energy, limits and heat are compared", tables.of(DutyCycle)
            ),
            "tasks": _named(
                "Wrenches at twists that machines must exert, or with `type` sessions of a user, by name",
                {"if": {"required": ["type"]}, "then": tables.of(SessionTask), "else": tables.of(MachineTask)},
            ),
            "paths": _named("Motions of the end point of machines, by name", tables.of(MachinePath)),
            "envelope": tables.of(Envelope),
            "rig": tables.of(Rig),
            "uncertainty": _object(
                "Spreads of the drives' values: one table per drive, with the keys of that drive",
                {"draws": {"type": "integer", "description": "Number of samples per drive, a power of two"}},
                _reference("Spreads"),
            ),
            "correlations": {
                "type": "array",
                "description": "Correlations between two spreads of a drive",
                "items": {
                    "type": "object",
                    "required": list(correlation),
                    "additionalProperties": False,
                    "properties": correlation,
                },
            },
        },
        "$defs": tables.definitions,
    }
