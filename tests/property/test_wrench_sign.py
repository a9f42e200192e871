"""One sign: a wrench is what a machine exerts on its load, so that wrench times twist is the power to the load."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from internals import System, as_machine
from machines import MACHINES, REAL_WHEEL
from made import loaded

POINTS = 400
SIZES = {"axis": (0.2, 20.0), "planar": (0.3, 10.0), "sphere": (10.0, 0.03), "platform": (0.1, 10.0), "arm": (0.1, 3.0)}
SIZES["omniwheels"] = (0.2, 10.0)
"""Speeds and forces within the limits of the machines below."""


def every_kind():
    """A machine of each kind, with legs and with motors of its own where it has either."""
    found = {f"axis {name}": as_machine(loaded("hand_controller").drives[name]) for name in ("cobotic", "motor2-gear4")}
    for study in (
        "planar_cart",
        "sphere_joint",
        "six_leg_display",
        "two_joint_arm",
        "omniwheel_platform",
        "driven_cart",
    ):
        found |= {
            f"{drive.WORD} {name}": drive for name, drive in loaded(study).drives.items() if hasattr(drive, "WORD")
        }
    return found


KINDS = every_kind()


def drawn(seed, freedoms, speed, force, count=POINTS):
    """Twists and wrenches of both signs; each pair of signs of the first components is among them."""
    random = np.random.default_rng(seed)
    twist, wrench = (size * random.uniform(-1, 1, (count, freedoms)) for size in (speed, force))
    signs = {tuple(one) for one in np.sign(np.stack([twist[:, 0], wrench[:, 0]], -1)).astype(int)}
    assert signs == {(1, 1), (1, -1), (-1, 1), (-1, -1)}
    return twist, wrench


def check(power_in, power_out, losses, twist, wrench):
    """Power to the load is wrench times twist, and power in exceeds it by losses that are none of them negative."""
    known = np.isfinite(power_in)
    assert known.mean() > 0.5
    to_load = np.sum(wrench * twist, axis=-1)
    scale = np.abs(to_load).max()
    assert_allclose(power_out[known], to_load[known], rtol=0, atol=1e-9 * scale)
    lost = sum(np.broadcast_to(loss, known.shape) for loss in losses.values())
    assert_allclose((power_in - to_load)[known], lost[known], rtol=0, atol=1e-9 * scale)
    assert all(np.all(np.broadcast_to(loss, known.shape)[known] >= -1e-9 * scale) for loss in losses.values())


def test_every_kind_is_among_them():
    assert {name.split()[0] for name in KINDS} == set(SIZES)


@pytest.mark.parametrize("name", KINDS)
def test_power_to_the_load_of_every_kind_of_machine(name):
    machine, (speed, force) = KINDS[name], SIZES[name.split()[0]]
    count = 40 if name.startswith("sphere") else POINTS
    twist, wrench = drawn(1, len(machine.coordinates), speed, force, count)
    if "rz" in machine.coordinates:
        wrench[:, 3:] *= 0.02
    pose = np.broadcast_to(np.array(machine.home, dtype=float), twist.shape)
    point = machine.perform(pose=pose, twist=twist, wrench=wrench)
    check(point.power_in, point.power_out, point.losses, twist, wrench)


def test_power_to_the_load_of_legged_drives():
    machine, platform = (
        iv.machines.LeggedDrive.of(loaded("hand_controller").drives["cobotic"], 6),
        iv.transmission.Platform.hexapod(),
    )
    place = platform.at([0.01, 0.0, platform.home], [0.0, 0.05, 0.0])
    twist, wrench = drawn(2, 6, 0.1, 10.0)
    wrench[:, 3:] *= 0.02
    point = machine.operate(place, wrench=wrench, twist=twist)
    check(point.power_in, point.power_out, point.losses, twist, wrench)
    legs = point.legs
    check(legs.power_in, legs.power_out, legs.losses, twist, wrench)
    of_links = np.sum(place.link_forces(wrench) * place.link_speeds(twist), axis=-1)
    assert_allclose(of_links, np.sum(wrench * twist, axis=-1), rtol=0, atol=1e-12)
    locked = machine.operate(place, wrench=0.1 * wrench).legs
    assert np.all(locked.power_out[locked.limit == iv.Limit.OK] <= 0.0)  # a machine without power yields to its load


@pytest.mark.parametrize("spin", [False, True])
def test_power_to_all_that_is_connected_to_a_mechanism(spin):
    """The forces of the contacts times the rates are minus the losses; prescribed forces are met with that sign."""
    random = np.random.default_rng(3)
    rows = random.normal(size=(4, 3)) if spin else None
    mechanism = iv.transmission.Mechanism(contacts=REAL_WHEEL, jacobian=random.normal(size=(4, 2, 3)), spin=rows)
    rates, wrench = drawn(4, 3, 0.5, 10.0)
    heading = mechanism.steer(rates=rates, applied={"q1": wrench[:, 0], "q2": wrench[:, 1]})
    found = np.isfinite(heading[0][:, 0])
    assert found.mean() > 0.3  # the others slip
    heading = tuple(part[found] for part in heading)
    turned = mechanism.operate(rates=rates[found], heading=heading, steering_rate=random.normal(size=(found.sum(), 4)))
    assert_allclose(
        np.sum(turned.steering_power, axis=-1) - np.sum(turned.power, axis=-1), sum(turned.losses.values()), rtol=1e-9
    )
    point = mechanism.operate(rates=rates[found], heading=heading)
    assert_allclose(point.applied[:, :2], wrench[found, :2], rtol=0, atol=1e-6)
    assert_allclose(point.power, point.applied * rates[found], rtol=1e-15)
    lost = sum(point.losses.values())
    assert np.all(lost > 0.0)
    assert_allclose(-np.sum(point.power, axis=-1), lost, rtol=1e-9)
    assert_allclose(point.power_in - point.power_out, lost, rtol=1e-9)
    solved = mechanism.solve(
        heading=point.heading,
        rates={"q1": rates[found, 0]},
        applied={"q2": point.applied[:, 1], "q3": point.applied[:, 2]},
    )
    ended = np.isfinite(solved.rates[:, 0])
    assert ended.mean() > 0.9
    assert_allclose(solved.applied[ended], point.applied[ended], rtol=0, atol=1e-5)


@pytest.mark.parametrize("name", MACHINES)
def test_power_of_the_load_in_motion(name):
    """The load gives a machine in motion minus wrench times the rates."""
    machine, random = MACHINES[name][0], np.random.default_rng(5)
    mechanics = machine.mechanics(1e-4)
    wrench = random.normal(size=min(2, len(mechanics.configuration)))
    system = System(mechanics=mechanics, wrench=lambda time: wrench, servo=None)
    first, second, _ = system.places
    rates = 0.1 * random.normal(size=(20, second - first))
    state = np.concatenate([np.tile(machine.home, (20, 1)), rates], axis=-1)
    found = system.rates(system.idle(), np.zeros(20), state).balance()
    power = found.power[:, system.sources.index("user")]
    assert_allclose(power, -np.sum(wrench * rates[:, : len(wrench)], axis=-1), rtol=0, atol=1e-12)
