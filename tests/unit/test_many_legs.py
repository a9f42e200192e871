"""A machine of many legs behind one motor: points, maps, the best cylinder speed, and one motor against one a joint."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from infinivar import Limit
from infinivar.machines import LeggedDrive
from infinivar.transmission import Configuration, Platform
from internals import CREEP_LAWS as LAWS
from internals import run_up_energy
from internals import workspaces as workspace
from made import loaded
from sampled import sampled

STUDY = loaded("hand_controller")
LEG, OTHER, SEPARATE = (STUDY.drives[name] for name in ("cobotic", "cobotic-b", "motor2-gear4"))
MACHINE, PLATFORM = LeggedDrive.of(LEG, 6), Platform.hexapod()
HOME = PLATFORM.at([0.0, 0.0, PLATFORM.home])


def poses(count, seed=0):
    random = np.random.default_rng(seed)
    return {
        "position": np.array([0, 0, PLATFORM.home]) + random.uniform(-0.03, 0.03, (count, 3)),
        "rotation": random.uniform(-0.2, 0.2, (count, 3)),
        "wrench": random.normal(size=(count, 6)) * [15, 15, 30, 0.5, 0.5, 0.5],
        "twist": random.normal(size=(count, 6)) * [0.1, 0.1, 0.1, 1, 1, 1],
    }


# Points


def test_machine_of_one_leg_is_the_cobotic_drive():
    speed, force = np.meshgrid(np.linspace(-0.4, 0.4, 9), np.linspace(-70, 70, 8))
    known = LEG.operate(speed=speed, force=force)
    point = LeggedDrive.of(LEG, 1).operate(
        Configuration(jacobian=[[1.0]]), wrench=force[..., None], twist=speed[..., None]
    )
    assert_array_equal(point.power_in, known.power_in)
    assert_array_equal(point.limit, known.limit)
    slips = known.limit == Limit.SLIP
    assert_array_equal(np.isnan(point.power_out), slips)
    assert_allclose(point.power_out[~slips], known.power_out[~slips], rtol=0, atol=1e-12)
    for name, loss in known.losses.items():
        assert_array_equal(
            np.broadcast_to(point.losses[name], speed.shape) + 0.0, np.broadcast_to(loss, speed.shape) + 0.0
        )
    assert {Limit.OK, Limit.SLIP, Limit.THERMAL} == set(np.unique(point.limit))


@pytest.mark.parametrize("law", ["linear", "exact"])
def test_supply_and_user_and_losses_balance(law):
    machine = LeggedDrive.of(replace(LEG, transmission=replace(LEG.transmission, creep_law=LAWS[law])), 6)
    given = poses(300)
    point = machine.operate(
        PLATFORM.at(given["position"], given["rotation"]), wrench=given["wrench"], twist=given["twist"]
    )
    rolls = point.limit != Limit.SLIP
    assert np.mean(rolls) > 0.5
    residual = point.power_in - point.power_out - point.loss
    assert_allclose(residual[rolls], 0.0, rtol=0, atol=1e-11)
    locked = machine.operate(PLATFORM.at(given["position"]), wrench=0.1 * given["wrench"])
    assert_allclose(locked.power_in - locked.power_out - locked.loss, 0.0, rtol=0, atol=1e-12)
    assert np.all(locked.power_out <= 0)  # it yields to the user, unless guideways hold it
    assert np.any(locked.power_out < 0)


@pytest.mark.parametrize("speed", [14.0, -14.0])
@sampled("law", sorted(set(LAWS) - {"faulring"}), slow=3)
def test_power_closure_of_the_platform_at_many_points(law, speed):
    """100,000 poses per law and way of the cylinder, from the supply to the user, with all losses."""
    drive = replace(LEG, transmission=replace(LEG.transmission, creep_law=LAWS[law]))
    machine = replace(LeggedDrive.of(drive, 6), cylinder_speed=speed)
    point = iv.analysis.static_points(machine, PLATFORM, **poses(100_000, seed=9))
    holds = np.isfinite(point.power_in)
    assert np.mean(holds) > 0.5
    assert point.audit_residual < 1e-9
    left = point.power_in - point.power_out - point.loss
    assert np.max(np.abs(left[holds]) / np.maximum(np.abs(point.power_in), np.abs(point.power_out))[holds]) < 1e-9
    assert {-1.0, 1.0} == set(np.sign(point.power_out[holds]))


def test_inertia_of_the_cylinder_stores_power():
    point = MACHINE.operate(HOME, wrench=np.zeros(6), twist=np.zeros(6), cylinder_speed=10.0, cylinder_acceleration=4.0)
    assert point.stored == pytest.approx(MACHINE.turning_inertia * 10.0 * 4.0)
    assert point.power_in == pytest.approx(point.power_out + point.loss + point.stored)
    with pytest.raises(iv.ParameterError, match="cylinder_inertia is missing: motion needs it"):
        replace(MACHINE, cylinder_inertia=None).operate(
            HOME, wrench=np.zeros(6), twist=np.zeros(6), cylinder_acceleration=4.0
        )


# Many poses


def test_chunks_and_threads_do_not_change_points(monkeypatch):
    monkeypatch.setattr(workspace, "_CHUNK", 37)
    given = poses(200)
    found = iv.analysis.static_points(MACHINE, PLATFORM, **given)
    whole = MACHINE.operate(
        PLATFORM.at(given["position"], given["rotation"]), wrench=given["wrench"], twist=given["twist"]
    )
    assert_array_equal(found.limit, whole.limit)
    assert_allclose(found.power_in, whole.power_in, rtol=1e-12)
    assert_allclose(found.loss, whole.loss, rtol=1e-12)
    assert_allclose(found.margin, whole.margin, rtol=1e-12)
    assert_allclose(found.loss_of_legs, whole.legs.loss_of_legs, rtol=1e-9, atol=1e-12)
    assert_array_equal(iv.analysis.static_points(MACHINE, PLATFORM, **given, workers=1).power_in, found.power_in)
    one = iv.analysis.static_points(MACHINE, PLATFORM, **{name: value[3] for name, value in given.items()})
    assert found.audit_residual < 1e-12
    assert one.power_in.shape == ()
    assert one.power_in == pytest.approx(whole.power_in[3])


def test_workspace_map():
    axes = {
        "x": np.linspace(-0.08, 0.08, 9),
        "y": np.linspace(-0.06, 0.06, 7),
        "z": PLATFORM.home + np.array([-0.03, 0.0]),
    }
    task = {"wrench": [0, 25.0, 20.0, 0, 0, 0], "twist": [0, 0.1, 0.1, 0, 0, 0]}
    found = iv.analysis.workspace_map(MACHINE, PLATFORM, **axes, **task)
    assert found.points.loss.shape == (9, 7, 2)
    assert found.points.loss_of_legs.shape == (9, 7, 2, 6)
    for place in ((4, 3, 1), (2, 5, 0)):
        position = [axes[name][at] for name, at in zip("xyz", place, strict=True)]
        point = MACHINE.operate(PLATFORM.at(position), **{name: np.array(value) for name, value in task.items()})
        assert found.points.power_in[place] == pytest.approx(point.power_in, rel=1e-12)
        assert found.points.limit[place] == point.limit
    assert 0.1 < found.share < 0.9
    assert {Limit.OK, Limit.TRAVEL} <= set(np.unique(found.points.limit))
    assert found.equals(iv.analysis.workspace_map(MACHINE, PLATFORM, **axes, **task), rtol=1e-12)


def test_malformed_maps():
    axis = {"x": [0.0], "y": [0.0], "z": [PLATFORM.home]}
    cases = [
        ({"x": []}, "x must be a row of positions, got shape"),
        ({"rotation": [0.0]}, "rotation must be 3 numbers"),
        ({"wrench": [1.0]}, "wrench must be 6 numbers"),
        ({"twist": np.zeros((2, 6))}, "twist must be 6 numbers"),
    ]
    for change, message in cases:
        with pytest.raises(iv.ParameterError, match=message):
            iv.analysis.workspace_map(MACHINE, PLATFORM, **{**axis, "wrench": np.zeros(6)} | change)
    with pytest.raises(iv.ParameterError, match="position and wrench must broadcast to one shape"):
        iv.analysis.static_points(MACHINE, PLATFORM, position=np.zeros((2, 3)), wrench=np.zeros((3, 6)))
    with pytest.raises(iv.ParameterError, match="configuration must be of 4, as many as there are legs, got 6 links"):
        iv.analysis.static_points(LeggedDrive.of(LEG, 4), PLATFORM, position=[0, 0, 0.1], wrench=np.zeros(6))
    with pytest.raises(iv.ParameterError, match="output must have no springs or linkage"):
        LeggedDrive.of(replace(LEG, output=iv.Output(parallel_spring=iv.parts.Spring(stiffness=100.0))), 6)
    with pytest.raises(iv.ParameterError, match="leg must be a CoboticDrive, got a ConventionalDrive"):
        LeggedDrive.of(SEPARATE, 6)
    with pytest.raises(iv.ParameterError, match="position must be one or more, got none"):
        iv.analysis.static_points(MACHINE, PLATFORM, position=np.zeros((0, 3)), wrench=np.zeros(6))
    with pytest.raises(iv.ParameterError, match="x must be a real number or an array"):
        iv.analysis.workspace_map(MACHINE, PLATFORM, **axis | {"x": ["left"]}, wrench=np.zeros(6))


# Best cylinder speed


def strokes(count, speed, force):
    """Up and down against a force that resists."""
    phase = 2.0 * np.pi * np.arange(count) / count
    twist, wrench = np.zeros((count, 6)), np.zeros((count, 6))
    twist[:, 2], wrench[:, 2] = speed * np.cos(phase), force * np.cos(phase)
    return {"twist": twist, "wrench": wrench}


def test_best_speed_against_a_fine_grid():
    motions = strokes(5, 0.2, 40.0)
    found = iv.analysis.best_cylinder_speed(MACHINE, HOME, **motions)
    grid = np.linspace(0.1, 4.0, 6001)[:, None] * MACHINE.cylinder_speed
    point = MACHINE.operate(HOME, **motions, cylinder_speed=grid)
    power = np.where(np.asarray(point.limit) == Limit.OK, point.power_in, np.inf)
    mean = power.mean(axis=1)
    # The best lies at a limit, up to a step of the grid beyond its last feasible speed.
    assert mean.min() * (1 - 2e-4) < found.fixed_power <= mean.min()
    assert found.fixed == pytest.approx(grid[np.argmin(mean), 0], rel=2e-3)
    assert found.by_motion_power == pytest.approx(power.min(axis=0).mean(), rel=1e-4)
    assert_allclose(found.by_motion, grid[np.argmin(power, axis=0), 0], rtol=2e-3)
    assert found.by_motion_power < found.fixed_power < found.nominal_power
    assert found.scheduled is None


@pytest.mark.slow
def test_best_schedule_counts_the_inertia():
    motions = strokes(32, 0.2, 40.0)
    slow, fast = (iv.analysis.best_cylinder_speed(MACHINE, HOME, **motions, period=period) for period in (20.0, 0.5))
    assert slow.by_motion_power <= slow.scheduled_power < slow.fixed_power
    assert slow.scheduled_power <= fast.scheduled_power <= fast.fixed_power
    assert np.ptp(slow.scheduled.value) > np.ptp(fast.scheduled.value)
    again = MACHINE.operate(
        HOME, **motions, cylinder_speed=slow.scheduled.value, cylinder_acceleration=slow.scheduled.rate
    )
    assert np.mean(again.power_in) == pytest.approx(slow.scheduled_power, rel=1e-12)
    # Over a cycle the inertia returns what it has stored.
    assert abs(np.mean(again.stored)) < 1e-3 * np.mean(np.abs(again.stored))
    assert np.mean(again.power_in) == pytest.approx(np.mean(again.power_out + again.loss), rel=1e-3)


def test_speed_without_any_feasible_one_is_nan():
    found = iv.analysis.best_cylinder_speed(MACHINE, HOME, **strokes(16, 0.2, 600.0), period=1.0)
    assert np.all(np.isnan([found.fixed, found.fixed_power]))
    assert found.scheduled is None
    with pytest.raises(iv.ParameterError, match=r"period must be > 0 s, got -1.0"):
        iv.analysis.best_cylinder_speed(MACHINE, HOME, **strokes(4, 0.2, 10.0), period=-1.0)
    with pytest.raises(iv.ParameterError, match=r"of shape \(m, d\)"):
        iv.analysis.best_cylinder_speed(MACHINE, HOME, twist=np.zeros(6), wrench=np.zeros(6))


# One motor or many


def test_one_motor_against_one_for_each_joint():
    """The powers of both drives' own operation, for any number of legs."""
    found = iv.analysis.share_motor(LEG, SEPARATE, force=[0.0, 25.0, 50.0], legs=(1, 2, 6), duty=(1.0, 0.25))
    one = LEG.operate(speed=0.0, force=np.array([0.0, 25.0, 50.0]))
    assert_allclose(found.turning[0, 0], one.power_in, rtol=1e-12)
    alone = SEPARATE.without_static_friction().operate(speed=0.0, force=np.array([0.0, 25.0, 50.0])).power_in
    assert_allclose(found.separate[0], np.array([1, 2, 6])[:, None] * alone, rtol=1e-12)
    assert_allclose(found.turning[1], 0.25 * found.turning[0] + 0.75 * found.turning[0][:, :1], rtol=1e-12)
    assert_allclose(found.stopping[1], 0.25 * found.stopping[0], rtol=1e-12)
    assert_allclose(found.separate[1], 0.25 * found.separate[0], rtol=1e-12)
    # A lossless guideway would hold 4.5 N less with its friction.
    held = iv.analysis.share_motor(LEG, SEPARATE, force=[25.0], held_by_friction=True)
    assert held.separate[0, 0, 0] == pytest.approx(float(SEPARATE.operate(speed=0.0, force=25.0).power_in))


@pytest.mark.parametrize(("leg", "common", "six"), [(LEG, 3.68, 5.25), (OTHER, 1.09, 2.82)])
def test_powers_of_the_reconstructions(leg, common, six):
    """Watts of a shared motor in the shipped reconstructions: common part, 0.2 W a leg idle, six legs at 50 N against 28.3 W."""
    found = iv.analysis.share_motor(leg, SEPARATE, force=[0.0, 25.0, 50.0], legs=(1, 2, 6))
    idle = found.turning[0, :, 0]
    assert idle[1] - idle[0] == pytest.approx(0.21, abs=0.01)
    assert 2 * idle[0] - idle[1] == pytest.approx(common, abs=0.03)
    assert found.turning[0, 2, 2] == pytest.approx(six, abs=0.02)
    assert_allclose(found.separate[0, 2], [0.0, 7.09, 28.35], atol=0.01)
    counts = np.array([1, 2, 6])
    assert_allclose(found.separate_mass, 0.324 * counts)
    assert_allclose(found.shared_mass, 0.12 + leg.steering.motor.mass * counts)
    # The lightest cylinder of that inertia weighs as much as several motors.
    assert found.cylinder_mass > 3 * SEPARATE.motor.mass


def test_break_even():
    forces = np.linspace(0.0, 50.0, 26)
    found = iv.analysis.share_motor(LEG, SEPARATE, force=forces, legs=(6, 1, 2), duty=(1.0, 0.1))
    least = found.least_force()
    for duty in range(2):
        for legs in range(3):
            excess = found.turning[duty, legs] - found.separate[duty, legs]
            if np.isinf(least[duty, legs]):
                assert excess[-1] >= 0
            else:
                assert np.interp(least[duty, legs], forces, excess) == pytest.approx(0.0, abs=1e-9)
                assert np.all(excess[forces > least[duty, legs]] < 0)
    # Least force falls with the number of legs, and where the cylinder stops while idle.
    assert least[0, 0] < least[0, 2] < least[0, 1]
    assert np.all(found.least_force(stopped=True) <= least)
    legs = found.least_legs()
    assert np.isnan(legs[0, 0])  # nothing to hold: a geared drive draws nothing
    at = int(np.searchsorted(forces, 30.0))
    assert legs[0, at] == min(
        n for n, w in zip((6, 1, 2), found.turning[0, :, at] < found.separate[0, :, at], strict=True) if w
    )


def test_figure_of_break_even_forces():
    """The lines are the break-even forces in the order of rising duty; nothing is drawn where there is none."""
    from internals import shared_motor_figure as shared_motor

    found = iv.analysis.share_motor(
        LEG, SEPARATE, force=np.linspace(0.0, 55.0, 12), legs=(1, 6), duty=(1.0, 0.1), period=10.0
    )
    numbers = shared_motor.data(found)
    assert_array_equal(numbers["duty"], [10.0, 100.0])
    assert_array_equal(numbers["turning"], found.least_force()[::-1])
    assert_array_equal(numbers["stopped"], found.least_force(stopped=True)[::-1])
    made = found.plot()
    lines = {line.get_label(): line.get_ydata() for line in made.axes[0].lines}
    assert list(lines) == ["1 leg", "6 legs"]
    assert np.isnan(lines["6 legs"][0])
    assert lines["6 legs"][1] == numbers["turning"][1, 1]


def test_run_up_energy():
    """Kinetic energy, and the losses of motor, gear and legs on the way; a long run-up loses more."""
    stored = 0.5 * MACHINE.turning_inertia * MACHINE.cylinder_speed**2
    quick, slow = run_up_energy(MACHINE, 0.5), run_up_energy(MACHINE, 5.0)
    assert stored < quick < slow
    found = iv.analysis.share_motor(
        LEG, SEPARATE, force=[50.0], legs=(6,), duty=(0.5, 1.0), period=10.0, run_up_time=0.5
    )
    longer = iv.analysis.share_motor(LEG, SEPARATE, force=[50.0], legs=(6,), duty=(0.5, 1.0))
    assert_allclose((found.stopping - longer.stopping)[:, 0, 0], [quick / 10.0, 0.0], rtol=1e-12)
    unknown = iv.analysis.share_motor(replace(LEG, cylinder_inertia=None, steering=None), SEPARATE, force=[50.0])
    assert np.all(np.isnan([*unknown.run_up_energy, unknown.cylinder_mass]))


def test_malformed_comparisons():
    cases = [
        ({"force": [20.0, 10.0]}, "force must be a row of forces >= 0 that rise N"),
        ({"force": [-1.0]}, "force must be a row of forces >= 0"),
        ({"legs": (0, 1)}, "legs must be whole numbers, 1 or more"),
        ({"legs": (1.5,)}, "legs must be whole numbers, 1 or more"),
        ({"duty": 1.5}, "duty must be between 0 and 1, got 1.5"),
        ({"period": 0.0}, "period must be > 0 s, got 0.0"),
        ({"run_up_time": np.nan}, "run_up_time must be > 0 s, got nan"),
    ]
    for change, message in cases:
        with pytest.raises(iv.ParameterError, match=message):
            iv.analysis.share_motor(LEG, SEPARATE, **{"force": [10.0]} | change)
    with pytest.raises(iv.ParameterError, match="leg must be a CoboticDrive"):
        iv.analysis.share_motor(SEPARATE, SEPARATE, force=[10.0])
    with pytest.raises(iv.ParameterError, match="separate must be a drive"):
        iv.analysis.share_motor(LEG, "motor", force=[10.0])
