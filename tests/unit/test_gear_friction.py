"""Friction of a geared actuator that depends on load, direction and speed: the law, the part, a drive by two ways."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import DutyCycle, Scenario, duty_cycle, gearheads
from infinivar.analysis import two_ways
from infinivar.motion import ConstantForce, Hold, Reaches
from internals import DERIVATIVE_METHODS as METHODS
from internals import friction_budget, gradient, stribeck_friction
from internals import gear_friction_terms as terms
from internals import loss_outcome as loss
from made import parameter_study
from sampled import sampled

GEARED = parameter_study("faulring2006").drives["motor2-gear4"]
IDENTIFIED = {key: gear for key, gear in gearheads().items() if gear.friction is not None}


def random_friction(random, scale=1.0):
    inward = random.uniform(0.0, 0.45, 2)
    return iv.parts.GearFriction(
        friction=scale * random.uniform(0, 0.2),
        viscous=scale * random.uniform(0, 0.1),
        friction_stribeck=scale * random.uniform(0, 0.2),
        stribeck_speed=random.uniform(0.2, 4),
        stribeck_exponent=random.uniform(0.5, 4),
        load_motor=inward[0],
        load_output=random.uniform(0, 1.5),
        load_motor_stribeck=inward[1],
        load_output_stribeck=random.uniform(0, 0.6),
        load_motor_squared=random.uniform(0, 0.5) / scale,
        load_output_squared=random.uniform(0, 0.5) / scale,
    )


def by_the_source(friction, speed, torque, lost):
    """Right-hand side of the source's law at a friction torque: what the implicit law must return."""
    entering = torque + lost * np.sign(speed)
    p = friction
    slow = np.exp(-(np.abs(speed / p.stribeck_speed) ** p.stribeck_exponent))
    driving = np.abs(entering) > np.abs(torque)
    squared = np.where(driving, p.load_output_squared * torque**2, p.load_motor_squared * entering**2)
    squared = np.where(entering * torque > 0, squared, 0.0)
    loads = np.abs(p.load_motor_stribeck * entering + p.load_output_stribeck * torque)
    base = p.friction + p.viscous * np.abs(speed) + np.abs(p.load_motor * entering + p.load_output * torque)
    return base + slow * (p.friction_stribeck + loads + squared)


@pytest.mark.parametrize("seed", range(40))
def test_it_solves_the_law_and_never_creates_power(seed):
    """Forty random gears at 500 random points in all four quadrants."""
    random = np.random.default_rng(seed)
    friction = random_friction(random)
    speed, torque = random.uniform(-6, 6, 500), random.normal(0, 3, 500)
    lost = friction_budget(speed, torque, **terms(friction))
    assert np.all(lost >= 0)
    assert_allclose(by_the_source(friction, speed, torque, lost), lost, rtol=1e-9, atol=1e-12)
    gear = iv.parts.Gearhead(ratio=30.0, loss_model="stribeck", friction=friction)
    point = gear.operate(output_torque=torque, output_speed=speed, motor_rated_torque=1.0)
    received, delivered = point.motor_torque * point.motor_speed, torque * speed
    assert np.all(point.loss >= 0)
    assert_allclose(received - delivered, point.loss, atol=1e-9)
    smooth = stribeck_friction(30.0 * speed, torque / 30.0, 30.0, 15.0, **terms(friction))
    assert np.all(smooth * speed >= 0)
    assert np.all(np.abs(smooth) <= lost / 30.0 * (1 + 1e-12))


@pytest.mark.parametrize("seed", range(20))
def test_between_two_inertias_it_solves_the_law_exactly(seed):
    """Friction that lowers the torque that leaves the gear: the law at that torque, in all quadrants and while sticking."""
    random = np.random.default_rng(seed)
    p = random_friction(random)
    speed, torque = random.uniform(-6, 6, 500), random.normal(0, 3, 500)
    returned = random.uniform(0, 0.95 * min(p.largest_returned, 1.0), 500)
    lost = friction_budget(speed, torque, returned=returned, **terms(p))
    left = torque - returned * lost * np.sign(speed)
    assert_allclose(friction_budget(speed, left, **terms(p)), lost, rtol=1e-9, atol=1e-12)
    gain, ratio, stick = -returned, 12.0, random.uniform(5, 100)
    friction = stribeck_friction(ratio * speed, torque, ratio, stick, gain=gain, **terms(p))
    by_hand = stribeck_friction(ratio * speed, torque + gain * friction, ratio, stick, **terms(p))
    assert_allclose(by_hand, friction, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_it_jams_from_the_stated_inertia_on(seed):
    """Just below, a large load slowed by friction has one solution; just above, the straight lines far out cross again."""
    p = random_friction(np.random.default_rng(seed))
    p = replace(p, load_output=p.load_output + 0.5)
    most = p.largest_returned
    far = 1e9  # of friction; torque is then that of the lowered load alone, which drives
    for returned, jams in ((0.99 * most, False), (1.01 * most, True)):
        found = friction_budget(1e-12, -returned * far, **terms(replace(p, load_motor_squared=0.0)))
        assert (found > far) == jams


@pytest.mark.slow
def test_a_gear_that_would_jam_is_refused():
    """Load terms of 2 in all: friction exceeds the load that drives it, and would stop a large inertia at once."""
    locking = replace(LOADED, load_output=1.9)
    drive = actuated(locking)
    both = drive.motor.rotor_inertia * drive.gearhead.ratio**2
    most = both * locking.largest_returned / (1.0 - locking.largest_returned)
    assert 0 < most < 1
    heaviest = (most - drive.gear_output_inertia) / drive.pulley.radius**2
    iv.simulate(drive, Scenario(duration=0.01, motion=Hold(time=1.0), load_mass=0.99 * heaviest))
    message = "load_mass is too large: inertias at the gearhead's output must be < .* jams when the load drives it"
    with pytest.raises(iv.InputError, match=message):
        iv.simulate(drive, Scenario(duration=0.01, motion=Hold(time=1.0), load_mass=1.01 * heaviest))
    with pytest.raises(iv.InputError, match="link = 'imposed' cannot move a self-locking gearhead"):
        iv.simulate(drive, Scenario(duration=0.01, motion=Hold(time=1.0), load_mass=0.1, link="imposed"))


@pytest.mark.parametrize("seed", range(10))
def test_it_is_continuous_but_for_the_step_at_rest(seed):
    """Across zero load and zero speed on either side, and where the friction just equals the load."""
    random = np.random.default_rng(seed)
    p = terms(random_friction(random))
    speed = random.uniform(-4, 4, 200)
    assert_allclose(friction_budget(speed, 1e-12, **p), friction_budget(speed, -1e-12, **p), rtol=1e-9)
    torque = np.linspace(-2, 2, 200_001)
    assert np.abs(np.diff(friction_budget(1.0, torque, **p))).max() < 1e-3
    # With a stick speed, the direction changes smoothly, too; a law without power at rest may have any torque there.
    crossing = np.linspace(-1e-4, 1e-4, 2001)
    steps = np.abs(np.diff(stribeck_friction(crossing, 0.5, 1.0, 1e-3, **p)))
    assert steps.max() < 5e-3 * friction_budget(0.0, -0.5, **p) + 5e-3 * friction_budget(1e-9, 0.5, **p)


def test_without_load_and_speed_terms_it_is_the_coulomb_model():
    """The same torque, loss and holding torque in every quadrant and at rest."""
    torque, speed = np.array([2.0, -2.0, -2.0, 2.0, 2.0, 0.01]), np.array([3.0, -3.0, 3.0, -3.0, 0.0, 0.0])
    coulomb = iv.parts.Gearhead(ratio=20.0, efficiency=0.8, rated_torque=0.1)
    stribeck = iv.parts.Gearhead(
        ratio=20.0, loss_model="stribeck", friction=iv.parts.GearFriction(friction=20.0 * 0.2 * 0.1)
    )
    points = [g.operate(output_torque=torque, output_speed=speed, motor_rated_torque=9.0) for g in (coulomb, stribeck)]
    assert_allclose(points[0].motor_torque, points[1].motor_torque, rtol=1e-12)
    assert_allclose(points[0].loss, points[1].loss, rtol=1e-12)


def test_viscous_and_load_terms_by_hand():
    """2 N m at 3 rad/s: 0.1 + 0.05 x 3 N m, and with 0.2 of the motor's and 0.1 of the load's torque either way."""
    plain = iv.parts.GearFriction(friction=0.1, viscous=0.05)
    assert friction_budget(3.0, 2.0, **terms(plain)) == pytest.approx(0.25)
    loaded = terms(replace(plain, load_motor=0.2, load_output=0.1))
    driving, driven = friction_budget(3.0, 2.0, **loaded), friction_budget(-3.0, 2.0, **loaded)
    assert driving == pytest.approx((0.25 + 0.3 * 2.0) / 0.8)
    assert driving == pytest.approx(0.25 + 0.2 * (2.0 + driving) + 0.1 * 2.0)
    assert driven == pytest.approx(0.25 + 0.2 * (2.0 - driven) + 0.1 * 2.0)


def test_at_rest_it_holds_up_to_the_backdriving_friction_and_breaks_away_above_the_driving_one():
    friction = iv.parts.GearFriction(friction=0.1, friction_stribeck=0.2, load_output=0.1)
    gear = iv.parts.Gearhead(ratio=10.0, loss_model="stribeck", friction=friction)
    torque = np.array([0.2, 1.0, -1.0])
    held = gear.operate(output_torque=torque, output_speed=np.zeros(3), motor_rated_torque=1.0).motor_torque
    assert_allclose(held, [0.0, 0.06, -0.06], atol=1e-15)  # 0.3 N m and a tenth of the load less
    breakaway = gear.operate(output_torque=1.0, output_speed=1e-9, motor_rated_torque=1.0).motor_torque
    assert breakaway == pytest.approx(0.14, rel=1e-6)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"load_motor": 0.6, "load_motor_stribeck": 0.4}, "load_motor_stribeck must be < 1"),
        ({"friction": -0.1}, "friction must be >= 0 N m, got -0.1"),
        ({"stribeck_speed": 0.0}, "stribeck_speed must be > 0 rad/s, got 0"),
    ],
)
def test_terms_that_are_refused(changed, message):
    with pytest.raises(iv.InputError, match=message):
        iv.parts.GearFriction(**changed)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"loss_model": "stribeck"}, "friction is missing: loss_model = 'stribeck' needs it"),
        ({"loss_model": "coulomb"}, "efficiency is missing: loss_model = 'coulomb' needs it"),
        (
            {"loss_model": "stribeck", "friction": iv.parts.GearFriction(), "efficiency": 0.9},
            "efficiency does not apply with loss_model = 'stribeck'; remove it",
        ),
        (
            {"efficiency": 0.9, "friction": iv.parts.GearFriction()},
            "friction does not apply with loss_model = 'coulomb'",
        ),
    ],
)
def test_gearheads_that_are_refused(changed, message):
    with pytest.raises(iv.InputError, match=message):
        iv.parts.Gearhead(ratio=20.0, **changed)


def actuated(friction):
    """A drive of the paper with another gear, whose friction is about that of the original one."""
    gear = iv.parts.Gearhead(ratio=4.0, loss_model="stribeck", friction=friction)
    return replace(GEARED, gearhead=gear, guideway=iv.parts.Guideway(friction=0.5))


LOADED = iv.parts.GearFriction(
    friction=0.004,
    viscous=4e-5,
    friction_stribeck=0.006,
    stribeck_speed=2.0,
    stribeck_exponent=1.2,
    load_motor=0.1,
    load_output=0.06,
    load_motor_stribeck=0.1,
    load_output_stribeck=0.05,
    load_motor_squared=0.05,
    load_output_squared=0.05,
)


SLOW_FALL = replace(LOADED, stribeck_speed=0.5, stribeck_exponent=0.5)
"""The Stribeck terms have fallen by a few percent at the speed at which a load at rest creeps."""
LOCKING = random_friction(np.random.default_rng(1), 0.05)
"""It locks against its load, by a friction that grows with the load faster than the load itself."""


def check_both_ways(drive, duty):
    """Energy, loss of the gear and position by inverse dynamics and in time; and the law at every instant of the simulation."""
    both = two_ways(drive, duty)
    assert both.rms_error < 1e-3 * np.ptp(duty.instants().position)
    assert both.followed == pytest.approx(both.prescribed, rel=0.01)
    assert both.lost_followed["gearhead"] == pytest.approx(both.lost_prescribed["gearhead"], rel=0.01)
    run, gear = both.simulation.trajectory, drive.gearhead
    friction, speed = run.at("gear_loss")
    stick = run.graph["gear_loss"].parameters["stick_speed"].value
    law = stribeck_friction(speed, run.signals["gear_torque"], gear.ratio, stick, **terms(gear.friction))
    assert_allclose(friction, law, atol=1e-9 * np.abs(law).max())


def reaches(force, pause, mass=0.8):
    return DutyCycle(motion=Reaches(distance=0.1, time=0.6, pause=pause), force=force, load_mass=mass)


def turned(key, sign, pause=0.3):
    """An identified actuator as a joint: its friction with a motor strong enough for it, and a moment of 1.5 times that."""
    friction = IDENTIFIED[key].friction
    rest = friction.friction + friction.friction_stribeck
    gear = iv.parts.Gearhead(
        ratio=max(4.0, 6.0 * rest / GEARED.motor.continuous_torque), loss_model="stribeck", friction=friction
    )
    drive = iv.ConventionalDrive(motor=GEARED.motor, gearhead=gear, shaft=iv.parts.Shaft(), amplifier=GEARED.amplifier)
    motion = Reaches(angle=1.0, time=0.8, pause=pause)
    return drive, DutyCycle(motion=motion, moment=sign * 1.5 * rest, load_inertia=0.01)


@sampled(
    ("friction", "force", "pause"),
    [(LOADED, -25.0, 0.0), (SLOW_FALL, 25.0, 0.3), (LOADED, -25.0, 0.3), (LOADED, 25.0, 1.0), (LOCKING, -15.0, 0.3)],
    slow=2,
)
def test_motion_and_simulation_agree(friction, force, pause):
    """Lifting and lowering, without and with rests, in which part of the friction helps to hold."""
    check_both_ways(actuated(friction), reaches(force, pause))


@pytest.mark.slow
def test_motion_and_simulation_of_an_identified_joint_agree():
    check_both_ways(*turned("mx64", -1.0))


@sampled("force", [-15.0, 15.0], slow=2)
@pytest.mark.parametrize("pause", [0.1, 0.6])
@sampled("seed", range(4), slow=4)
def test_motion_and_simulation_of_random_gears_agree(seed, pause, force):
    check_both_ways(actuated(random_friction(np.random.default_rng(seed), 0.05)), reaches(force, pause))


@sampled("sign", [-1.0, 1.0], slow=2)
@sampled("key", IDENTIFIED, slow=4)
def test_motion_and_simulation_of_identified_joints_agree(key, sign):
    check_both_ways(*turned(key, sign))


@sampled("seed", range(4), every=4)
def test_both_ways_close_on_random_gears(seed):
    """The audit of inverse dynamics and of a simulation, driven, back-driven and at rest."""
    random = np.random.default_rng(seed)
    drive = actuated(random_friction(random, 0.05))
    duty = DutyCycle(motion=Reaches(distance=0.1, time=0.6, pause=0.3), force=-15.0, load_mass=0.8)
    assert duty_cycle(drive, duty).closure < 1e-9
    run = iv.simulate(drive, Scenario(duration=0.3, link="free", force=ConstantForce(size=-20.0), load_mass=0.8))
    assert run.trajectory.closure < 1e-6


def test_gears_that_are_held_by_friction_stay():
    """Load friction of the output above 1 locks the gear against its load: it holds without current."""
    drive = actuated(replace(LOADED, load_output=1.2))
    assert duty_cycle(drive, DutyCycle(motion=Hold(time=1.0), force=-25.0, load_mass=0.8)).power_in == 0.0


@pytest.mark.slow
def test_derivatives_are_exact_by_every_method():
    drive, point = actuated(LOADED), {"speed": 0.3, "force": 20.0}
    paths = ["gearhead.friction.load_motor", "gearhead.friction.friction", "gearhead.friction.stribeck_speed"]
    slopes = [gradient(lambda d: loss(d, **point), drive, paths, method=method)[1] for method in METHODS]
    for slope in slopes[1:]:
        assert_allclose(slope, slopes[0], rtol=1e-5, atol=1e-12)
    assert np.all(slopes[0][:2] > 0)


def test_without_friction_nothing_is_lost():
    gear = iv.parts.Gearhead(ratio=4.0, loss_model="stribeck", friction=LOADED).without_friction()
    assert gear.lossless
    point = gear.operate(output_torque=2.0, output_speed=3.0, motor_rated_torque=1.0)
    assert (point.loss, point.motor_torque) == (0.0, 0.5)


def test_identified_actuators_can_be_used_in_a_study(tmp_path):
    assert set(IDENTIFIED) == {*("erob80-100", "erob80-50", "feetech-sts3215-7-4V", "mx106", "mx64", "xl320", "xl330")}
    (tmp_path / "s.toml").write_text(
        '[requirement]\nbase = "faulring2006"\n[drives.a]\nbase = "faulring2006.motor2-gear4"\n'
        '[drives.a.gearhead]\npart = "xl330"\nratio = 10\n',
        "utf-8",
    )
    study = iv.load_study(tmp_path / "s.toml")
    gear = study.drives["a"].gearhead
    assert gear.friction == IDENTIFIED["xl330"].friction
    assert {row.kind for row in study.provenance if row.field.startswith("gearhead.friction.")} == {"fitted"}
    assert np.all(
        iv.steady_map(study.drives["a"], np.linspace(0.05, 1, 5), np.linspace(-20, 20, 5)).losses["gearhead"] > 0
    )


@pytest.mark.parametrize("key", IDENTIFIED)
def test_an_entry_has_every_term_of_the_identified_form(key):
    """No figure is lost between the table and the part; a term that is left out is zero there, too."""
    from internals import catalogue

    raw = catalogue.data("actuator_friction")
    actuator = next(value for name, value in raw.items() if name.replace("_", "-") == key)
    form = actuator[max(name for name in actuator if name in catalogue.FORMS)]
    friction = IDENTIFIED[key].friction
    named = {field.name for field in dataclasses.fields(friction)}
    assert {name: getattr(friction, name) for name in form if name in named} == {
        name: value for name, value in form.items() if name in named
    }
