"""Results that state units, dimensions and meaning of their fields: dictionary, data set, table and NetCDF follow."""

import dataclasses
import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pytest
from scipy.io import netcdf_file

from infinivar import Limit, Result
from internals import (
    LINEAR,
    PLANE,
    ROTARY,
    Axis,
    Frozen,
    Labels,
    at,
    codes,
    dictionary,
    finite,
    force_axis,
    is_labelled,
    named,
    plain,
    reported,
    result,
    rows,
    speed_axis,
    suffix,
    unit_of,
)
from internals import described_derived as derived
from internals import labelled_arrays as arrays


class Corner(NamedTuple):
    """A point and its limit."""

    limit: Limit
    margin: float


@result
class Lap(Frozen):
    """Part of a result."""

    time: float = reported("s")
    laps: int = reported()


@dataclasses.dataclass
class Bare:
    """A dataclass that states nothing."""

    name: str
    corner: Corner


@result
class Told(Result):
    """Result with one field of each form."""

    name: str = reported(key="drive")
    mean_loss: float = reported("W")
    rate: float = reported("rad s-1")
    share: float = reported("1")
    corner: Corner = reported()
    lap: Lap = reported(key="*")
    laps: tuple[Lap, ...] = reported(key="all_laps", table="time_s")
    demands: Mapping[tuple[Limit, str], float] = reported("1")
    counts: Mapping[tuple[str, Limit], int] = reported(convert=rows("task", "limit", "number"))
    history: np.ndarray = reported("N", convert=finite)
    bare: Bare | None = reported(optional=True, default=None)
    notes: tuple[str, ...] = reported(optional=True, default=())
    hidden: str = "not shown"

    _also = (at("bare.corner.margin", key="margin"), at("lap", key="lap_seconds", convert=lambda lap: lap.time))

    @derived("J")
    def energy(self) -> float:
        """Twice the loss. [J]"""
        return 2.0 * self.mean_loss

    @derived(key="*")
    def _powers(self) -> dict[str, float]:
        return {"least_W": 1.0, "largest_W": 2.0}


def sample_run(**fields):
    usual = {
        "name": "one",
        "mean_loss": 3.0,
        "rate": 4.0,
        "share": 0.5,
        "corner": Corner(Limit.SLIP, 0.5),
        "lap": Lap(time=2.0, laps=1),
        "laps": (Lap(time=2.0, laps=1), Lap(time=3.0, laps=2)),
        "demands": {(Limit.THERMAL, "motor"): 0.7},
        "counts": {("walk", Limit.GEAR): 4},
        "history": np.array([1.0, np.nan, np.inf]),
        "bare": Bare("two", Corner(Limit.OK, 9.0)),
    }
    return Told(**{**usual, **fields})


def test_the_dictionary_follows_from_the_fields():
    assert sample_run().to_dict() == {
        "drive": "one",
        "mean_loss_W": 3.0,
        "rate_rad_s": 4.0,
        "share": 0.5,
        "corner": {"limit": "SLIP", "margin": 0.5},
        "time_s": 2.0,
        "laps": 1,
        "all_laps": [{"time_s": 2.0, "laps": 1}, {"time_s": 3.0, "laps": 2}],
        "demands": {"THERMAL (motor)": 0.7},
        "counts": [{"task": "walk", "limit": "GEAR", "number": 4}],
        "history_N": [1.0, None, None],
        "bare": {"name": "two", "corner": {"limit": "OK", "margin": 9.0}},
        "energy_J": 6.0,
        "least_W": 1.0,
        "largest_W": 2.0,
        "margin": 9.0,
        "lap_seconds": 2.0,
    }
    assert sample_run(notes=("a",)).to_dict()["notes"] == ["a"]


def test_a_table_of_rows_follows_from_the_fields():
    pytest.importorskip("pandas")
    made = sample_run().to_dataframe()
    assert made.index.name == "time_s"
    assert made.index.tolist() == [2.0, 3.0]
    assert made["laps"].tolist() == [1, 2]
    assert sample_run().to_xarray()["laps"].dims == ("time_s",)


def test_properties_that_take_part_are_properties():
    assert isinstance(Told.energy, property)
    assert Told.energy.__doc__ == "Twice the loss. [J]"
    assert sample_run().energy == 6.0


@result
class Plane(Result):
    """Map with everything that a data set has."""

    speed: np.ndarray = speed_axis()
    force: np.ndarray = force_axis()
    loss: np.ndarray = reported("W", "lost", PLANE)
    losses: Mapping[str, np.ndarray] = reported("W", "power lost in {}", PLANE, variable="loss_{}")
    shares: Mapping[Limit, np.ndarray] = reported("1", "share limited by {}", PLANE, variable="limit_{}")
    states: Mapping[str, np.ndarray] = reported(dims=PLANE)
    limit: np.ndarray = reported("1", "limit exceeded", PLANE, notes=codes)
    heating: np.ndarray = reported("m/s^2 or rad/s^2", dims=PLANE, variable="+")
    total: float = reported("1", dims=(), key="+")
    missing: np.ndarray | None = reported("1", dims=PLANE, default=None)
    title: str = reported(attribute="title")
    axis: Axis = LINEAR
    labels: Labels | None = None

    @derived(dims=("part",), convert=list)
    def _part(self) -> tuple[str, str]:
        return ("a", "b")

    @derived(key="", attribute="each")
    def _attributes(self) -> dict[str, float]:
        return {"mean_W": 1.0}


def plane(**fields):
    grid = np.ones((2, 3))
    usual = {
        "speed": np.arange(2.0),
        "force": np.arange(3.0),
        "loss": grid,
        "losses": {"motor friction": grid},
        "shares": {Limit.GEAR: grid},
        "states": {"motor_torque_Nm": grid},
        "limit": np.zeros((2, 3), np.int8),
        "heating": grid,
        "total": 5.0,
        "title": "a map",
    }
    return Plane(**{**usual, **fields})


def test_the_data_set_follows_from_the_fields():
    made = arrays(plane())
    assert {name: dims for name, (dims, _, _) in made.data.items()} == {
        "total": (),
        **dict.fromkeys(
            ("loss", "loss_motor_friction", "limit_gear", "motor_torque_Nm", "limit", "heating_m_s2"), PLANE
        ),
    }
    assert made.data["loss_motor_friction"][2] == {"units": "W", "long_name": "power lost in motor friction"}
    assert made.data["limit_gear"][2]["long_name"] == "share limited by gearhead continuous torque"
    assert made.data["motor_torque_Nm"][2] == {"units": "N m"}
    assert made.data["limit"][2]["flag_meanings"].startswith("OK SLIP")
    assert made.coordinates["speed"][2] == {"units": "m s-1", "long_name": "speed of the load"}
    assert made.coordinates["part"] == ["a", "b"]
    assert made.attributes == {"title": "a map", "mean_W": 1.0}
    assert plane().to_dict() == {"title": "a map", "total": 5.0}


def test_units_follow_the_axis():
    made = arrays(plane(axis=ROTARY))
    assert made.coordinates["speed"][2] == {"units": "rad s-1", "long_name": "angular speed of the load"}
    assert made.coordinates["force"][2] == {"units": "N m", "long_name": "moment on the load"}
    assert made.data["heating_rad_s2"][2] == {"units": "rad/s^2"}


def test_labels_of_inputs_name_the_axes():
    labels = Labels(dims=("v", "f"), coords={"v": (("v",), np.arange(2.0), {"units": "m/s"})})
    made = arrays(plane(labels=labels))
    assert made.data["loss"][0] == ("v", "f")
    assert set(made.coordinates) == {"v", "force", "part"}
    assert made.coordinates["force"][0] == ("f",)


def test_the_netcdf_file_holds_the_data_set(tmp_path):
    plane().to_netcdf(tmp_path / "plane.nc")
    with netcdf_file(tmp_path / "plane.nc", mmap=False) as read:
        assert read.variables["loss"].units == b"W"
        assert read.variables["loss"].dimensions == PLANE
        assert read.title == b"a map"


@result
class Point(Result):
    """Arrays that broadcast."""

    one: float = reported("W", dims=(...,))
    other: np.ndarray = reported("N", dims=(...,))


@result
class Instants(Result):
    """The same with a name for the last axis, and columns over time."""

    one: np.ndarray = reported("W", dims=(..., "instant"))


@result
class Course(Result):
    """Columns whose names end in their unit."""

    columns: Mapping[str, np.ndarray] = reported(dims=("time",))


@result
class Around(Result):
    """A result with another one's data set."""

    course: Course

    _also = (at("course", dims=(), variable="*"),)


def test_arrays_that_broadcast_get_numbered_axes():
    made = arrays(Point(one=1.0, other=np.ones((2, 3))))
    assert made.data["one"][0] == made.data["other"][0] == ("axis_0", "axis_1")
    assert made.data["one"][1].shape == (2, 3)
    assert arrays(Instants(one=np.ones((2, 3)))).data["one"][0] == ("axis_0", "instant")
    assert arrays(Instants(one=np.array(1.0))).data["one"][0] == ()


def test_columns_over_time_have_their_units_in_their_names():
    made = arrays(Course(columns={"time_s": np.arange(3.0), "speed_m_s": np.ones(3)}))
    assert made.coordinates["time"][2] == {"units": "s"}
    assert made.data["speed_m_s"][2] == {"units": "m/s"}
    assert arrays(Around(course=Course(columns={"speed_m_s": np.ones(3)}))).data.keys() == {"speed_m_s"}


def test_what_states_nothing_says_so(tmp_path):
    assert not is_labelled(Lap)
    with pytest.raises(TypeError, match="there is no dictionary of Point"):
        Point(one=1.0, other=np.ones(2)).to_dict()
    with pytest.raises(TypeError, match="there is no data set of Told: its fields state no dimensions"):
        sample_run().to_netcdf(tmp_path / "run.nc")
    assert dictionary(Bare("x", Corner(Limit.OK, 1.0))) == {"name": "x", "corner": {"limit": "OK", "margin": 1.0}}


@pytest.mark.parametrize(
    ("unit", "ending"),
    [
        ("", ""),
        ("1", ""),
        ("W", "_W"),
        ("N m", "_Nm"),
        ("rad/s", "_rad_s"),
        ("m s-1", "_m_s"),
        ("m s-1 N-1", "_m_s_N"),
        ("N s/m", "_Ns_m"),
        ("J/kg", "_J_kg"),
        ("W h", "_Wh"),
        ("m/s^2", "_m_s2"),
    ],
)
def test_names_end_in_their_unit(unit, ending):
    assert suffix(unit) == ending


def test_units_are_read_from_names():
    assert [unit_of(name) for name in ("a_m_s", "a_rad_s", "a_rad", "a_Nm", "a_m", "share")] == [
        "m/s",
        "rad/s",
        "rad",
        "N m",
        "m",
        "1",
    ]


def test_plain_values_have_types_of_python():
    found = plain({"a": np.float64(1.0), 2: (np.int64(3), Limit.GEAR), Limit.SLIP: [None, "b", True]})
    assert found == {"a": 1.0, "2": [3, "GEAR"], "SLIP": [None, "b", True]}
    assert type(found["a"]) is float
    assert type(found["2"][0]) is int
    assert finite({"a": math.inf, "b": [1.0, math.nan]}) == {"a": None, "b": [1.0, None]}
    assert finite(np.float64(2.0)) == 2.0
    assert named(None) is None
