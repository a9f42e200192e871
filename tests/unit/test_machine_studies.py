"""Machines in study files: loaded, refused with one clear message, saved, with provenance, in the schema."""

import tomllib

import pytest

import infinivar as iv
from internals import check_study as check
from internals import json_schema
from machine_studies import ARM, EVERY, PLANAR, PLATFORM, SPHERE


@pytest.fixture
def load(tmp_path):
    def write_and_load(text):
        path = tmp_path / "mine.toml"
        path.write_text(text, "utf-8")
        return iv.load_study(path)

    return write_and_load


@pytest.mark.parametrize("name", EVERY)
def test_a_saved_machine_is_the_same(name, load, tmp_path):
    study = load(EVERY[name])
    check(study)
    again = iv.load_study(study.save(tmp_path / "again.toml"))
    assert again.drives == study.drives
    assert (again.tasks, again.paths) == (study.tasks, study.paths)
    assert [(row.owner, row.field, row.value, row.kind) for row in again.provenance] == [
        (row.owner, row.field, row.value, row.kind) for row in study.provenance
    ]


def test_units_are_those_of_the_coordinates(load):
    study = load(PLATFORM)
    box = study.tasks["lift"].box
    assert (box.x, box.rz) == (5.0, 0.1)
    assert load(SPHERE).tasks["turn"].wrench.angle == pytest.approx(0.05)


def test_every_number_has_a_source(load):
    rows = {(row.owner, row.field): row for row in load(PLATFORM).provenance}
    assert rows["cobotic", "geometry.rod_length"].value == pytest.approx(0.14)
    assert rows["cobotic", "geometry.rod_length"].where == "mine.toml"
    assert rows["cobotic", "leg.motor.resistance"].kind == "catalogue"
    assert rows["separate", "separate.motor.resistance"].kind == "catalogue"
    assert rows["tasks.lift", "wrench.y"].written == "20 N"
    assert rows["paths.circle", "load_mass"].value == 0.5
    cart = {row.field: row for row in load(PLANAR).provenance if row.owner == "cart"}
    assert cart["positions"].written == "x = 0.4 m; x = -0.2 m, y = 0.25 m; x = -0.2 m, y = -0.25 m"


def test_a_drive_like_another_differs_where_it_says_so(load):
    drives = load(PLATFORM).drives
    assert drives["separate"].geometry == drives["cobotic"].geometry
    assert drives["separate"].leg is None
    assert drives["cobotic"].separate is None


def test_leg_of_a_machine_takes_single_values_over_its_base(load):
    text = PLATFORM.replace(
        'base = "faulring2006.cobotic"', 'base = "faulring2006.cobotic"\ncylinder_speed = "9 rad/s"'
    )
    assert load(text).drives["cobotic"].leg.cylinder_speed == 9.0


def test_a_study_extends_one_of_machines(load, tmp_path):
    (tmp_path / "below.toml").write_text(PLATFORM, "utf-8")
    study = load('extends = "below.toml"\n[tasks.hold]\nwrench = { z = "40 N" }')
    assert study.tasks["hold"].wrench.z == 40.0
    assert study.tasks["hold"].time_share == 0.2


def test_schema_has_every_machine_task_and_path():
    schema = json_schema()
    assert {"PlatformDrive", "ArmDrive", "SphereDrive", "PlanarDrive", "MachineTask", "MachinePath"} <= {
        *schema["$defs"]
    }
    assert schema["$defs"]["Twist"]["properties"]["rx"]["anyOf"][0]["examples"]
    points = schema["$defs"]["PlanarDrive"]["properties"]["positions"]["anyOf"][0]["items"]["properties"]
    assert {*points} == {"x", "y"}


X_WAVE = 'x = { shape = "sinusoid", distance = "20 mm", frequency = "1 Hz" }'
TWO = '[{ x = "0.4 m" }, { x = "-0.4 m" }]'

ROLLERS = """rollers = [
    { x = 1, axle_y = -1, shaft = 1 },
    { y = 1, axle_x = -1, shaft = 2 },
    { x = -1, y = -1, z = 1.4142135623730951 },
    { x = -1, y = -1, z = -1.4142135623730951 },
]"""


def test_rollers_may_be_written_with_five_digits(load):
    written = ROLLERS.replace(str(2.0**0.5), "1.4142")
    assert written != ROLLERS
    study, rounded = (load(SPHERE.replace('layout = "cubic"', text)) for text in (ROLLERS, written))
    task = study.tasks["turn"]
    powers = [iv.perform_task(one.drives["ball"], task).mean_power for one in (study, rounded)]
    assert powers[0] == pytest.approx(powers[1], rel=1e-4)


def test_rollers_of_a_sphere_at_given_places(load, tmp_path):
    text = SPHERE.replace('layout = "cubic"', ROLLERS)
    study = load(text)
    tetrahedral = load(SPHERE.replace('"cubic"', '"tetrahedral"')).drives["ball"]
    task = study.tasks["turn"]
    assert iv.perform_task(study.drives["ball"], task).mean_power == pytest.approx(
        iv.perform_task(tetrahedral, task).mean_power, rel=1e-9
    )
    assert iv.load_study(study.save(tmp_path / "again.toml")).drives == study.drives


BAD = {
    "unknown type": (PLATFORM.replace('"platform"', '"platfrom"'), "drives.cobotic.type", "did you mean 'platform'"),
    "no geometry": (
        PLATFORM.replace("[drives.cobotic.geometry]", "[drives.cobotic.geometri]"),
        "geometri",
        "'geometry'",
    ),
    "short rods": (
        PLATFORM.replace('"140 mm"', '"30 mm"'),
        "drives.cobotic.geometry.rod_length",
        "must be > 0.05562 m to reach",
    ),
    "one end of the stroke": (PLATFORM.replace('lowest = "-50 mm"', ""), "geometry.lowest is missing"),
    "empty stroke": (PLATFORM.replace('"-50 mm"', '"60 mm"'), "geometry.highest must be > lowest, 0.06 m, got 0.05 m"),
    "missing radius": (PLATFORM.replace('joint_radius = "40 mm"', ""), "geometry.joint_radius is missing"),
    "neither leg nor separate": (
        PLATFORM.replace('[drives.cobotic.leg]\nbase = "faulring2006.cobotic"', "").replace(
            "[drives.separate.separate]", "[x]"
        ),
        "needs one of leg, separate",
    ),
    "both leg and separate": (
        PLATFORM + '[drives.cobotic.separate]\nbase = "faulring2006.motor2-gear4"\n',
        "drives.cobotic.separate does not apply beside leg",
    ),
    "leg of another kind": (
        PLATFORM.replace('base = "faulring2006.cobotic"', 'base = "faulring2006.motor2-gear4"'),
        'drives.cobotic.leg.base = "faulring2006.motor2-gear4" is a conventional drive, but a cobotic one is needed',
        "faulring2006.cobotic-b",
    ),
    "unknown base of a leg": (
        PLATFORM.replace('"faulring2006.cobotic"', '"faulring2006.cobotik"'),
        "drives.cobotic.leg.base",
        "did you mean 'faulring2006.cobotic'",
    ),
    "leg with a spring": (
        PLATFORM.replace(
            'base = "faulring2006.cobotic"',
            'base = "faulring2006.cobotic"\noutput = { parallel_spring = { stiffness = "1 N/mm" } }',
        ),
        "drives.cobotic.leg.output must have no springs",
    ),
    "like itself": (PLATFORM.replace('like = "cobotic"', 'like = "separate"'), "drives.separate.like", "another drive"),
    "like nobody": (PLATFORM.replace('like = "cobotic"', 'like = "cobotik"'), "drives.separate.like", "'cobotic'"),
    "like no name of a drive": (
        PLATFORM.replace('like = "cobotic"', 'like = ")"'),
        "drives.separate.like",
        "another drive: cobotic",
    ),
    "like with another type": (
        PLATFORM.replace('like = "cobotic"', 'like = "cobotic"\ntype = "arm"'),
        "drives.separate.type",
        "'platform'",
    ),
    "twist in metres": (PLATFORM.replace('y = "0.1 m/s"', 'y = "0.1 m"'), "tasks.lift.twist.y", "0.1 m"),
    "moment in newtons": (PLATFORM.replace('rz = "0.1 N m"', 'rz = "0.1 N"'), "tasks.lift.box.rz", "N m"),
    "unknown coordinate": (
        PLATFORM.replace('wrench = { z = "30 N" }', 'wrench = { w = "30 N" }'),
        "tasks.hold.wrench.w",
    ),
    "coordinate of another machine": (
        PLATFORM.replace('wrench = { z = "30 N" }', 'wrench = { angle = "3 N m" }'),
        "tasks.hold.wrench.angle does not apply",
        "drives.cobotic has x, y, z, rx, ry, rz only",
    ),
    "negative box": (
        PLATFORM.replace('box = { x = "5 N"', 'box = { x = "-5 N"'),
        "tasks.lift.box.x must be >= 0 N, as it is a half-width, got -5 N",
    ),
    "box and corners": (
        PLATFORM.replace("box = {", 'wrenches = [{ x = "1 N" }]\nbox = {'),
        "tasks.lift.box and wrenches exclude each other",
    ),
    "no corners": (
        PLATFORM.replace("box = {", "wrenches = []\nbox = {"),
        "tasks.lift.wrenches",
        "must be a list of tables",
    ),
    "corner with an unknown key": (
        PLANAR.replace('{ angle = "5 N m" }', '{ angel = "5 N m" }'),
        "tasks.turn.wrenches",
        "entry 2 has an unknown key 'angel' (did you mean 'angle'?)",
    ),
    "corner in another unit": (PLANAR.replace('{ angle = "5 N m" }', '{ angle = "5 N" }'), "entry 2, angle = 5 N"),
    "shares that do not add up": (PLATFORM.replace('"60 %"', '"50 %"'), "add up to 90 %", "tasks.lift 50 %"),
    "a share left out": (PLATFORM.replace('time_share = "60 %"', ""), "tasks.lift.time_share is missing"),
    "path that does not move": (
        "\n".join(line for line in PLATFORM.splitlines() if not line.startswith(("x = {", "y = {"))),
        "paths.circle: no coordinate moves",
    ),
    "path of two periods": (
        PLATFORM.replace('frequency = "1 Hz", start', 'frequency = "2 Hz", start'),
        "paths.circle.y must have the period of x, 1 s, got 0.5 s",
    ),
    "path by an angle": (
        PLATFORM.replace('x = { shape = "sinusoid", distance = "20 mm"', 'x = { shape = "sinusoid", angle = "2 deg"'),
        "paths.circle.x must be a motion along a line: state distance, not angle",
    ),
    "path of an unknown shape": (
        PLATFORM.replace('x = { shape = "sinusoid"', 'x = { shape = "sinusoit"'),
        "paths.circle.x.shape",
        "'sinusoid'",
    ),
    "path from a file that is not there": (
        PLATFORM.replace(
            'x = { shape = "sinusoid", distance = "20 mm", frequency = "1 Hz" }',
            'x = { shape = "file", file = "no.csv" }',
        ),
        "paths.circle.x",
        "no.csv",
    ),
    "tasks beside a requirement": (
        PLATFORM + '[requirement]\nforce = "5 N"\nspeed = "1 m/s"\n',
        "requirement does not apply beside tasks",
    ),
    "machine with a requirement": (
        SPHERE.partition("[tasks.turn]")[0] + '[requirement]\nmoment = "5 N m"\nangular_speed = "1 rad/s"\n',
        "requirement is of drives of one axis; drives.ball is a machine of type sphere",
    ),
    "four members": (
        ARM.replace('["0.3 m", "0.25 m"]', '["1 m", "1 m", "1 m", "1 m"]'),
        "drives.cobotic.lengths",
        "one to three",
    ),
    "no members": (ARM.replace('["0.3 m", "0.25 m"]', "[]"), "drives.cobotic.lengths"),
    "negative member": (ARM.replace('"0.25 m"', '"-0.25 m"'), "drives.cobotic.lengths", "entry 2"),
    "unknown elbow": (ARM.replace('type = "arm"', 'type = "arm"\nelbow = "up"'), "drives.cobotic.elbow", "left, right"),
    "zero preload": (PLANAR.replace('"200 N"', '"0 N"'), "drives.cart.wheel.preload", "> 0"),
    "wheel measured in part": (
        PLANAR.replace('rolling_torque = "9 mN m"', ""),
        "drives.cart.wheel.rolling_torque is missing",
    ),
    "wheel with a flow loss": (
        PLANAR.replace("friction = 0.2", 'friction = 0.2\ncreep_law = "faulring"'),
        "drives.cart.wheel.creep_law must be one without a flow loss",
    ),
    "one wheel at a point": (PLANAR.replace(', { x = "-0.4 m" }]', "]"), "drives.two.positions", "two wheels or more"),
    "wheels at one point": (
        PLANAR.replace('{ x = "-0.4 m" }]', '{ x = "0.4 m" }]'),
        "drives.two.positions 2",
        "different points",
    ),
    "wheels above the plane": (
        PLANAR.replace('{ x = "-0.4 m" }]', '{ z = "0.4 m" }]'),
        "entry 2 has an unknown key 'z'; known keys: x, y",
    ),
    "positions as numbers": (
        PLANAR.replace(TWO, "[[0.4, 0]]"),
        "drives.two.positions",
        "list of tables",
    ),
    "a table instead of a list": (
        SPHERE.replace("[tasks.turn]", "[drives.ball.rollers]\nx = 1\n[tasks.turn]"),
        "drives.ball.rollers",
        "must be a list of tables, such as [{ x = ... }, ...]",
    ),
    "another key of a roller": (
        SPHERE.replace('layout = "cubic"', ROLLERS.replace("axle_y", "axis_y")),
        "entry 1 has an unknown key 'axis_y' (did you mean 'axle_y'?); known keys: x, y, z, axle_x",
    ),
    "layout beside rollers": (
        SPHERE.replace('layout = "cubic"', f'layout = "cubic"\n{ROLLERS}'),
        "drives.ball.layout and rollers exclude each other",
    ),
    "idler without a place": (
        SPHERE.replace('"cubic"', '"tetrahedral"') + '[drives.ball.idler]\nwheel_radius = "20 mm"\npreload = "400 N"\n'
        'friction = 0.1\ncreep_stiffness = "20 kN"\nrolling_torque = "1 mN m"\nbearing_torque = "1 mN m"\n',
        "drives.ball.idler does not apply",
    ),
    "mass that only turns": (
        SPHERE
        + '[paths.nod]\nload_mass = "1 kg"\nangle = { shape = "sinusoid", angle = "5 deg", frequency = "1 Hz" }\n',
        "paths.nod.load_mass does not apply: drives.ball has angle only",
    ),
    "sphere at rest": (SPHERE.replace('"40 rad/s"', '"0 rad/s"'), "drives.ball.input_speed", "!= 0 rad/s"),
    "unknown layout": (SPHERE.replace('"cubic"', '"octahedral"'), "drives.ball.layout", "tetrahedral, cubic"),
    "roller on a third shaft": (
        SPHERE.replace('layout = "cubic"', ROLLERS.replace("shaft = 2", "shaft = 3")),
        "drives.ball.rollers",
        "entry 2, shaft = 3",
    ),
    "rollers in one plane": (
        SPHERE.replace(
            'layout = "cubic"',
            ROLLERS.replace("z = 1.4142135623730951", "z = 0").replace("z = -1.4142135623730951", "z = 0"),
        ),
        "drives.ball.rollers",
    ),
    "axle through the sphere": (
        SPHERE.replace('layout = "cubic"', ROLLERS.replace("axle_y = -1", "axle_x = -1")),
        "drives.ball.rollers",
        "right angle",
    ),
    "speed without an angle": (SPHERE.replace('"30 rad/s"', '"30 1/s"'), "tasks.turn.twist.angle"),
    "tasks as text": (
        SPHERE.partition("[tasks.turn]")[0].replace('title = "Joint"', 'tasks = "lift"'),
        "tasks",
        "[tasks.NAME]",
    ),
    "a task as number": (
        SPHERE.replace("[tasks.back]", "[tasks]\nmore = 3\n[tasks.back]"),
        "tasks.more",
        "[tasks.more]",
    ),
    "neither tasks nor requirement": (SPHERE.partition("[tasks.turn]")[0], "requirement is missing", "[tasks.NAME]"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_malformed_machine_has_one_clear_message(case, load):
    text, *words = BAD[case]
    tomllib.loads(text)
    with pytest.raises(iv.InputError) as found:
        check(load(text))
    for word in words:
        assert word in str(found.value)
    assert "nan" not in str(found.value)
    assert len(str(found.value).split("\n")) <= 6
