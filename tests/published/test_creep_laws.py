"""Creep laws of lateral creep against exact rolling theory (kalker1990), and the law "fastsim" against what it stands for.

Largest error of the lateral force in units of mu N, for the shapes a/b = 0.2, 1 and 5. "faulring" is as "linear".
"""

import numpy as np
import pytest

from infinivar.contact import creep, exact_tables
from internals import DrivenContact
from internals import contact_laws as laws

LARGEST = {
    "linear": 0.235,
    "faulring": 0.235,
    "vermeulen-johnson": 0.032,
    "polach": 0.058,
    "fastsim": 0.043,
    "exact": 0.0013,
}


@pytest.mark.parametrize("law", creep.LAWS)
def test_largest_errors(law):
    """The errors of the table, whose last digit is the tolerance; the exact curves are good to 0.001."""
    errors = [
        np.abs(creep.lateral_force(law, curve["scaled_creepage"], curve["a_over_b"]) - curve["force_ratio"])
        for curve in exact_tables.lateral_creep()
    ]
    assert np.max(errors) == pytest.approx(LARGEST[law], abs=0.0006)


@pytest.mark.parametrize("law", creep.LAWS)
def test_creep_in_both_directions(law):
    """A driven wheel keeps the direction of the linear force, but at gross slip the force opposes the creepage: within 0.15."""
    wheel = DrivenContact(
        wheel_radius=0.03,
        preload=200.0,
        friction=0.2,
        creep_stiffness=4000.0,
        rolling_torque=0.01,
        bearing_torque=0.01,
        creep_law=law,
    )
    errors = []
    for curve in exact_tables.combined_creep():
        angle, linear = np.radians(curve["direction"]), 3.0 * curve["scaled_creepage"] * wheel.slip_force / 4000.0
        found = wheel.act((linear * np.cos(angle), linear * np.sin(angle)), surface_speed=np.ones_like(linear))
        x, y = (-one / wheel.slip_force for one in (found.x, found.y))
        errors.append(np.hypot(x - curve["longitudinal_force"], y - curve["lateral_force"]))
    assert np.max(np.concatenate(errors)) == pytest.approx(0.150, abs=0.0006)


def test_closed_form_against_quadrature():
    """The strips' forces, integrated over the patch's width by Gauss in the angle; both to a few roundings of 1."""
    node, weight = np.polynomial.legendre.leggauss(60)
    for w in (0.01, 0.3, 0.7, 0.99):
        top = np.arccos(w)
        half = np.cos(0.5 * top * (node + 1.0))
        missing = 0.5 * top * np.sum(weight * (half - w) ** 3 / 3.0 * half)
        found = laws.fastsim_force(np.float64(w * laws.FASTSIM_SLIP))
        assert found == pytest.approx(1.0 - 16.0 / np.pi * missing, abs=1e-14)


def as_published(k_x, k_y, psi, a_over_b, cells, strips):
    """Kalker's algorithm as he gives it, with dimensions: strips and cells of equal width, bound at their middles."""
    a, b, shear, slip_force = a_over_b * 0.7, 0.7, 80e3, 50.0
    c11, c22, c23 = 4.3, 3.73, 1.5  # drop out
    u_x, u_y = 3 * slip_force / (c11 * shear * a * b) * k_x, 3 * slip_force / (c22 * shear * a * b) * k_y
    phi = slip_force / (c23 * shear * (a * b) ** 1.5) * psi
    l_1, l_2 = 8 * a / (3 * c11 * shear), 8 * a / (3 * c22 * shear)
    l_3 = np.pi * a**2 / (4 * c23 * shear * np.sqrt(a * b))
    width = 2 * b / strips
    y = -b + width * (np.arange(strips) + 0.5)
    half = a * np.sqrt(1 - (y / b) ** 2)
    step = 2 * half / cells
    p_x, p_y, fx, fy, mz = np.zeros((5, strips))
    for i in range(cells):
        x = half - step * (i + 0.5)
        advance, at = (0.5 * step, x + 0.25 * step) if i == 0 else (step, x + 0.5 * step)
        p_x = p_x + (u_x / l_1 - phi * y / l_3) * advance
        p_y = p_y + (u_y / l_2 + phi * at / l_3) * advance
        bound = 2 * slip_force / (np.pi * a * b) * (1 - (x / a) ** 2 - (y / b) ** 2)
        kept = np.minimum(1.0, bound / np.hypot(p_x, p_y))
        p_x, p_y = p_x * kept, p_y * kept
        fx, fy, mz = fx + p_x * step * width, fy + p_y * step * width, mz + (x * p_y - y * p_x) * step * width
    return fx.sum() / slip_force, fy.sum() / slip_force, mz.sum() / (slip_force * np.sqrt(a * b))


@pytest.mark.parametrize("k", [-1.1, -0.3, 1e-3, 0.1, 0.6, 1.0, 1.3])
def test_closed_form_is_what_the_published_algorithm_tends_to(k):
    """Lateral creep over strips and cells of a shape that must not matter."""
    fx, fy, _ = as_published(0.0, k, 0.0, 1.7, 1000, 1000)
    assert fy == pytest.approx(creep.lateral_force("fastsim", k), abs=3e-5)
    assert abs(fx) < 1e-12
