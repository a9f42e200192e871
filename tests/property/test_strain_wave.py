"""Strain-wave gears at random: passive in all quadrants, an inverse, a loop solved exactly, a spring that keeps its energy."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.parts import StrainWave
from internals import Torsion, hardening, hardening_energy, strain_wave_friction

MOTOR = 0.2  # continuous torque [N m], of no effect on these gears


def random_gear(random):
    """Any size: torque without load up to a third of the rated one, any load share in either direction."""
    ratio, rated = random.uniform(30, 160), 10 ** random.uniform(0, 3)
    running = random.uniform(0.01, 0.3) * rated / ratio
    starting = random.uniform(0.2, 1.0) * running
    most = 1.0 / (1.0 + ratio * running / rated)
    backdriving = ratio * starting * random.uniform(1.0, 3.0) if random.random() < 0.7 else None
    said = StrainWave(
        efficiency=random.uniform(0.4, 1.0) * most,
        rated_torque=rated,
        rated_speed=random.uniform(50, 400),
        starting_torque=starting,
        running_torque=running,
        backdriving_torque=backdriving,
        temperature=random.uniform(263.15, 333.15),
    )
    return iv.parts.Gearhead(ratio=ratio, loss_model="strain wave", strain_wave=said)


@pytest.mark.parametrize("seed", range(30))
def test_it_never_creates_power(seed):
    """Power in, power out and loss at 500 points in all four quadrants; at rest it helps to hold the load."""
    random = np.random.default_rng(seed)
    gear = random_gear(random)
    rated = gear.strain_wave.rated_torque
    speed, torque = random.uniform(-5, 5, 500), rated * random.normal(0, 1, 500)
    point = gear.operate(output_torque=torque, output_speed=speed, motor_rated_torque=MOTOR)
    received, delivered = point.motor_torque * point.motor_speed, torque * speed
    assert np.all(point.loss >= 0)
    assert_allclose(received - delivered, point.loss, atol=1e-9 * np.abs(received).max())
    resting = gear.operate(output_torque=torque, output_speed=0.0, motor_rated_torque=MOTOR)
    assert np.all(np.abs(resting.motor_torque) <= np.abs(torque) / gear.ratio * (1 + 1e-12))
    assert np.all(resting.motor_torque * torque >= 0)


@pytest.mark.parametrize("seed", range(30))
def test_the_torque_of_the_load_follows_from_that_of_the_motor(seed):
    """There and back, in all four quadrants."""
    random = np.random.default_rng(seed)
    gear = random_gear(random)
    speed, torque = random.uniform(-500, 500, 500), random.normal(0, 1, 500) * gear.strain_wave.rated_torque
    ideal = torque / gear.ratio
    law = gear.law(MOTOR)
    motor = ideal + law.friction_torque(speed, ideal)
    assert_allclose(law.transmitted(speed, motor), ideal, rtol=1e-9, atol=1e-12 * np.abs(ideal).max())


@pytest.mark.parametrize("seed", range(20))
def test_between_two_inertias_the_law_holds_exactly(seed):
    """Friction that lowers the torque that leaves the gear; and without that it is the law of the steady map."""
    random = np.random.default_rng(seed)
    gear = random_gear(random)
    law = gear.law(MOTOR)
    given = {name: one.value for name, one in law.graph_law("n").parameters.items()}
    speed, torque = (
        random.uniform(-500, 500, 500),
        random.normal(0, 1, 500) * gear.strain_wave.rated_torque / gear.ratio,
    )
    assert_allclose(strain_wave_friction(speed, torque, **given), law.friction_torque(speed, torque), rtol=1e-12)
    gain, stick = -random.uniform(0, 1, 500), random.uniform(1, 100)
    friction = strain_wave_friction(speed, torque, stick_speed=stick, gain=gain, **given)
    again = strain_wave_friction(speed, torque + gain * friction, stick_speed=stick, **given)
    # Where the sign of the torque turns, both straight lines meet and rounding decides.
    assert_allclose(again, friction, rtol=1e-9, atol=1e-12 * np.abs(torque).max())
    assert np.all(friction * speed >= 0)


@pytest.mark.parametrize("seed", range(20))
def test_the_spring_gives_back_what_it_stores(seed):
    """Torque at an angle and angle at a torque are inverse; the energy is the integral of the torque."""
    random = np.random.default_rng(seed)
    first, second, third = 10 ** random.uniform(3, 5, 3)
    low, high = np.sort(random.uniform(1, 100, 2))
    spring = Torsion(stiffness=first, corners=((low, second), (high, third)))
    torque = np.linspace(-150, 150, 4001)
    angle = spring.twist(torque)
    named = {
        "stiffness": first,
        "corner_1": spring.twist(low),
        "beyond_1": second,
        "corner_2": spring.twist(high),
        "beyond_2": third,
    }
    assert_allclose(hardening(angle, **named), torque, atol=1e-9)
    middle = 0.5 * (torque[1:] + torque[:-1])
    straight = np.min(np.abs(np.abs(middle)[:, None] - [low, high]), axis=1) > torque[1] - torque[0]
    slope = np.diff(torque) / np.diff(angle)
    assert_allclose(spring.stiffness_at(middle)[straight], slope[straight], rtol=1e-9)
    energy = hardening_energy(angle, **named)
    by_hand = np.concatenate([[0.0], np.cumsum(middle * np.diff(angle))])
    assert_allclose(energy - energy[0], by_hand, atol=1e-5 * energy.max())
