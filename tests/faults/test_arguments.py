"""Wrong arguments of Python calls: one message that names the argument, or a point that names its limit."""

import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from faults.rows import sections
from infinivar.contact import creep
from made import loaded

MEASURED = {
    "wheel_radius": 0.03,
    "preload": 200.0,
    "friction": 0.2,
    "creep_stiffness": 4000.0,
    "rolling_torque": 0.009,
    "bearing_torque": 0.006,
}
WHEEL = iv.transmission.RollingContact(**MEASURED)
BALL = iv.transmission.RollingContact(**MEASURED, surface="sphere")
WITH_FLOW_LOSS = replace(WHEEL, creep_law="faulring")
STUDY = loaded("hand_controller")
LEG, SEPARATE = STUDY.drives["cobotic"], STUDY.drives["motor2-gear4"]
DRIVE, PLATFORM = iv.machines.LeggedDrive.of(LEG, 6), iv.transmission.Platform.hexapod()
PAIR = iv.machines.LeggedDrive.of(LEG, 2)
HOME = PLATFORM.at([0.0, 0.0, PLATFORM.home])
POINTS = ((0.4, 0.0), (-0.2, 0.25), (-0.2, -0.25))
CART = iv.transmission.PlanarCobot(contacts=WHEEL, positions=POINTS, mass=20.0, inertia=1.5)
MACHINE = CART.mechanism
SPHERE = iv.SphericalIVT(sphere_radius=0.03, drive=BALL)
ARM = iv.transmission.PlanarArm(lengths=(0.3, 0.25))
ROOT = math.sqrt(0.5)
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
FIRST, SECOND = (
    iv.transmission.Roller(position=X, axis=(0, -1, 0), shaft=1),
    iv.transmission.Roller(position=Y, axis=(-1, 0, 0), shaft=2),
)
STEERED = (iv.transmission.Roller(position=(-0.5, -0.5, ROOT)), iv.transmission.Roller(position=(-0.5, -0.5, -ROOT)))
AHEAD = [0.0, 0.0, 0.0]


def cobot(**changed):
    return iv.transmission.PlanarCobot(**{"contacts": WHEEL, "positions": POINTS} | changed)


def sphere(**changed):
    return iv.SphericalIVT(**{"sphere_radius": 0.03, "drive": BALL} | changed)


def platform(**changed):
    return iv.transmission.Platform(**{"base": PLATFORM.base, "joints": PLATFORM.joints, "rod_length": 0.14} | changed)


def machine(**changed):
    return iv.transmission.Mechanism(**{"contacts": WHEEL, "jacobian": np.ones((1, 2, 2))} | changed)


def links(jacobian, **more):
    return iv.transmission.Configuration(jacobian=jacobian, **more)


def solve(rates, heading=AHEAD, **applied):
    return MACHINE.solve(heading=heading, rates=rates, applied={"y": 0.0, "angle": 0.0} | applied)


def share(**changed):
    return iv.analysis.share_motor(LEG, SEPARATE, **{"force": [1.0]} | changed)


def common(motions=1, **changed):
    given = {"wrench": np.zeros((motions, 6)), "twist": np.full((motions, 6), 0.01)} | changed
    return iv.analysis.best_cylinder_speed(given.pop("drive", DRIVE), given.pop("configuration", HOME), **given)


def static(**changed):
    given = {"position": [0.0, 0.0, 0.1], "wrench": np.zeros(6)} | changed
    return iv.analysis.static_points(given.pop("drive", DRIVE), given.pop("platform", PLATFORM), **given)


def mapped(**changed):
    return iv.analysis.workspace_map(
        DRIVE, PLATFORM, **{"x": [0.0], "y": [0.0], "z": [0.1], "wrench": np.zeros(6)} | changed
    )


SINGULAR = platform(joints=np.zeros((6, 3))).at([0.0, 0.0, 0.1])
ACROSS = 0.5 * math.pi * np.ones(3)
HOLD = iv.motion.Hold(time=1.0)


def waypoints(time, position=(0.0, 0.01)):
    return iv.motion.Waypoints(file="way", time=time, position=position)


def law(**changed):
    values = {name: getattr(creep.LINEAR, name) for name in ("creepage", "slope", "force", "slip_creepage")}
    return creep.CreepLaw(**{"name": "mine", **values, **changed})


CALLS = sections("arguments")
LIMITS = CALLS.pop("limits")


@pytest.mark.parametrize(
    ("error", "call", "said"),
    [pytest.param(error, *row, id=row[0]) for error, table in CALLS.items() for row in table.items()],
)
def test_the_message_names_the_argument(error, call, said):
    with pytest.raises(getattr(iv, error)) as caught:
        eval(call)
    message = str(caught.value)
    assert message.startswith(said[:-1]) if said.endswith("…") else message == said


@pytest.mark.parametrize(("limit", "call"), LIMITS.values(), ids=LIMITS)
def test_infeasible_points_name_their_limit(limit, call):
    assert np.all(np.asarray(eval(call).limit) == iv.Limit[limit])


def test_infeasible_forces_of_a_shared_motor_name_their_limit():
    found = share(force=[10.0, 1e5], legs=(1, 6))
    assert np.all(found.turning_limit == [[iv.Limit.OK, iv.Limit.SLIP]] * 2)
    assert found.separate_limit[0] == iv.Limit.OK != found.separate_limit[1]
    assert np.all(np.isfinite(found.turning[..., 0]))
    assert np.array_equal(found.turning_feasible, found.turning_limit == iv.Limit.OK)
    assert np.array_equal(found.separate_feasible, [True, False])
