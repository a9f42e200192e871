"""Driven carts in time: the equations of motion at steady points, and runs against the same by inverse dynamics."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Limit
from made import loaded

STUDY = loaded("driven_cart")
CARTS = {name: replace(STUDY.drives[name], battery=None) for name in ("steered", "rear")}
CURVE = iv.motion.MachinePath(
    x=iv.motion.Sinusoid(distance=0.4, frequency=0.4),
    y=iv.motion.Sinusoid(distance=0.2, frequency=0.4, start=0.625),
    angle=iv.motion.Sinusoid(angle=0.3, frequency=0.4, start=0.2),
    wrench=iv.motion.Wrench(x=20.0),
)


@pytest.mark.parametrize("name", CARTS)
def test_equations_of_motion_at_steady_points(name):
    """At rates and headings of steady points nothing accelerates: wheels exert the wrench, and axles what motors must."""
    cart, random = CARTS[name], np.random.default_rng(2)
    twist = random.uniform(-1, 1, (200, 3)) * [0.8, 0.8, 0.8]
    wrench = random.uniform(-1, 1, (200, 3)) * [80.0, 80.0, 15.0]
    found = cart.operated(twist, wrench)
    rolls = found.limit == Limit.OK
    assert rolls.mean() > 0.5
    mechanics = cart.moving().mechanics(1e-9)
    places = [3 + place for place in cart.driven]
    rates = np.asarray(found.rates)[rolls][:, [0, 1, 2, *places]]
    angles = np.asarray(found.heading)[rolls]
    forces = mechanics.act(mechanics.at(np.zeros((len(rates), 3)), rates), rates, angles, 0.0 * angles)
    # A free wheel creeps along its heading in steady points, by its rolling resistance of 4 N, and not in time; that costs 3 mW.
    close = {"rtol": 0, "atol": 1e-5 if name == "steered" else 0.1}
    assert_allclose(forces.generalised[:, :3], wrench[rolls], **close)
    assert_allclose(forces.generalised[:, 3:], np.asarray(found.applied)[rolls][:, places], **close)
    lost = forces.losses()
    for loss in ("creep", "rolling", "bearing"):
        assert_allclose(lost[loss], found.losses[loss][rolls], rtol=1e-6, atol=1e-6 if name == "steered" else 0.01)


@pytest.mark.parametrize("name", CARTS)
def test_a_task_in_time_is_the_steady_point(name):
    cart, task = CARTS[name], STUDY.tasks["corner"]
    run, point = iv.simulate(cart, task), iv.perform_task(cart, task)
    assert run.outcome == ""
    assert run.closure < 1e-6
    assert run.mean_powers["supply"] == pytest.approx(point.mean_power, rel=2e-3)
    wheels = cart.operated(np.array([0.5, 0.0, 0.25]), np.array([200.0, 0.0, 0.0]))
    for place in cart.driven:
        assert run.columns[f"axle_{place + 1}_rad_s"][-1] == pytest.approx(wheels.rates[3 + place], rel=2e-3)
    assert_allclose([run.columns[f"h_{place}_rad"][-1] for place in (1, 2, 3)], wheels.heading, rtol=0, atol=2e-3)


@pytest.mark.parametrize("name", ["rear", pytest.param("steered", marks=pytest.mark.slow)])
def test_a_path_in_time_needs_the_power_of_inverse_dynamics(name):
    """Sideways and turning, with reversals and a load: power within 1 %, and the cart within 5 mm of its path."""
    cart = CARTS[name]
    run, path = iv.simulate(cart, CURVE), iv.follow_path(cart, CURVE)
    assert run.outcome == ""
    assert run.closure < 1e-6
    assert np.max(run.position_error) < 5e-3
    assert run.mean_powers["supply"] == pytest.approx(path.mean_power - path.steering_power, rel=1e-2)
    assert run.mean_powers["steering supply"] == pytest.approx(path.steering_power, rel=5e-2)


def test_wheels_that_slip_in_steady_points_slip_in_time():
    """With less grip two wheels do not push the load: no steady point, and a run that leaves its path with an event."""
    cart = replace(CARTS["rear"], wheel=replace(CARTS["rear"].wheel, friction=0.35))
    assert iv.perform_task(cart, STUDY.tasks["corner"]).demand[0] == Limit.SLIP
    run = iv.simulate(cart, STUDY.tasks["corner"])
    assert any(event.limit == Limit.SLIP for event in run.events)
    assert run.closure < 1e-6
    assert np.max(run.position_error) > 5e-3


def test_what_does_not_move_in_time():
    with pytest.raises(iv.ParameterError, match="steering is missing: motion needs it"):
        replace(CARTS["rear"], steering=None).moving()
    with pytest.raises(iv.ParameterError, match="drive must be motor and rigid gearhead alone to move in time"):
        replace(CARTS["rear"], drive=loaded("hand_controller").drives["motor2-gear4"]).moving()
    assert not hasattr(loaded("planar_cart").drives["two-wheels"], "scenario")
