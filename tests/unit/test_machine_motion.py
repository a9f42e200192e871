"""Machines of many contacts in motion: closed forms of coasting and pushing, creep drift, slip, and the balance of energies."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import infinivar as iv
from cobotic_study import unweighed
from infinivar import Limit, simulate_machine
from infinivar.motion import MachineScenario, VectorHistory
from internals import creep_drift, marching, reflected_mass
from internals import machine_run_figure as machine_run
from machines import (
    HEXAPOD,
    IDEAL_WHEEL,
    LEG,
    MACHINES,
    PLATFORM,
    REAL_WHEEL,
    cart,
    circles,
    ideal_leg,
    one_joint,
)
from sampled import sampled

# Coasting


@pytest.mark.slow
@pytest.mark.parametrize(("tolerance", "duration"), [(1e-3, 1.5), pytest.param(1e-4, 6.0, marks=pytest.mark.slow)])
def test_balance_closes_where_energy_goes_to_and_fro(tolerance, duration):
    # Without losses, what the user gives comes back in each cycle: little has passed in the end.
    wheel = replace(IDEAL_WHEEL, creep_stiffness=2e4)
    run = simulate_machine(
        iv.machines.PlanarMachine(
            cobot=iv.transmission.PlanarCobot(contacts=wheel, positions=[(0.0, 0.0)], mass=10.0, inertia=0.8)
        ),
        MachineScenario(
            duration=duration,
            source="none",
            servos=False,
            steering=lambda time: [0.5 * math.sin(2.0 * time)],
            wrench=lambda time: [-10.0 * math.sin(20.0 * time), 0.0, 0.0],
            output_step=0.02,
            tolerance=tolerance,
        ),
    )
    assert run.complete
    assert run.closure < 7e-7


@pytest.mark.slow
def test_coasting_leg_keeps_its_inertia_times_speed_squared():
    leg = ideal_leg()
    machine = one_joint(leg)

    def steering(time):
        return [0.3 + 0.5 * math.sin(9.0 * time)]

    first = math.tan(0.3)
    radius, speed = 0.05, 14.0
    run = simulate_machine(
        machine,
        MachineScenario(
            duration=0.2,
            output_step=0.004,
            source="none",
            servos=False,
            steering=steering,
            rates=[-first * speed * radius / machine.pulley_radius, speed],
        ),
    )
    tangent = np.tan([steering(one)[0] for one in run.time])
    carried = leg.link_mass + 0.05 * 0.3**2 / 3.0 / machine.pulley_radius**2
    kept = (leg.cylinder_inertia + carried * (radius * tangent) ** 2) * run.columns["cylinder_speed_rad_s"] ** 2
    assert_allclose(kept, kept[0], rtol=3e-4)
    assert np.ptp(run.columns["cylinder_speed_rad_s"]) > 1.0
    assert run.closure < 1e-6


@pytest.mark.slow
def test_coasting_cobot_keeps_its_energy_under_any_steering():
    machine = cart(IDEAL_WHEEL)

    def steering(time):
        return np.asarray(machine.cobot.headings([1.0, 0.0, 1.5 * math.sin(4.0 * time)]))

    run = simulate_machine(
        machine,
        MachineScenario(
            duration=0.6, output_step=0.01, source="none", servos=False, steering=steering, rates=[0.5, 0.0, 0.0]
        ),
    )
    energy = run.stored["machine"]
    assert_allclose(energy, energy[0], rtol=3e-4)
    assert abs(run.columns["angle_rad"]).max() > 0.1
    assert run.closure < 1e-6


def test_a_reversal_of_prescribed_angles_is_no_jump():
    """Rates of the angles are differences: near 0 their noise is all that is left."""
    machine = cart(IDEAL_WHEEL)
    run = simulate_machine(
        machine,
        MachineScenario(
            duration=0.05,
            source="none",
            servos=False,
            steering=lambda time: machine.cobot.headings([1.0, 0.0, 1.2 * math.sin(3.0 * time + 4.65)]),
            rates=[0.5, 0.0, 0.0],
        ),
    )
    assert run.outcome == ""


def integrated(cobot, twist, steering, push, time, stick_speed):
    """Pose, and losses by name, of a pushed body on wheels without spin: Newton and Euler, by an integrator of SciPy."""
    start = np.zeros(3)
    names = tuple(cobot.mechanism.forces(np.array(twist), (np.ones(3), start), start, stick_speed)[0].losses)

    def rates(now, state):
        angle, (x, y, turning) = state[2], state[3:6]
        heading = steering(now)
        forces, exerted = cobot.mechanism.forces(state[3:6], (np.cos(heading), np.sin(heading)), start, stick_speed)
        pushed = (push + exerted) / [cobot.mass, cobot.mass, cobot.inertia]
        moved = [math.cos(angle) * x - math.sin(angle) * y, math.sin(angle) * x + math.cos(angle) * y, turning]
        whirled = [turning * y, -turning * x, 0.0]
        return np.concatenate([moved, pushed + whirled, [np.sum(forces.losses[name]) for name in names]])

    state = np.concatenate([start, twist, np.zeros(len(names))])
    found = solve_ivp(rates, (0.0, time[-1]), state, method="Radau", rtol=1e-9, atol=1e-10, t_eval=time)
    return found.y[:3].T, dict(zip(names, found.y[6:], strict=True))


@pytest.mark.slow
def test_planar_cobot_moves_as_by_another_integration():
    machine = cart(REAL_WHEEL)

    def steering(time):
        return np.asarray(machine.cobot.headings([1.0, 0.0, 1.2 * math.sin(3.0 * time)]))

    run = simulate_machine(
        machine,
        MachineScenario(
            duration=0.6,
            source="none",
            servos=False,
            steering=steering,
            rates=[0.5, 0.0, 0.0],
            wrench=[-2.0, -1.0, -0.3],
            output_step=0.02,
            tolerance=1e-7,
        ),
    )
    pose, losses = integrated(machine.cobot, [0.5, 0.0, 0.0], steering, [2.0, 1.0, 0.3], run.time, 1e-4)
    for place, name in enumerate(("x_m", "y_m", "angle_rad")):
        assert_allclose(run.columns[name], pose[:, place], atol=1e-9)
    assert set(run.lost) >= {"creep", "rolling", "bearing"}
    for name, loss in losses.items():
        assert_allclose(run.lost.get(name, 0.0 * run.time), loss, atol=1e-9)


# Pushed by a user


@pytest.mark.parametrize("angle", [-0.6, 0.35, 1.1])
def test_user_feels_the_reflected_mass(angle):
    leg = ideal_leg()
    machine = one_joint(leg, mass=0.3)
    push = -0.02
    run = simulate_machine(
        machine,
        MachineScenario(duration=0.2, source="none", servos=False, steering=[angle], wrench=[-push], output_step=0.01),
    )
    carried = leg.link_mass + 0.3 * 0.3**2 / 3.0 / machine.pulley_radius**2
    felt = reflected_mass(carried, leg.cylinder_inertia, 0.05, math.tan(angle))
    speed = machine.pulley_radius * run.columns["q1_rate_rad_s"]
    found = (push / machine.pulley_radius) * (run.time[-1] - run.time[10]) / (speed[-1] - speed[10])
    assert_allclose(found, felt, rtol=2e-3)


# Held and locked


def test_locked_platform_drifts_by_the_closed_form_while_the_cylinder_turns():
    leg = ideal_leg(stiffness=3e4)
    machine = replace(HEXAPOD, leg=leg)
    wrench = np.array([8.0, -5.0, 12.0, 0.1, -0.2, 0.15])
    given = {"wrench": wrench, "steering": [0.0] * 6, "servos": False, "output_step": 0.01}
    turning = simulate_machine(machine, MachineScenario(duration=0.05, rates=[0.0] * 6 + [14.0], **given))
    jacobian = PLATFORM.at(machine.home[:3]).jacobian
    expected = creep_drift(jacobian, wrench, 0.05 * 14.0, 3e4)
    twist = np.array([turning.columns[name][-1] for name in machine.mechanics(1e-4).coordinates[:6]])
    assert_allclose(twist, expected, rtol=2e-3, atol=1e-3 * np.abs(expected).max())
    still = simulate_machine(machine, MachineScenario(duration=0.05, source="none", **given))
    assert np.abs([still.columns[name][-1] for name in ("v_x_m_s", "v_z_m_s")]).max() < 2e-4 * np.abs(expected).max()


@pytest.mark.slow
def test_slip_begins_when_the_static_limit_is_reached():
    machine = replace(HEXAPOD, leg=ideal_leg(stiffness=3e4))
    rise = 1000.0
    direction = np.array([0.3, 0.0, -1.0, 0.0, 0.0, 0.0])
    run = simulate_machine(
        machine,
        MachineScenario(
            duration=0.5,
            source="held",
            steering=[0.0] * 6,
            servos=False,
            wrench=lambda time: -rise * time * direction,
            output_step=0.01,
            rates=[0.0] * 6 + [14.0],
        ),
    )
    assert run.slips
    begin = run.slips[0]
    pose = [np.interp(begin, run.time, run.columns[name]) for name in ("x_m", "y_m", "z_m")]
    turn = [np.interp(begin, run.time, run.columns[name]) for name in ("theta_x_rad", "theta_y_rad", "theta_z_rad")]
    force = np.abs(PLATFORM.at(pose, turn).link_forces(rise * begin * direction)).max()
    assert_allclose(force, machine.leg.transmission.slip_force, rtol=5e-3)
    assert any(line.startswith("wheel slip (wheel") for line in run.event_lines)
    assert not run.feasible
    assert run.lost["slip"][-1] > 0.0
    assert run.closure < 1e-6


# Closed loops


@pytest.mark.slow
def test_platform_follows_a_motion():
    run = simulate_machine(
        HEXAPOD, MachineScenario(duration=0.15, motion=circles(0.15), wrench=[-4.0, 0.0, 10.0, 0.0, -0.1, 0.0])
    )
    assert run.feasible, run.verdict
    assert run.position_error.max() < 3e-4
    assert run.closure < 1e-7
    assert np.abs(run.columns["cylinder_speed_rad_s"] / 14.0 - 1.0).max() < 0.02
    assert run.scenario.motion(0.15)[2] - HEXAPOD.home[2] > 1e-3
    steady = iv.machines.LeggedDrive.of(LEG, 6)
    place = PLATFORM.at([run.columns[n][-1] for n in ("x_m", "y_m", "z_m")])
    still = steady.operate(place, wrench=np.zeros(6), twist=np.zeros(6))
    assert run.lost["bearing"][-1] / 0.15 == pytest.approx(still.losses["bearing"], rel=0.1)


@sampled("name", MACHINES, every=3)
def test_balance_of_energies_closes(name):
    machine, given = MACHINES[name]
    run = simulate_machine(machine, MachineScenario(**given))
    assert run.complete, run.outcome
    assert run.closure < 1e-6
    assert sum(float(lost[-1]) for lost in run.lost.values()) > 1e-6
    assert all(np.all(np.diff(lost) >= -1e-12) for lost in run.lost.values())
    assert {"user"} <= set(run.supplied)


def test_limits_are_events():
    assert Limit.SLIP in {limit for limit, _ in HEXAPOD.mechanics(1e-4).demands}


@pytest.mark.slow
@sampled("law", ["exact", "polach", "fastsim", "vermeulen-johnson"], every=3)
def test_balance_closes_with_other_laws_and_with_spin(law):
    leg = replace(LEG, transmission=replace(LEG.transmission, creep_law=law))
    assert leg.transmission.turns_with_spin == (law == "exact")
    run = simulate_machine(
        replace(HEXAPOD, leg=leg),
        MachineScenario(duration=0.02, motion=circles(0.1), wrench=[-4.0, 0.0, 10.0, 0, -0.1, 0]),
    )
    assert run.complete
    assert run.closure < 1e-6
    assert ("spin" in run.lost) == (law == "exact")


def test_steering_without_a_patch_names_it():
    roller = iv.transmission.RollingContact(
        wheel_radius=0.02,
        preload=300.0,
        friction=0.1,
        creep_stiffness=6e3,
        rolling_torque=0.01,
        bearing_torque=0.01,
        surface="sphere",
        surface_radius=0.05,
    )
    machine = iv.machines.SphereMachine(
        ivt=iv.SphericalIVT(sphere_radius=0.05, drive=roller),
        input_inertia=5e-4,
        output_inertia=2e-3,
        sphere_inertia=1e-3,
        steering=LEG.steering,
    )
    with pytest.raises(iv.InputError, match=r"steering\.patch_half_length is missing: give it, or the geometry"):
        simulate_machine(machine, MachineScenario(duration=0.02, source="none", steering=lambda time: [0.7]))


@pytest.mark.slow
@sampled("layout", ["cubic", "tetrahedral"], every=2)
def test_spheres_with_spin_close_their_balance(layout):
    roller = iv.transmission.RollingContact(
        wheel_radius=0.02,
        preload=300.0,
        friction=0.1,
        surface="sphere",
        surface_radius=0.05,
        geometry=LEG.transmission.geometry,
    )
    ivt = iv.SphericalIVT(sphere_radius=0.05, drive=roller, layout=layout)
    machine = iv.machines.SphereMachine(ivt=ivt, input_inertia=5e-4, output_inertia=2e-3, sphere_inertia=1e-3)
    run = simulate_machine(
        machine,
        MachineScenario(
            duration=0.02,
            source="none",
            servos=False,
            rates=list(ivt.rolling_rates(0.7, 5.0)),
            steering=lambda time: [0.7 + 0.3 * math.sin(5.0 * time)],
            wrench=[-0.1, 0.05],
            output_step=0.005,
        ),
    )
    assert run.closure < 1e-6
    assert run.lost["spin"][-1] > 0.0
    assert run.supplied["steering"][-1] > 0.0


# Results and misuse


@pytest.mark.slow
def test_run_is_drawn_labelled_and_said():
    machine, given = MACHINES["planar"]
    run = iv.simulate_machine(machine, MachineScenario(**{**given, "duration": 0.03}), title="Cart")
    numbers = machine_run.data(run)
    assert set(numbers["motion"]) == {"displacement [mm]", "angle [degrees]"}
    assert_allclose(numbers["angles"]["h_1"], np.degrees(run.columns["h_1_rad"]))
    assert sum(float(lost[-1]) for lost in numbers["lost"].values()) == pytest.approx(
        sum(float(lost[-1]) for lost in run.lost.values())
    )
    labelled = run.to_xarray()
    assert labelled["x_m"].attrs["units"] == "m"
    assert labelled["energy_lost_J"].shape == (len(run.lost), len(run.time))
    said = run.to_dict()
    assert said["complete"]
    assert said["verdict"] == run.verdict
    assert "position error" in run.verdict
    assert run.plot().axes[0].get_title() == "Cart"
    assert run == run
    assert "MachineRun" in repr(run)


@pytest.mark.slow
def test_platform_at_the_end_of_its_reach_stops_and_says_why():
    scenario = MachineScenario(
        duration=0.5,
        source="none",
        servos=False,
        steering=[1.2] * 6,
        wrench=[-900.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        output_step=0.01,
    )
    run = simulate_machine(HEXAPOD, scenario)
    assert not run.complete
    assert "reach" in run.verdict
    assert not run.feasible
    assert run.closure < 1e-6


def test_histories():
    line = VectorHistory(time=[0.0, 1.0, 2.0], values=[[0.0], [1.0], [4.0]], smooth=False)
    assert_allclose(line(0.5), [0.5])
    assert_allclose(line.rate(1.5), [3.0])
    assert_allclose(line(5.0), [4.0])
    assert_allclose(line.rate(5.0), [0.0])
    curve = VectorHistory.of(math.sin, 1.0)
    assert_allclose(curve.acceleration(0.4), [-math.sin(0.4)], rtol=1e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"duration": 0.0}, "duration must be > 0"),
        ({"source": "on"}, "source must be one of"),
        ({"steering": "free"}, "steering must be controlled, locked, or angles over time"),
        ({"steering": [0.1, 0.2], "servos": False}, "steering must be 6 finite numbers"),
        ({"servos": False}, "steering = 'controlled' needs servos"),
        ({"wrench": [1.0, 2.0]}, "wrench must be 6 finite numbers"),
        ({"wrench": [math.nan] * 6}, "wrench must be 6 finite numbers"),
        ({"pose": [0.0, 0.0]}, "pose must be 6 values"),
        ({"pose": [0.3, 0.0, 0.1, 0.0, 0.0, 0.0]}, "pose must be within the reach"),
        ({"rates": [math.inf] * 7}, "rates must be a row of finite numbers"),
        ({"motion": VectorHistory(time=[0.0, 1.0], values=[[0.0], [1.0]])}, "motion must be 6 values"),
        ({"motion": VectorHistory(time=[0.0, 1.0], values=[[0.0]] * 2, smooth=False)}, "motion.smooth must be true"),
        ({"motion": 3}, "motion must be a VectorHistory"),
        ({"tolerance": 0.1}, "tolerance must be"),
        ({"duration": 1e9, "output_step": 1e-3}, "duration must be at most a million samples long"),
    ],
)
def test_bad_scenarios_have_one_clear_message(change, message):
    with pytest.raises(iv.ParameterError) as caught:
        simulate_machine(HEXAPOD, MachineScenario(**{"duration": 0.01, **change}))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: replace(HEXAPOD, mass=-1.0), "mass must be > 0"),
        (lambda: replace(HEXAPOD, inertia=[1.0]), "inertia must be three"),
        (lambda: replace(HEXAPOD, leg=None), "leg must be a CoboticDrive"),
        (lambda: simulate_machine(replace(HEXAPOD, leg=unweighed(LEG)), MachineScenario(duration=0.01)),
         "leg.link_mass is missing"),
        (lambda: simulate_machine(replace(HEXAPOD, leg=replace(LEG, steering=None)), MachineScenario(duration=0.01)),
         "steering is missing"),
        (lambda: simulate_machine(cart(REAL_WHEEL), MachineScenario(duration=0.01, source="none")), "steering is missing"),
        (lambda: simulate_machine(LEG, MachineScenario(duration=0.01)), "machine must be one of PlatformMachine"),
        (lambda: simulate_machine(HEXAPOD, None), "scenario must be a MachineScenario"),
        (lambda: simulate_machine(MACHINES["tetrahedral sphere"][0], MachineScenario(duration=0.01)), "source must be 'none'"),
        (lambda: replace(MACHINES["arm"][0], member_masses=[1.0]), "member_masses must be 2"),
        (lambda: simulate_machine(MACHINES["sphere"][0], MachineScenario(duration=0.01)), "steering must be 'locked' or"),
        (lambda: VectorHistory(time=[0.0, 0.0], values=[[0.0], [1.0]]), "time must be two increasing instants"),
        (lambda: VectorHistory(time=[0.0], values=[[0.0]]), "time must be two increasing instants"),
        (lambda: VectorHistory(time=[0.0, np.inf], values=[[0.0], [1.0]]), "time must be two increasing instants"),
        (lambda: VectorHistory(time=[[0.0, 1.0]], values=[[0.0], [1.0]]), "time must be two increasing instants"),
        (lambda: VectorHistory(time=[0.0, 1.0], values=[0.0, 1.0]), "values must be of shape (2, quantities), got shape (2,)"),
        (lambda: VectorHistory(time=[0.0, 1.0], values=[[0.0]] * 3), "values must be of shape (2, quantities), got shape (3, 1)"),
        (lambda: VectorHistory(time=[0.0, 1.0], values=[[0.0], [np.nan]]), "values must be finite, got nan or inf"),
        (lambda: VectorHistory.of(None, 1.0), "function must be a function of time, got None"),
        (lambda: VectorHistory.of(lambda time: time, 0.0), "duration must be > 0 s"),
        (lambda: VectorHistory.of(lambda time: time, 1.0, points=1), "points must be a whole number, 2 or more, got 1"),
        (lambda: VectorHistory.of(lambda time: time, 1.0, points=True), "points must be a whole number, 2 or more, got True"),
    ],
)  # fmt: skip
def test_bad_machines_have_one_clear_message(make, message):
    with pytest.raises(iv.ParameterError) as caught:
        make()
    assert message in str(caught.value)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_residual_is_over_all_energy_moved_whichever_way_it_goes(way):
    """A source that takes energy back moves as much as one that gives it."""
    stored = np.array([[7.0], [7.0 + 7.0 * way], [1e-9]])
    lost = np.array([[0.0], [1.0], [2.0]])
    supplied = stored - stored[0] + lost
    stored[-1] += 1.4e-8
    moved = np.max(np.abs(supplied[:, 0]) + lost[:, 0]) + np.max(stored[:, 0])
    assert_allclose(marching._residual(supplied, lost, stored), [0.0, 0.0, 1.4e-8 / moved], rtol=1e-6, atol=1e-18)
