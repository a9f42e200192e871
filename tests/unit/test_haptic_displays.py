"""Haptic displays: results, words, figures, limits of guidance, and malformed input."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from cobotic_study import unweighed
from internals import (
    impedance,
    largest_turn_rate,
    overrun,
    required_damping,
    run_in_time,
    sampled_loop,
    stopping_distance,
    with_values,
)
from internals import stability_map_figure as map_figure
from internals import z_width_figure as width_figure

ARM = iv.motion.ArmModel.named("vanbeek2015")


@pytest.fixture(scope="module")
def drives():
    return iv.load_study("hand_controller").drives


@pytest.fixture(scope="module")
def admittance(drives):
    return iv.displays.AdmittanceDisplay(drive=drives["cobotic"], virtual_mass=1.0, filter_frequency=100.0)


@pytest.fixture(scope="module")
def geared(drives):
    return iv.displays.ImpedanceDisplay(drive=drives["motor2-gear4"], wall_stiffness=2000.0, viscous_friction=2.0)


@pytest.fixture(scope="module")
def found(admittance):
    over = {"virtual_mass": np.geomspace(0.2, 5.0, 12), "wall_stiffness": np.geomspace(1e3, 1e5, 10)}
    return iv.displays.stability_map(admittance, ARM, over)


def test_the_map_and_its_boundary(admittance, found):
    assert found.growth.shape == found.stable.shape == (10, 12)
    assert 0.2 < found.stable.mean() < 0.8
    for mass, stiffness in found.boundary[::4]:
        at = replace(admittance, virtual_mass=mass, wall_stiffness=stiffness)
        assert sampled_loop(at, ARM).growth == pytest.approx(1.0, abs=1e-8)
    edge = found.least[0]
    assert edge == pytest.approx(iv.displays.least_stable_mass(replace(admittance, wall_stiffness=1e3), ARM), rel=1e-6)
    assert math.isnan(found.least[-1])
    assert found.units == ("kg", "N/m")
    assert found.verdict.startswith("Stable in ")
    assert "least stable virtual mass 0.4" in found.verdict
    assert "at a wall stiffness of 1000 N/m, none at" in found.verdict
    json.dumps(found.to_dict(), allow_nan=False)
    drawn = map_figure.data(found)
    assert drawn["labels"] == ("virtual mass [kg]", "wall stiffness [N/m]")
    assert len(found.plot().axes) == 1
    pytest.importorskip("xarray")
    assert found.to_xarray().growth.dims == ("wall_stiffness", "virtual_mass")


@pytest.mark.slow
def test_usual_maps(admittance, geared):
    for display, first in ((admittance, "virtual_mass"), (geared, "wall_stiffness")):
        usual = iv.displays.stability_map(display, ARM)
        assert (usual.first, usual.growth.shape) == (first, (50, 50))
        assert 0.1 < usual.stable.mean() < 0.9


def test_a_wall_that_is_stiffer_needs_a_higher_rate(geared):
    usual = iv.displays.stability_map(
        geared, ARM, {"wall_stiffness": [1e2, 1e4, 1e6], "sample_rate": [500.0, 1e3, 4e3]}
    )
    assert np.all(np.diff(usual.most) > 0)
    assert usual.most[1] == pytest.approx(iv.displays.stiffest_wall(geared, ARM), rel=1e-6)


def test_a_verdict_states_the_bound_that_matters(geared):
    over = {"sample_rate": [300.0, 1e3, 4e3], "wall_stiffness": [500.0, 2000.0, 1e4]}
    found = iv.displays.stability_map(geared, ARM, over)
    assert np.all(np.diff(found.least) >= 0)
    assert "least stable sample rate beyond 300 Hz at a wall stiffness of 500 N/m, 1" in found.verdict


def test_free_and_clamped(admittance, geared):
    """Without a hand a handle of no mass closes no loop; a clamp is the stiffest arm there is."""
    assert sampled_loop(admittance, "free").growth == 1.0
    assert sampled_loop(replace(admittance, virtual_mass=1e-3), "free").stable
    heavy = replace(admittance, handle_mass=0.5)
    assert 0.05 < iv.displays.least_stable_mass(heavy, "free") < iv.displays.least_stable_mass(heavy, ARM)
    assert iv.displays.least_stable_mass(admittance, "clamped") > 100.0 * iv.displays.least_stable_mass(admittance, ARM)
    assert sampled_loop(geared, "clamped").growth == 0.0


def test_the_impedance_at_low_frequency_is_that_wanted(admittance, geared):
    omega = 2.0 * math.pi * 0.2
    free, wall = (complex(impedance(replace(admittance, wall_stiffness=k), [0.2], ARM)[0]) for k in (0.0, 5000.0))
    assert free.imag / omega == pytest.approx(1.0, rel=1e-3)
    # A wall on the measured position is in parallel to the virtual mass.
    assert -wall.imag * omega == pytest.approx(5000.0 - omega**2, rel=2e-3)
    mass, spring = (complex(impedance(one, [0.2], ARM)[0]) for one in (geared.softest(), geared))
    assert mass == pytest.approx(complex(geared.damping, omega * geared.reflected_mass), rel=1e-6)
    assert -spring.imag * omega == pytest.approx(2000.0 - omega**2 * geared.reflected_mass, rel=1e-4)


def test_a_force_sensor_makes_a_geared_drive_lighter_and_no_wall_softer(geared):
    """At low frequency the drive feels as its mass over 1 + gain, its wall as stated; the largest gain is where growth begins."""
    helped = replace(geared, force_gain=4.0, filter_frequency=100.0)
    omega = 2.0 * math.pi * 0.2
    mass, spring = (complex(impedance(one, [0.2], ARM)[0]) for one in (helped.softest(), helped))
    # Filter, held current and late sample delay the help; by their lag the viscous friction feels as mass.
    lag = math.sqrt(2.0) / (2.0 * math.pi * 100.0) + 1.5 * geared.period
    assert mass.imag / omega == pytest.approx(geared.reflected_mass / 5.0 + 4.0 * lag * geared.damping / 25.0, rel=1e-4)
    assert -spring.imag * omega == pytest.approx(2000.0 - omega**2 * geared.reflected_mass / 5.0, rel=1e-3)
    free = replace(helped.softest(), handle_mass=0.5)
    largest = iv.displays.largest_force_gain(free, ARM)
    assert sampled_loop(replace(free, force_gain=largest), ARM).growth == pytest.approx(1.0, abs=1e-8)
    assert not sampled_loop(replace(free, force_gain=1.01 * largest), ARM).stable
    # A clamped handle feels the motor's force at once: in the loop are the gain, the filter and the late sample.
    assert iv.displays.largest_force_gain(free, "clamped") < largest
    with pytest.raises(iv.InputError, match="filter_frequency is missing"):
        replace(geared, force_gain=1.0)
    with pytest.raises(iv.InputError, match="display must be an ImpedanceDisplay, got an AdmittanceDisplay"):
        iv.displays.largest_force_gain(
            iv.displays.AdmittanceDisplay(drive=iv.load_study("hand_controller").drives["cobotic"], virtual_mass=1.0),
            ARM,
        )


def test_z_width(admittance, geared):
    width = iv.displays.z_width(admittance, ARM)
    assert width.least_mass == pytest.approx(1.1 * iv.displays.least_stable_mass(admittance, ARM))
    assert width.wall == pytest.approx(iv.displays.stiffest_wall(admittance, ARM) / 1.1)
    assert width.mass_felt[0] == pytest.approx(width.least_mass, rel=1e-3)
    assert width.stiffness_felt[0] == pytest.approx(width.wall, rel=1e-3)
    assert np.all(width.decades[width.frequency < 10.0] > 0.5)
    assert 10.0 < width.crossing < 30.0
    assert "the width ends at" in width.verdict
    json.dumps(width.to_dict(), allow_nan=False)
    drawn = width_figure.data(width)
    np.testing.assert_array_equal(drawn["softest"], np.abs(width.softest))
    assert width.plot().axes[0].get_xlabel() == "frequency [Hz]"
    other = iv.displays.z_width(geared, ARM, [0.5, 5.0, 50.0], margin=2.0)
    assert math.isnan(other.least_mass)
    assert other.to_dict()["least_mass_kg"] is None
    assert other.mass_felt == pytest.approx(geared.reflected_mass, rel=1e-6)
    pytest.importorskip("xarray")
    assert other.to_xarray().stiffest_imag.shape == (3,)


def test_a_wall_on_the_virtual_mass_has_no_stiffest(admittance):
    """The position loop follows a virtual mass that stands still: only its own stiffness and creep limit what is felt."""
    width = iv.displays.z_width(replace(admittance, wall="virtual"), ARM, [0.1, 1.0])
    assert not width.limited
    assert "which stability does not limit" in width.verdict
    drive = admittance.drive
    groups = drive.transmission.groups(drive.cylinder_speed)
    # Held by the position loop against creep: C g/S, with the gain g of that loop.
    stiffness = groups.creep_stiffness * 2.0 * math.pi * drive.control.link_bandwidth / admittance.surface_speed
    assert width.stiffness_felt[0] == pytest.approx(stiffness, rel=0.1)


def test_passivity_of_an_impedance_display(geared):
    two = iv.displays.passivity(geared)
    assert two.passive is False
    assert two.required == pytest.approx(3.0)
    assert two.verdict == "Not passive: viscous friction of 2 N s/m < 3 N s/m, the condition for one sample late."
    at_once = replace(geared, samples_late=0)
    assert iv.displays.passivity(at_once).verdict == "Passive: viscous friction of 2 N s/m > 1 N s/m, K T/2 + |B|."
    dry = iv.displays.passivity(replace(geared, viscous_friction=0.0))
    assert "Coulomb friction only" in dry.verdict
    assert iv.displays.passivity(geared.softest()).passive
    json.dumps(dry.to_dict(), allow_nan=False)


def test_an_admittance_display_is_not_passive_at_any_mass(admittance):
    """A pure lag takes the real part of any virtual mass below zero, and the displays show it."""
    draw = np.random.default_rng(1)
    mass, lag, share = (
        10.0 ** draw.uniform(-3, 3, 500),
        10.0 ** draw.uniform(-4, -1, 500),
        draw.uniform(0.001, 0.999, 500),
    )
    omega = math.pi * share / lag
    found = 1j * omega * mass * np.exp(1j * omega * lag)
    np.testing.assert_allclose(found.real, -omega * mass * np.sin(omega * lag), rtol=1e-10)
    assert np.all(found.real < 0.0)
    for size in (0.1, 1.0, 10.0, 100.0):
        shown = iv.displays.passivity(replace(admittance, virtual_mass=size))
        assert shown.passive is False
        assert shown.required > 100.0 * size
        assert "passive at no mass" in shown.verdict


def test_limits_of_guidance(drives):
    drive = drives["cobotic"]
    held = iv.displays.guidance_limits(drive, speed=0.3, push=20.0)
    creep = drive.transmission.operate(cylinder_speed=14.0, steering_angle=0.0, link_force=-20.0).link_speed
    assert held.leak_speed == pytest.approx(float(creep), rel=1e-9)
    assert held.leak * 20.0 == pytest.approx(float(creep), rel=1e-6)
    assert held.overrun == pytest.approx(0.4 * 0.3**2 / (2.0 * (78.0 - 20.0)))
    assert held.leak_per_angle > 0.0
    assert not held.slips
    assert "leak 0.0217 mm/s per N" in held.verdict
    assert math.isnan(held.turn_rate)
    json.dumps(held.to_dict(), allow_nan=False)
    slid = iv.displays.guidance_limits(drive, speed=0.3, push=80.0)
    assert slid.slips
    assert slid.verdict == "Slips: the push of 80 N is 1.03 of the slip limit of 78 N; no steering holds it."
    assert math.isinf(slid.overrun)
    json.dumps(slid.to_dict(), allow_nan=False)


def test_limits_of_a_planar_cobot():
    wheel = iv.transmission.RollingContact(
        wheel_radius=0.03,
        preload=200.0,
        friction=0.3,
        creep_stiffness=2e4,
        rolling_torque=0.0,
        bearing_torque=0.0,
    )
    positions = [[0.3, 0.0], [-0.2, 0.2], [-0.2, -0.2]]
    cobot = iv.transmission.PlanarCobot(contacts=wheel, positions=positions, mass=40.0, inertia=3.0)
    found = iv.displays.guidance_limits(cobot, speed=0.5, push=30.0, angle=1.0)
    assert found.slip_force == pytest.approx(180.0)
    assert found.turn_rate == pytest.approx(150.0 / (40.0 * 0.5))
    assert found.overrun == pytest.approx(0.5 / 7.5 * (1.0 - math.cos(1.0)))
    assert found.leak == pytest.approx(0.5 / 6e4)
    assert math.isnan(found.leak_per_angle)
    assert "turning at 7.5 rad/s at most" in found.verdict
    # An arc through the wall, step by step.
    time = np.linspace(0.0, 1.0 / 7.5, 20_001)
    depth = np.trapezoid(0.5 * np.sin(1.0 - 7.5 * time), time)
    assert found.overrun == pytest.approx(depth, rel=1e-7)


def test_laws_of_guidance_at_their_ends():
    assert largest_turn_rate(10.0, 12.0, 1.0, 1.0) == 0.0
    assert overrun(1.0, 0.0, 0.5) == math.inf
    assert overrun(1.0, 0.0, 0.0) == 0.0
    assert stopping_distance(10.0, 10.0, 1.0, 1.0) == math.inf
    np.testing.assert_allclose(largest_turn_rate(10.0, np.array([0.0, 5.0]), 2.0, 0.5), [10.0, 5.0])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"virtual_mass": 0.0}, r"virtual_mass must be > 0 kg, got 0.0"),
        ({"virtual_mass": math.nan}, r"virtual_mass must be > 0 kg, got nan"),
        ({"virtual_mass": [1.0]}, r"virtual_mass must be a real number"),
        ({"virtual_damping": -1.0}, r"virtual_damping must be >= 0 N s/m"),
        ({"wall_damping": -5.0}, r"wall_damping must be >= 0 N s/m"),
        ({"wall_stiffness": -5.0}, r"wall_stiffness must be >= 0 N/m"),
        ({"handle_mass": -0.1}, r"handle_mass must be >= 0 kg"),
        ({"filter_frequency": 0.0}, r"filter_frequency must be > 0 Hz"),
        ({"filter_order": 3}, r"filter_order must be one of 1, 2"),
        ({"wall": "both"}, r"wall must be one of measured, virtual"),
        ({"samples_late": 2}, r"samples_late must be one of 0, 1"),
        ({"rate_feedforward": "yes"}, r"rate_feedforward must be true or false"),
        ({"drive": None}, r"drive must be a CoboticDrive, got None"),
        ({"viscous_friction": 1.0}, r"viscous_friction does not apply"),
        ({"structure_stiffness": 0.0}, r"structure_stiffness must be > 0 N/m"),
        ({"sensor_stiffness": -1.0}, r"sensor_stiffness must be > 0 N/m"),
        ({"structure_damping": -1.0}, r"structure_damping must be >= 0 N s/m"),
    ],
)
def test_malformed_admittance_displays(admittance, wrong, message):
    with pytest.raises(iv.ParameterError, match=message):
        replace(admittance, **wrong)


def test_drives_that_are_no_displays(drives, admittance, geared):
    with pytest.raises(iv.ParameterError, match="drive must be a ConventionalDrive"):
        iv.displays.ImpedanceDisplay(drive=drives["cobotic"])
    with pytest.raises(iv.ParameterError, match="link_mass is missing"):
        replace(admittance, drive=unweighed(drives["cobotic"]))
    with pytest.raises(iv.ParameterError, match="steering is missing"):
        replace(admittance, drive=replace(drives["cobotic"], steering=None))
    spring = iv.Output(series_spring=iv.parts.Spring(stiffness=1e4))
    with pytest.raises(iv.ParameterError, match=r"drive\.output must have no springs or linkage"):
        replace(admittance, drive=replace(drives["cobotic"], output=spring))
    drive = drives["motor2-gear4"]
    with pytest.raises(iv.ParameterError, match="filter_frequency is missing: the force sensor of a geared drive"):
        iv.displays.AdmittanceDisplay(drive=drive, virtual_mass=1.0)
    with pytest.raises(iv.ParameterError, match="along a line"):
        replace(geared, drive=replace(drive, pulley=None, shaft=iv.parts.Shaft(), guideway=iv.parts.Guideway()))
    with pytest.raises(iv.ParameterError, match="rotor_inertia is missing"):
        replace(geared, drive=replace(drive, motor=replace(drive.motor, rotor_inertia=None)))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"mass": 0.0}, "^mass must be > 0 and <= 1000 kg, got 0.0"),
        ({"damping": -1.0}, "^damping must be >= 0 and <= 100000 N s/m"),
        ({"stiffness": math.inf}, "stiffness must be >= 0 and <= 1e\\+06 N/m, got inf"),
        ({"name": ""}, "name must be a text"),
        ({"source": 3}, "source must be a text"),
    ],
)
def test_malformed_arms(wrong, message):
    with pytest.raises(iv.ParameterError, match=message):
        replace(ARM, **wrong)


def test_unknown_arms():
    with pytest.raises(
        iv.ParameterError, match=r"arm must be one of vanbeek2015, got 'vanbeek' \(did you mean 'vanbeek2015'\?\)"
    ):
        iv.motion.ArmModel.named("vanbeek")


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ({"virtual_mass": [1.0, 2.0]}, "over must hold two parameters"),
        ({"mass": [1.0, 2.0], "wall_stiffness": [1.0, 2.0]}, "unknown parameter 'mass'"),
        ({"virtual_mass": [2.0, 1.0], "wall_stiffness": [1.0, 2.0]}, "over.virtual_mass must be rising"),
        ({"virtual_mass": [1.0], "wall_stiffness": [1.0, 2.0]}, "a row of two values or more"),
        ({"virtual_mass": [0.0, 1.0], "wall_stiffness": [1.0, 2.0]}, "virtual_mass must be > 0 kg"),
        ({"virtual_mass": [1.0, math.nan], "wall_stiffness": [1.0, 2.0]}, "over.virtual_mass must be finite kg"),
        (
            {"sample_rate": [100.0, 2e3], "wall_stiffness": [1.0, 2.0]},
            "steering_bandwidth must be <= a tenth of sample_rate",
        ),
        ({"virtual_mass": "many", "wall_stiffness": [1.0, 2.0]}, "over.virtual_mass must be a real number or an array"),
        ({"viscous_friction": [1.0, 2.0], "wall_stiffness": [1.0, 2.0]}, "viscous_friction does not apply"),
        ({"force_gain": [1.0, 2.0], "wall_stiffness": [1.0, 2.0]}, "unknown parameter 'force_gain'"),
    ],
)
def test_malformed_maps(admittance, over, message):
    with pytest.raises(iv.ParameterError, match=message):
        iv.displays.stability_map(admittance, ARM, over)


def test_other_malformed_arguments(drives, admittance, geared):
    cases = (
        (
            lambda: iv.displays.stability_map(drives["cobotic"], ARM),
            "display must be an AdmittanceDisplay or an ImpedanceDisplay",
        ),
        (
            lambda: iv.displays.stability_map(admittance, "loose"),
            "held must be an ArmModel, 'free' or 'clamped', got 'loose'",
        ),
        (lambda: iv.displays.stability_map(admittance, None), "held must be an ArmModel"),
        (
            lambda: iv.displays.least_stable_mass(geared, ARM),
            "display must be an AdmittanceDisplay, got an ImpedanceDisplay",
        ),
        (lambda: iv.displays.stiffest_wall(geared, ARM, (10.0, 1.0)), "between must be two rising values > 0"),
        (lambda: iv.displays.z_width(admittance, "clamped"), "held must be an ArmModel or 'free'"),
        (
            lambda: iv.displays.z_width(admittance, ARM, [1.0, 500.0]),
            r"frequency must be > 0 and < 500 \(half of the sample rate\) Hz",
        ),
        (lambda: iv.displays.z_width(admittance, ARM, margin=0.5), "margin must be >= 1"),
        (
            lambda: iv.displays.z_width(with_values(admittance, {"drive.control.steering_bandwidth": 90.0}), ARM),
            "no virtual mass is stable in free motion",
        ),
        (
            lambda: iv.displays.swept_impedance(replace(admittance, virtual_mass=0.1), ARM, 5.0),
            "display must settle within",
        ),
        (lambda: run_in_time(admittance, ARM, [0.0], 5), r"start must be 6 values: x_m, v_m_s"),
        (lambda: required_damping(100.0, 1.0, 0.0), "period must be > 0 s"),
        (lambda: required_damping(100.0, 1.0, 1e-3, 2), "late must be 0 or 1"),
        (lambda: iv.displays.guidance_limits(drives["cobotic"], speed=0.0), "speed must be > 0 m/s"),
        (lambda: iv.displays.guidance_limits(drives["cobotic"], speed=1.0, push=-1.0), "push must be >= 0 N"),
        (
            lambda: iv.displays.guidance_limits(drives["motor2-gear4"], speed=1.0),
            "machine must be a CoboticDrive or a PlanarCobot",
        ),
        (lambda: iv.displays.guidance_limits(unweighed(drives["cobotic"]), speed=1.0), "mass is missing"),
        (
            lambda: iv.displays.guidance_limits(drives["cobotic"], speed=1.0, angle=4.0),
            "angle must be >= 0 and <= 3.14159 rad",
        ),
    )
    for call, message in cases:
        with pytest.raises(iv.ParameterError, match=message):
            call()
