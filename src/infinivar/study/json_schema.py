"""JSON Schema of study files, for editors; derived from the same dataclasses as the parsers of `infinivar.study.schema`,
with the words of installed packages.

Pydantic assembles it. Loading a study does not import this module, because the import takes as long as the rest of loading.
"""

from __future__ import annotations

import copy
import functools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.machine_tasks import MachinePath, MachineTask
from infinivar.motion.scenario import Scenario
from infinivar.study import extensions
from infinivar.study.requirement import JointRequirement, Requirement
from infinivar.study.rig import Rig
from infinivar.study.schema import CATALOGUES, CHOICES, DRIVES, KINDS, SHAPE, SPREAD, in_kinds, shape_key, table_keys
from infinivar.study.sessions import SessionTask

if TYPE_CHECKING:
    import pydantic


@functools.cache
def table(part: type) -> type[pydantic.BaseModel]:
    """Build a Pydantic model of the same table, for its JSON Schema."""
    import pydantic

    fields: dict[str, Any] = {
        name: (
            Annotated[Any, pydantic.WithJsonSchema(key.schema)] if key.part is None else table(key.part),
            pydantic.Field(... if key.required else None, description=key.meaning),
        )
        for name, key in table_keys(part).items()
    }
    summary = (part.__doc__ or "").strip().split("\n")[0]
    config = pydantic.ConfigDict(extra="forbid")
    return pydantic.create_model(part.__name__, __config__=config, __doc__=summary, **fields)


def table_schema(part: type) -> dict[str, Any]:
    """Return the JSON Schema of a table, with the definitions of its parts."""
    return copy.deepcopy(_table_schema(part))


@functools.cache
def _table_schema(part: type) -> dict[str, Any]:
    return table(part).model_json_schema(ref_template="#/$defs/{model}")


def kinds_schema(kinds: Mapping[str, type], selects: str = SHAPE) -> dict[str, Any]:
    """Return the JSON Schemas of every key of the kinds of a field, including `shape`, or the key that selects the kind."""
    shape = shape_key(tuple(kinds))
    properties: dict[str, Any] = {selects: {**(shape.schema or {}), "description": shape.meaning}}
    for word, kind in kinds.items():
        for name, key in table_keys(kind).items():
            meaning = f"{word}: {key.meaning}"
            before = properties.get(name)
            properties[name] = {
                **(key.schema or {}),
                "description": f"{before['description']}; {meaning}" if before else meaning,
            }
        for field in in_kinds(kind):
            properties[field.name] = {
                "type": "object",
                "description": f"{word}: {field.metadata['meaning']}",
                "properties": {**kinds_schema(field.metadata["kinds"], field.metadata["key"]), **origins()},
                "additionalProperties": False,
            }
    return properties


def origins() -> dict[str, Any]:
    """Return the JSON Schemas of the keys that state the origin of a table's values."""
    return {
        "kind": {"enum": list(KINDS), "description": "Default kind of the values in this table"},
        "where": {"type": "string", "description": "Default source of the values in this table"},
    }


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a study file, for editors.

    Editors use it to check words and ranges while the file is written; fields that a base may supply are not required.
    """
    definitions: dict[str, Any] = {}
    for part in (Requirement, Scenario, DutyCycle, MachineTask, MachinePath, SessionTask, Rig, *DRIVES.values()):
        schema = table_schema(part)
        for name, inner in schema.pop("$defs", {}).items():
            definitions.setdefault(name, inner)
        # The schema of a class that stands within itself or another refers to its definition.
        definitions[part.__name__] = schema
        for field in in_kinds(part):
            if field.metadata["flat"]:
                schema["properties"].update(kinds_schema(field.metadata["kinds"], field.metadata["key"]))
                continue
            name = field.name.capitalize()
            schema["properties"][field.name] = {"$ref": f"#/$defs/{name}"}
            definitions[name] = {
                "type": "object",
                "title": name,
                "description": field.metadata["meaning"],
                "properties": kinds_schema(field.metadata["kinds"], field.metadata["key"]),
                "additionalProperties": False,
            }
    # One table, along a line or about a joint; loading refuses a mixture.
    definitions["Requirement"]["properties"] |= table_schema(JointRequirement)["properties"]
    origin = origins()
    for schema in definitions.values():
        schema.pop("required", None)
        for field in schema["properties"].values():
            field.pop("default", None)
        schema["properties"].update(origin)
    # A spread has the same path as the value in the drive: text, a table of one spread, or a table of further spreads.
    size = {"anyOf": [{"type": "string"}, {"type": "number"}]}
    definitions["Spreads"] = {
        "type": "object",
        "properties": {
            **{key: {**size, "description": meaning} for key, meaning in SPREAD.items()},
            **origin,
        },
        "additionalProperties": {"anyOf": [size, {"$ref": "#/$defs/Spreads"}]},
    }
    base = {"type": "string", "description": "Shipped parameter set to start from, such as faulring2006.cobotic"}
    part = {
        "type": "string",
        "description": "Catalogue part to start from, KEY or SET:KEY; `infinivar catalogue` lists them",
    }
    definitions["Requirement"]["properties"]["base"] = {**base, "examples": ["faulring2006"]}
    definitions["Scenario"]["properties"]["base"] = {**base, "examples": ["faulring2006.shake"]}
    definitions["DutyCycle"]["properties"]["base"] = {**base, "examples": ["faulring2006.shake"]}
    for kind in CATALOGUES:
        definitions[kind.__name__]["properties"]["part"] = part
    for name, kind in DRIVES.items():
        definitions[kind.__name__]["properties"].update(
            {
                "base": base,
                "like": {
                    "type": "string",
                    "description": "Drive of this study to start from; values here override its",
                },
                "type": {"const": name},
                "title": {"type": "string", "description": "Name for reports"},
            }
        )
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "infinivar study",
        "type": "object",
        "anyOf": [
            {"required": ["requirement", "drives"]},
            {"required": ["duty", "drives"]},
            {"required": ["tasks", "drives"]},
            {"required": ["paths", "drives"]},
            {"required": ["extends"]},
        ],
        "additionalProperties": False,
        "properties": {
            "extends": {
                "type": "string",
                "description": "Study file to start from; values in this file override it",
            },
            "parts": {
                "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}],
                "description": "Files or folders with sets of parts; by default the folder parts beside the study",
            },
            "title": {"type": "string", "description": "Headline of the report"},
            "name": {"type": "string", "description": "Name of the study; defaults to that of the file"},
            "reconstruction": {
                "type": "array",
                "items": {"type": "string"},
                "description": "What is reconstructed, for reports",
            },
            "description": {"type": "string", "description": "What is compared and why"},
            "requirement": {"$ref": "#/$defs/Requirement"},
            "drives": {
                "type": "object",
                "description": "Drive-trains to compare, by name",
                "minProperties": 1,
                "propertyNames": {"pattern": "^[A-Za-z0-9_-]+$"},
                "additionalProperties": {"anyOf": [{"$ref": f"#/$defs/{kind.__name__}"} for kind in DRIVES.values()]},
            },
            "scenarios": {
                "type": "object",
                "description": "Runs to simulate, by name",
                "propertyNames": {"pattern": "^[A-Za-z0-9_-]+$"},
                "additionalProperties": {"$ref": "#/$defs/Scenario"},
            },
            "duty": {
                "type": "object",
                "description": "Repeated motions, by name, over which energy, limits and heat are compared",
                "propertyNames": {"pattern": "^[A-Za-z0-9_-]+$"},
                "additionalProperties": {"$ref": "#/$defs/DutyCycle"},
            },
            "tasks": {
                "type": "object",
                "description": "Wrenches at twists that machines must exert, or with `type` sessions of a user, by name",
                "propertyNames": {"pattern": "^[A-Za-z0-9_-]+$"},
                "additionalProperties": {
                    "if": {"required": ["type"]},
                    "then": {"$ref": "#/$defs/SessionTask"},
                    "else": {"$ref": "#/$defs/MachineTask"},
                },
            },
            "paths": {
                "type": "object",
                "description": "Motions of the end point of machines, by name",
                "propertyNames": {"pattern": "^[A-Za-z0-9_-]+$"},
                "additionalProperties": {"$ref": "#/$defs/MachinePath"},
            },
            "rig": {"$ref": "#/$defs/Rig"},
            "uncertainty": {
                "type": "object",
                "description": "Spreads of the drives' values: one table per drive, with the keys of that drive",
                "properties": {
                    "draws": {"type": "integer", "description": "Number of samples per drive, a power of two"}
                },
                "additionalProperties": {"$ref": "#/$defs/Spreads"},
            },
            "correlations": {
                "type": "array",
                "description": "Correlations between two spreads of a drive",
                "items": {
                    "type": "object",
                    "required": ["drive", "between", "value"],
                    "additionalProperties": False,
                    "properties": {
                        "drive": {"type": "string"},
                        "between": {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2},
                        "value": {"type": "number", "exclusiveMinimum": -1, "exclusiveMaximum": 1},
                    },
                },
            },
        },
        "$defs": definitions,
    }


def extended_schema(skip: extensions.Skip | None = None) -> dict[str, Any]:
    """Return the JSON Schema of study files on this machine: that of `json_schema`, and what installed packages add.

    Parameters
    ----------
    skip : callable   Called, once each, with what is wrong with extensions that are left out as they cannot be used.
    """
    schema = json_schema()
    reported: set[str] = set()

    def tell(fault: str) -> None:
        if skip is not None and fault not in reported:
            skip(fault)
        reported.add(fault)

    definitions = schema["$defs"]
    _add_drives(schema, definitions, tell)
    _add_kinds(definitions, tell)
    _add_laws(definitions, tell)
    _add_parts(definitions, tell)
    return schema


def _add_drives(schema: dict[str, Any], definitions: dict[str, Any], skip: extensions.Skip) -> None:
    general = definitions["ConventionalDrive"]["properties"]
    for word, kind in extensions.drive_types(DRIVES, skip).items():
        if word in DRIVES:
            continue
        made = _definition(kind, definitions)
        made["properties"] |= {key: general[key] for key in ("title", "kind", "where")} | {"type": {"const": word}}
        definitions[kind.__name__] = made
        drives = schema["properties"]["drives"]["additionalProperties"]["anyOf"]
        drives.append({"$ref": f"#/$defs/{kind.__name__}"})


def _definition(part: type, definitions: dict[str, Any]) -> dict[str, Any]:
    """Schema of the table of a part or drive; the definitions of its parts join the others."""
    made = table_schema(part)
    inner = made.pop("$defs", {})
    for one in (made, *inner.values()):
        one.pop("required", None)
        for key in one["properties"].values():
            key.pop("default", None)
    for name, one in inner.items():
        definitions.setdefault(name, one)
    return made


def _add_kinds(definitions: dict[str, Any], skip: extensions.Skip) -> None:
    for part in (DutyCycle, Scenario):
        for field in in_kinds(part):
            where = definitions[part.__name__ if field.metadata["flat"] else field.name.capitalize()]
            where["properties"] |= kinds_schema(extensions.kinds(field, skip))


def _add_laws(definitions: dict[str, Any], skip: extensions.Skip) -> None:
    known = CHOICES["creep_law"]
    words = list(extensions.creep_laws(known, skip))
    for definition in definitions.values():
        for choice in definition["properties"].get("creep_law", {}).get("anyOf", ()):
            for place in (choice, choice.get("properties", {}).get("value", {})):
                if "enum" in place:
                    place["enum"] = words


def _add_parts(definitions: dict[str, Any], skip: extensions.Skip) -> None:
    for word, kind in extensions.parts(skip).items():
        made = _definition(kind, definitions)
        for base in kind.__mro__[1:]:
            properties = definitions.get(base.__name__, {}).get("properties")
            if properties is not None:
                for key, one in made["properties"].items():
                    properties.setdefault(key, one)
                properties.setdefault(extensions.VARIANT, {"enum": [], "description": "Part of an installed package"})
                properties[extensions.VARIANT]["enum"].append(word)
