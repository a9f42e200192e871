r"""Traction through a lubricant film: the fluid of Johnson and Tevaarwerk between two rolling bodies.

The fluid shears elastically with the modulus G and flows with the viscosity eta, beyond the Eyring stress tau_0 ever more
easily. A particle enters the patch unstressed and is sheared at a constant rate while it passes through:

.. math:: \dot\gamma = \frac{\dot\tau}{G} + \frac{\tau_0}{\eta}\sinh\frac{\tau}{\tau_0}

Pressure, and with it all properties, are taken as uniform over the patch, at their mean. The traction of the patch is the
mean stress times the area. There is no longitudinal force, spin or heating of the film.

Source: johnson1977.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
from annotated_types import Gt, Interval

from infinivar._core.array_namespace import Array, as_floats, namespace, newton
from infinivar._core.fields import check_value
from infinivar.contact.creep import CreepLaw

_NODES = 24
"""Places of a passage at which the stress is evaluated; clustered at the entry, they leave errors of at most 2e-4 of its mean."""

_STEPS = 40
"""Most points need 5."""

_STRIDE = 1.0
"""Longest step in the stress of a viscous film: where an elastic film begins to flow, Newton's method would overshoot."""


def deborah(viscosity: Array, shear_modulus: Array, rolling_speed: Array, transit_length: Array) -> Array:
    r"""Relaxation time of the fluid over the time of its passage through the patch.

    .. math:: D = \frac{\eta V}{G l}

    Parameters
    ----------
    viscosity : (...,) float        eta at the mean pressure of the patch, which is many times that at rest, > 0. [Pa s]
    shear_modulus : (...,) float    G of the fluid there, > 0. [Pa]
    rolling_speed : (...,) float    V; its sign does not matter. [m s^-1]
    transit_length : (...,) float   l: 2 a for a line contact, on average pi a/2 for an ellipse, > 0. [m]

    Returns
    -------
    (...,) float   0: viscous; far above 1: elastic. [-]

    Raises
    ------
    ParameterError
        If an argument is not above zero.

    Source: johnson1977.
    """
    check_value("viscosity", viscosity, "Pa s", Gt(0))
    check_value("shear_modulus", shear_modulus, "Pa", Gt(0))
    check_value("transit_length", transit_length, "m", Gt(0))
    xp = namespace(viscosity, shear_modulus, rolling_speed, transit_length)
    return viscosity * xp.abs(as_floats(xp, rolling_speed)[0]) / (shear_modulus * transit_length)


def creep_stiffness(
    area: Array,
    film_thickness: Array,
    viscosity: Array,
    shear_modulus: Array,
    rolling_speed: Array,
    transit_length: Array,
) -> Array:
    r"""Traction over creepage of the film alone at small creepage, where the fluid is Maxwell's.

    .. math:: C = \frac{A\,\eta V}{h}\left[1 - D\left(1 - e^{-1/D}\right)\right]

    Parameters
    ----------
    area : (...,) float             A of the patch. [m^2]
    film_thickness : (...,) float   h in the patch, > 0. [m]
    viscosity, shear_modulus, rolling_speed, transit_length : (...,) float   As in `deborah`.

    Returns
    -------
    (...,) float   A eta V/h of a Newtonian film for D = 0, A G l/(2 h) of an elastic one for a large D. [N]

    Raises
    ------
    ParameterError
        If an argument is not above zero.

    Notes
    -----
    The bodies are in series with the film: 1/C of the contact is the sum of this and of 1/(C22 G a b) of the bodies.

    Source: johnson1977.
    """
    check_value("area", area, "m^2", Gt(0))
    check_value("film_thickness", film_thickness, "m", Gt(0))
    number = deborah(viscosity, shear_modulus, rolling_speed, transit_length)
    xp = namespace(area, film_thickness, number, rolling_speed)
    number, speed = as_floats(xp, number, rolling_speed)
    return area * viscosity * xp.abs(speed) / film_thickness * _builds_up(xp, number)


@functools.cache
def law(stress_ratio: float, deborah_number: float = 0.0) -> CreepLaw:
    r"""Creep law of a film: force ratio by scaled creepage.

    With the mean stress over tau_0, :math:`\bar s`, and that of a viscous film, :math:`s_\infty`,

    .. math:: x = \frac{\bar s}{m}, \quad \xi = \frac{g}{m}\sinh s_\infty, \quad
        g = 1 - D\left(1 - e^{-1/D}\right), \quad \bar s = \int_0^1 2\,\mathrm{artanh}\,
        \frac{u(1 - E)}{1 + u^2 E}\,dt, \quad u = \tanh\frac{s_\infty}{2}, \quad E = e^{-t\cosh(s_\infty)/D}

    The stress at each place of the passage is a closed form; its mean is a sum.

    Parameters
    ----------
    stress_ratio : float     m: mean shear stress at the friction limit, mu P over the area, over the Eyring stress, 0.01 to
        30. Near 0 the viscous law is linear. [-]
    deborah_number : float   D of `deborah`, 0 to 1000; 0: :math:`x = \mathrm{arsinh}(m\xi)/m`. [-]

    Returns
    -------
    CreepLaw   Named "johnson-tevaarwerk", for elements with measured values: creep stiffness as by `creep_stiffness`,
        friction as the largest traction coefficient of the fluid. The same value for the same arguments.

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Notes
    -----
    Film and creep stiffness depend on the speed, the law does not: it holds near one rolling speed. The largest traction
    coefficient, which a limiting stress or heat causes, is a given value here.

    Source: johnson1977.
    """
    check_value("stress_ratio", stress_ratio, "1", Interval(ge=0.01, le=30.0))
    check_value("deborah_number", deborah_number, "1", Interval(ge=0.0, le=1000.0))
    film = Film(float(stress_ratio), float(deborah_number))
    return CreepLaw(
        name="johnson-tevaarwerk",
        creepage=functools.partial(_creepage, film=film),
        slope=functools.partial(_slope, film=film),
        force=functools.partial(_force, film=film),
        slip_creepage=float(_creepage(1.0, film)),
    )


class Film(NamedTuple):
    """Parameters of the law of one film."""

    stress_ratio: float
    deborah_number: float

    @property
    def builds_up(self) -> float:
        """g, traction at small creepage over that of a viscous film."""
        return float(_builds_up(np, self.deborah_number))


def _force(scaled_creepage: Array, film: Film) -> Array:
    """Force ratio, 1 in slip."""
    xp = namespace(scaled_creepage)
    (creepage,) = as_floats(xp, scaled_creepage)
    viscous = xp.asinh(film.stress_ratio / film.builds_up * xp.abs(creepage))
    mean, _ = _mean_stress(xp, viscous, film)
    ratio = mean / film.stress_ratio
    return xp.sign(creepage) * xp.where(ratio < 1.0, ratio, 1.0)


def _creepage(force_ratio: Array, film: Film) -> Array:
    """Scaled creepage, that of slip beyond it."""
    xp = namespace(force_ratio)
    (ratio,) = as_floats(xp, force_ratio)
    return xp.sign(ratio) * xp.sinh(_viscous_stress(xp, ratio, film)) * (film.builds_up / film.stress_ratio)


def _slope(force_ratio: Array, film: Film) -> Array:
    """Derivative of the scaled creepage by the force ratio."""
    xp = namespace(force_ratio)
    (ratio,) = as_floats(xp, force_ratio)
    viscous = _viscous_stress(xp, ratio, film)
    _, rise = _mean_stress(xp, viscous, film)
    return film.builds_up * xp.cosh(viscous) / rise


def _viscous_stress(xp, ratio: Array, film: Film) -> Array:
    """Stress of a viscous film at the creepage of a force ratio, over the Eyring stress; >= 0."""
    size = xp.abs(ratio)
    required = film.stress_ratio * xp.where(size < 1.0, size, 1.0)
    least = film.builds_up
    start, other = required / least, required + math.log1p(1.0 / least) + 1.0

    def step(viscous: Array) -> Array:
        mean, rise = _mean_stress(xp, viscous, film)
        return viscous - xp.clip((mean - required) / rise, -_STRIDE, _STRIDE)

    return newton(xp, step, xp.where(start < other, start, other), _STEPS)


def _mean_stress(xp, viscous: Array, film: Film) -> tuple[Array, Array]:
    """Mean stress of the passage over the Eyring stress, and its derivative by `viscous`."""
    if film.deborah_number == 0.0:
        return viscous, 1.0 + 0.0 * viscous
    rest = 2.0 / (xp.exp(viscous) + 1.0)  # 1 - u without cancellation
    u, d_u = 1.0 - rest, 0.5 * rest * (2.0 - rest)
    rate, d_rate = xp.cosh(viscous) / film.deborah_number, xp.sinh(viscous) / film.deborah_number
    mean, rise = 0.0 * viscous, 0.0 * viscous
    for time, weight in _passage():
        left = xp.exp(-time * rate)
        gone, d_left = -xp.expm1(-time * rate), -time * d_rate * left
        above, below = 2.0 * u * gone, rest + left * u * (1.0 + u)
        d_above = 2.0 * (d_u * gone - u * d_left)
        d_below = -d_u + d_left * u * (1.0 + u) + left * d_u * (1.0 + 2.0 * u)
        mean = mean + weight * xp.log1p(above / below)
        rise = rise + weight * (d_above * below - above * d_below) / (below * (below + above))
    return mean, rise


@functools.cache
def _passage() -> tuple[tuple[float, float], ...]:
    """Places of a passage from 0 to 1, clustered at the entry, and their weights."""
    node, weight = np.polynomial.legendre.leggauss(_NODES)
    node, weight = 0.5 * (node + 1.0), 0.5 * weight
    return tuple(zip((node**3).tolist(), (3.0 * node**2 * weight).tolist(), strict=True))


def _builds_up(xp, number: Array) -> Array:
    """Mean of 1 - exp(-t/D) over a passage; 1 for D = 0."""
    flows = number > 0
    safe = xp.where(flows, number, 1.0)
    return xp.where(flows, 1.0 + safe * xp.expm1(-1.0 / safe), 1.0)
