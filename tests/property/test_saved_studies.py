"""A saved study loads to the same study: values, kinds and sources, spreads, tasks, and data of recordings."""

import dataclasses
import math
import tempfile
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import infinivar as iv
from infinivar import units
from internals import described, hints, in_kinds, part_of, shipped_studies, study_template
from internals import permitted_bounds as permitted
from internals import study_schema as schema
from internals import toml_tables as toml
from made import parameter_study
from sampled import examples, sampled

SHIPPED = parameter_study("faulring2006")


# Plain values

plain_text = st.text(max_size=40)
scalars = plain_text | st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False)
keys = st.text(max_size=12)
tables = st.recursive(
    st.dictionaries(keys, scalars | st.lists(scalars, max_size=3), max_size=4),
    lambda inner: st.dictionaries(keys, inner | scalars | st.lists(inner, min_size=1, max_size=3), max_size=4),
    max_leaves=12,
)


@examples(25)
@given(table=tables)
def test_tables_survive_toml(table):
    inline = any(isinstance(value, list) and any(isinstance(one, dict) for one in value) for value in nested(table))
    text = toml.dumps(table if not inline else within(table))
    assert tomllib.loads(text) == table


def nested(value):
    """Every value in a table."""
    yield value
    for one in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from nested(one)


def within(value):
    """The same with the tables of lists on one line each, with all they hold."""
    if isinstance(value, dict):
        return {key: within(one) for key, one in value.items()}
    return [line(one) for one in value] if isinstance(value, list) else value


def line(value):
    if isinstance(value, dict):
        return toml.Inline({key: line(one) for key, one in value.items()})
    return [line(one) for one in value] if isinstance(value, list) else value


UNITS = sorted(units.EXAMPLES)


@given(
    unit=st.sampled_from(UNITS),
    value=st.floats(1e-15, 1e15)
    | st.floats(-1e9, -1e-9)
    | st.just(0.0)
    | st.integers(1, 10**6).map(lambda n: n * 1e-5),
)
def test_numbers_survive_their_text(unit, value):
    assert units.parse(units.exact(value, unit), unit) == value


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (8040 * math.pi / 30, "rad/s", "8040 rpm"),
        (math.radians(75.0), "rad", "75 deg"),
        (2.1e11, "Pa", "210 GPa"),
        (1500.0, "N", "1500 N"),
        (0.12, "1", "0.12"),
        (1.0 / 3.0, "m", "0.3333333333333333 m"),
        (398.15, "K", "398.15 K"),
    ],
)
def test_numbers_are_written_as_people_write_them(value, unit, text):
    assert units.exact(value, unit) == text


# Whole studies


def saved_and_loaded(study):
    with tempfile.TemporaryDirectory() as folder:
        again = iv.load_study(study.save(Path(folder) / "saved.toml"))
        return again, replace(again, path=None)


@sampled("name", shipped_studies(), every=3)
def test_shipped_studies_survive(name, tmp_path):
    study = iv.load_study(name)
    again = iv.load_study(iv.save_study(study, tmp_path / f"{name}.toml"))
    assert again == study
    assert again.provenance == study.provenance
    assert again.warnings == study.warnings
    assert again.to_toml(tmp_path) == study.to_toml(tmp_path)


def test_the_shipped_set_and_the_template_survive(tmp_path):
    assert saved_and_loaded(SHIPPED)[0] == SHIPPED
    path = tmp_path / "mine.toml"
    path.write_text(study_template("mine", "Mine"), "utf-8")
    mine = iv.load_study(path)
    assert saved_and_loaded(mine)[0] == mine


def test_what_extends_another_study_survives(tmp_path):
    (tmp_path / "over.toml").write_text(
        'extends = "hand.toml"\n[drives.cobotic.transmission]\n'
        'preload = { value = 700, unit = "N", kind = "fitted", where = "run 7" }\n'
        '[uncertainty.cobotic.transmission]\npreload = "5 %"\n[uncertainty.cobotic.gearhead]\nefficiency = { deviation = 0.01 }\n'
        '[[correlations]]\ndrive = "cobotic"\nbetween = ["transmission.preload", "gearhead.efficiency"]\nvalue = 0.5\n',
        "utf-8",
    )
    (tmp_path / "hand.toml").write_text(shipped_studies()["hand_controller"].read_text("utf-8"), "utf-8")
    study = iv.load_study(tmp_path / "over.toml")
    again, _ = saved_and_loaded(study)
    assert again == study
    assert again.uncertainty == study.uncertainty != iv.Uncertainty()


def quantities(part):
    """Strategies of the physical fields of a class, within their bounds; some of them left out where they may be."""
    made = {}
    for field in described(part):
        if "unit" not in field.metadata or field.name in ("poisson",):
            continue
        low, high = permitted(field.metadata["bound"], 1.0)
        value = st.floats(max(low, 1e-6), min(high, 1e6))
        made[field.name] = value if field.default is dataclasses.MISSING else st.just(field.default) | value
    return made


def amount(most):
    """Zero, or a number that a file may state: not one below 1e-20."""
    return st.just(0.0) | st.floats(1e-6, most)


def some(part, **fixed):
    """A part of random values; only the required ones and those given here, if the others contradict one another."""

    def built(values):
        try:
            return part(**values)
        except iv.ParameterError:
            required = {field.name for field in dataclasses.fields(part) if field.default is dataclasses.MISSING}
            return part(**{name: value for name, value in values.items() if name in required or name in fixed})

    return st.fixed_dictionaries({**quantities(part), **fixed}).map(built)


names = st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z")), min_size=1, max_size=20)
motors = some(
    iv.parts.Motor,
    name=names,
    voltage=st.floats(10.0, 100.0),
    resistance=st.floats(0.1, 1.0),
    torque_constant=st.floats(0.01, 0.1),
    no_load_current=amount(1.0),
    continuous_torque=st.floats(0.01, 0.02),
    peak_torque=st.none() | st.floats(0.02, 0.05),
)
gearheads = some(iv.parts.Gearhead, name=names, loss_model=st.just("proportional"), efficiency=st.floats(0.1, 1.0))
conventional = st.builds(
    lambda motor, scale, gear, radius, inertia, friction: iv.ConventionalDrive(
        motor=motor if scale is None else motor.scaled(scale),
        gearhead=gear,
        pulley=iv.parts.Pulley(radius=radius),
        output_inertia=inertia,
        guideway=iv.parts.Guideway(friction=friction),
    ),
    motors,
    st.none() | st.floats(0.1, 10.0),
    gearheads,
    st.floats(1e-3, 1.0),
    st.none() | st.floats(1e-9, 1.0),
    amount(10.0),
)
cobotic = st.builds(
    lambda speed, preload, law, range_: replace(
        SHIPPED.drives["cobotic"],
        cylinder_speed=speed,
        transmission=replace(
            SHIPPED.drives["cobotic"].transmission, preload=preload, creep_law=law, steering_range=range_
        ),
    ),
    st.floats(1.0, 30.0) | st.floats(-30.0, -1.0),
    st.floats(100.0, 900.0),
    st.sampled_from(["linear", "polach", "fastsim", "vermeulen-johnson"]),
    st.floats(0.5, 1.5),
)
positive = st.floats(1e-3, 1e3)
motions = (
    st.builds(lambda d, f: iv.motion.Sinusoid(distance=d, frequency=f), positive, positive)
    | st.builds(lambda t: iv.motion.Hold(time=t), positive)
    | st.builds(lambda d, t, p: iv.motion.Reaches(distance=d, time=t, pause=p), positive, positive, amount(2.0))
    | st.builds(
        lambda joint, mass, share: iv.motion.Walking(
            joint=joint, body_mass=mass, stride_time=1.1, lever_arm=0.05, share=share
        ),
        st.sampled_from(["ankle", "knee", "hip"]),
        positive,
        st.floats(0.1, 1.0),
    )
    | st.builds(
        lambda mass, stride: iv.motion.Running(joint="hip", body_mass=mass, stride_time=stride, lever_arm=0.05),
        positive,
        st.none() | positive,
    )
)
duties = st.builds(
    lambda motion, force, mass, title: iv.DutyCycle(motion=motion, force=force, load_mass=mass, title=title),
    motions,
    st.none() | amount(50.0) | st.floats(-50.0, -1e-6),
    st.none() | amount(5.0),
    st.just("") | names,
)
scenarios = st.builds(
    lambda duration, distance, force: iv.Scenario(
        duration=duration,
        motion=None if distance is None else iv.motion.Reach(distance=distance, time=0.5),
        force=None if force is None else iv.motion.StepForce(size=force, start=0.1),
    ),
    positive,
    st.none() | positive,
    st.none() | positive,
)
words = st.from_regex(r"[a-z][a-z0-9_-]{0,8}", fullmatch=True)
studies = st.builds(
    lambda title, required, drives, duty, runs, rig, said: iv.Study(
        name="random",
        title=title,
        description=said,
        requirement=required,
        drives=drives,
        duty=duty,
        scenarios=runs,
        rig=rig,
    ),
    st.just("") | names,
    some(iv.Requirement, quadrants=st.sampled_from([1, 2, 4])),
    st.dictionaries(words, conventional | cobotic, min_size=1, max_size=3),
    st.dictionaries(words, duties, max_size=2),
    st.dictionaries(words, scenarios, max_size=2),
    st.just(iv.study.Rig()) | some(iv.study.Rig),
    st.text(st.characters(codec="utf-8", exclude_categories=("C", "Zl", "Zp")), max_size=60).filter(str.isprintable),
)


@pytest.mark.slow
@examples(20)
@given(study=studies)
def test_studies_built_in_python_survive(study):
    again, pathless = saved_and_loaded(study)
    assert again == study
    assert again.provenance == study.provenance
    assert again.titles == study.titles
    assert iv.Study.from_dict(tomllib.loads(study.to_toml()), name="random") == pathless


def test_springs_and_linkages_survive():
    tables = {
        "requirement": {"force": "40 N", "speed": "1 m/s"},
        "drives": {
            "leg": {
                "base": "faulring2006.motor1-gear1",
                "output": {
                    "parallel_spring": {
                        "shape": "progressive",
                        "deflections": {"value": [-5, 0, 10.5], "unit": "mm"},
                        "forces": ["-10 N", "0 N", "0.05 kN"],
                        "at": {"value": "drive", "kind": "stated", "where": "drawing 3"},
                    },
                    "series_spring": {"stiffness": "20 N/mm", "hysteresis": "1 N"},
                },
            }
        },
    }
    study = iv.Study.from_dict(tables, name="leg")
    output = study.drives["leg"].output
    assert output.parallel_spring.deflections == (-0.005, 0.0, 0.0105)
    again, _ = saved_and_loaded(replace(study, name="saved"))
    assert again.drives == study.drives
    assert again.provenance == study.provenance
    bare = iv.Study(name="bare", requirement=study.requirement, drives=study.drives)
    again, _ = saved_and_loaded(bare)
    assert again == bare


def fields_below(part, seen):
    """All fields of a class and its parts that a study file states."""
    if part not in seen:
        seen.add(part)
        for field in described(part):
            inner = part_of(hints(part)[field.name])
            if inner is not None:
                yield from fields_below(inner, seen)
            else:
                yield part, field
        for field in in_kinds(part):
            for kind in field.metadata["kinds"].values():
                yield from fields_below(kind, seen)


def test_the_key_of_every_field_reads_what_is_written():
    """Whatever field a part gets: its key gives back the number whose text is written."""
    from internals import study_tables, text_of

    seen: set = set()
    found = []
    for owner in (*schema.DRIVES.values(), iv.Requirement, iv.study.Rig, iv.DutyCycle, iv.Scenario):
        found += fields_below(owner, seen)
    assert len(found) > 150
    for part, field in found:
        unit = field.metadata.get("unit", field.metadata.get("row of"))
        if unit is None:
            continue
        low, high = permitted(field.metadata["bound"], 1.0)
        value = min(max(1.0 / 3.0, low), high)
        if "row of" in field.metadata:
            value = (value, value)
        key = schema.table_keys(part)[field.name]
        raw = study_tables(key, value, [text_of(field, value)], field.name)
        assert key.read(raw).value == value, (part, field.name)


# Recordings

TIME = np.linspace(0.0, 1.0, 201)
WAVE = 0.01 * np.sin(2.0 * np.pi * TIME)
ROWS = list(zip(TIME.tolist(), WAVE.tolist(), strict=True))


def test_recordings_by_their_file(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "walk.csv").write_text(
        "time [ms],position [mm]\n" + "\n".join(f"{1e3 * t!r},{1e3 * x!r}" for t, x in ROWS),
        "utf-8",
    )
    (tmp_path / "mine.toml").write_text(
        '[requirement]\nforce = "5 N"\nspeed = "1 m/s"\n[drives.a]\nbase = "faulring2006.cobotic"\n'
        '[duty.walk]\nshape = "file"\nfile = "data/walk.csv"\ncutoff = "8 Hz"\n'
        '[scenarios.walk]\nduration = "1 s"\n[scenarios.walk.motion]\nshape = "file"\nfile = "data/walk.csv"\n',
        "utf-8",
    )
    study = iv.load_study(tmp_path / "mine.toml")
    (tmp_path / "deep").mkdir()
    path = study.save(tmp_path / "deep" / "again.toml")
    assert tomllib.loads(path.read_text("utf-8"))["duty"]["walk"]["file"] == "../data/walk.csv"
    assert iv.load_study(path) == study
    assert [file.name for file in path.parent.iterdir()] == ["again.toml"]
    assert Path(tomllib.loads(study.to_toml())["duty"]["walk"]["file"]) == (tmp_path / "data" / "walk.csv").absolute()


@pytest.mark.parametrize("kind", ["position", "speed"])
def test_data_without_a_file_get_one(kind, tmp_path):
    recording = iv.motion.Recording(file="none", time=TIME, force=100.0 * WAVE, resolution=1e-5, **{kind: WAVE})
    study = iv.Study(
        name="mine",
        requirement=iv.Requirement(force=5.0, speed=1.0),
        drives={"a": SHIPPED.drives["cobotic"]},
        duty={"walk": iv.DutyCycle(motion=recording)},
        scenarios={
            "walk": iv.Scenario(
                duration=1.0,
                motion=iv.motion.Waypoints(file="x", time=TIME, position=WAVE),
                force=iv.motion.RecordedForce(file="y", time=TIME, force=WAVE / 3.0),
            )
        },
    )
    again = iv.load_study(study.save(tmp_path / "mine.toml"))
    assert again == study
    assert again.duty["walk"].motion.force.tolist() == recording.force.tolist()
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "mine-duty-walk.csv",
        "mine-scenarios-walk-force.csv",
        "mine-scenarios-walk-motion.csv",
        "mine.toml",
    ]
    with pytest.raises(iv.InputError, match=r"duty.walk.file: the data have no file; save_study writes them"):
        replace(study, scenarios={}).to_toml()


def test_keys_on_how_to_read_a_file_survive(tmp_path):
    rows = "\n".join(f"{t!r};{x!r};{20.0 * x!r}" for t, x in ROWS)
    (tmp_path / "gait.csv").write_text(f"t (s);Knee (rad);M (N m)\n{rows}\n", "utf-8")
    (tmp_path / "mine.toml").write_text(
        '[requirement]\nforce = "5 N"\nspeed = "1 m/s"\n[drives.a]\nbase = "faulring2006.cobotic"\n'
        '[duty.walk]\nshape = "file"\nfile = "gait.csv"\ncolumns = { time = "t", angle = "Knee", moment = "M" }\n'
        'flip = ["moment"]\nwindow = ["0.1 s", "0.9 s"]\nclosed = false\n',
        "utf-8",
    )
    study = iv.load_study(tmp_path / "mine.toml")
    (tmp_path / "deep").mkdir()
    path = study.save(tmp_path / "deep" / "again.toml")
    table = tomllib.loads(path.read_text("utf-8"))["duty"]["walk"]
    assert table["columns"] == {"time": "t", "angle": "Knee", "moment": "M"}
    assert (table["flip"], table["window"], table["closed"]) == (["moment"], ["0.1 s", "0.9 s"], False)
    again = iv.load_study(path)
    assert again == study
    (tmp_path / "gait.csv").unlink()
    there = iv.load_study(again.save(tmp_path / "deep" / "third.toml"))
    assert there == study
    assert (
        (tmp_path / "deep" / "third-duty-walk.csv").read_text("utf-8").startswith("time [s],angle [rad],moment [N m]\n")
    )


# Refusals

MINE = iv.Study(
    name="mine", requirement=iv.Requirement(force=5.0, speed=1.0), drives={"a": SHIPPED.drives["motor1-gear1"]}
)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"drives": {"a b": MINE.drives["a"]}}, "mine: drives.'a b' must have a name"),
        (
            {"drives": {"a": replace(MINE.drives["a"], output_inertia=1e-25)}},
            "drives.a.output_inertia = 1e-25 cannot be stated",
        ),
        (
            {"requirement": iv.Requirement(force=np.array([1.0, 2.0]), speed=1.0)},
            "requirement.force = .* cannot be stated",
        ),
        ({"title": "a\nb"}, "title = .* must be text without control characters"),
        (
            {"duty": {"a": iv.DutyCycle(motion=iv.motion.Hold(time=1.0), title="x\x07")}},
            "duty.a.title = .* cannot be stated",
        ),
    ],
)
def test_what_no_file_can_state_is_refused(change, message, tmp_path):
    study = replace(MINE, **change)
    with pytest.raises(iv.InputError, match=message):
        study.to_toml()
    with pytest.raises(iv.InputError, match=message):
        study.save(tmp_path / "mine.toml")
    assert list(tmp_path.iterdir()) == []


def test_own_values_need_a_word(tmp_path):
    law = iv.contact.CreepLaw(
        name="mine", creepage=lambda x: x, slope=lambda x: 1.0, force=lambda x: x, slip_creepage=1.0
    )
    drive = SHIPPED.drives["cobotic"]
    drive = replace(drive, transmission=replace(drive.transmission, creep_law=law))
    with pytest.raises(iv.InputError, match=r"drives.a.transmission.creep_law = mine cannot be stated in a study file"):
        replace(MINE, drives={"a": drive}).to_toml()


def test_files_are_not_replaced_unasked(tmp_path):
    path = MINE.save(tmp_path / "mine.toml")
    before = path.read_text("utf-8")
    with pytest.raises(iv.InputError, match=r"mine.toml: already exists; set overwrite=True"):
        replace(MINE, title="Other").save(path)
    assert path.read_text("utf-8") == before
    replace(MINE, title="Other").save(path, overwrite=True)
    assert iv.load_study(path).title == "Other"
    with pytest.raises(iv.InputError, match=r"must end in .toml"):
        MINE.save(tmp_path / "mine.txt")
    (tmp_path / "file").write_text("")
    with pytest.raises(iv.InputError, match="cannot be written"):
        MINE.save(tmp_path / "file" / "mine.toml")


# Tables

LEAN = {
    "requirement": {"force": "40 N", "speed": "0.8 m/s"},
    "drives": {"a": {"base": "faulring2006.cobotic"}},
    "duty": {"d": {"shape": "sinusoid", "distance": "5 mm", "frequency": "2 Hz"}},
}


def test_tables_give_the_study_of_their_file(tmp_path):
    (tmp_path / "lean.toml").write_text(toml.dumps(LEAN), "utf-8")
    before = repr(LEAN)
    study = iv.Study.from_dict(LEAN, name="lean.toml")
    assert repr(LEAN) == before
    assert replace(iv.load_study(tmp_path / "lean.toml"), name="lean.toml", title="lean.toml") == study
    mixed = {**LEAN, "requirement": {"force": "40 N", "speed": {"value": np.float64(0.8), "unit": "m/s"}}}
    assert iv.Study.from_dict(mixed, name="lean.toml").requirement == study.requirement


def test_files_in_tables_are_relative_to_the_folder(tmp_path, monkeypatch):
    rows = "\n".join(f"{t!r},{x!r}" for t, x in ROWS)
    (tmp_path / "walk.csv").write_text(f"time [s],position [m]\n{rows}\n", "utf-8")
    tables = {**LEAN, "duty": {"d": {"shape": "file", "file": "walk.csv"}}}
    found = iv.Study.from_dict(tables, name="lean", folder=tmp_path)
    monkeypatch.chdir(tmp_path)
    assert iv.Study.from_dict(tables, name="lean") == found
    (tmp_path / "base.toml").write_text(toml.dumps(tables), "utf-8")
    assert iv.Study.from_dict({"extends": "base.toml"}, name="lean", folder=tmp_path).duty == found.duty


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"drives": LEAN["drives"]}, r"^lean: requirement is missing"),
        ({}, r"^lean: requirement is missing: .*\nlean: drives is missing: write a table \[drives.NAME\]$"),
        ({**LEAN, "requirement": {"force": 5, "speed": "1 m/s"}}, r"^lean: requirement.force = \"?5\"? needs a unit"),
        ({**LEAN, 3: {}}, "lean: the study has the key 3, which must be text"),
        ({**LEAN, "rig": {"travel": object}}, "lean: rig.travel = .* must be text, a number, a list or a table"),
        ({**LEAN, "rig": {"travel": None}}, "lean: rig.travel = None must be text, a number, a list or a table"),
        ({**LEAN, "reconstruction": "x"}, "lean: reconstruction = .* must be a list of texts"),
        (3, "lean: must be tables by name, got 3"),
    ],
)
def test_faulty_tables_give_the_messages_of_files(tables, message):
    with pytest.raises(iv.InputError, match=message):
        iv.Study.from_dict(tables, name="lean")


@pytest.mark.parametrize("name", ["", 3, "a\nb", "x" * 200])
def test_a_name_is_text(name):
    with pytest.raises(iv.InputError, match="name must be text of 1 to 120 characters"):
        iv.Study.from_dict(LEAN, name=name)


def test_mistakes_of_one_section_do_not_hide_those_of_another():
    wrong = {
        "titel": "x",
        "requirement": {"force": "5 kg", "speed": "1 m/s"},
        "drives": {"a": {"base": "faulring2006.cobotic"}, "b": {"type": "cobotik"}},
        "duty": {"d": {"shape": "walkin"}},
        "scenarios": 3,
        "rig": {"travel": "1 s"},
        "uncertainty": {"a": {"motor": {"resistence": "5 %"}}, "b": {"motor": {"resistance": "5 %"}}, "c": {}},
    }
    with pytest.raises(iv.InputError) as found:
        iv.Study.from_dict(wrong, name="lean")
    lines = str(found.value).splitlines()
    starts = ("titel", "scenarios", "requirement.force", "drives.b.type", "duty.d.shape", "rig.travel")
    starts += ("uncertainty.a.motor.resistence", "uncertainty.c")
    assert [line.removeprefix("lean: ").startswith(start) for line, start in zip(lines, starts, strict=True)] == [
        True
    ] * 8


# Studies in Python


def test_a_study_in_python_is_complete():
    drive = SHIPPED.drives["motor1-gear1"]
    study = iv.Study(
        name="mine",
        requirement=iv.Requirement(force=5.0, speed=1.0, load_mass=2.0),
        drives={"a": drive},
        duty={"d": iv.DutyCycle(motion=iv.motion.Hold(time=1.0))},
    )
    assert study.title == "mine"
    assert study.duty["d"].title == "d"
    assert study.duty["d"].load_mass == 2.0
    rows = {row.field: row for row in study.provenance if row.owner == "a"}
    ratio = rows["gearhead.ratio"]
    assert (ratio.value, ratio.unit, ratio.kind, ratio.where) == (
        drive.gearhead.ratio,
        "1",
        "assumed",
        "given in Python",
    )
    heavier = replace(study, drives={"a": replace(drive, output_inertia=1e-3)})
    changed = {row.field: row.value for row in heavier.provenance if row.owner == "a"}
    assert changed == {**{field: row.value for field, row in rows.items()}, "output_inertia": 1e-3}


def test_a_changed_value_loses_its_source():
    study = iv.load_study("hand_controller")
    drive = study.drives["cobotic"]
    changed = replace(study, drives={**study.drives, "cobotic": replace(drive, cylinder_speed=15.0)})
    before = [row for row in study.provenance if (row.owner, row.field) != ("cobotic", "cylinder_speed")]
    after = [row for row in changed.provenance if (row.owner, row.field) != ("cobotic", "cylinder_speed")]
    assert after == before
    (row,) = [row for row in changed.provenance if (row.owner, row.field) == ("cobotic", "cylinder_speed")]
    assert (row.written, row.where) == ("15 rad/s", "given in Python")
