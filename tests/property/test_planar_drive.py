"""Wheels of a planar cobot that are driven along their headings: closed forms of longitudinal creep, and balances."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Limit
from internals import driving_creepage
from made import loaded
from sampled import sampled

LAWS = ("linear", "vermeulen-johnson", "polach", "fastsim", "exact")
POINTS = ((0.3, 0.0), (-0.2, 0.25), (-0.2, -0.25))
GEOMETRY = loaded("hand_controller").drives["cobotic"].transmission.geometry
RADIUS, SLIP, STIFFNESS, RESISTANCE = 0.03, 40.0, 4000.0, 0.5


def wheel(law="exact"):
    torques = {"rolling_torque": 0.6 * RADIUS * RESISTANCE, "bearing_torque": 0.4 * RADIUS * RESISTANCE}
    return iv.transmission.RollingContact(
        wheel_radius=RADIUS, preload=200.0, friction=0.2, creep_stiffness=STIFFNESS, creep_law=law, **torques
    )


def pressed():
    return iv.transmission.RollingContact(wheel_radius=0.012, preload=65.0, friction=0.2, geometry=GEOMETRY)


def body(contacts=None, positions=POINTS):
    return iv.transmission.PlanarCobot(contacts=contacts or wheel(), positions=positions)


def off_balance(point):
    scale = np.abs(point.power).sum(axis=-1)
    return np.abs(point.power.sum(axis=-1) + sum(point.losses.values())) / scale


@sampled("law", LAWS, every=8)
@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("share", [-0.6, -0.1, 0.1, 0.8])
def test_longitudinal_creep_of_a_driven_cart(law, way, share):
    """One torque on three parallel wheels: ``w r = V/(1 + s)`` with the creepage of the traction, and three tractions drive."""
    traction = share * SLIP
    torque = RADIUS * (traction + way * RESISTANCE)
    point = body(wheel(law)).drive(twist=[way * 0.5, 0.0, 0.0], heading=np.zeros(3), torque=torque)
    along, across = driving_creepage(wheel(law), traction)
    assert across == 0.0
    assert_allclose(-along, wheel(law).creepage(traction), rtol=1e-12)
    speed = way * 0.5 / (1.0 + way * along)
    assert point.limit == Limit.OK
    assert_allclose(RADIUS * point.rates[3:], speed, rtol=1e-9)
    assert_allclose(point.applied[:3], [3.0 * traction, 0.0, 0.0], rtol=1e-7, atol=1e-9)
    assert_allclose(point.applied[3:], -torque, rtol=1e-9)
    assert_allclose(point.losses["creep"], 3.0 * traction * -along * abs(speed), rtol=1e-6)
    assert_allclose(point.losses["rolling"], 3.0 * 0.6 * RESISTANCE * abs(speed), rtol=1e-9)


def test_linear_creep_by_hand():
    """Traction 8 N of a wheel with C = 4000 N: creepage 0.002, efficiency (1 - 0.002) T/(T + F0)."""
    point = body(wheel("linear")).drive(twist=[0.5, 0.0, 0.0], heading=np.zeros(3), torque=RADIUS * 8.5)
    assert_allclose(point.rates[3:], 0.5 / RADIUS / (1.0 - 0.002), rtol=1e-9)
    assert_allclose(point.power_out / point.power_in, 8.0 / 8.5 * (1.0 - 0.002), rtol=1e-8)


@pytest.mark.parametrize("law", LAWS)
def test_side_load_on_a_driven_wheel(law):
    """The wheel drifts and slips with one creepage, along the force; the other way round, the twist gives these forces."""
    traction, side = 14.0, 21.0
    along, across = driving_creepage(wheel(law), traction, side)
    assert_allclose(np.hypot(along, across), wheel(law).creepage(np.hypot(traction, side)), rtol=1e-12)
    assert_allclose(across / along, -side / traction, rtol=1e-12)
    speed = 0.5  # of the circumference
    twist = [speed * (1.0 + along), speed * across, 0.0]
    point = body(wheel(law), [(0.0, 0.0)]).drive(twist=twist, heading=[0.0], torque=RADIUS * (traction + RESISTANCE))
    assert_allclose(RADIUS * point.rates[3], speed, rtol=1e-9)
    assert_allclose(point.applied[:2], [traction, -side], rtol=1e-6)


def test_stiffness_along_the_heading_is_c11():
    contact = pressed()
    traction = 1e-3 * contact.slip_force
    along, _ = driving_creepage(contact, traction)
    _, across = driving_creepage(contact, 0.0, traction)
    coefficients = contact.contact.coefficients
    assert_allclose(-across / along, coefficients.c11 / coefficients.c22, rtol=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_free_wheels_are_nearly_those_without_an_axle(law):
    """Without a torque the traction is the rolling resistance, whose creep is second to it."""
    cart, twist = body(wheel(law)), np.array([0.5, 0.1, 0.3])
    heading = cart.headings(twist, {"y": 20.0})
    free = cart.drive(twist=twist, heading=heading, torque=0.0)
    known = cart.mechanism.operate(rates=twist, heading=heading)
    assert_allclose(free.applied[:3], known.applied, rtol=2e-3, atol=2e-3)
    assert_allclose(free.applied[3:], 0.0, atol=1e-9)
    assert off_balance(free) < 1e-9


@sampled("law", ["with spin", *LAWS], slow=6)
def test_power_closure_at_many_points(law):
    """100,000 points of driving and braking wheels in all directions, 20,000 with spin; losses are never negative."""
    random, count = np.random.default_rng(3), 20_000 if law == "with spin" else 100_000
    _closes(random, count, law)


@sampled("law", [*LAWS, "with spin"], every=3)
def test_power_closure(law):
    _closes(np.random.default_rng(4), 200, law)


def _closes(random, count, law):
    contact = pressed() if law == "with spin" else wheel(law)
    cart, slip = body(contact), contact.slip_force * contact.wheel_radius
    twist = random.normal(size=(count, 3)) * [0.5, 0.5, 1.0]
    heading = (
        cart.headings(twist)
        + random.normal(0, 0.001 if law == "with spin" else 0.006, (count, 3))
        + random.choice([0.0, math.pi], (count, 3))
    )
    torque = random.uniform(-0.9, 0.9, (count, 3)) * slip
    point = cart.drive(twist=twist, heading=heading, torque=torque)
    rolls = point.limit == Limit.OK
    assert 0.2 < rolls.mean() < 0.99
    assert off_balance(point)[rolls].max() < 1e-9
    known = np.isfinite(point.rates).all(axis=-1)
    assert np.all(np.asarray(point.limit)[~known] == Limit.SLIP)
    assert all(np.all(loss[rolls] >= -1e-12) for loss in point.losses.values())
    assert_allclose(point.applied[rolls][:, 3:], -torque[rolls], rtol=0, atol=1e-8 * slip)
    signs = {(a, b) for a, b in np.sign(np.stack([point.rates[rolls][:, 3], torque[rolls][:, 0]], -1)).astype(int)}
    assert signs == {(1, 1), (1, -1), (-1, 1), (-1, -1)}


def test_a_torque_beyond_slip_and_a_wheel_at_rest_are_slip():
    cart = body()
    for twist, torque in (([0.5, 0.0, 0.0], 1.1 * SLIP * RADIUS), ([0.0, 0.5, 0.0], 0.1)):
        point = cart.drive(twist=twist, heading=np.zeros(3), torque=torque)
        assert point.limit == Limit.SLIP
        assert np.isnan(point.power_in)


MESSAGES = {
    "torque must be one number, or 3 of them, got shape (2,)": {"torque": [1.0, 2.0]},
    "torque must be finite, got nan or inf": {"torque": math.nan},
    "twist must be of shape (..., 3), got shape (2,)": {"twist": [1.0, 2.0]},
    "twist and torque must broadcast to one shape, got shapes (2,) and (3,)": {
        "twist": np.ones((2, 3)),
        "torque": np.ones((3, 3)),
    },
}


@pytest.mark.parametrize("message", MESSAGES)
def test_messages(message):
    with pytest.raises(iv.InputError) as caught:
        body().drive(**{"twist": [0.5, 0.0, 0.0], "heading": np.zeros(3), "torque": 0.0} | MESSAGES[message])
    assert str(caught.value) == message
