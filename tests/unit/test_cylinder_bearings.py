"""The cylinder's own bearings: statics and friction by hand, maps, motion, graphs, legs on one cylinder, study files."""

import math
from dataclasses import replace

import array_api_strict
import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import InputError, ParameterError, power
from infinivar.analysis import two_ways
from infinivar.parts import CylinderBearings, PulleyBearings
from internals import WheelLoad, built_part, experiment, known_values, predict, protocol
from made import loaded
from sampled import sampled

KNEE = loaded("knee_walking")
BARE = replace(KNEE.drives["cobotic"], cylinder_bearings=None)
WALKING = KNEE.duty["walking"]
PART = built_part(iv.parts.Bearing, "6004")
SIMPLE, MAKERS = (replace(PART, friction_model=model) for model in ("coefficient", "skf"))
PRELOAD, RADIUS, SPEED = 2200.0, 0.05, 14.0
STILL = WheelLoad(preload=PRELOAD, torque=0.0, force=0.0, radius=RADIUS)

KINDS = {
    "coefficient": CylinderBearings(bearing=SIMPLE, span=0.14, wheel_position=0.05),
    "maker's model": CylinderBearings(bearing=MAKERS, span=0.14, pull=90.0, pull_position=-0.02, pull_direction=1.0),
    "stated coefficient": CylinderBearings(friction_coefficient=0.0015, bore=0.02),
    "measured": CylinderBearings(torque=0.033),
    "backing rollers": CylinderBearings(bearing=MAKERS, span=0.14, locating="second", backing_rollers=2),
}


def held(leg, kind):
    """A drive with bearings; its guideway carries no preload where rollers do."""
    guideway = iv.parts.Guideway(friction=1.0) if kind == "backing rollers" else leg.guideway
    return replace(leg, cylinder_bearings=KINDS[kind], guideway=guideway)


# By hand


def test_coefficient_by_hand():
    # M = mu P d/2 summed over both bearings: 0.0015 * 2200 N * 20 mm/2 = 33 mN m; with a bore of 17 mm (a 6003) 28 mN m.
    assert_allclose(CylinderBearings(bearing=SIMPLE).moment([STILL], SPEED), 33e-3, rtol=1e-12)
    stated = CylinderBearings(friction_coefficient=0.0015, bore=0.017)
    assert_allclose(stated.moment([STILL], SPEED), 28.05e-3, rtol=1e-12)


def test_makers_model_by_hand():
    # SKF 2018, series 60, dm = 31 mm, 1,100 N each, 133.7 r/min, 100 mm^2/s, without axial load.
    mean, radial, turns, viscosity = 31.0, 1100.0, SPEED * 30.0 / math.pi, 100.0
    g_rr, g_sl = 4.1e-7 * mean**1.96 * radial**0.54, 3.73e-3 * mean**-0.26 * radial ** (5.0 / 3.0)
    shear = 1.0 / (1.0 + 1.84e-9 * (turns * mean) ** 1.28 * viscosity**0.64)
    starved = math.exp(-6e-8 * viscosity * turns * 62.0 * math.sqrt(3.1 / (2.0 * 22.0)))
    boundary = math.exp(-2.6e-8 * (turns * viscosity) ** 1.4 * mean)
    rolling = shear * starved * g_rr * (viscosity * turns) ** 0.6
    sliding = (0.12 * boundary + 0.05 * (1.0 - boundary)) * g_sl
    found = float(CylinderBearings(bearing=MAKERS).moment([STILL], SPEED))
    assert_allclose(found, 2e-3 * (rolling + sliding), rtol=1e-12)
    assert 0.0415 < found < 0.0425


@pytest.mark.parametrize("seed", range(5))
def test_reactions_are_those_of_equilibrium(seed):
    """All forces and moments on the cylinder, summed in space, against the sizes of the bearing forces."""
    random = np.random.default_rng(seed)
    span, begin, pull, at, towards = random.uniform(0.1, 0.2), 0.06, 120.0, -0.03, random.uniform(0, 6)
    made = CylinderBearings(
        torque=0.0, span=span, wheel_position=begin, pull=pull, pull_position=at, pull_direction=towards
    )
    wheels = [
        WheelLoad(*random.uniform([100, -5, -80], [900, 5, 80]), RADIUS, random.uniform(-0.04, 0.04), azimuth)
        for azimuth in random.uniform(0, 6, 3)
    ]
    # Pull in the direction of the preload at azimuth 0 is -x.
    forces = [(np.array([-pull * math.cos(towards), -pull * math.sin(towards), 0.0]), np.array([0.0, 0.0, at]))]
    for one in wheels:
        across = np.array([math.cos(one.azimuth), math.sin(one.azimuth), 0.0])
        round_ = np.array([-math.sin(one.azimuth), math.cos(one.azimuth), 0.0])
        place = RADIUS * across + np.array([0.0, 0.0, begin + one.position])
        force = -one.preload * across - one.torque / RADIUS * round_ - np.array([0.0, 0.0, one.force])
        forces.append((force, place))
    total = sum(force for force, _ in forces)
    moment = sum(np.cross(place, force) for force, place in forces)
    second = np.array([-moment[1], moment[0]]) / span  # L e_z x F_2 = -moment, about the first bearing
    first = -total[:2] - second
    found = made.reactions(wheels)
    assert_allclose(found.first, [np.hypot(*first), abs(total[2])], rtol=1e-12)
    assert_allclose(found.second, [np.hypot(*second), 0.0], rtol=1e-12)


@pytest.mark.parametrize(("torque", "energy"), [(0.028, 5.64), (0.042, 5.81)])
def test_knee_by_hand(torque, energy):
    # 0.028 N m at 14 rad/s for 1.1 s is 0.431 J at the cylinder; the motor was braking for a part of the stride.
    drive = replace(BARE, cylinder_bearings=CylinderBearings(torque=torque))
    before, after = iv.duty_cycle(BARE, WALKING), iv.duty_cycle(drive, WALKING)
    assert_allclose(before.energy, 5.294, rtol=1e-3)
    assert_allclose(after.energy, energy, rtol=2e-3)
    assert_allclose(after.losses["cylinder bearings"], torque * SPEED * WALKING.period, rtol=1e-9)


def test_reaching_by_hand():
    """0.0015 * 650 N * 20 mm/2 = 9.75 mN m at 14 rad/s for 4.2 s: 0.573 J at the cylinder, whatever the link does."""
    study = iv.load_study("reach_and_hold")
    drive, (duty,) = study.drives["cobotic"], study.duty.values()
    bare, found = (iv.duty_cycle(one, duty) for one in (replace(drive, cylinder_bearings=None), drive))
    assert_allclose(found.losses["cylinder bearings"], 0.573, rtol=1e-2)
    assert_allclose([bare.energy, found.energy], [20.51, 21.06], rtol=1e-3)


def test_the_knee_hangs_on_the_model_of_its_bearings():
    """Energies per stride as the theory page states them."""
    cobotic, geared = KNEE.drives["cobotic"], KNEE.drives["geared"]

    def energies(model):
        held, pulley = cobotic.cylinder_bearings, geared.pulley.bearings
        held = replace(held, bearing=replace(held.bearing, friction_model=model))
        pulley = replace(pulley, bearing=replace(pulley.bearing, friction_model=model))
        drives = (
            replace(cobotic, cylinder_bearings=held),
            replace(geared, pulley=replace(geared.pulley, bearings=pulley)),
        )
        return [iv.duty_cycle(drive, WALKING).energy for drive in drives]

    assert_allclose(energies("coefficient"), [5.698, 5.786], rtol=1e-3)
    assert_allclose(energies("skf"), [5.934, 5.794], rtol=1e-3)


def test_bearings_of_a_pulley_by_hand():
    # 0.0015 * 600 N * 10 mm/2 = 4.5 mN m, at a pulley of 8 mm 0.5625 N.
    carried = PulleyBearings(friction_coefficient=0.0015, bore=0.01, pull=600.0)
    assert_allclose(carried.friction_torque, 4.5e-3, rtol=1e-12)
    overhung = PulleyBearings(friction_coefficient=0.0015, bore=0.01, pull=600.0, span=0.02, position=-0.01)
    assert_allclose(overhung.friction_torque, 9e-3, rtol=1e-12)
    geared = KNEE.drives["geared"]
    both = [
        replace(geared, pulley=replace(geared.pulley, bearings=bearings, friction_torque=torque))
        for bearings, torque in ((carried, 0.0), (None, 4.5e-3))
    ]
    energies = [iv.duty_cycle(drive, WALKING).energy for drive in both]
    assert_allclose(*energies, rtol=1e-12)
    assert both[0].pulley.without_friction().shaft_friction == 0.0


# Maps and motion


def in_four_quadrants(count, seed=0):
    """Drives of all signs of cylinder speed as one, and points."""
    random = np.random.default_rng(seed)
    speed = random.uniform(2.0, 60.0, count) * random.choice([-1.0, 1.0], count)
    preload = random.uniform(200.0, 2500.0, count)
    drive = replace(BARE, transmission=replace(BARE.transmission, preload=preload), cylinder_speed=speed)
    slip = drive.transmission.friction * preload
    return drive, {
        "speed": random.uniform(-1.0, 1.0, count),
        "force": random.uniform(-0.8, 0.8, count) * slip,
        "position": random.uniform(-0.04, 0.04, count),
    }


def check_passive(count, kind):
    bare, points = in_four_quadrants(count)
    point = held(bare, kind).operate(**points)
    rolls = np.isfinite(point.power_in)
    assert np.mean(rolls) > 0.5
    for name, loss in point.losses.items():
        assert np.all(np.broadcast_to(loss, rolls.shape)[rolls] >= 0.0), name
    assert np.all(point.losses["cylinder bearings"][rolls] > 0.0)
    assert np.max(power.residual(point.power_in, point.power_out, point.losses)[rolls]) < 1e-12
    # The bearings only add torque against the cylinder's rotation, whatever the sign of power.
    bare = replace(held(bare, kind), cylinder_bearings=None)
    more = point.states["cylinder_torque_Nm"] - bare.operate(**points).states["cylinder_torque_Nm"]
    assert np.all((more * bare.cylinder_speed)[rolls] > 0.0)
    powers = (np.asarray(point.power_out) >= 0.0) & rolls, (np.asarray(point.power_out) < 0.0) & rolls
    assert min(map(np.sum, powers)) > 0.2 * count


@pytest.mark.parametrize("kind", KINDS)
def test_passive_in_four_quadrants(kind):
    check_passive(1000, kind)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "count", [pytest.param(4_000, marks=pytest.mark.slow), pytest.param(200_000, marks=pytest.mark.full)]
)
def test_passive_in_four_quadrants_at_many_points(kind, count):
    check_passive(count, kind)


@sampled("kind", ["coefficient", "maker's model", "backing rollers"], slow=3)
def test_prescribed_and_simulated_losses_agree(kind):
    found = two_ways(held(BARE, kind), WALKING)
    # The controlled link passes reversals of its force at other instants.
    assert_allclose(
        found.lost_followed["cylinder bearings"],
        found.lost_prescribed["cylinder bearings"],
        rtol=3e-3,
    )
    if kind == "backing rollers":
        assert_allclose(found.lost_followed[kind], found.lost_prescribed[kind], rtol=1e-6)


def test_backing_rollers_relieve_and_cost():
    relieved = CylinderBearings(bearing=SIMPLE, backing_rollers=1)
    assert_allclose(relieved.moment([STILL], SPEED), 0.0, atol=1e-15)
    drive = replace(BARE, cylinder_bearings=relieved, guideway=iv.parts.Guideway())
    losses = drive.operate(speed=0.0, force=0.0).losses
    with pytest.raises(
        ParameterError, match=r"guideway\.coefficient must be 0 with cylinder_bearings\.backing_rollers"
    ):
        replace(BARE, cylinder_bearings=relieved)
    # At standstill of the link each rolls as the wheel does.
    assert_allclose(losses["backing rollers"], losses["rolling"] + losses["bearing"], rtol=1e-9)


def test_motor_of_a_coasting_cylinder_supplies_its_bearings():
    leg = replace(iv.load_study("hand_controller").drives["cobotic"], cylinder_bearings=None)
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.02, frequency=2.0), load_mass=0.8)
    course, torques = duty.instants().course, []
    for bearings in (None, KINDS["measured"], KINDS["coefficient"]):
        drive = replace(leg, cylinder_bearings=bearings)
        turning = drive.coast(course, period=np.asarray(duty.period), load_mass=0.8)
        point = drive.follow(course, load_mass=0.8, cylinder_speed=turning)
        torque = np.asarray(point.states["motor_torque_Nm"])
        assert np.ptp(torque) < 1e-9
        torques.append(drive.gearhead.ratio * np.mean(torque))
        assert (
            np.max(power.residual(point.power_in - sum(point.stored.values()), point.power_out, point.losses)) < 1e-12
        )
    bare, measured, simple = torques
    assert_allclose(measured - bare, 0.033, rtol=1e-3)
    assert_allclose(simple - bare, 0.0015 * 0.01 * leg.transmission.preload, rtol=0.05)


@pytest.mark.parametrize("kind", KINDS)
def test_formulas_use_the_array_standard_only(kind):
    rows = np.array([[0.2, -90.0, 0.01], [0.0, 50.0, 0.0], [-0.3, 120.0, -0.02]])

    def run(xp):
        torque, force, position = (xp.asarray(row, dtype=xp.float64) for row in rows)
        wheel = WheelLoad(preload=650.0, torque=torque, force=force, radius=RADIUS, position=position)
        drag, losses = KINDS[kind].operate([wheel], xp.asarray(14.0, dtype=xp.float64), torque=torque, rolling=1.2)
        return [drag, *losses.values()]

    for known, strict in zip(run(np), run(array_api_strict), strict=True):
        assert_allclose(np.asarray(strict), known, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_formulas_run_on_jax(kind):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    drive = held(BARE, kind)

    def loss(force):
        return drive.turned(drive.cylinder_speed, 0.01 * force, force, 0.01)[1]["cylinder bearings"]

    forces = np.array([-150.0, 0.0, 150.0])
    assert_allclose(jax.vmap(loss)(forces), [float(loss(force)) for force in forces], rtol=1e-12)
    assert np.all(np.isfinite(jax.vmap(jax.grad(loss))(forces)))


# Legs on a common cylinder


def test_evenly_spaced_legs_cancel():
    wheels = [STILL._replace(azimuth=angle) for angle in KINDS["coefficient"].around(6)]
    assert_allclose(KINDS["coefficient"].moment(wheels, SPEED), 0.0, atol=1e-12)
    aside = [wheels[0]._replace(position=0.02), *wheels[1:]]
    # One leg 20 mm aside tilts the cylinder: P dx/L on each bearing.
    assert_allclose(KINDS["coefficient"].moment(aside, SPEED), 0.0015 * 0.01 * 2 * PRELOAD * 0.02 / 0.14, rtol=1e-9)
    with pytest.raises(ParameterError, match="azimuths must be 2, one for each leg, got 1 values"):
        CylinderBearings(torque=0.0, azimuths=(0.0,)).around(2)


@pytest.mark.parametrize("kind", KINDS)
def test_machine_of_one_leg_is_the_drive(kind):
    leg = held(BARE, kind)
    speed, force = np.meshgrid([-0.3, 0.0, 0.4], [-150.0, 0.0, 120.0])
    known = leg.operate(speed=speed, force=force)
    point = iv.machines.LeggedDrive.of(leg, 1).operate(
        iv.transmission.Configuration(jacobian=[[1.0]]), wrench=force[..., None], twist=speed[..., None]
    )
    for name in ("cylinder bearings", *(["backing rollers"] if kind == "backing rollers" else [])):
        assert_allclose(point.losses[name], known.losses[name], rtol=1e-12)
    assert_allclose(point.power_in, known.power_in, rtol=1e-12)


@pytest.mark.parametrize("kind", ["coefficient", "maker's model", "backing rollers"])
def test_six_legs_stay_passive(kind):
    """At random poses, wrenches and twists the balance closes and the cylinder's bearings only take power."""
    leg = held(iv.load_study("hand_controller").drives["cobotic"], kind)
    platform, random, count = iv.transmission.Platform.hexapod(), np.random.default_rng(5), 300
    place = platform.at(
        np.array([0.0, 0.0, platform.home]) + random.uniform(-0.02, 0.02, (count, 3)),
        random.uniform(-0.2, 0.2, (count, 3)),
    )
    point = iv.machines.LeggedDrive.of(leg, 6).operate(
        place,
        wrench=random.normal(size=(count, 6)) * [15, 15, 30, 0.5, 0.5, 0.5],
        twist=random.normal(size=(count, 6)) * [0.1, 0.1, 0.1, 1, 1, 1],
        cylinder_speed=random.choice([-14.0, 14.0], count),
    )
    rolls = np.isfinite(point.power_in)
    assert np.mean(rolls) > 0.5
    assert np.all(point.losses["cylinder bearings"][rolls] > 0.0)
    assert np.max(power.residual(point.power_in, point.power_out, point.losses)[rolls]) < 1e-12


@pytest.mark.parametrize("kind", KINDS)
def test_machine_in_time_loses_what_its_steady_point_does(kind):
    """Friction of the cylinder's bearings in the mechanics of six legs, against the drive at the same speeds and forces."""
    leg = held(iv.load_study("hand_controller").drives["cobotic"], kind)
    legs = iv.machines.PlatformMachine(
        leg=leg, platform=iv.transmission.Platform.hexapod(), mass=1.0, inertia=(1e-3, 1e-3, 2e-3)
    )
    mechanics = legs.mechanics(1e-4)
    pose = legs.home[None] + np.array([[0.01, -0.005, 0.004, 0.05, -0.04, 0.02]])
    twist, angles = np.array([[0.05, 0.02, -0.06, 0.2, -0.1, 0.3]]), np.zeros((1, 6))
    rates = np.append(twist, [[14.0]], axis=-1)
    place = mechanics.at(pose, rates)
    configuration = legs.platform.at(pose[:, :3], pose[:, 3:])
    angles = -np.arctan(configuration.link_speeds(twist) / (leg.transmission.cylinder_radius * 14.0))
    found = mechanics.act(place, rates, angles, 0.0 * angles).losses()
    # The forces of these wheels on their links, of which the steady machine knows the sum over its legs.
    carrier = (place.kinematics.speed, -leg.transmission.cylinder_radius * rates[:, -1:] + 0.0 * angles)
    forces = mechanics.transmission.wheel.act(
        carrier,
        (np.sin(angles), np.cos(angles)),
        surface_speed=leg.transmission.cylinder_radius * 14.0,
        stick_speed=1e-4,
    )
    radius = leg.transmission.cylinder_radius
    wheels = [
        WheelLoad(
            leg.transmission.preload,
            radius * forces.y[:, one],
            forces.x[:, one],
            radius,
            configuration.link_position[:, one],
            azimuth,
        )
        for one, azimuth in enumerate(KINDS[kind].around(6))
    ]
    assert_allclose(found["cylinder bearings"], KINDS[kind].moment(wheels, 14.0) * 14.0, rtol=1e-12)


# Study files


def test_study_states_them(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(
        """
[requirement]
force = "175 N"
speed = "0.33 m/s"

[drives.cobotic]
base = "faulring2006.cobotic"

[drives.cobotic.cylinder_bearings]
span = "140 mm"
wheel_position = "60 mm"
locating = "second"
pull = "90 N"
pull_position = "-20 mm"
pull_direction = "90 deg"
azimuths = ["0 deg"]

[drives.cobotic.cylinder_bearings.bearing]
part = "6004"
friction_model = "coefficient"
"""
    )
    made = iv.load_study(path).drives["cobotic"].cylinder_bearings
    assert made == CylinderBearings(
        bearing=SIMPLE,
        span=0.14,
        wheel_position=0.06,
        locating="second",
        pull=90.0,
        pull_position=-0.02,
        pull_direction=math.pi / 2,
        azimuths=(0.0,),
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "bearing is missing: give exactly one of bearing, friction_coefficient with bore, and torque"),
        ({"torque": 0.1, "bearing": SIMPLE}, "bearing and torque exclude each other"),
        ({"friction_coefficient": 0.0015}, "bore is missing"),
        ({"torque": 0.1, "bore": 0.02}, "bore does not apply"),
        ({"torque": -0.1}, "torque must be >= 0 N m, got -0.1"),
        ({"torque": 0.1, "backing_rollers": 3}, "backing_rollers must be 0, 1 .* got 3"),
        ({"torque": 0.1, "wheel_position": 0.03}, "span is missing: wheel_position needs it"),
        ({"torque": 0.1, "span": 0.1, "pull": 50.0}, "pull_position is missing"),
        ({"torque": 0.1, "locating": "third"}, "locating must be one of first, second"),
        ({"bearing": replace(SIMPLE, type="needle")}, "bearing.type must be deep_groove or angular_contact"),
    ],
)
def test_wrong_values_are_named(given, message):
    with pytest.raises((ParameterError, InputError), match=message):
        CylinderBearings(**given)


# Rig


RIGGED = ["measured", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("maker's model", "backing rollers"))]


@pytest.mark.slow
@pytest.mark.parametrize("kind", RIGGED)
def test_rig_has_them_and_calibration_knows_them(kind):
    leg = held(iv.load_study("hand_controller").drives["cobotic"], kind)
    rig = iv.study.Rig()
    settings = protocol(leg, rig, ratios=(20.0, 4.0), loads=(0.3,))
    found = experiment(leg, rig, settings, exact=True, simulated=False)
    predicted = predict(leg, rig, found.data, known_values(leg))
    assert_allclose(predicted.motor_current, found.data.motor_current, rtol=1e-9)
    assert_allclose(predicted.link_travel, found.data.link_travel, rtol=1e-6, atol=1e-12)
    # Lifted off, only what does not depend on the preload is left.
    lifted = float(found.data.motor_current[0] * leg.motor.torque_constant)
    beside = {"measured": 0.033 / 57.0}.get(kind, 0.0)
    bare = leg.motor.friction_torque + leg.gearhead.coulomb_friction(leg.motor.continuous_torque)
    if kind != "maker's model":  # whose pull loads the bearings without the wheel
        assert_allclose(lifted, bare + beside, rtol=1e-9)
    in_time = experiment(leg, rig, [settings[0], settings[2]], exact=True)
    steady = experiment(leg, rig, [settings[0], settings[2]], exact=True, simulated=False)
    assert_allclose(in_time.data.motor_current, steady.data.motor_current, rtol=1e-5)


def test_verdict_on_machines_says_what_is_not_counted():
    study = iv.load_study("two_joint_arm")
    one = study.drives["one-motor"]
    bare = replace(one, leg=replace(one.leg, cylinder_bearings=None))
    verdicts = [iv.compare(replace(study, drives={**study.drives, "one-motor": arm})).verdict for arm in (one, bare)]
    assert "not counted" not in verdicts[0].lower()
    assert verdicts[1].endswith("Not counted: cylinder bearings of two legs, one motor (none are stated).")


def test_loads_that_are_unknown_leave_the_friction_unknown():
    """Where a wheel slips its torque is nan; the bearings' friction is then nan, and not that of no load."""
    wheel = WheelLoad(preload=2200.0, torque=np.array([1.0, np.nan]), force=np.array([10.0, np.nan]), radius=0.05)
    moment = CylinderBearings(friction_coefficient=0.0015, bore=0.02).moment([wheel], 14.0)
    assert np.isfinite(moment[0])
    assert np.isnan(moment[1])


def test_a_wrong_number_of_azimuths_is_named_by_its_key():
    with pytest.raises(ParameterError, match=r"cylinder_bearings\.azimuths must be 6, one for each leg, got 2 values"):
        CylinderBearings(torque=0.1, azimuths=(0.0, 1.0)).around(6)


def test_the_journal_of_the_cylinder_bends_and_twists():
    """A shaft of 20 mm, 2,200 N at the middle of a bearing of 12 mm and 7 N m: the stresses of a solid round bar by hand."""
    held = CylinderBearings(bearing=replace(PART, bore=0.02, width=0.012))
    wheel = WheelLoad(preload=4400.0, torque=0.0, force=0.0, radius=0.05)
    found = held.journal_stress(held.reactions([wheel]), 7.0)
    bending = 32.0 * 2200.0 * 0.006 / (np.pi * 0.02**3)
    torsion = 16.0 * 7.0 / (np.pi * 0.02**3)
    assert_allclose(found, np.sqrt(bending**2 + 3.0 * torsion**2), rtol=1e-12)


def test_a_thin_journal_is_a_limit():
    """The knee study's drive by hand over its motion, and on bearings of a third of the bore."""
    drive = KNEE.drives["cobotic"]
    bearings, element = drive.cylinder_bearings, drive.transmission
    course = iv.duty_cycle(drive, WALKING).instants.course
    rolled = drive.roll(course, load_mass=WALKING.moved_mass)
    loads = bearings.reactions(
        [WheelLoad(element.preload, rolled.wheel_torque, rolled.force, element.cylinder_radius, course.position)]
    )
    moment = np.maximum(loads.first[0], loads.second[0]) * 0.5 * bearings.bearing.breadth
    modulus = np.pi * bearings.bearing.bore**3 / 32.0
    stress = np.sqrt((moment / modulus) ** 2 + 3.0 * (rolled.wheel_torque / (2.0 * modulus)) ** 2)
    demand = iv.duty_cycle(drive, WALKING).demands[iv.Limit.JOURNAL, "cylinder"]
    assert_allclose(demand, np.max(stress) / element.geometry.axle_strength, rtol=1e-9)
    thin = replace(bearings, bearing=replace(bearings.bearing, bore=bearings.bearing.bore / 3.0))
    found = iv.duty_cycle(replace(drive, cylinder_bearings=thin), WALKING)
    assert not found.feasible
    assert_allclose(found.demands[iv.Limit.JOURNAL, "cylinder"], 27.0 * demand, rtol=0.01)
