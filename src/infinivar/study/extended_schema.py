"""JSON Schema of study files with the words of installed packages."""

from __future__ import annotations

from typing import Any

from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.scenario import Scenario
from infinivar.study import extensions
from infinivar.study.json_schema import json_schema, kinds_schema, table_schema
from infinivar.study.schema import CHOICES, DRIVES, in_kinds


def extended_schema(skip: extensions.Skip | None = None) -> dict[str, Any]:
    """Return the JSON Schema of study files on this machine: that of `json_schema`, and what installed packages add.

    Parameters
    ----------
    skip : callable   Is told, once each, what is wrong with extensions that are left out as they cannot be used.
    """
    schema = json_schema()
    told: set[str] = set()

    def tell(fault: str) -> None:
        if skip is not None and fault not in told:
            skip(fault)
        told.add(fault)

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
