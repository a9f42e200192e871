"""Moments of a user at the handle: against closed forms, in all quadrants, two ways, in C, in studies, and messages."""

import itertools
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from arms import MOTOR
from infinivar.machines import ArmDrive, RobotDrive
from infinivar.motion import AboutAxis, AboutPoint, Caster, Fixture
from internals import (
    PlatformLoad,
    SeparateMachine,
    SessionSetup,
    c_library,
    compiled_motion,
    inputs_of,
    rotation_matrix,
    rotation_vector,
    session_arguments,
)
from machines import HEXAPOD, IDEAL_WHEEL, LEG, PLATFORM, REAL_WHEEL, cart, ideal_leg
from made import loaded
from session_studies import tables

STEERING = replace(LEG.steering, patch_half_length=3e-4)
CART, IDEAL_CART = (cart(wheel, steering=STEERING) for wheel in (REAL_WHEEL, IDEAL_WHEEL))
IDEAL_HEXAPOD = replace(HEXAPOD, leg=ideal_leg())
GEAR = loaded("hand_controller").drives["motor1-gear1"]
FRICTIONLESS = replace(
    GEAR,
    motor=replace(GEAR.motor, no_load_current=0.0),
    gearhead=replace(GEAR.gearhead, efficiency=1.0),
    guideway=iv.parts.Guideway(),
)
GEARED_HEXAPOD = SeparateMachine(
    separate=FRICTIONLESS,
    load=PlatformLoad(platform=PLATFORM, mass=1.0, inertia=np.array([1e-3, 1e-3, 2e-3])),
    home=HEXAPOD.home,
)
OMNIWHEELS = next(
    one.moving() for one in loaded("omniwheel_platform").drives.values() if getattr(one, "separate", None) is not None
)
ARM = ArmDrive(lengths=(0.3, 0.25, 0.12), member_masses=(0.4, 0.3, 0.1), pulley_radius=0.05, separate=MOTOR).moving()


@dataclass
class Grips:
    """An arm that turns the handle."""

    mass: float = 0.3
    damping: float = 4.0
    stiffness: float = 80.0
    inertia: float = 2e-3
    turning_damping: float = 0.05
    turning_stiffness: float = 1.2


def robot():
    study = loaded(Path(__file__).parents[2] / "studies" / "robots" / "pick_and_place.toml")
    return next(one for one in study.drives.values() if isinstance(one, RobotDrive))


# Closed forms


@pytest.mark.parametrize("about", range(3))
def test_a_constant_moment_turns_a_free_platform_as_its_virtual_inertia(about):
    moment, inertia = np.eye(3)[about] * 0.04, 0.02
    run = iv.session(IDEAL_HEXAPOD, Caster(mass=2.0, inertia=inertia), moment=moment, duration=0.2, servos="ideal")
    turned = np.stack([run.columns[f"handle_{one}_rad"] for one in run.turns], axis=-1)
    assert run.turns == ("rx", "ry", "rz")
    # Commands act a sample late: by t/2 of this, of a turn of M t^2 / 2 J.
    late = 0.04 / inertia * 0.2 * run.sensing.period
    assert_allclose(turned, 0.5 * moment / inertia * run.time[:, None] ** 2, atol=late)
    assert_allclose(run.moment, np.broadcast_to(moment, turned.shape))
    assert_allclose(run.position, np.broadcast_to(run.position[0], turned.shape), atol=1e-5)
    assert_allclose(run.joules["from user"], 0.5 * 0.04**2 / inertia * 0.2**2, rtol=2.5 * run.sensing.period / 0.2)
    assert run.closure < 1e-6


def test_a_constant_moment_against_damping_turns_a_platform_by_the_closed_form():
    inertia, damping, moment = 0.02, 0.4, 0.05
    guide = iv.machines.AdmittanceGuide(inertia=inertia, turning_damping=damping)
    run = iv.session(
        IDEAL_HEXAPOD, controller=guide, moment=[0.0, moment, 0.0], duration=0.2, servos="ideal", output_step=1e-3
    )
    known = moment / damping * (1.0 - np.exp(-damping / inertia * run.time))
    # A sample of delay, and one in which the virtual mass moves by an explicit step.
    assert_allclose(run.angular_velocity[:, 1], known, atol=2.0 * run.sensing.period * moment / inertia)


@pytest.mark.parametrize("servos", ["ideal", "real"])
def test_a_planar_arm_of_three_joints_on_legs_is_free_to_move_and_turn(servos):
    drive = ArmDrive(lengths=(0.3, 0.25, 0.12), member_masses=(0.4, 0.3, 0.1), pulley_radius=0.05, leg=ideal_leg())
    task, push, moment = Caster(mass=2.0, inertia=0.02), np.array([1.0, -0.5]), 0.03
    user = {"user": push, "moment": [moment]}
    run = iv.session(drive.moving(), task, duration=0.1, servos=servos, pose=[0.4, 0.9, -0.5], **user)
    turned = run.columns["handle_angle_rad"]
    assert_allclose(turned - turned[0], 0.5 * moment / 0.02 * run.time**2, atol=4e-4)
    assert_allclose(run.position - run.position[0], 0.5 * push / 2.0 * run.time[:, None] ** 2, atol=2e-4)
    assert run.closure < 1e-6


def test_an_arm_turns_a_member_without_friction_by_the_closed_form():
    drive = ArmDrive(lengths=(0.3,), member_masses=(0.4,), pulley_radius=0.05, separate=FRICTIONLESS)
    arm, wanted = Grips(mass=0.2, damping=0.0, stiffness=0.0, turning_damping=0.2, turning_stiffness=25.0), 0.05
    run = iv.session(drive.moving(), user=arm, turned=[wanted], duration=0.5, output_step=0.005)
    reflected = drive.moving().link_motors(1e-4).moved_mass * 0.05**2
    inertia = 0.4 * 0.3**2 / 3.0 + reflected + arm.mass * 0.3**2 + arm.inertia
    decay, circular = 0.5 * arm.turning_damping / inertia, math.sqrt(arm.turning_stiffness / inertia)
    ring = math.sqrt(circular**2 - decay**2)
    known = wanted * (
        1.0 - np.exp(-decay * run.time) * (np.cos(ring * run.time) + decay / ring * np.sin(ring * run.time))
    )
    assert_allclose(run.columns["handle_angle_rad"], known, atol=1e-6)
    assert_allclose(run.stored["arm"][0], 0.5 * arm.turning_stiffness * wanted**2, rtol=1e-12)
    assert_allclose(run.supplied["user"], 0.0, atol=1e-12)
    # Between hand and handle acts what turns the rest; the arm's mass at the end point is not in the moment.
    rest = (inertia - arm.inertia - arm.mass * 0.3**2) * np.gradient(run.angular_velocity[:, 0], run.time)
    tip = run.force[:, 1] * np.cos(known) * 0.3 - run.force[:, 0] * np.sin(known) * 0.3
    assert_allclose((run.moment[:, 0] + tip)[2:-2], rest[2:-2], atol=0.02)
    assert run.closure < 1e-6


# Two ways


def test_a_pure_moment_and_an_eccentric_force_turn_a_platform_about_an_axis_alike():
    radius, moment = 0.03, 0.06
    task = Fixture(allowed=AboutAxis(point=(-radius, 0.0, 0.0), axis=(0.0, 0.0, 1.0)))

    def turned(**user):
        run = iv.session(IDEAL_HEXAPOD, task, duration=0.2, servos="ideal", **user)
        return run, run.columns["theta_z_rad"]

    by_moment, angle = turned(moment=[0.0, 0.0, moment])

    def force(time):
        around = np.interp(time, by_moment.time, angle)
        return moment / radius * np.array([-math.sin(around), math.cos(around), 0.0])

    by_force, other = turned(user=force)
    guide = iv.machines.AdmittanceGuide()
    known = 0.5 * moment / (guide.inertia + guide.mass * radius**2) * 0.2**2
    assert_allclose(angle[-1], known, rtol=0.02)
    assert_allclose(other, angle, atol=1e-3 * known)
    assert_allclose(by_force.joules["from user"], by_moment.joules["from user"], rtol=1e-3)


def test_a_pure_moment_and_an_eccentric_force_turn_a_cart_about_a_point_alike():
    radius, moment = 0.3, 3.0
    task = Fixture(allowed=AboutPoint(point=(-radius, 0.0)))

    def turned(**user):
        run = iv.session(IDEAL_CART, task, duration=0.4, servos="ideal", **user)
        return run, run.columns["angle_rad"]

    by_moment, angle = turned(moment=[moment])

    def force(time):
        around = np.interp(time, by_moment.time, angle)
        return moment / radius * np.array([-math.sin(around), math.cos(around)])

    _, other = turned(user=force)
    body = IDEAL_CART.cobot
    assert_allclose(angle, 0.5 * moment / (body.inertia + body.mass * radius**2) * by_moment.time**2, atol=2e-4)
    assert_allclose(other, angle, atol=1e-4)


# Energies


TURNING = {
    "legs": (HEXAPOD, {}),
    "motors": (GEARED_HEXAPOD, {}),
    "cart": (CART, {"handle": [0.1, -0.2], "rates": [0.2, 0.1, 0.3]}),
    "arm": (ARM, {"pose": [0.4, 0.9, -0.5]}),
    "omniwheels": (OMNIWHEELS, {}),
}
PLANAR = ("cart", "arm", "omniwheels")


@pytest.mark.parametrize("name", TURNING)
@pytest.mark.parametrize("grips", [False, True])
def test_the_power_of_a_user_who_turns_is_balanced_in_all_quadrants(name, grips):
    """Powers are the rate of the energies along the motion."""
    (machine, more), planar = TURNING[name], name in PLANAR
    pushing = np.array([2.0, -3.0] if planar else [2.0, -3.0, 4.0])
    turning = np.array([0.3] if planar else [0.3, -0.2, 0.25])
    wanted = 0.2 * turning
    user = {"user": Grips(), "force": pushing, "turned": lambda at: wanted + 2.0 * at * turning} if grips else {}
    setup = SessionSetup(machine=machine, duration=0.01, moment=turning, **({"user": pushing} | user), **more)
    system, start = setup.system, np.zeros(1)
    first, second, _ = system.places
    random, quadrants = np.random.default_rng(3), set()
    for speed, push in itertools.product((-1.0, 1.0), repeat=2):
        state = setup.state.copy()
        state[:first] += 0.02 * random.normal(size=first)
        state[first:second] = 0.3 * random.normal(size=second - first)
        held = setup.grip.at(state[None, :first], state[None, first:second])
        turned = held.about().jacobian[0] @ state[first:second]
        if speed * (turned @ turning) < 0.0:
            state[first:second] *= -1.0
        outside = system.outside(start)
        outside = outside._replace(force=push * outside.force)
        moved = system.moved(system.idle(), outside, state[None])
        balance = moved.balance()

        def stored(time, state=state, outside=outside, derivative=moved.derivative):
            row, acts = state[None] + time * derivative, outside
            if grips:  # the intention moves at the rate that the user gives it
                acts = outside._replace(intended=outside.intended + time * outside.intending)
            moves = row[:, :first], row[:, first:second]
            held = system.hand.act(acts.force, acts.intended, acts.intending, *moves)
            return replace(system, hand=None).energies(start, row).sum() + held.energy(moves[1])[0]

        along = (stored(1e-6) - stored(-1e-6)) / 2e-6
        peak = np.abs(balance.power).max()
        assert abs(float(system.balance @ balance.power[0]) - along) < 1e-6 * peak
        moment = push * turning
        quadrants.add((bool(moment[0] > 0.0), bool(moment @ held.about().jacobian[0] @ state[first:second] > 0.0)))
        if not grips:
            power = (
                push * pushing @ (held.jacobian[0] @ state[first:second])
                + moment @ held.about().jacobian[0] @ state[first:second]
            )
            assert_allclose(balance.power[0, 0], power, rtol=1e-12)
    assert len(quadrants) == 4


@pytest.mark.parametrize("name", TURNING)
def test_a_handle_turns_by_its_jacobian_and_bias(name):
    """Angular velocity and acceleration by differences of the orientation along a motion."""
    machine, more = TURNING[name]
    mechanics = machine.mechanics(1e-4)
    grip, random = mechanics.grip(), np.random.default_rng(7)
    begins = np.array(more.get("pose", machine.home), dtype=float)
    count, width = len(mechanics.coordinates), len(begins)
    for _ in range(5):
        c, nu = begins + 0.1 * random.normal(size=width), random.normal(size=count)
        check_turning(grip, lambda c, nu: mechanics.at(c[None], nu[None]).changes[0], c, nu)


def check_turning(grip, changes, c, nu, step=1e-4):
    def at(time):  # a Taylor series of the configuration, at constant rates
        first = changes(c, nu)
        second = (changes(c + 1e-6 * first, nu) - changes(c - 1e-6 * first, nu)) / 2e-6
        return grip.at((c + time * first + 0.5 * time**2 * second)[None], nu[None]).about().at[0]

    def between(one, other):
        return rotation_vector(other @ one.T) if one.ndim == 2 else other - one

    about = grip.at(c[None], nu[None]).about()
    back, here, ahead = at(-step), at(0.0), at(step)
    assert_allclose(between(back, ahead) / (2.0 * step), about.jacobian[0] @ nu, atol=1e-6)
    assert_allclose((between(here, ahead) - between(back, here)) / step**2, about.bias[0], atol=1e-5)


def test_the_tool_of_a_robot_turns_by_its_jacobian_and_bias():
    pytest.importorskip("pinocchio", reason="the extra infinivar[robots] has pin")
    machine = robot().moving()
    grip, random = machine.mechanics(1e-4).grip(), np.random.default_rng(5)
    count = len(machine.mechanics(1e-4).coordinates)
    for _ in range(5):
        c = machine.home + 0.1 * random.normal(size=len(machine.home))
        check_turning(grip, lambda c, nu: nu[: len(c)], c, random.normal(size=count))


def test_a_moment_acts_on_a_body_wherever_it_is_held():
    near, far = (iv.session(CART, moment=[0.5], duration=0.02, handle=point) for point in ([0.0, 0.0], [0.3, 0.2]))
    assert_allclose(far.columns["angle_rad"], near.columns["angle_rad"], rtol=1e-12, atol=1e-15)


def test_what_turns_to_an_intention_stays_within_half_a_turn():
    start = rotation_matrix(np.array([0.2, -0.1, 3.0]))
    held = HEXAPOD.mechanics(1e-4).grip().at(np.append(HEXAPOD.home[:3], [0.3, 0.1, -3.1])[None], np.zeros((1, 7)))
    goal = np.array([[0.1, 0.2, 0.05]])
    turn = held.about().apart(start, goal)
    assert_allclose(
        rotation_matrix(turn[0]) @ held.about().at[0], rotation_matrix(goal[0]) @ start, rtol=0.0, atol=1e-12
    )


@pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler on this machine")
@pytest.mark.parametrize("name", TURNING)
def test_compiled_it_is_the_same(name):
    (machine, more), count = TURNING[name], 1 if name in PLANAR else 3
    setup = SessionSetup(
        machine=machine, user=Grips(), moment=[0.1] * count, turned=lambda at: [0.3 * at] * count, duration=0.01, **more
    )
    motion = compiled_motion(setup.system)
    assert motion is not None
    random, system = np.random.default_rng(1), setup.system
    # At the start, where turn and intention are zero, and elsewhere.
    for time, away in ((0.0, 0.0), (0.1, 0.02)):
        state = setup.state + away * random.normal(size=len(setup.state))
        outside = system.outside(np.array([time]))
        known = system.moved(system.idle(), outside, state[None]).derivative[0]
        inputs = inputs_of(system.idle(), outside)
        assert_allclose(motion.called("rates_at", motion.states, state, inputs), known, rtol=1e-9, atol=1e-9)
        slopes = motion.called("slopes_at", motion.states**2, state, inputs)
        assert np.isfinite(slopes).all()


# Studies

TURNS = {
    "pushed": ({"type": "force", "angle": {"shape": "constant", "moment": "0.5 N m"}}, [0.5]),
    "pushed both ways": (
        {
            "type": "force",
            "x": {"shape": "constant", "size": "2 N"},
            "angle": {"shape": "sinusoid", "moment": "0.5 N m", "frequency": "2 Hz"},
        },
        [0.0],
    ),
}
HELD = {"mass": "0.5 kg", "damping": "5 N s/m", "stiffness": "100 N/m"}
TURNED = {"inertia": "2 g m^2", "turning_damping": "0.05 N m s/rad", "turning_stiffness": "1.2 N m/rad"}


@pytest.mark.parametrize("case", TURNS)
def test_a_study_states_moments(case, tmp_path):
    user, first = TURNS[case]
    study = iv.Study.from_dict(tables(("free", "user", user)), name="turned")
    found = session_arguments(study.sessions["free"], study.drives["cart"], "tasks.free", "drives.cart")
    assert found["moment"](0.0).tolist() == first
    run = iv.study_session(study, "free")
    assert run.turns == ("angle",)
    assert_allclose(run.moment[0], first)
    iv.save_study(study, tmp_path / "study.toml")
    assert iv.load_study(tmp_path / "study.toml").sessions == study.sessions
    files = iv.save(run, tmp_path / "out")
    assert iv.load_result(tmp_path / "out").turns == run.turns
    assert any("moment_angle_Nm" in file.read_text("utf-8") for file in files if file.suffix == ".csv")


@pytest.mark.parametrize("named", [False, True])
def test_a_study_states_an_arm_that_turns(named):
    user = {"type": "arm", **({"arm": "vanbeek2015"} if named else HELD), **TURNED}
    user["angle"] = {"shape": "reach", "angle": "0.1 rad", "time": "0.2 s"}
    study = iv.Study.from_dict(tables(("free", "user", user), ("free", "duration", "50 ms")), name="turned")
    run = iv.study_session(study, "free")
    assert run.user.inertia == 2e-3
    assert run.closure < 1e-6
    assert run.moment[-1, 0] > 0.0
    assert ("the study" in run.user.source) is True


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"machine": iv.machines.SlideMachine(leg=LEG, masses=[0.3]), "moment": [0.1]},
         "moment does not apply: the handle of a SlideMachine does not turn"),
        ({"machine": iv.machines.SlideMachine(leg=LEG, masses=[0.3]), "user": Grips()},
         "user.inertia does not apply: the handle of a SlideMachine does not turn"),
        ({"machine": CART, "moment": [0.1, 0.2, 0.3]}, "moment must be 1 finite numbers at each instant"),
        ({"machine": HEXAPOD, "moment": [0.1]}, "moment must be 3 finite numbers at each instant"),
        ({"machine": CART, "turned": [0.1]}, "turned is of an arm that turns: user must be one, with inertia"),
        ({"machine": CART, "user": iv.motion.ArmModel.named("vanbeek2015"), "turned": [0.1]}, "turned is of an arm that"),
    ],
)  # fmt: skip
def test_bad_moments_have_one_clear_message(given, message):
    with pytest.raises(iv.ParameterError, match=message):
        iv.session(duration=0.01, **given)


def test_an_arm_that_wants_the_handle_turned_beyond_half_a_turn_is_named():
    """The shortest turn from handle to intention changes its direction there."""
    with pytest.raises(iv.ParameterError, match=r"half a turn or more from where it is, at 0\.3"):
        iv.session(
            HEXAPOD,
            iv.motion.HoldingTask(),
            user=Grips(turning_stiffness=0.05),
            turned=lambda at: [0.0, 0.0, 10.0 * at],
            duration=0.4,
        )
