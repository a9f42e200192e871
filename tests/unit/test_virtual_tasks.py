"""Tasks of virtual constraints: as values, as tables of study files, and messages."""

import math
import pickle
import tomllib

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
import reference_meshes
from infinivar.motion import (
    AboutAxis,
    AlongLine,
    ArcCurve,
    Ball,
    Caster,
    Coasting,
    Fixture,
    HalfSpace,
    HoldingTask,
    LineCurve,
    OnSurface,
    PointCurve,
    TriangleMesh,
    Tube,
    VirtualPath,
    VirtualWall,
)
from internals import VIRTUAL_TASKS as TASKS
from internals import ByRows, FlatWalls, MeshFile, StudyError, annotated
from internals import FixtureRow as Row
from internals import built_from_study as built

LINE, FLOOR = LineCurve(start=(0.0, 0.0), end=(1.0, 0.0)), HalfSpace(point=(0.0, 0.0), direction=(0.0, 1.0))


def read(text):
    """A task as the study loader builds it from its table."""
    table = tomllib.loads(text)
    word = table.pop("type")
    return built(TASKS[word], annotated(table, "tasks.mine", "mine"), "tasks.mine", "mine", [])


def test_every_kind_has_a_word():
    assert {word: kind.__name__ for word, kind in TASKS.items()} == {
        "path": "VirtualPath",
        "wall": "VirtualWall",
        "fixture": "Fixture",
        "caster": "Caster",
        "coast": "Coasting",
        "hold": "HoldingTask",
    }


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            'type = "path"\nsettling_length = "50 mm"\n'
            '[curve]\nshape = "points"\nx = ["0 mm", "10 mm", "2 cm"]\ny = ["0 mm", "1 mm", "0 mm"]',
            VirtualPath(curve=PointCurve(x=(0.0, 0.01, 0.02), y=(0.0, 0.001, 0.0)), settling_length=0.05),
        ),
        (
            'type = "path"\nends = "free"\n'
            '[curve]\nshape = "points"\nclosed = true\n'
            'x = { value = [0, 10, 0], unit = "mm" }\ny = { value = [0, 0, 10], unit = "mm" }',
            VirtualPath(curve=PointCurve(x=(0.0, 0.01, 0.0), y=(0.0, 0.0, 0.01), closed=True), ends="free"),
        ),
        (
            'type = "path"\ncurve = { shape = "line", start = ["0 m", "0 m"], end = ["1 m", "0 m"] }',
            VirtualPath(curve=LINE),
        ),
        (
            'type = "path"\ncurve = { shape = "arc", centre = ["0 m", "0 m"], radius = "10 cm", turn = "-90 deg" }',
            VirtualPath(curve=ArcCurve(centre=(0.0, 0.0), radius=0.1, turn=-math.pi / 2)),
        ),
        (
            'type = "wall"\nsides = "two"\nstiffness = "20 N/mm"\ndamping = "5 N s/m"\n'
            'surface = { shape = "half-space", point = ["0 m", "0 m"], direction = [0, 1] }',
            VirtualWall(surface=FLOOR, sides="two", stiffness=20e3, damping=5.0),
        ),
        (
            'type = "wall"\nsurface = { shape = "ball", centre = ["1 m", "2 m", "3 m"], radius = "5 cm", free = "inside" }',
            VirtualWall(surface=Ball(centre=(1.0, 2.0, 3.0), radius=0.05, free="inside")),
        ),
        (
            'type = "wall"\nsurface = { shape = "tube", point = ["0 m", "0 m", "0 m"], axis = [0, 0, 1], radius = "5 cm" }',
            VirtualWall(surface=Tube(point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), radius=0.05)),
        ),
        (
            'type = "wall"\n[surface]\nshape = "flat walls"\nfree = "any"\n'
            'walls = [{ point = ["0 m", "0 m"], direction = [0, 1] }, { point = ["1 m", "0 m"], direction = [1, 0] }]',
            VirtualWall(
                surface=FlatWalls(walls=(FLOOR, HalfSpace(point=(1.0, 0.0), direction=(1.0, 0.0))), free="any")
            ),
        ),
        (
            'type = "fixture"\nallowed = { shape = "line", direction = [1, 0], turning = true }',
            Fixture(allowed=AlongLine(direction=(1.0, 0.0), turning=True)),
        ),
        (
            'type = "fixture"\nallowed = { shape = "axis", point = ["0 m", "0 m", "1 m"], axis = [1, 0, 0], pitch = "2 mm" }',
            Fixture(allowed=AboutAxis(point=(0.0, 0.0, 1.0), axis=(1.0, 0.0, 0.0), pitch=0.002)),
        ),
        (
            'type = "fixture"\nallowed = { shape = "rows", constraints = [{ x = 1, rz = "10 mm" }] }',
            Fixture(allowed=ByRows(constraints=(Row(x=1.0, rz=0.01),))),
        ),
        ('type = "caster"\ntitle = "free"\nmass = "2 kg"', Caster(title="free", mass=2.0)),
        ('type = "coast"', Coasting()),
        ('type = "hold"\nstop_cylinder = true', HoldingTask(stop_cylinder=True)),
    ],
)
def test_tables_of_studies(text, expected):
    made = read(text)
    assert made == expected
    assert hash(made) == hash(expected)
    assert pickle.loads(pickle.dumps(made)) == made
    assert repr(made).count("\n") == 0


def test_rows_of_a_table():
    made = read('type = "fixture"\nallowed = { shape = "rows", constraints = [{ x = 1, rz = "10 mm" }, { y = 1 }] }')
    assert_allclose(made.allowed.rows(("x", "y", "angle")).rows, [[1.0, 0.0, 0.01], [0.0, 1.0, 0.0]])


def test_a_mesh_in_a_table(tmp_path):
    trimesh = pytest.importorskip("trimesh", reason="the extra infinivar[robots] has it")
    file = tmp_path / "block.stl"
    trimesh.Trimesh(*reference_meshes.box((10.0, 20.0, 30.0)), process=False).export(file)
    made = read(f'type = "wall"\nsurface = {{ shape = "mesh", file = "{file}", unit = "mm" }}')
    assert made.surface == MeshFile(file=str(file), unit="mm")
    assert made.surface.distance([0.02, 0.0, 0.0]) == pytest.approx(0.01)
    file.unlink()
    with pytest.raises(StudyError, match=r"tasks.mine.surface: .*block.stl: no such file"):
        read(f'type = "wall"\nsurface = {{ shape = "mesh", file = "{file}", unit = "mm" }}')


def test_what_only_python_states():
    """Meshes by their triangles, and fixtures on surfaces and curves."""
    vertices, faces = reference_meshes.box()
    wall = VirtualWall(surface=TriangleMesh(vertices=vertices, faces=faces))
    assert wall.surface.distance(np.zeros(3)) == -1.0
    assert Fixture(allowed=OnSurface(surface=FLOOR)).allowed.freedoms(("x", "y")) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('type = "path"\ncurve = 3', r"tasks.mine.curve = 3 must be a table \[tasks.mine.curve\]"),
        ('type = "path"\ncurve = { shape = "pionts", x = ["0 m"], y = ["0 m"] }', "did you mean 'points'"),
        ('type = "path"\ncurve = { shape = "points", x = ["0 m", "1 m"] }', "tasks.mine.curve.y is missing"),
        (
            'type = "path"\ncurve = { shape = "points", x = ["0 m", "1 m", "2 m", "2 m", "2 m"], '
            'y = ["0 m", "0 m", "0 m", "1 m", "2 m"] }',
            "tasks.mine.curve.points must lie on a smooth curve, got a kink of 90 degrees at point 3",
        ),
        (
            'type = "path"\ncurve = { shape = "points", x = ["0 m", "far"], y = ["0 m", "1 m"] }',
            "tasks.mine.curve.x.* entry 2",
        ),
        (
            'type = "path"\ncurve = { shape = "line", start = ["0 m", "0 m"], end = ["1 s", "0 m"] }',
            "has the unit 's' where m is needed",
        ),
        (
            'type = "path"\ncurve = { shape = "arc", centre = ["0 m", "0 m"], radius = "0 m" }',
            "must be >= 1e-09 and <= 1e.09 m",
        ),
        (
            'type = "path"\nends = "open"\ncurve = { shape = "line", start = ["0 m", "0 m"], end = ["1 m", "0 m"] }',
            "one of stop, free",
        ),
        (
            'type = "wall"\nsurface = { shape = "half-space", point = ["0 m", "0 m"], direction = [0, 0] }',
            "direction, not zero",
        ),
        ('type = "wall"\nsurface = { shape = "cube" }', "must be one of half-space, ball, tube, flat walls, mesh"),
        ('type = "wall"\nsurface = { shape = "mesh", file = "hand.stl" }', "tasks.mine.surface.unit is missing"),
        (
            'type = "wall"\nstiffness = "0 N/m"\nsurface = { shape = "ball", centre = ["0 m", "0 m"], radius = "1 m" }',
            "must be > 0 N/m",
        ),
        (
            'type = "fixture"\nallowed = { shape = "line", direction = [1, 0], pitch = "1 mm" }',
            "pitch does not apply with shape = 'line'",
        ),
        ('type = "fixture"\nallowed = { shape = "rows", constraints = [{ x = 0 }] }', "row must be a constraint"),
        (
            'type = "fixture"\nallowed = { shape = "plane", normal = [0, 0, 1], turning = "al" }',
            "must be one of none, normal, any",
        ),
        ('type = "caster"\nmass = "0 kg"', 'tasks.mine.mass = "0 kg" must be > 0 kg'),
        ('type = "caster"\nmas = "1 kg"', "did you mean 'mass'"),
        ('type = "coast"\nspeed = "1 m/s"', 'tasks.mine.speed = "1 m/s" is not a known key'),
        ('type = "hold"\nstop_cylinder = "no"', "must be true or false"),
    ],
)
def test_one_clear_message_from_a_table(text, message):
    with pytest.raises(StudyError, match=message) as caught:
        read(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: VirtualPath(curve=FLOOR), "curve must be a curve, such as a PointCurve or an ArcCurve, got HalfSpace"),
        (lambda: VirtualPath(curve=LINE, settling_length=0.0), "settling_length must be > 0 m, got 0"),
        (lambda: VirtualPath(curve=LINE, ends="open"), "ends must be one of stop, free, got 'open'"),
        (lambda: VirtualPath(curve=LINE, title=3), "title must be text, got 3"),
        (lambda: VirtualWall(surface=LINE), "surface must be a surface, such as a HalfSpace"),
        (lambda: VirtualWall(surface=FLOOR, sides="both"), "sides must be one of one, two, got 'both'"),
        (lambda: VirtualWall(surface=FLOOR, stiffness=math.nan), "stiffness must be > 0 N/m, got nan"),
        (lambda: VirtualWall(surface=FLOOR, damping=-1.0), "damping must be >= 0 N s/m, got -1"),
        (lambda: Fixture(allowed="line"), "allowed must be what is allowed to move, such as AlongLine"),
        (lambda: Caster(mass=0.0), "mass must be > 0 kg, got 0"),
        (lambda: Caster(inertia=-1.0), r"inertia must be > 0 kg m\^2, got -1"),
        (lambda: Caster(mass="2 kg"), "mass must be a real number"),
        (lambda: HoldingTask(stop_cylinder=1), "stop_cylinder must be true or false, got 1"),
    ],
)
def test_one_clear_message(make, message):
    with pytest.raises(iv.InputError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_a_fixture_of_an_own_kind_serves_every_machine():
    class Own:
        def rows(self, coordinates, position=(0.0, 0.0, 0.0), twist=None):
            return iv.motion.AlongLine(point=(0.0, 0.0, 0.0), direction=(1.0, 0.0, 0.0)).rows(
                coordinates, position, twist
            )

    own = Own()
    assert iv.motion.Fixture(allowed=own).allowed is own
    with pytest.raises(iv.ParameterError, match="allowed must be what is allowed to move"):
        iv.motion.Fixture(allowed=3)
