"""Models compared with measurements by others: a motor's efficiency map, and the friction of geared actuators."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from measured import figures as measurements
from measured import gear_laws, motor_map

MAP = motor_map.published()
NOISE = motor_map.noise(MAP)


def rms(fit):
    return 100.0 * float(np.sqrt(np.mean(fit.residual[MAP.loaded] ** 2)))


@pytest.mark.source("parsons2019")
def test_resistance_and_constant_friction_leave_two_points():
    """Stated with the data: 2.2 points rms, 9 at worst; tolerance 0.1 and 0.5, the choice of points without load."""
    fit = motor_map.fit(MAP)
    assert (len(MAP.speed), int(MAP.loaded.sum())) == (341, 303)
    assert rms(fit) == pytest.approx(2.2, abs=0.1)
    assert 100 * np.abs(fit.residual[MAP.loaded]).max() == pytest.approx(9.0, abs=0.5)


def test_the_fitted_motor_is_a_motor_of_this_program():
    """The same efficiencies by `Motor.operate`, with the torque constant of 270 rpm/V: the loss has no other definition."""
    fit = motor_map.fit(MAP)
    constant = 60.0 / (2 * math.pi * 270.0)
    motor = iv.parts.Motor(
        voltage=48.0,
        resistance=fit.values[0] * constant**2,
        torque_constant=constant,
        no_load_current=fit.values[1] / constant,
        continuous_torque=1.0,
    )
    power = motor.operate(torque=MAP.torque, speed=MAP.speed).power
    assert_allclose(MAP.torque * MAP.speed / power - MAP.efficiency, fit.residual, atol=1e-12)


def test_most_of_the_residual_is_noise():
    """Noise from neighbouring speeds; as a check, from third differences of the efficiency: 20 % apart at most."""
    floor = 100 * motor_map.noise_floor(MAP, NOISE)
    rest, squares = motor_map.fit(MAP).residual, []
    for row in range(1, 9):
        line = rest[MAP.row == row]
        squares.append((line[:-3] - 3 * line[1:-2] + 3 * line[2:-1] - line[3:]) ** 2 / 20.0)
    assert floor == pytest.approx(100 * math.sqrt(np.mean(np.concatenate(squares))), rel=0.2)
    assert 0.5 < (floor / rms(motor_map.fit(MAP))) ** 2 < 0.7


def test_the_map_has_no_loss_that_grows_with_the_square_of_speed():
    """Its coefficient is negative by more than five standard deviations, a constant power positive by as many."""
    eddy, constant = motor_map.fit(MAP, ["eddy"]), motor_map.fit(MAP, ["constant"])
    assert eddy.values[2] < -5 * eddy.deviations[2]
    assert constant.values[2] > 5 * constant.deviations[2]
    assert rms(constant) < 1.8 < rms(eddy)
    assert 100 * motor_map.across_speeds(MAP, ["constant"]) < 1.1 * rms(constant)


def test_two_terms_reach_the_noise():
    best = motor_map.ranked(MAP, 2, NOISE)[0]
    assert set(best.extra) == {"alternating", "slow friction"}
    assert rms(best) == pytest.approx(100 * motor_map.noise_floor(MAP, NOISE), rel=0.05)
    assert 1.2 < motor_map.lack_of_fit(best, 303) < 1.4


def test_known_losses_are_found_again():
    """A map made of known losses and noise: coefficients within four deviations, noise within 10 %, no lack of fit."""
    random = np.random.default_rng(5)
    true = np.array([53.0, 0.04, 2.0])
    power = MAP.torque * MAP.speed + motor_map.loss(true, ["constant"], MAP.speed, MAP.torque)
    measured = power + NOISE * random.standard_normal(power.size)
    made = motor_map.MotorMap(
        speed=MAP.speed, torque=MAP.torque, efficiency=MAP.torque * MAP.speed / measured, row=MAP.row
    )
    sigma = motor_map.noise(made)
    assert_allclose(np.mean(sigma[MAP.loaded] / NOISE[MAP.loaded]), 1.0, atol=0.1)
    fit = motor_map.fit(made, ["constant"], sigma)
    assert np.all(np.abs(fit.values - true) < 4 * fit.deviations)
    assert motor_map.lack_of_fit(fit, 303) == pytest.approx(1.0, abs=0.15)
    needless = motor_map.fit(made, ["constant", "eddy"], sigma)
    assert abs(needless.values[3]) < 4 * needless.deviations[3]


@pytest.mark.source("duclusaud2025")
@pytest.mark.parametrize(
    ("key", "closer"),
    [
        ("erob80_100", "coulomb"),
        ("erob80_50", "coulomb"),
        ("mx106", "proportional"),
        ("mx64", "proportional"),
        ("xl320", "coulomb"),
    ],
)
def test_which_gear_law_is_closer(key, closer):
    """Decided the same way for two fifths of the loads, as the range is assumed; better than no law by a wide margin."""
    for share in (1.0, 0.4):
        found = gear_laws.compare(key, share)
        assert found.closer == closer
        assert found.laws[closer].share < 0.45
        assert found.laws[closer].error < 0.95 * max(found.laws[law].error for law in gear_laws.LAWS[:2])


def test_one_actuator_is_undecidable():
    assert {gear_laws.compare("xl330", share).closer for share in (1.0, 0.4)} == {"coulomb", "proportional"}


@pytest.mark.parametrize("law", ["coulomb", "proportional"])
def test_a_compared_law_is_the_gearhead_of_this_program(law):
    """The fitted parameters in a `Gearhead` give the friction that the comparison counts."""
    found = gear_laws.compare("mx64")
    values = found.laws[law].values
    if law == "coulomb":
        gear = iv.parts.Gearhead(ratio=1.0, efficiency=0.5, rated_torque=2.0 * values[0])
    else:
        gear = iv.parts.Gearhead(ratio=1.0, efficiency=values[0], backdriving_efficiency=values[1], loss_model=law)
    point = gear.operate(output_torque=found.torque, output_speed=found.speed, motor_rated_torque=1.0)
    error = math.sqrt(np.mean((point.motor_torque - found.torque - found.friction) ** 2))
    assert error == pytest.approx(found.laws[law].error, rel=1e-9)


def test_the_figures_show_these_numbers():
    numbers = measurements.map_data()
    fits = numbers["residuals"]
    assert [len(values) for values in fits.values()] == [303, 303, 303]
    assert_allclose(fits["resistance and constant friction"], 100 * motor_map.fit(MAP).residual[MAP.loaded])
    gear = measurements.gear_data("mx64")
    found = gear_laws.compare("mx64")
    assert gear["coulomb"][0] == found.laws["coulomb"].values[0]
    assert gear["identified"]["slow"].shape == gear["load"].shape == (41,)
    assert len(measurements.draw_map().axes) == 4
    assert len(measurements.draw_gears().axes) == 2
