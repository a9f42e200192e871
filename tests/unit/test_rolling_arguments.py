"""Wrong arguments of the exact solver and of the laws fitted to it: one message that names them; results of changing rolling."""

import pickle

import numpy as np
import pytest

import infinivar as iv
from infinivar import ParameterError
from infinivar.contact import TransientRolling, creep, shakedown
from internals import shipped_study, turning

PATCH = iv.contact.RollingPatch(1.0, cells=8)
NUMBER = "must be a real number or an array of them, got "
SHAPES = {"a_over_b": [1.0, 2.0], "lateral": [0.1, 0.2, 0.3]}


def measured():
    """The shipped wheel with measured losses in place of its geometry."""
    given = {"creep_stiffness": 3e4, "rolling_torque": 4e-4, "bearing_torque": 2e-3}
    return iv.RotaryLinearIVT(cylinder_radius=0.05, wheel_radius=0.01, preload=650.0, friction=0.12, **given)


def deliver(element, speed):
    return turning.deliver(element, cylinder_speed=speed, link_speed=0.1, link_force=1.0, steering_rate=1.0)


CALLS = {
    "cells of a number with a point": (
        lambda: iv.contact.rolling_forces(1.0, lateral=0.1, cells=20.0),
        "cells must be a multiple of 4 from 8 to 60, got 20.0",
    ),
    "text for many": (lambda: iv.contact.rolling_forces(1.0, lateral="x"), f"lateral {NUMBER}'x'"),
    "shapes for many": (
        lambda: iv.contact.rolling_forces(**SHAPES),
        r"a_over_b and lateral must broadcast to one shape, got shapes \(2,\) and \(3,\)",
    ),
    "array for one state": (
        lambda: PATCH.steady(lateral=np.array([0.1, 0.2])),
        "lateral must be one number, got an array",
    ),
    "nan": (lambda: PATCH.steady(spin=np.nan), "spin must be .*, got nan"),
    "start": (lambda: PATCH.steady(start=3), "start must be a SteadyRolling or None, got 3"),
    "start of a path": (
        lambda: PATCH.transient([1.0], start=3),
        "start must be a SteadyRolling, a TransientRolling or None",
    ),
    "patches": (
        lambda: iv.contact.RollingPatch(np.array([1.0, 2.0])),
        "a_over_b must be one number, got an array of shape",
    ),
    "list of patches": (lambda: iv.contact.RollingPatch([1.0, 2.0]), r"a_over_b must be one number, got \[1.0, 2.0\]"),
    "complex": (lambda: iv.contact.RollingPatch(1.0 + 0.1j), r"a_over_b must be one number, got \(1\+0.1j\)"),
    "distance": (lambda: PATCH.transient(distance="x"), f"distance {NUMBER}'x'"),
    "series": (lambda: PATCH.transient([1.0], lateral="x"), f"lateral {NUMBER}'x'"),
    "kept": (lambda: PATCH.transient([1.0], keep=0), "keep must be indices of the 1 distances, got 0"),
    "kept outside": (lambda: PATCH.transient([1.0], keep=[-2]), "keep must be indices of the 1 distances, got -2"),
    "law": (lambda: creep.lateral_force("exact", "a"), f"k {NUMBER}'a'"),
    "inverse law": (lambda: creep.lateral_creep("polach", "b"), f"force_ratio {NUMBER}'b'"),
    "shapes of a law": (
        lambda: creep.lateral_force("exact", [0.1, 0.2, 0.3], np.array([1.0, 2.0])),
        r"k and a_over_b must broadcast to one shape, got shapes \(3,\) and \(2,\)",
    ),
    "measured wheel on the spot": (
        lambda: turning.on_the_spot(measured(), 1.0),
        "geometry is missing: measured values",
    ),
    "measured wheel": (lambda: deliver(measured(), 14.0), "geometry is missing: measured values"),
    "cylinder at rest": (
        lambda: deliver(shipped_study("faulring2006").drives["cobotic"].transmission, [14.0, 0.0]),
        "cylinder_speed must be nonzero rad/s, got 0.0",
    ),
    "negative friction": (
        lambda: shakedown.shakedown_pressure(1e-3, 1e-3, 1e9, -0.1),
        "friction must be >= 0, got -0.1",
    ),
    "unknown friction": (
        lambda: shakedown.shakedown_pressure(1e-3, 1e-3, 1e9, np.nan),
        "friction must be >= 0, got nan",
    ),
}


@pytest.mark.parametrize("call", CALLS)
def test_wrong_argument(call):
    called, said = CALLS[call]
    with pytest.raises(ParameterError, match=said):
        called()


def test_lists_of_shapes_for_a_law():
    shapes = [0.5, 1.0, 2.0]
    forces = creep.lateral_force("exact", 0.1, shapes)
    assert forces.tolist() == [float(creep.lateral_force("exact", 0.1, shape)) for shape in shapes]


@pytest.fixture(scope="module")
def run():
    return PATCH.transient([0.5, 1.0, 1.5], lateral=[0.3, 0.3, -0.3], spin=0.1, keep=[0])


def test_changing_rolling_is_a_result(run):
    """Locked, compared by values, also after pickling, and with what other results have."""
    distance = np.array([0.5, 1.0, 1.5])
    again = PATCH.transient(distance, lateral=[0.3, 0.3, -0.3], spin=0.1, keep=[-3])
    assert run == again == pickle.loads(pickle.dumps(again))
    assert run != PATCH.transient(distance, lateral=0.3, spin=0.1, keep=[0])
    distance[0] = 0.1
    assert again.distance[0] == 0.5
    for name in ("distance", "fy", "traction", "slides"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(run, name)[0] = 0
    assert isinstance(run, TransientRolling)
    assert len(repr(run).splitlines()) <= 10


def test_its_figure_and_tables(run):
    labelled = run.to_xarray()
    assert labelled.kept.values.tolist() == [0.5, 1.5]
    assert labelled.fy.sel(distance=1.0) == run.fy[1]
    assert labelled.traction.shape == (2, 2, 8, 8)
    assert run.to_dataframe().loc[1.5, "dissipated"] == run.dissipated[2]
    above, below = run.plot().axes
    curves = {line.get_label(): line.get_ydata() for ax in (above, below) for line in ax.lines}
    assert curves[r"lateral force over $\mu N$"].tolist() == run.fy.tolist()
    assert r"force along rolling over $\mu N$" not in curves  # none without longitudinal creepage
    assert np.allclose(curves["stored since the start"], run.energy)
