"""Hertzian contacts against an independent program, textbook values, and Boussinesq's point loads added up."""

import numpy as np
import pytest

from infinivar.contact import Material, hertz
from internals import ContactWheel as Wheel
from internals import Cylinder, plane_strain_modulus

STEEL = Material(youngs_modulus=210e9, poisson=0.3)

# Computed with an independent program: radii [mm], steering [deg], load [N]; a, b [mm], p0 [MPa], approach [mm]. The last
# case has a flat wheel stood in for by a crown of a kilometre, which changes the fourth column of results by 1e-9.
CASES = {
    "sphere on cylinder": ((10, 10, 20, 0, 100), (0.15204869707, 0.19919944842, 1576.4149754, 0.0037179314837)),
    "sharp crown": ((10, 2, 20, 0, 50), (0.15472436527, 0.069691631281, 2213.9716261, 0.0030097030583)),
    "crossed cylinders": ((10, 1e9, 10, 90, 100), (0.18662555784, 0.18662555784, 1370.8790787, 0.0034829098899)),
}


@pytest.mark.parametrize("case", CASES)
def test_wheel_on_cylinder(case):
    """To 1e-6, as an independent closed form allows; the two programs agree to eight digits and more."""
    (r, crown, radius, angle, load), expected = CASES[case]
    wheel = Wheel(rolling_radius=r * 1e-3, crown_radius=crown * 1e-3, material=STEEL)
    patch, rotation = hertz.crossed(load, wheel, Cylinder(radius=radius * 1e-3, material=STEEL), np.radians(angle))
    found = (patch.a * 1e3, patch.b * 1e3, patch.peak_pressure * 1e-6, patch.approach * 1e3)
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    assert rotation == pytest.approx(0.0, abs=1e-8)


def test_where_the_shear_is_largest():
    """johnson1985, sections 3.4, 4.2 and 4.5: 0.31 p0 at 0.48 a below a circle, 0.30 p0 at 0.78 a below a line."""
    shear, depth = hertz.largest_shear(1.0, 1.0, 1.0, 0.3)
    assert (shear, depth) == (pytest.approx(0.31, abs=0.005), pytest.approx(0.48, abs=0.005))
    shear, depth = hertz.largest_shear(1e-4, 1.0, 1.0, 0.3)
    assert (shear, depth) == (pytest.approx(0.30, abs=0.005), pytest.approx(0.78e-4, abs=0.01e-4))


def test_first_yield():
    """johnson1985, section 6.1: a circle yields (Tresca) at p0 = 1.6 Y, a line at 1.67 Y."""
    assert 0.5 / hertz.largest_shear(1.0, 1.0, 1.0, 0.3)[0] == pytest.approx(1.6, abs=0.05)
    assert 0.5 / hertz.largest_shear(1e-4, 1.0, 1.0, 0.3)[0] == pytest.approx(1.67, abs=0.01)


def boussinesq(depth, a, b, poisson):
    """Stresses below the middle by adding up point loads: Gauss points in radius, equal steps around."""
    node, weight = np.polynomial.legendre.leggauss(80)
    angle = 0.25 * np.pi * (node + 1.0)
    around = 2.0 * np.pi * (np.arange(800) + 0.5) / 800
    rho = np.sin(angle)[:, None]
    # sqrt(1 - rho^2) rho d rho = cos^2 sin d angle
    load = (0.25 * np.pi * weight * np.cos(angle) ** 2 * np.sin(angle))[:, None] * (2.0 * np.pi / 800) * a * b
    x, y = a * rho * np.cos(around), b * rho * np.sin(around)
    r, far = x * x + y * y, np.sqrt(x * x + y * y + depth**2)

    def sideways(x, y):
        radial = (1.0 - depth / far) * (x * x - y * y) / r + depth * y * y / far**3
        return load / (2 * np.pi) * ((1 - 2 * poisson) / r * radial - 3 * depth * x * x / far**5)

    sigma_z = -3.0 * load * depth**3 / (2.0 * np.pi * far**5)
    return sideways(x, y).sum(), sideways(y, x).sum(), sigma_z.sum()


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (1.0, 2.5), (3.0, 0.7)])
def test_stresses_below_the_middle(a, b, poisson):
    """johnson1985, Eq 3.18 (point load), integrated numerically: an independent way to all three stresses."""
    for depth in (0.3, 0.8, 2.0):
        expected = boussinesq(depth, a, b, poisson)
        found = hertz.axis_stresses(depth, a, b, 1.0, poisson)
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-9)


def test_plane_strain_modulus_of_steel():
    """Two like bodies: E/(2 (1 - nu^2)) = 115.4 GPa for 210 GPa and 0.3."""
    assert plane_strain_modulus(STEEL, STEEL) == pytest.approx(115.4e9, rel=1e-3)
