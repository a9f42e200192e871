"""The fluid of Johnson and Tevaarwerk: its limits, its equation integrated in time, and its place in the element."""

import math
import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import infinivar as iv
from infinivar.contact import traction_fluid

X = np.linspace(-1.0, 1.0, 41)


@pytest.mark.parametrize("ratio", [0.5, 3.0, 12.0])
def test_viscous_limit_is_eyrings_law(ratio):
    """At Deborah number 0 the force is the inverse hyperbolic sine of creepage; it is approached as the number falls."""
    eyring = traction_fluid.law(ratio)
    assert_allclose(eyring.creepage(X), np.sinh(ratio * X) / ratio, rtol=1e-12)
    assert eyring.slip_creepage == pytest.approx(math.sinh(ratio) / ratio)
    near = traction_fluid.law(ratio, 1e-4)
    assert_allclose(near.creepage(X), eyring.creepage(X), rtol=1e-3)


def test_newtonian_and_elastic_films_are_linear():
    """Far below the Eyring stress, and in a film that has no time to flow."""
    assert_allclose(traction_fluid.law(0.01).creepage(X), X, rtol=1e-4)
    assert_allclose(traction_fluid.law(1.0, 1000.0).creepage(X), X, rtol=1e-3)


def test_stiffness_at_small_creepage():
    """Newton's film for a low modulus' relaxation time, Hooke's for a long one, and Maxwell's build-up between them."""
    area, film, length, speed = 4e-7, 0.3e-6, 0.6e-3, 2.0
    given = {"area": area, "film_thickness": film, "rolling_speed": speed, "transit_length": length}
    viscous = traction_fluid.creep_stiffness(viscosity=1.0, shear_modulus=1e12, **given)
    assert viscous == pytest.approx(area * 1.0 * speed / film, rel=1e-6)
    elastic = traction_fluid.creep_stiffness(viscosity=1e9, shear_modulus=1e8, **given)
    assert elastic == pytest.approx(area * 1e8 * length / (2.0 * film), rel=1e-3)
    assert traction_fluid.creep_stiffness(
        viscosity=1e9, shear_modulus=1e8, **{**given, "rolling_speed": -speed}
    ) == pytest.approx(elastic)
    viscosity, modulus = 1e4, 1e8
    number = traction_fluid.deborah(viscosity, modulus, speed, length)
    time = (np.arange(20000) + 0.5) / 20000
    stress = viscosity * speed / film * (1.0 - np.exp(-time / number))  # of Maxwell's fluid, per creepage
    found = traction_fluid.creep_stiffness(viscosity=viscosity, shear_modulus=modulus, **given)
    assert found == pytest.approx(area * stress.mean(), rel=1e-6)


@pytest.mark.parametrize("ratio", [1.0, 5.0, 15.0])
@pytest.mark.parametrize("number", [0.02, 1.0, 20.0])
def test_against_the_fluids_equation_in_time(ratio, number):
    """D ds/dt = sinh(s_viscous) - sinh(s) from s = 0 over one passage, whose mean stress is the force."""
    film = traction_fluid.law(ratio, number)
    build_up = 1.0 - number * (1.0 - math.exp(-1.0 / number))
    for force in (0.2, 0.6, 0.95):
        drive = ratio * float(film.creepage(force)) / build_up

        def flow(_, state, drive=drive):
            return [(drive - np.sinh(state[0])) / number, state[0]]

        end = solve_ivp(flow, (0.0, 1.0), [0.0, 0.0], method="LSODA", rtol=1e-10, atol=1e-12).y[1, -1]
        assert end == pytest.approx(ratio * force, rel=5e-4)


@pytest.mark.parametrize("number", [0.0, 1e-3, 0.3, 10.0, 1000.0])
@pytest.mark.parametrize("ratio", [0.01, 1.0, 8.0, 30.0])
def test_odd_passive_monotone_and_inverse(ratio, number):
    law = traction_fluid.law(ratio, number)
    creepage = law.creepage(X)
    assert_allclose(creepage, -creepage[::-1], rtol=1e-12)
    assert np.all(np.diff(creepage) > 0)
    assert np.all(creepage * X >= 0)
    assert_allclose(law.force(creepage), X, atol=1e-9)
    assert_allclose(law.force(2.0 * law.slip_creepage), 1.0)
    step = 1e-6
    rise = (law.creepage(X[1:-1] + step) - law.creepage(X[1:-1] - step)) / (2.0 * step)
    assert_allclose(law.slope(X[1:-1]), rise, rtol=1e-6)
    assert law.slope(0.0) == pytest.approx(1.0, abs=1e-6)


def test_in_an_element():
    """Power balance and passivity in four quadrants, and the inverse; the law is a value that processes can exchange."""
    law = traction_fluid.law(8.0, 0.5)
    assert traction_fluid.law(8.0, 0.5) is law
    again = pickle.loads(pickle.dumps(law))
    assert_allclose(again.force(0.7), law.force(0.7), rtol=0)
    wheel = iv.RotaryLinearIVT(
        cylinder_radius=0.05,
        wheel_radius=0.02,
        preload=1000.0,
        friction=0.08,
        creep_stiffness=4e3,
        rolling_torque=1e-3,
        bearing_torque=4e-3,
        creep_law=law,
    )
    rng = np.random.default_rng(5)
    omega, phi = rng.uniform(-60.0, 60.0, 500), rng.uniform(-1.2, 1.2, 500)
    point = wheel.operate(cylinder_speed=omega, steering_angle=phi, link_force=rng.uniform(-60.0, 60.0, 500))
    rolls = point.limit == iv.Limit.OK
    assert np.mean(rolls) > 0.3
    loss = sum(point.losses.values())
    assert_allclose((point.power_in - point.power_out)[rolls], loss[rolls], rtol=1e-9, atol=1e-9)
    assert all(np.all(part[rolls] >= 0.0) for part in point.losses.values())
    speed = np.linspace(-0.5, 0.5, 11)
    found = wheel.deliver(cylinder_speed=20.0, link_speed=speed, link_force=30.0)
    assert_allclose(found.link_speed, speed, atol=1e-9)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((0.0,), "stress_ratio"),
        ((40.0,), "stress_ratio"),
        ((5.0, -1.0), "deborah_number"),
        ((5.0, 2e3), "deborah_number"),
    ],
)
def test_parameters_out_of_range(given, message):
    with pytest.raises(iv.ParameterError, match=message):
        traction_fluid.law(*given)
