"""Tables generated from the program when the documentation is built, so that both always agree."""

import dataclasses
import typing
from collections.abc import Mapping
from pathlib import Path

from infinivar import units
from infinivar._core.bounds import words
from infinivar._core.fields import described, in_kinds, part_of
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.machine_tasks import MachinePath, MachineTask
from infinivar.motion.scenario import FORCES, MOTIONS, Scenario
from infinivar.motion.virtual.tasks import HandleTask
from infinivar.parts import catalogue
from infinivar.parts.tables.columns import ONE
from infinivar.parts.tables.relations import RELATIONS
from infinivar.study import schema
from infinivar.study.load import shipped_study
from infinivar.study.requirement import Requirement
from infinivar.study.rig import Rig
from infinivar.study.sessions import SessionTask
from infinivar.study.shipped import parameter_set, parameter_sets


def grid(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A Markdown table."""
    lines = [header, ("---",) * len(header), *rows]
    return "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def _options(key: schema.Key) -> list[object]:
    """Options that a field accepts, from its JSON Schema; empty if any value is allowed."""
    return next((branch["enum"] for branch in (key.schema or {}).get("anyOf", []) if "enum" in branch), [])


def _default(field: dataclasses.Field) -> str:
    if field.default is None:
        return "not given"
    if field.default is not dataclasses.MISSING:
        if field.default == "":
            return "the name"
        shown = units.show(field.default, field.metadata["unit"]) if "unit" in field.metadata else field.default
        return f"`{str(shown).lower() if isinstance(shown, bool) else shown}`"
    return "**required**" if field.default_factory is dataclasses.MISSING else "its defaults"


def _written(meta: Mapping, hint: object) -> str:
    """How a value is written."""
    unit = meta.get("unit", "")
    if "row of" in meta:
        one = schema.example(meta["row of"], meta["bound"])
        return "list of numbers" if meta["row of"] == "1" else f'list, such as `["{one}", ...]`'
    if hint in (bool, int):
        return "`true` or `false`" if hint is bool else "whole number"
    if unit == "1":
        return "number"
    return f'`"{schema.example(unit, meta["bound"])}"`' if unit else "text"


def fields_of(part: type) -> str:
    """Table of the keys of a part."""
    hints = typing.get_type_hints(part)
    known = {field.name: field for field in dataclasses.fields(part)}
    rows = []
    for key, entry in schema.table_keys(part).items():
        field = known.get(key)
        meta = field.metadata if field is not None else {"meaning": entry.meaning, "unit": "1"}
        inner = part_of(hints.get(key))
        options = _options(entry)
        if inner is not None:
            write = f"table, see [{inner.__name__}](#{inner.__name__.lower()})"
        elif "several" in meta:
            kind = meta["several"].__name__
            write = f"list of tables, see [{kind}](#{kind.lower()})"
        elif options:
            write = ", ".join(
                f"`{option if isinstance(option, int) else chr(34) + option + chr(34)}`" for option in options
            )
        else:
            write = _written(meta, hints.get(key))
        rows.append(
            (
                f"`{key}`",
                "not given" if field is None else _default(field),
                write,
                words(meta["bound"]) if "bound" in meta else "",
                meta["meaning"],
            )
        )
    for field in in_kinds(part):
        kinds = list(field.metadata["kinds"].values())
        if kinds in ([*MOTIONS.values()], [*FORCES.values()]):
            owner = "force" if kinds == [*FORCES.values()] else "motion"
            link = f"table with `shape`, as `{owner}` in `[scenarios.NAME]`"
            rows.append((f"`{field.name}`", _default(field), link, "", field.metadata["meaning"]))
        elif part is MachinePath:
            link = "table with `shape`, as in `[duty.NAME]`"
            rows.append((f"`{field.name}`", _default(field), link, "", field.metadata["meaning"]))
        elif not field.metadata["flat"]:
            link = f"table, see [{field.name.capitalize()}](#{field.name})"
            rows.append((f"`{field.name}`", _default(field), link, "", field.metadata["meaning"]))
    return grid(("key", "if left out", "write", "must be", "meaning"), rows)


def kinds_of(field: dataclasses.Field) -> str:
    """Description and keys of each kind of a field."""
    text = []
    for shape, kind in field.metadata["kinds"].items():
        summary = kind.__doc__.strip().splitlines()[0].replace("``", "`")
        text.append(f'With `{field.metadata["key"]} = "{shape}"`: {summary[0].lower()}{summary[1:]}\n')
        if described(kind) or in_kinds(kind):
            text.append(fields_of(kind))
    return "\n".join(text)


def section(field: dataclasses.Field) -> str:
    """Section on the kinds of a field."""
    title = field.name.capitalize()
    return f"({field.name})=\n#### {title}\n\n{field.metadata['meaning']}.\n\n{kinds_of(field)}"


def _parts(part: type, found: list[type]) -> None:
    hints = typing.get_type_hints(part)
    for field in described(part):
        inner = field.metadata.get("several") or part_of(hints[field.name])
        if inner is not None and inner not in found:
            found.append(inner)
            _parts(inner, found)
    for field in in_kinds(part):
        if part is SessionTask or issubclass(part, HandleTask):
            for kind in field.metadata["kinds"].values():
                _parts(kind, found)


def study_fields() -> str:
    """Reference of all tables of a study file."""
    parts: list[type] = []
    for owner in (*schema.DRIVES.values(), Scenario, DutyCycle, MachineTask, SessionTask, MachinePath, Rig):
        _parts(owner, parts)
    sections = [
        ("`[requirement]`", Requirement),
        ("`[scenarios.NAME]`", Scenario),
        ("`[duty.NAME]`", DutyCycle),
        ("`[tasks.NAME]`", MachineTask),
        ("`[tasks.NAME]` with `type`", SessionTask),
        ("`[paths.NAME]`", MachinePath),
        ("`[rig]`", Rig),
    ]
    sections += [(f'`[drives.NAME]` with `type = "{name}"`', drive) for name, drive in schema.DRIVES.items()]
    text = []
    for heading, part in sections:
        text.append(f"### {heading}\n\n{part.__doc__.strip().splitlines()[0]}\n\n{fields_of(part)}")
        for field in in_kinds(part):
            if part is MachinePath:
                continue  # the kinds of every coordinate are those of a duty cycle
            if field.metadata["flat"]:
                text.append(kinds_of(field))
            else:
                text.append(section(field))
            # What a task at a handle consists of comes in kinds as well.
            inner = [one for kind in field.metadata["kinds"].values() for one in in_kinds(kind)]
            text += [section(one) for one in inner if part is SessionTask and field.metadata["flat"]]
    for part in parts:
        summary = part.__doc__.strip().splitlines()[0].replace("``", "`")
        text.append(f"({part.__name__.lower()})=\n### {part.__name__}\n\n{summary}\n\n{fields_of(part)}")
    return "\n".join(text)


def unit_examples() -> str:
    rows = [
        (unit if unit != "1" else "pure number", f"`{text}`" if unit == "1" else f'`"{text}"`')
        for unit, text in units.EXAMPLES.items()
    ]
    return grid(("quantity in", "write for example"), rows)


def motors() -> str:
    keys = ("name", "voltage", "continuous_torque", "max_speed", "resistance", "torque_constant", "mass")
    return _catalogue("motors", keys)


def gearheads() -> str:
    return _catalogue("gearheads", ("name", "ratio", "efficiency", "continuous_torque", "mass"))


def bearings() -> str:
    return _catalogue(
        "bearings", ("bore", "outside_diameter", "width", "dynamic_rating", "static_rating", "mass", "series")
    )


def rails() -> str:
    return _catalogue("rails", ("width", "height", "dynamic_rating", "static_rating", "carriage_mass", "rail_density"))


def belts() -> str:
    return _catalogue("belts", ("pitch", "width", "belt_density", "permissible_force", "specific_stiffness"))


def springs() -> str:
    return _catalogue(
        "springs",
        ("made_for", "stiffness", "permissible_force", "wire_diameter", "outer_diameter", "free_length", "mass"),
    )


def tubes() -> str:
    return _catalogue("tubes", ("metal", "outer_diameter", "wall", "tube_density"))


def materials() -> str:
    return _catalogue("materials", ("name", "youngs_modulus", "poisson", "yield_strength", "hardness"))


def _catalogue(kind: str, keys: tuple[str, ...]) -> str:
    rows = [(f"`{name}`", *(part.get(key, "") for key in keys)) for name, part in catalogue.entries(kind).items()]
    return grid(("part", *(key.replace("_", " ") for key in keys)), rows)


def relations() -> str:
    """Figures of data sheets that `infinivar catalogue check` compares."""
    rows = [
        (
            f"{ONE[one.kind]}: {one.name}",
            f"{'at most' if one.at_most else 'equal to'} {one.follows}",
            units.percent(one.tolerance) if one.unit != "1" else f"{100 * one.tolerance:g} points",
            one.reason,
        )
        for one in RELATIONS
    ]
    return grid(("figure", "must be", "tolerance", "because"), rows)


def parameter_set_values(name: str) -> str:
    """Values of a shipped set and their sources, drive by drive, with one line per catalogue part."""
    study = shipped_study(name)
    text = [f"> {statement}\n" for statement in study.reconstruction]
    for owner in ("requirement", *study.drives):
        rows, shown = [], set()
        for row in study.provenance:
            if row.owner != owner or row.field.endswith(".name"):
                continue
            if row.kind == "catalogue":
                part = row.field.rsplit(".", 1)[0]
                if part not in shown:
                    shown.add(part)
                    names = [r.value for r in study.provenance if (r.owner, r.field) == (owner, f"{part}.name")]
                    rows.append((f"`{part}`", *names, row.kind, row.where))
            else:
                default = row.where == "program default" and row.unit != ""
                written = units.show(row.value, row.unit) if default else row.written
                rows.append((f"`{row.field}`", written.replace(" ", "\N{NO-BREAK SPACE}"), row.kind, row.where))
        title = "The requirement" if owner == "requirement" else f"`{name}.{owner}`: {study.titles[owner]}"
        text.append(f"#### {title}\n\n{grid(('key', 'value', 'kind', 'source'), rows)}")
    return "\n".join(text)


def set_drives() -> str:
    """Drives of all shipped sets, by the names that `base` uses."""
    rows = []
    for name in parameter_sets():
        for key, drive in parameter_set(name)["drives"].items():
            rows.append((f"`{name}.{key}`", f"`{drive['type']}`", drive["title"]))
    return grid(("base", "type", "what it is"), rows)


def references() -> str:
    from infinivar.references import cite, entries

    return "\n".join(f"`{key}`\n: {cite(key)}\n" for key in sorted(entries()))


def write(app) -> None:
    """Write the tables that changed; unchanged files keep an incremental build short."""
    folder = Path(app.srcdir) / "reference" / "generated"
    folder.mkdir(parents=True, exist_ok=True)
    pages = {
        "study_fields": study_fields(),
        "unit_examples": unit_examples(),
        "motors": motors(),
        "gearheads": gearheads(),
        "bearings": bearings(),
        "rails": rails(),
        "belts": belts(),
        "springs": springs(),
        "tubes": tubes(),
        "materials": materials(),
        "references": references(),
        "set_drives": set_drives(),
        "relations": relations(),
        **{f"set_{name}": parameter_set_values(name) for name in parameter_sets()},
    }
    for name, text in pages.items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text("utf-8") != text:
            path.write_text(text, "utf-8")


def setup(app):
    app.connect("builder-inited", write, priority=400)
    return {"parallel_read_safe": True}
