"""Sessions of planar cobots against closed forms: free mass, path, wall, coasting."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import infinivar as iv
from infinivar import session
from infinivar.machines import CasterGuide, Commands, PathGuide, PlanarMachine, Sensing, WallGuide
from internals import CoboticControl, largest_turn_rate, overrun
from machines import IDEAL_WHEEL, LEG, REAL_WHEEL, cart
from reference_curves import Circle, Disc, HalfPlane, Line
from sampled import sampled

STIFF = replace(IDEAL_WHEEL, creep_stiffness=1e8)
STEERING = replace(LEG.steering, patch_half_length=3e-4)


def one_wheel(wheel, mass=10.0):
    cobot = iv.transmission.PlanarCobot(contacts=wheel, positions=[(0.0, 0.0)], mass=mass, inertia=0.8)
    return PlanarMachine(cobot=cobot, steering=STEERING)


# Free mode


@pytest.mark.slow
def test_caster_with_the_mass_of_the_machine_moves_as_a_free_mass():
    run = session(
        one_wheel(STIFF), controller=CasterGuide(), user=[3.0, 2.0], duration=0.2, rates=[0.4, 0.0, 0.0], servos="ideal"
    )
    time = run.time
    free = np.stack([0.4 * time + 0.15 * time**2, 0.1 * time**2], axis=-1)
    assert_allclose(run.position, free, atol=1e-7)
    assert run.closure < 1e-6
    assert_allclose(run.joules["from user"], run.joules["stored in machine"], rtol=1e-5)


def test_what_the_user_put_in_is_lost_or_stored_at_the_end():
    """A push of 5 N for 50 ms on 10 kg at rest: p^2/2m = 3.1 mJ of work, and energies of the end, not of some sample."""
    run = session(one_wheel(IDEAL_WHEEL, 10.0), controller=CasterGuide(), user=np.array([5.0, 0.0]), duration=0.05)
    assert_allclose(run.joules["from user"], (5.0 * 0.05) ** 2 / 20.0, rtol=1e-3)
    supplied = sum(energy for name, energy in run.joules.items() if name.startswith("from "))
    assert_allclose(supplied, sum(run.joules.values()) - supplied, rtol=1e-5)


@pytest.mark.slow
def test_heavier_caster_turns_as_its_mass_wants():
    heavy, own, force = 25.0, 10.0, np.array([3.0, 2.0])
    run = session(
        one_wheel(STIFF, own),
        controller=CasterGuide(mass=heavy),
        user=force,
        duration=0.2,
        rates=[0.4, 0.0, 0.0],
        servos="ideal",
    )

    def law(time, state):
        _, _, psi, u = state
        along, left = np.array([math.cos(psi), math.sin(psi)]), np.array([-math.sin(psi), math.cos(psi)])
        return [u * along[0], u * along[1], force @ left / (heavy * u), force @ along / own]

    known = solve_ivp(law, [0.0, 0.2], [0.0, 0.0, 0.0, 0.4], rtol=1e-10, atol=1e-12).y[:2, -1]
    assert_allclose(run.position[-1], known, atol=1e-7)


def test_caster_at_rest_sets_off_along_the_force():
    run = session(one_wheel(IDEAL_WHEEL), controller=CasterGuide(), user=[3.0, 4.0], duration=0.05, servos="ideal")
    moved = run.position[-1]
    assert_allclose(moved, 0.5 * np.array([0.3, 0.4]) * 0.05**2, rtol=1e-4)


# Path


def test_path_law_is_critically_damped_along_the_travelled_length():
    k1 = 1600.0
    run = session(
        one_wheel(STIFF),
        controller=PathGuide(curve=Line(), k1=k1, direction=0.0),
        duration=0.2,
        rates=[0.4, 0.0, 0.0],
        pose=[0.0, 0.001, 0.0],
        servos="ideal",
    )
    travelled = 0.4 * run.time
    known = 0.001 * (1.0 + math.sqrt(k1) * travelled) * np.exp(-math.sqrt(k1) * travelled)
    assert_allclose(run.path_offset, known, atol=2e-7)


@pytest.mark.slow
@sampled("forwards", [True, False], every=2)
def test_path_offset_of_creep_is_that_of_the_closed_form_and_zero_with_feedforward(forwards):
    machine, push = one_wheel(replace(IDEAL_WHEEL, creep_stiffness=2e4)), 20.0
    offsets = {}
    for fed in (False, True):
        run = session(
            machine,
            controller=PathGuide(curve=Line(), k1=1600.0, slip_feedforward=fed, direction=0.0),
            user=[0.0, push],
            duration=0.35,
            rates=[1.0 if forwards else -1.0, 0.0, 0.0],
            servos="ideal",
            output_step=0.02,
        )
        offsets[fed] = run.path_offset[-1]
    # Without feeding the slip angle forward, the law of steering settles at 2 beta/sqrt(k1) if critically damped.
    assert_allclose(offsets[False], 2.0 * math.atan(push / 2e4) / math.sqrt(1600.0), rtol=1e-4)
    assert abs(offsets[True]) < 1e-9


@sampled("machine", [one_wheel(REAL_WHEEL), cart(REAL_WHEEL, steering=STEERING)], every=2)
def test_round_path_with_real_servos(machine):
    run = session(
        machine,
        controller=PathGuide(curve=Circle(0.5)),
        user=lambda time: [-6.0 * math.sin(time), 6.0 * math.cos(time)],
        duration=0.15,
        pose=[0.5, 0.0, 0.0],
        rates=[0.0, 0.5, 0.0],
        output_step=0.01,
    )
    assert np.abs(run.path_offset).max() < 3e-4
    assert run.closure < 1e-6
    assert run.feasible
    assert run.supplied["steering supply"][-1] > 0.0
    assert_allclose(run.columns["angle_rad"], 0.0, atol=2e-3)
    assert "offset from the path" in run.verdict


@pytest.mark.slow
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_handle_goes_straight_on_past_the_end_of_an_open_path(way):
    curve = iv.motion.ArcCurve(centre=[0.0, 0.3], radius=0.3, start_angle=-0.5 * math.pi, turn=0.5)
    at = curve.length if way > 0 else 0.0
    (point, tangent, _), speed = curve.at(0.5 * curve.length), 0.4
    run = session(
        one_wheel(IDEAL_WHEEL),
        iv.motion.VirtualPath(curve=curve),
        duration=0.4,
        pose=[*point, 0.0],
        rates=[*(way * speed * tangent), 0.0],
        servos="ideal",
    )
    end, along, _ = curve.at(at)
    assert np.max(np.abs(run.path_offset)) < 2e-5
    (passed,) = run.overruns
    expected = 0.5 * curve.length / speed
    assert passed.start == pytest.approx(expected, abs=2e-3)
    assert passed.end == run.time[-1]
    assert passed.distance == pytest.approx(way * (run.position[-1] - end) @ along, rel=1e-9)
    assert passed.distance == pytest.approx(speed * (0.4 - expected), rel=1e-3)
    assert "mm past the end of the path" in run.verdict
    assert str(passed) in run.event_lines
    assert run.to_dict()["overruns"] == [{"start_s": passed.start, "end_s": passed.end, "distance_m": passed.distance}]


@pytest.mark.slow
def test_handle_beside_the_centre_follows_the_path():
    run = session(
        cart(STIFF),
        controller=PathGuide(curve=Circle(0.5)),
        duration=0.1,
        pose=[0.4, 0.0, 0.0],
        handle=(0.1, 0.0),
        rates=[0.0, 0.4, 0.0],
        servos="ideal",
        output_step=0.01,
    )
    assert np.abs(run.path_offset).max() < 2e-6
    energy = run.stored["machine"]
    assert_allclose(energy, energy[0], rtol=1e-5)


# Wall


@pytest.mark.slow
def test_wall_is_overrun_by_the_closed_form_if_the_wheel_turns_only_from_it_on():
    """A controller of one's own reads the wall's distance, and turns with one rate until the wheel heads along the wall."""
    speed, rate, angle = 0.4, 8.0, 0.8
    wall, begun = HalfPlane(), []

    def late(measured):
        if wall.distance(measured.position) <= 0.0 or begun:
            begun.append(float(measured.time))
        turned = rate * (measured.time + 5e-4 - begun[0]) if begun else 0.0
        return Commands(
            steering=np.array([min(turned, angle) - angle]), steering_rate=np.array([rate * (0.0 < turned < angle)])
        )

    run = session(
        one_wheel(replace(STIFF, preload=1e5)),
        controller=late,
        wall=wall,
        duration=0.13,
        rates=[speed * math.cos(angle), -speed * math.sin(angle), 0.0],
        pose=[0.0, 0.004, 0.0],
        servos="ideal",
        sensing=Sensing(sample_rate=2000.0),
    )
    (touch,) = run.touches
    # What is measured in a sample acts in the next one.
    assert_allclose(touch.depth, overrun(speed, rate, angle), atol=2.0 * speed * math.sin(angle) / 2000.0)
    begin = 0.004 / (speed * math.sin(angle))
    assert_allclose(touch.start, begin, atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wall", "servos"),
    [
        (HalfPlane(), "real"),
        (Disc(0.2), "ideal"),
        pytest.param(HalfPlane(), "ideal", marks=pytest.mark.slow),
        pytest.param(Disc(0.2), "real", marks=pytest.mark.slow),
    ],
)
def test_wall_ahead_is_not_overrun(wall, servos):
    start = [0.0, 0.05, 0.0] if isinstance(wall, HalfPlane) else [-0.3, 0.05, 0.0]
    run = session(
        one_wheel(REAL_WHEEL),
        controller=WallGuide(wall=wall, direction=-0.6),
        user=[5.0, -10.0],
        duration=0.3,
        rates=[0.4 * math.cos(0.6), -0.4 * math.sin(0.6), 0.0],
        pose=start,
        servos=servos,
        output_step=0.005,
    )
    assert run.penetration.max() < 5e-4
    assert run.feasible
    assert run.penetration[-1] > -5e-3
    assert run.wall_force[-1] > 1.0


def test_handle_that_is_too_fast_for_its_contact_goes_through_the_wall():
    weak = replace(REAL_WHEEL, preload=100.0)
    speed = 1.0
    assert largest_turn_rate(weak.slip_force, 15.0, 10.0, speed) < 1.0
    run = session(
        one_wheel(weak),
        controller=WallGuide(wall=HalfPlane(), direction=-0.8),
        user=[0.0, -15.0],
        duration=0.2,
        rates=[speed * math.cos(0.8), -speed * math.sin(0.8), 0.0],
        pose=[0.0, 0.05, 0.0],
        servos="ideal",
        output_step=0.01,
    )
    assert run.penetration.max() > 0.03
    assert run.touches[0].depth == pytest.approx(run.penetration.max(), rel=1e-3)
    assert "wall penetrated" in " ".join(run.event_lines)


def test_push_beyond_the_slip_force_slips_along_and_through():
    run = session(
        one_wheel(replace(REAL_WHEEL, preload=100.0)),
        controller=PathGuide(curve=Line(), direction=0.0),
        user=[0.0, 30.0],
        duration=0.1,
        rates=[0.5, 0.0, 0.0],
        output_step=0.01,
    )
    assert run.slips
    assert not run.feasible
    assert abs(run.path_offset[-1]) > 1e-3
    assert run.closure < 1e-6


# Own controllers


@pytest.mark.slow
def test_coasting_keeps_its_energy_under_any_steering_of_ones_own():
    machine = cart(STIFF)

    def swinging(measured):
        def headings(time):
            return np.asarray(machine.cobot.headings([1.0, 0.0, 1.5 * math.sin(4.0 * time)]))

        ahead = measured.time + 0.001
        return Commands(steering=headings(ahead), steering_rate=(headings(ahead + 1e-3) - headings(ahead)) / 1e-3)

    run = session(machine, controller=swinging, duration=0.2, rates=[0.5, 0.0, 0.0], servos="ideal", output_step=0.01)
    twist = np.stack([run.columns[name] for name in ("v_x_m_s", "v_y_m_s", "w_rad_s")], axis=-1)
    kept = twist**2 @ [10.0, 10.0, 0.8]
    assert_allclose(kept, kept[0], rtol=1e-5)
    assert np.ptp(run.columns["angle_rad"]) > 0.02


def test_command_acts_one_sample_late():
    seen = []

    def stepping(measured):
        seen.append(float(measured.steering[0]))
        return Commands(steering=np.array([0.0 if measured.time < 0.0095 else 0.1]), steering_rate=np.zeros(1))

    session(one_wheel(STIFF), controller=stepping, duration=0.015, rates=[0.3, 0.0, 0.0], servos="ideal")
    # Commanded at the sample of 10 ms, it acts from 11 to 12 ms.
    assert_allclose(seen[:12], 0.0, atol=1e-12)
    assert_allclose(seen[12:], 0.1, atol=1e-12)


# Sensors


def test_sensors_are_quantised_differenced_noisy_and_repeatable():
    def watched(into):
        def law(measured):
            into.append(measured)
            return Commands()

        return law

    sensing = Sensing(
        position_resolution=1e-5, differenced=True, speed_filter=50.0, force_noise=0.2, force_filter=100.0, seed=3
    )
    runs = []
    for _ in range(2):
        into = []
        session(one_wheel(STIFF), controller=watched(into), user=[2.0, 0.0], duration=0.1, rates=[0.3, 0.0, 0.0],
                sensing=sensing, servos="ideal")  # fmt: skip
        runs.append(into)
    first, second = runs
    assert all(np.array_equal(one.force, other.force) for one, other in zip(first, second, strict=True))
    positions = np.array([one.position[0] for one in first]) / 1e-5
    assert_allclose(positions, np.round(positions), atol=1e-6)
    assert_allclose(np.mean([one.velocity[0] for one in first[40:]]), 0.3 + 0.2 * 0.0667, rtol=0.02)
    forces = np.array([one.force[0] for one in first])
    assert 0.02 < np.std(forces) < 0.2
    assert abs(np.mean(forces) - 2.0) < 0.1


def test_results_say_and_hold_what_happened():
    run = session(
        one_wheel(REAL_WHEEL),
        controller=WallGuide(wall=HalfPlane(), direction=-0.6),
        user=[5.0, -10.0],
        duration=0.05,
        pose=[0.0, 0.05, 0.0],
        rates=[0.3, -0.2, 0.0],
        title="Cart at a wall",
    )
    said = run.to_dict()
    assert said["machine"] == "Cart at a wall"
    assert said["closure"] < 1e-6
    assert set(said["supplied_J"]) == {"user", "steering supply"}
    assert_allclose(
        sum(run.supplied[name][-1] for name in run.supplied),
        sum(lost[-1] for lost in run.lost.values()) + sum(one[-1] - one[0] for one in run.stored.values()),
        atol=1e-7,
    )
    assert run == run
    assert run.force.shape == run.position.shape == (len(run.time), 2)
    with pytest.raises(iv.ParameterError, match="path is missing"):
        _ = run.path_offset


# Misuse


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"machine": LEG}, "machine must be one of PlatformMachine"),
        ({"duration": 0.0}, "duration must be > 0"),
        ({"duration": 1e9}, "duration must be at most a million samples long"),
        ({"duration": math.nan}, "duration must be"),
        ({"servos": "none"}, "servos must be real or ideal"),
        ({"sensing": 3}, "sensing must be a Sensing"),
        ({"user": [1.0]}, "user must be 2 finite numbers"),
        ({"user": [1.0, math.inf]}, "user must be 2 finite numbers"),
        ({"user": [1.0, 0.0], "force": [1.0, 0.0]}, "user and force are both forces"),
        ({"intention": [0.0, 0.0]}, "intention is of an arm"),
        ({"pose": [0.0]}, "pose must be 3 finite numbers"),
        ({"rates": [0.0]}, "rates must be 3 finite numbers"),
        ({"handle": (0.0,)}, "handle must be x and y"),
        ({"controller": 3}, "controller must be a function"),
        ({"controller": lambda measured: Commands(steering=np.zeros(4))}, "controller must command steering by 1 finite numbers"),
        ({"wall": 3}, "wall must have distance and normal"),
        ({"sensing": Sensing(sample_rate=500.0), "machine": replace(
            one_wheel(STIFF), control=CoboticControl(steering_bandwidth=80.0))},
         "sensing.sample_rate must be at least ten times control.steering_bandwidth"),
        ({"output_step": -1.0}, "output_step must be > 0"),
        ({"tolerance": 1.0}, "tolerance must be"),
    ],
)  # fmt: skip
def test_bad_sessions_have_one_clear_message(change, message):
    given = {"machine": one_wheel(STIFF), "duration": 0.01, **change}
    with pytest.raises(iv.ParameterError) as caught:
        session(given.pop("machine"), **given)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Sensing(sample_rate=100.0), "sample_rate must be"),
        (lambda: Sensing(force_filter=600.0), "force_filter must be below half of sample_rate"),
        (lambda: Sensing(seed=-1), "seed must be a whole number"),
        (lambda: Sensing(force_noise=math.nan), "force_noise must be"),
        (lambda: PathGuide(curve=3), "curve must have nearest"),
        (lambda: PathGuide(curve=Line(), k1=0.0), "k1 must be > 0"),
        (lambda: WallGuide(wall=Line()), "wall must have distance, normal and hessian"),
        (lambda: CasterGuide(mass=-1.0), "mass must be > 0"),
        (
            lambda: session(cart(STIFF), controller=WallGuide(wall=HalfPlane(), share=2.0), duration=0.1),
            "share must be",
        ),
    ],
)
def test_bad_guides_have_one_clear_message(make, message):
    with pytest.raises(iv.ParameterError) as caught:
        make()
    assert message in str(caught.value)


# Audit


def _random_session(seed, duration=0.1):
    rng = np.random.default_rng(seed)
    wheel = replace(REAL_WHEEL, creep_stiffness=10.0 ** rng.uniform(4.0, 6.0), preload=rng.uniform(200.0, 800.0))
    machine = cart(wheel, steering=STEERING) if seed % 2 else one_wheel(wheel)
    speed, angle = rng.uniform(0.2, 1.0), rng.uniform(-0.8, 0.8)
    guides = (
        PathGuide(curve=Line(), k1=rng.uniform(100.0, 2000.0)),
        CasterGuide(mass=rng.uniform(5.0, 40.0)),
        WallGuide(wall=HalfPlane(-0.01)),
        PathGuide(curve=Circle(rng.uniform(0.3, 2.0)), slip_feedforward=False),
    )
    force, rate = rng.normal(0.0, 12.0, 2), rng.uniform(2.0, 20.0)
    return session(
        machine,
        controller=guides[seed % 4],
        user=iv.motion.ArmModel.named("vanbeek2015") if seed % 3 == 0 else None,
        force=lambda time: force * math.sin(rate * time),
        duration=duration,
        rates=[speed * math.cos(angle), speed * math.sin(angle), 0.0],
        pose=[0.02, 0.01, 0.0],
        servos="ideal" if seed % 5 == 0 else "real",
        sensing=Sensing(position_resolution=1e-6, force_noise=0.05, seed=seed),
        output_step=0.01,
    )


@sampled("seed", range(4), every=2)
def test_balance_closes_in_random_sessions(seed):
    run = _random_session(seed, duration=0.04)
    assert run.complete, run.outcome
    assert run.closure < 1e-6


@sampled("seed", range(100, 130), slow=6)
def test_balance_closes_in_many_random_sessions(seed):
    run = _random_session(seed)
    assert run.complete, run.outcome
    assert run.closure < 1e-6
