"""Lateral creep stiffness of an elliptical patch that is turned from the rolling direction."""

from __future__ import annotations

from annotated_types import Interval

from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar._core.fields import check_value
from infinivar.contact import kalker

_BEND = (0.0590, -0.0848, -0.0424, 0.0176, 0.1469, -0.7327)
"""Fitted to `contact.exact` at a/b from 1.25 to 9, Poisson's ratios 0, 0.25 and 0.5, turns of 10 to 80 degrees."""


def lateral_coefficient(a_over_b: Array, poisson: Array, turn: Array) -> Array:
    r"""Kalker's lateral coefficient of a wheel that rolls freely on a turned patch.

    Lateral creep of a turned patch causes a longitudinal force, too, until the wheel's own turning has adapted: at no
    longitudinal force the stiffness is C22 less C12 squared over C11. This effective coefficient follows

    .. math:: \frac{1}{C} = e^{q}\left[\frac{\cos^2\theta}{C_{22}(a/b)} + \frac{\sin^2\theta}{C_{22}(b/a)}\right], \quad
        q = \frac{(p_0 + p_1\nu + p_2\nu^2 + p_3\nu m)\, s^2 \sin^2 2\theta}{1 + p_4 s^2 + p_5 m}, \quad
        s = \ln\frac{a}{b}, \quad m = s\cos 2\theta

    The bracket is how a creep compliance turns if it is a tensor; q, fitted to the solver, is zero for an aligned patch and
    of second order in the departure from a circle.

    Parameters
    ----------
    a_over_b : (...,) float   Ratio of the semi-axes; at no turn, that along the rolling direction over the other. [-]
    poisson : (...,) float    Combined Poisson's ratio, 0 to 0.5. [-]
    turn : (...,) float       Angle theta from the rolling direction to the semi-axis a; its sign does not matter. [rad]

    Returns
    -------
    (...,) float   Lateral force over G a b times lateral creepage, at no longitudinal force. [-]

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Notes
    -----
    Differs from the solver by at most 0.25 % for a/b from 0.5 to 2 (0.1 % for a Poisson's ratio of 0.3), 0.4 % from 0.25 to 4
    and 1.2 % from 1/6 to 6, beside the error of `kalker.coefficients`; beyond, by 10 % at 20 and 1/20. Without q the first two
    would be 2.9 % and 11 %.

    Source: kalker1990 for C22; `contact.exact` for the turn.
    """
    check_value("turn", turn, "rad", Interval())
    xp = namespace(a_over_b, poisson, turn)
    ratio, nu, turn = as_floats(xp, a_over_b, poisson, turn)
    along, across = kalker.coefficients(ratio, nu).c22, kalker.coefficients(1.0 / ratio, nu).c22
    sine = xp.sin(turn)
    share = sine * sine
    size, mixed = xp.log(ratio), xp.log(ratio) * (1.0 - 2.0 * share)
    bend = _BEND[0] + nu * (_BEND[1] + _BEND[2] * nu + _BEND[3] * mixed)
    q = 4.0 * share * (1.0 - share) * size * size * bend / (1.0 + _BEND[4] * size * size + _BEND[5] * mixed)
    return along * xp.exp(-q) / (1.0 - share + share * along / across)
