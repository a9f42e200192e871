"""Shaking a mass: closed forms, convergence, limits and definitions of performance."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from cobotic_study import unweighed
from infinivar import Limit
from infinivar.analysis import Definition, dynamic_map, shaking
from internals import Varying
from internals import shaking_amplitude as amplitude
from made import parameter_study

STUDY = parameter_study("faulring2006")
FREQUENCY, FRACTION = np.geomspace(0.1, 30, 12), np.linspace(0.05, 1, 8)
STORED = Definition(measure="round trip", returned="store", storage_efficiency=1.0)
TINY = 1e-12


def returned_to_start(point):
    """Energy that the drive's inertias keep over a cycle, over the energy moved: the error of sampling. [-]

    A periodic motion gives back what it stored, but for the jumps of the steering angle at reversals, which are left out.
    """
    kept = sum(np.mean(np.broadcast_to(flow, np.shape(point.power_out)), axis=-1) for flow in point.stored.values())
    moved = np.mean(np.abs(point.power_in) + np.abs(point.power_out), axis=-1)
    return np.abs(kept) / (moved + 1e-300)


def shake(drive, **options):
    return dynamic_map(drive, FREQUENCY, FRACTION, **{"power": 12.0, "load_mass": 0.8, **options})


def lossless_motor(**values):
    given = {"voltage": 1e9, "resistance": 1e-15, "torque_constant": 0.02, "no_load_current": 0.0}
    return iv.parts.Motor(**{**given, "continuous_torque": 1e9, "rotor_inertia": 1e-6, **values})


def geared(motor, drag=0.0, ratio=4.0):
    return iv.ConventionalDrive(
        motor=motor,
        gearhead=iv.parts.Gearhead(ratio=ratio, efficiency=1.0),
        pulley=iv.parts.Pulley(radius=0.005),
        guideway=iv.parts.Guideway(friction=drag),
        output_inertia=2e-5,
    )


def test_amplitude_gives_the_power():
    """Footnote 8: the RMS of m lddot ldot over a cycle is the power asked for, to rounding."""
    mass, power = 0.8, 7.3
    course = shaking(amplitude(power, mass, FREQUENCY), FREQUENCY, 400)
    exchanged = mass * course.acceleration * course.speed
    assert_allclose(np.sqrt(np.mean(exchanged**2, axis=-1)), power, rtol=1e-12)


def test_derivatives_of_shaking():
    """From speed to the sixth, each follows from the one before: by differences over a step, to second order."""
    course, step = shaking(0.1, 2.0, 4000), 1 / (2.0 * 4000)
    for lower, higher in pairwise(("speed", "acceleration", "jerk", "snap", "fifth", "sixth")):
        slope = np.gradient(getattr(course, lower), step, edge_order=2)
        assert_allclose(slope, getattr(course, higher), atol=1e-5 * np.max(np.abs(getattr(course, higher))))


def test_lossless_geared_drive_performs_perfectly():
    """With storage, all that sets out arrives: 1. Burnt, half of what sets out is the load's and lost: 1/2."""
    drive = geared(lossless_motor(rotor_inertia=1e-12))
    drive = replace(drive, output_inertia=1e-15)
    assert_allclose(shake(drive, definition=STORED).performance, 1.0, rtol=1e-6)
    assert_allclose(shake(drive, definition=Definition(measure="round trip")).performance, 0.5, rtol=1e-6)
    assert_allclose(shake(drive).performance, 2.0, rtol=1e-6)


def test_lossless_cobotic_drive_performs_perfectly():
    """The same with a wheel that neither creeps nor resists, and a massless steering plant without friction."""
    wheel = iv.RotaryLinearIVT(
        cylinder_radius=0.05,
        wheel_radius=0.01,
        preload=1e6,
        friction=0.1,
        creep_stiffness=1e15,
        rolling_torque=0.0,
        bearing_torque=0.0,
    )
    steering = iv.drivetrain.SteeringPlant(
        motor=lossless_motor(rotor_inertia=1e-20),
        ratio=1.0,
        bell_inertia=1e-20,
        sliding_friction=1e-15,
        patch_half_length=1e-9,
        bell_friction=0.0,
    )
    drive = iv.CoboticDrive(
        motor=lossless_motor(),
        gearhead=iv.parts.Gearhead(ratio=57.0, efficiency=1.0),
        transmission=wheel,
        cylinder_speed=14.0,
        link_mass=1e-9,
        steering=steering,
    )
    assert_allclose(shake(drive, definition=STORED).performance, 1.0, rtol=1e-6)


def test_ohmic_drive_matches_its_resistance():
    """A drive whose only loss is its winding takes I^2 R: current amplitude a w^2 m_eff r/(n K), all power stored again."""
    resistance, constant, ratio, radius = 2.0, 0.02, 4.0, 0.005
    motor = lossless_motor(resistance=resistance, torque_constant=constant)
    found = shake(geared(motor), definition=replace(STORED, measure="exchange"))
    mass = 0.8 + (2e-5 + ratio**2 * 1e-6) / radius**2
    peak = mass * found.amplitude * (2 * np.pi * FREQUENCY[:, None]) ** 2 * radius / (ratio * constant)
    expected = 0.5 * resistance * peak**2
    assert_allclose(found.losses["winding"], expected, rtol=1e-12)
    assert_allclose(found.power_in, expected, rtol=1e-9)


@pytest.mark.parametrize("name", ["cobotic", "cobotic-b", "motor2-gear4"])
def test_samples_doubled_change_little(name):
    drive = STUDY.drives[name]
    coarse, fine = shake(drive), shake(drive, samples=400)
    known = ~np.isnan(coarse.unlimited)
    assert known.mean() > 0.9
    assert_allclose(coarse.unlimited[known], fine.unlimited[known], rtol=1e-3)


@pytest.mark.parametrize("name", ["cobotic", "cobotic-b", "motor2-gear4"])
def test_cycles_close(name):
    assert shake(STUDY.drives[name]).closure < 1e-9


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_inertias_return_what_they_took(name):
    """Over a cycle nothing stays in the inertias: to rounding without guideway friction, whose reversals make the angle jump."""
    drive = STUDY.drives[name]
    course = shaking(0.02, 3.0, 200)
    smooth = replace(drive, guideway=iv.parts.Guideway())
    assert returned_to_start(smooth.follow(course, load_mass=0.8)) < 1e-9
    assert returned_to_start(drive.follow(course, load_mass=0.8)) < 1e-5


def test_energy_that_inertias_keep():
    """By kinetic energies, for stretches that end at another speed than they begin with.

    A lossless drive of reduced mass d shakes a mass m up to a speed v. The load takes m v^2/2 and the supply gives
    (m + d) v^2/2 when it sets out; when it slows down the load gives m v^2/2 back, which is burnt. All powers follow one
    sine, so that sums over instants have the same error and the quotients none.
    """
    drive, mass = geared(lossless_motor()), 0.8
    reduced = (2e-5 + 4.0**2 * 1e-6) / 0.005**2
    whole = shaking(0.02, 3.0, 400)

    def kept(start, end):
        part = iv.motion.Course(
            **{name: getattr(whole, name)[start:end] for name in ("speed", "acceleration", "jerk", "snap")}
        )
        return returned_to_start(drive.follow(part, load_mass=mass))

    assert kept(300, 400) == pytest.approx(reduced / (2 * mass + reduced), rel=1e-9)  # from rest to v
    assert kept(0, 100) == pytest.approx(reduced / mass, rel=1e-9)  # from v to rest
    assert kept(100, 400) == pytest.approx(reduced / (5 * mass + 2 * reduced), rel=1e-9)  # to v, to rest, to v


def test_energy_goes_from_the_cylinder_to_the_link():
    """A cylinder slows down while it sets the link going: what stays is the difference of their kinetic energies.

    Steering takes its own: speeds of the wheel at both ends are read off the same motion. 1e-6 is what 4000 midpoints leave.
    """
    drive, mass, count = STUDY.drives["cobotic"], 0.8, 4000
    drive = replace(drive, guideway=iv.parts.Guideway())
    steering = drive.steering
    to_steer = steering.bell_inertia + steering.ratio**2 * steering.motor.rotor_inertia
    duration, speed, slowing, turn = 0.2, 0.3, 12.0, 8.0

    def instants(time):
        course = iv.motion.Course(
            speed=speed * np.sin(turn * time),
            acceleration=speed * turn * np.cos(turn * time),
            jerk=-speed * turn**2 * np.sin(turn * time),
            snap=-speed * turn**3 * np.cos(turn * time),
        )
        cylinder = Varying(drive.cylinder_speed - slowing * time, np.full(time.shape, -slowing), np.zeros(time.shape))
        return drive.follow(course, load_mass=mass, cylinder_speed=cylinder)

    middle = instants(duration * (np.arange(count) + 0.5) / count)
    first, last = instants(np.array([0.0, duration])).states["steering_rate_rad_s"]
    link = 0.5 * drive.link_mass * (speed * np.sin(turn * duration)) ** 2
    cylinder = (
        0.5 * drive.turning_inertia * ((drive.cylinder_speed - slowing * duration) ** 2 - drive.cylinder_speed**2)
    )
    wheel = 0.5 * to_steer * (last**2 - first**2)
    assert -cylinder > 2 * link > 0
    moved = duration * np.mean(np.abs(middle.power_in) + np.abs(middle.power_out))
    assert returned_to_start(middle) == pytest.approx(-(link + cylinder + wheel) / moved, rel=1e-6)


def test_limits_that_bind():
    cobotic, conventional = shake(STUDY.drives["cobotic"]), shake(STUDY.drives["motor2-gear4"])
    assert cobotic.limit_at(-1, -1) == (Limit.SLIP, "wheel")
    assert cobotic.limit_at(-3, -1) == (Limit.THERMAL, "steering motor")
    assert conventional.limit_at(0, -1) == (Limit.VOLTAGE, "motor")
    assert conventional.limit_at(-1, -1) == (Limit.THERMAL, "motor")
    assert np.all(np.isnan(cobotic.performance) == ~cobotic.works)


def test_travel_limits_slow_motion():
    found = shake(STUDY.drives["cobotic"], travel=0.1)
    too_far = 2.0 * found.amplitude > 0.1
    assert found.limit_at(0, -1) == (Limit.TRAVEL, "load")
    assert not np.any(found.works & too_far)
    assert np.any(found.works)


def test_peak_torque_is_stricter_than_rms():
    drive = STUDY.drives["cobotic"]
    rms, peak = shake(drive), shake(drive, definition=Definition(torque="peak"))
    key = (Limit.THERMAL, "motor")
    known = ~np.isnan(rms.demands[key])
    assert np.all(peak.demands[key][known] >= rms.demands[key][known])
    course = shaking(0.05, 2.0, 200)
    current = np.abs(drive.follow(course, load_mass=0.8).states["motor_current_A"])
    one = dynamic_map(drive, [2.0], [1.0], power=12 * (0.05 / amplitude(12, 0.8, 2.0)) ** 2, load_mass=0.8)
    assert one.demands[key][0, 0] == pytest.approx(np.sqrt(np.mean(current**2)) / drive.motor.continuous_current)


def test_gearheads_are_held_to_their_root_mean_square():
    """By either definition: what the definition says is of motors."""
    drive = STUDY.drives["motor2-gear4"]
    drive = replace(drive, gearhead=replace(drive.gearhead, continuous_torque=0.2))
    key = (Limit.GEAR, "gearhead")
    rms, peak = (shake(drive, definition=Definition(torque=torque)).demands[key] for torque in ("rms", "peak"))
    assert_allclose(rms, peak)
    course = shaking(amplitude(12.0, 0.8, 3.0), 3.0, 200)
    torque = drive.follow(course, load_mass=0.8).states["gear_output_torque_Nm"]
    one = dynamic_map(drive, [3.0], [1.0], power=12.0, load_mass=0.8)
    assert one.demands[key][0, 0] == pytest.approx(np.sqrt(np.mean(torque**2)) / 0.2)


def test_permissible_peak_torque_binds():
    drive = STUDY.drives["motor2-gear4"]
    weak = replace(drive, motor=replace(drive.motor, peak_torque=drive.motor.continuous_torque))
    assert shake(weak).limit_at(4, -1)[0] in (Limit.PEAK, Limit.VOLTAGE)
    assert np.all(shake(weak).works <= shake(drive).works)


def test_storage_takes_less():
    drive = STUDY.drives["cobotic"]
    burnt, kept = shake(drive), shake(drive, definition=Definition(returned="store", storage_efficiency=0.8))
    shared = shake(drive, definition=Definition(common_bus=True))
    known = ~np.isnan(burnt.power_in)
    assert np.all(kept.power_in[known] <= burnt.power_in[known] * (1 + TINY))
    assert np.all(shared.power_in[known] <= burnt.power_in[known] * (1 + TINY))
    assert np.any(shared.power_in[known] < 0.99 * burnt.power_in[known])


def test_impossible_regeneration_is_a_limit():
    found = shake(STUDY.drives["cobotic"], definition=Definition(returned="none"))
    assert {found.limit_at(5, -1)[0]} == {Limit.REGENERATION}


def test_cylinder_as_a_flywheel():
    """Braking energy stays in the cylinder where it can hold it, and too slow a motion would stop the cylinder."""
    drive = STUDY.drives["cobotic"]
    constant, flywheel = shake(drive), shake(drive, cylinder="flywheel")
    both = constant.works & flywheel.works
    assert both.sum() >= 10
    # Where hardly anything comes back the swinging speed costs up to a thousandth.
    assert np.all(flywheel.performance[both] >= constant.performance[both] * (1 - 2e-3))
    assert np.nanmax(flywheel.performance) > 1.2 * np.nanmax(constant.performance)
    assert flywheel.limit_at(0, -1) == (Limit.FLYWHEEL, "cylinder")
    assert np.all(np.isnan(flywheel.performance[0]))
    assert flywheel.closure < 1e-9
    geared = STUDY.drives["motor2-gear4"]
    np.testing.assert_array_equal(shake(geared, cylinder="flywheel").unlimited, shake(geared).unlimited)


def test_labelled_arrays():
    data = shake(STUDY.drives["cobotic"]).to_xarray()
    assert data.performance.dims == ("frequency", "fraction")
    assert data.frequency.attrs["units"] == "Hz"
    assert "SLIP (wheel)" in data.binding.attrs["long_name"]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"power": 0.0}, "power must be > 0 W, got 0.0"),
        ({"load_mass": -1.0}, "load_mass must be > 0 kg, got -1.0"),
        ({"samples": 30}, "samples must be a multiple of 4, got 30"),
    ],
)
def test_wrong_values_are_refused(changed, message):
    with pytest.raises((ValueError, iv.InputError), match=re.escape(message)):
        shake(STUDY.drives["cobotic"], **changed)


@pytest.mark.parametrize("axis", [[], [0.0, 1.0], [np.nan], [[1.0]]])
def test_wrong_axes_are_refused(axis):
    with pytest.raises(iv.InputError, match="frequency must be a vector of numbers > 0"):
        dynamic_map(STUDY.drives["cobotic"], axis, [1.0], power=12.0, load_mass=0.8)


@pytest.mark.parametrize("lacking", ["link_mass", "steering"])
def test_missing_values_are_named(lacking):
    drive = replace(unweighed(STUDY.drives["cobotic"]), **{lacking: None})
    with pytest.raises(ValueError, match=f"^{lacking} is missing: motion needs it$"):
        shake(drive)


def test_flow_loss_is_refused():
    drive = STUDY.drives["cobotic"]
    drive = replace(drive, transmission=replace(drive.transmission, creep_law="faulring"))
    with pytest.raises(ValueError, match="creep_law must be one of"):
        shake(drive)
