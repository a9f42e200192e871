"""Tables and figures generated from the program when the documentation is built, so that both always agree."""

import dataclasses
import multiprocessing
import types
import typing
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import infinivar
from infinivar import units
from infinivar._core.bounds import words
from infinivar._core.fields import described, in_kinds, part_of
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.machine_tasks import MachinePath, MachineTask
from infinivar.motion.scenario import FORCES, MOTIONS, Scenario
from infinivar.motion.virtual.tasks import HandleTask
from infinivar.parts import catalogue
from infinivar.parts.tables.columns import ONE
from infinivar.parts.tables.consistency import RELATIONS
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
    return _catalogue("bearings", ("bore", "outside_diameter", "dynamic_rating", "static_rating", "series"))


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


def figure_of_paper(number: int, title: str, caption: str, claims: list) -> str:
    """Image, caption and claims of a figure of the paper; number 0 stands for claims without a figure."""
    text = [f"![{title}](reference/generated/fig{number}.svg)\n", f"{caption}\n"] if number else []
    for claim in claims:
        found = f"{_claimed(claim.computed, claim.unit)} (threshold: {claim.threshold})"
        said = f"Paper, section {claim.section}: {_claimed(claim.paper, claim.unit)}. Computed: {found}. {claim.why}"
        text.append(f"{claim.id} {claim.claim}: **{claim.verdict}**\n: {said}\n")
    return "\n".join(text)


def _claimed(value, unit: str) -> str:
    return value if isinstance(value, str) else "none" if value is None else units.show(value, unit, 4)


def draw(app) -> None:
    """Draw the paper's figures, write their claims, and draw the figures of its contact and of a rolling patch."""
    from infinivar.analysis.contact_sheet import contact_sheet
    from infinivar.analysis.steering_step import steering_steps
    from infinivar.figures import contact_design, design_trends, steering_step, style
    from infinivar.paper.figures import FIGURES

    reproduction, folder = infinivar.reproduce(), Path(app.srcdir) / "reference" / "generated"
    machine = reproduction.machine
    for number, drawn in FIGURES.items():
        style.write(drawn.draw_all(machine), folder / f"fig{number}", ("svg",))
        claims = [claim for claim in reproduction.claims if claim.figure == number]
        (folder / f"paper_fig{number}.md").write_text(
            figure_of_paper(number, drawn.title, drawn.caption, claims), "utf-8"
        )
    others = [claim for claim in reproduction.claims if claim.figure not in FIGURES]
    (folder / "paper_claims_without_figure.md").write_text(figure_of_paper(0, "", "", others), "utf-8")
    style.write(contact_design.draw_all(contact_sheet(machine.study, "cobotic")), folder / "contact_design", ("svg",))
    (step,) = steering_steps(machine.study, "cobotic")
    style.write(steering_step.draw_all(step), folder / "steering_step", ("svg",))
    style.write(design_trends.draw_all(machine.drive), folder / "design_trends", ("svg",))
    style.write(infinivar.contact.RollingPatch(1.0).steady(lateral=0.3).plot(), folder / "rolling_patch", ("svg",))
    (folder / "design_trends_caption.md").write_text(f"{design_trends.CAPTION}\n", "utf-8")


def example(app, page: str, defines: str) -> dict:
    """Names of the first example of a page that defines a name, as `defines = ...`."""
    import re

    text = (Path(app.srcdir) / f"{page}.md").read_text("utf-8")
    names: dict = {}
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.S | re.M)
    exec(next(block for block in blocks if re.search(rf"^{defines} = ", block, re.M)), names)
    return names


def draw_sphere(app) -> None:
    """Draw the figures of a sphere between rollers, with the transmissions of the example on the page on machines."""
    import numpy as np

    import infinivar as iv
    from infinivar.figures import sphere_gears, sphere_map, style

    folder = Path(app.srcdir) / "reference" / "generated"
    page = example(app, "machines", "spheres")
    angle, load = np.radians(np.linspace(-90.0, 90.0, 73)), np.linspace(0.0, 1.45, 59) * page["roller"].slip_force
    maps = [iv.analysis.sphere_map(one, angle, load, sphere_speed=20.0) for one in page["spheres"].values()]
    style.write(sphere_map.draw_all(maps), folder / "sphere_map", ("svg",))
    style.write(sphere_gears.draw_all(page["spheres"], 20.0), folder / "sphere_gears", ("svg",))
    ivt = page["spheres"]["cubic"]
    point = ivt.operate(steering_angle=np.radians(30.0), sphere_speed=20.0, load=25.0)
    style.write(point.plot(ivt=ivt), folder / "sphere", ("svg",))


def draw_shared_motor(app) -> None:
    """Draw the figure of the page on machines: one motor against a motor for each joint."""
    import numpy as np

    import infinivar as iv
    from infinivar.figures import shared_motor, style

    study = iv.load_study("hand_controller")
    found = [
        iv.analysis.share_motor(
            study.drives[name],
            study.drives["motor2-gear4"],
            force=np.linspace(0.0, 55.0, 111),
            legs=(1, 2, 3, 6, 12),
            duty=np.linspace(0.02, 1.0, 50),
            period=10.0,
        )
        for name in ("cobotic", "cobotic-b")
    ]
    made = shared_motor.draw_all(found, ["cobotic (A)", "cobotic-b (B)"])
    style.write(made, Path(app.srcdir) / "reference" / "generated" / "shared_motor", ("svg",))


def draw_displays(app) -> None:
    """Draw the figures of the page on cobotic and conventional displays."""
    import numpy as np

    import infinivar as iv
    from infinivar.figures import displays, shared_motor, style

    folder = Path(app.srcdir) / "reference" / "generated"
    drives = iv.load_study("hand_controller").drives
    pairs = [
        iv.displays.DisplayPair(cobotic=drives[name], conventional=drives["motor2-gear4"])
        for name in ("cobotic", "cobotic-b")
    ]
    variants = iv.displays.assumed_variants(pairs[0], {"reconstruction B": drives["cobotic-b"]})
    style.write(
        displays.draw_all(iv.displays.compare_displays(pairs[0], variants=variants)),
        folder / "display_energy",
        ("svg",),
    )
    grid = {"force": np.linspace(0.0, 55.0, 111), "duty": np.linspace(0.02, 1.0, 50)}
    made = shared_motor.draw_map([iv.displays.display_break_even(pair, **grid) for pair in pairs], ["A", "B"])
    style.write(made, folder / "display_break_even", ("svg",))


def draw_legs(app) -> None:
    """Draw the platform of the page on machines under a load, and the wrenches that it can hold."""
    import infinivar as iv
    from infinivar.figures import machine as drawn
    from infinivar.figures import style, wrench_set

    folder = Path(app.srcdir) / "reference" / "generated"
    machine = iv.machines.LeggedDrive.of(iv.load_study("hand_controller").drives["cobotic"], 6)
    platform = iv.transmission.Platform.hexapod()
    home = platform.at([0.0, 0.0, platform.home])
    sets = [machine.wrench_set(home), machine.wrench_set(home, twist=[0.0, 0.0, 0.3, 0.0, 0.0, 0.0])]
    style.write(wrench_set.draw_all(sets, ["at rest", "rising at 0.3 m/s"]), folder / "wrench_set", ("svg",))
    pose = [0.01, 0.0, platform.home], [0.0, 0.1, 0.0]
    point = machine.operate(
        platform.at(*pose), wrench=[-30.0, 15.0, 60.0, 0.0, 0.0, 0.0], twist=[0.0, 0.1, 0.15, 0.0, 0.0, 0.0]
    )
    style.write(drawn.draw_all(platform, machine.legs, point.legs, *pose), folder / "machine", ("svg",))


def draw_planar(app) -> None:
    """Draw the cart of the page on machines under a load."""
    from infinivar.figures import style

    page = example(app, "machines", "cart")
    cart, twist = page["cart"], [0.5, 0.0, 0.7]
    point = cart.mechanism.operate(rates=twist, heading=cart.headings(twist, {"y": 50.0, "angle": 4.0}))
    made = point.plot(cobot=cart)
    style.write(made, Path(app.srcdir) / "reference" / "generated" / "planar_cobot", ("svg",))


def draw_machine_run(app) -> None:
    """Draw the run of the page on motion: a platform on six legs."""
    from infinivar.figures import machine_run, style

    run = example(app, "motion-and-control", "machine")["run"]
    style.write(machine_run.draw_all(run), Path(app.srcdir) / "reference" / "generated" / "machine_run", ("svg",))


def draw_motion(app) -> None:
    """Draw the bond graph of the page on motion, and a simulated reach."""
    import infinivar as iv
    from infinivar.figures import bond_graph, energy_flow, style, time_history

    folder = Path(app.srcdir) / "reference" / "generated"
    study = shipped_study("faulring2006")
    cobotic = study.drives["cobotic"]
    motor = example(app, "motion-and-control", "motor")["motor"]
    style.write(bond_graph.draw_all(motor), folder / "graph_motor", ("svg",))
    reach = iv.simulate(cobotic, study.scenarios["reach"])
    style.write(energy_flow.draw_all(reach), folder / "energy_reach", ("svg",))
    style.write(time_history.draw_all(reach), folder / "history_reach", ("svg",))


def draw_measurements(app) -> None:
    """Draw a calibration, a tornado chart, and models compared with measurements."""
    import numpy as np

    import infinivar as iv
    from infinivar.calibration import virtual_rig
    from infinivar.figures import calibration, sensitivity, style
    from measured import figures as measurements

    folder = Path(app.srcdir) / "reference" / "generated"
    study = shipped_study("faulring2006")
    drive = study.drives["cobotic"]
    runs = virtual_rig.experiment(drive, study.rig, virtual_rig.protocol(drive, study.rig), simulated=False).data
    style.write(calibration.draw_all(iv.calibrate(study, "cobotic", runs)), folder / "calibration", ("svg",))
    speed, torque = (part.ravel() for part in np.meshgrid(np.linspace(10, 60, 6), np.linspace(-0.25, 0.25, 8)))
    points = virtual_rig.dynamometer(
        study.drives["motor1-gear1"],
        study.rig,
        speed=speed,
        torque=torque,
        noise={"current": 0.005, "voltage": 0.02},
        values={"friction": 0.015, "load_share": 0.03, "viscous": 1e-4},
    )
    geared = iv.calibrate(study, "motor1-gear1", points)
    style.write(calibration.draw_geared(geared), folder / "geared_calibration", ("svg",))
    found = iv.sensitivity(study, "cobotic", "energy", duty="shake", samples=128)
    style.write(sensitivity.draw_all(found), folder / "sensitivity", ("svg",))
    style.write(measurements.draw_map(), folder / "motor_map", ("svg",))
    style.write(measurements.draw_gears(), folder / "gear_friction", ("svg",))


DRAWINGS = (
    draw,
    draw_sphere,
    draw_shared_motor,
    draw_displays,
    draw_legs,
    draw_planar,
    draw_machine_run,
    draw_motion,
    draw_measurements,
)


def begin(app) -> None:
    """Draw in a process of its own, while the examples of the gallery run."""
    pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"))
    place = types.SimpleNamespace(srcdir=str(app.srcdir))
    app.drawings = [pool.submit(one, place) for one in DRAWINGS]


def end(app, *_) -> None:
    """Wait for the drawings, before pages that show them are read."""
    for one in app.drawings:
        one.result()


def setup(app):
    # Before the gallery, with the default priority of 500.
    app.connect("builder-inited", write, priority=400)
    app.connect("builder-inited", begin, priority=400)
    app.connect("env-before-read-docs", end)
    return {"parallel_read_safe": True}
