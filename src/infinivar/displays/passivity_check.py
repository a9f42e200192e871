r"""Passivity of a display: whether it can ever give a user energy that the user has not put in.

A passive display is stable with every passive arm; coupled stability is less, that with one arm.

**Impedance display.** With a plant that has the damping b, a zero-order hold and a controller H(z) from position to force,
passivity is equivalent to

.. math:: b > \frac{T}{2}\,\frac{1}{1 - \cos\omega T}\,\mathrm{Re}\left\{(1 - e^{-j\omega T}) H(e^{j\omega T})\right\},
    \qquad 0 \le \omega \le \pi/T .

For a wall of stiffness K and damping B that is never late, this is :math:`b > KT/2 + |B|`. The mass does not matter. Behind a
structure that is not rigid the condition at the drive suffices; where it is not met, a negative real part at the handle decides.

**Admittance display.** A virtual mass M that follows the force with the lag :math:`\tau` has the impedance
:math:`Z = j\omega M e^{j\omega\tau}`, whose real part :math:`-\omega M \sin\omega\tau` is negative for all
:math:`0 < \omega < \pi/\tau`, whatever the mass: it is never passive, and a larger mass makes it worse. Virtual damping does not
help, as it is late as well: at :math:`\omega\tau = \pi/2` the real part remains :math:`-\omega M`. Only a damper beside it could.
Such a display is therefore judged with a named arm.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.described import derived, reported
from infinivar._core.fields import check_number
from infinivar._core.result import Result, result
from infinivar.displays.kinds import AdmittanceDisplay, Display, ImpedanceDisplay
from infinivar.displays.sampled_loop import impedance
from infinivar.displays.stability import check_display
from infinivar.errors import require
from infinivar.units import plain

_ANGLES = 20_001
"""Angles omega T at which the general condition is evaluated, from 0 to pi."""

_POINTS = 400
"""Frequencies at which a real part is looked for, from `_LOWEST` to `_HIGHEST` of the sample rate."""

_LOWEST, _HIGHEST = 1e-4, 0.49

_ROUNDING = 1e-6
"""Real part over magnitude that may be rounding. [-]"""


def required_damping(stiffness: float, damping: float, period: float, late: int = 0) -> float:
    r"""Damping that a plant needs so that a sampled virtual wall is passive.

    .. math:: b > \frac{KT}{2} + |B|

    for a controller that is not late. For one that is late by a sample, the general condition gives
    :math:`KT(1 + 2c)/2 - B(2c^2 - 1)`, largest over :math:`c = \cos\omega T`: :math:`3KT/2 - B` at :math:`c = 1`, or, if
    :math:`KT < 4B`, :math:`KT/2 + (KT)^2/(8B) + B` at :math:`c = KT/(4B)`.

    Parameters
    ----------
    stiffness : float   K, >= 0. [N m^-1]
    damping : float     B, of a backward difference; either sign. [N s m^-1]
    period : float      T, > 0. [s]
    late : int          Samples by which the controller is late, 0 or 1.

    Returns
    -------
    float   The display is passive if its viscous friction is larger. [N s m^-1]

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Source: colgate1997 for a controller that is not late; else its general condition, as `general_required_damping`.
    """
    check_number("stiffness", stiffness, "N/m", Ge(0))
    check_number("period", period, "s", Gt(0))
    require(late in (0, 1), "late", late, "0 or 1")
    across = stiffness * period
    if late == 0:
        return 0.5 * across + abs(damping)
    if damping > 0.0 and across < 4.0 * damping:
        return 0.5 * across + across * across / (8.0 * damping) + damping
    return 1.5 * across - damping


def required_friction(stiffness: float, damping: float, period: float, resolution: float) -> float:
    r"""Coulomb friction that a plant needs so that a wall of whole encoder counts is passive.

    .. math:: f > \Delta\left(\frac{K}{2} + \frac{B}{T}\right)

    A handle that moves to and fro across the edge of a count gains :math:`K\Delta + 2B\Delta/T` per travel each time, and
    friction takes 2f. A wall whose damping is nearer to :math:`T(f/\Delta - K/2)` chatters, however light the hand.

    Parameters
    ----------
    stiffness : float    K, >= 0. [N m^-1]
    damping : float      B, of a backward difference, >= 0. [N s m^-1]
    period : float       T, > 0. [s]
    resolution : float   Delta, travel of one count, >= 0. [m]

    Returns
    -------
    float   [N]

    Source: abbott2005 for B = 0, together with `required_damping`; with B the same cycle, which is necessary (the effect is
    that measured by colgate1994; diolaiti2006 has the regions that are stable all the same).
    """
    check_number("stiffness", stiffness, "N/m", Ge(0))
    check_number("damping", damping, "N s/m", Ge(0))
    check_number("period", period, "s", Gt(0))
    check_number("resolution", resolution, "m", Ge(0))
    return resolution * (0.5 * stiffness + damping / period)


def virtual_coupling(damping: float, period: float, late: int = 0) -> tuple[float, float]:
    r"""Stiffest spring and its damper between a display and any passive virtual object, so that the display is passive.

    With :math:`k = KT/2` and :math:`a = k + B`, an object of any passive impedance needs
    :math:`b > \max_w 4w\,(a^2(1-w) + k^2 w)/a` over :math:`0 \le w \le 1` if the controller is one sample late, which is least
    for :math:`a = \sqrt 3\,k`, and :math:`b > a` if it is not.

    Parameters
    ----------
    damping : float   b, viscous friction of the display, >= 0. [N s m^-1]
    period : float    T, > 0. [s]
    late : int        Samples by which the controller is late, 0 or 1.

    Returns
    -------
    stiffness, damping : float   K and B of the coupling. [N m^-1], [N s m^-1]

    Source: the coupling of colgate1995 and adams1999, for all passive objects by the disc of impedances that they give together
    with it, in the general condition of colgate1997.
    """
    check_number("damping", damping, "N s/m", Ge(0))
    check_number("period", period, "s", Gt(0))
    require(late in (0, 1), "late", late, "0 or 1")
    if late == 0:
        return 2.0 * damping / period, 0.0
    stiffness = 4.0 * damping / (3.0 * math.sqrt(3.0) * period)
    return stiffness, (math.sqrt(3.0) - 1.0) * 0.5 * stiffness * period


def general_required_damping(transfer: Callable[[np.ndarray], np.ndarray], period: float) -> tuple[float, float]:
    """Damping that a plant needs so that a sampled controller of any kind is passive, found numerically.

    Parameters
    ----------
    transfer : callable   H: maps z = exp(j omega T), (n,) complex, to force over position, (n,) complex. [N m^-1]
    period : float        T. [s]

    Returns
    -------
    damping, frequency : float   [N s m^-1]; the frequency that needs it [Hz].

    Source: colgate1997, general condition.
    """
    angle = np.linspace(0.0, math.pi, _ANGLES)[1:]
    turn = np.exp(1j * angle)
    needed = 0.5 * period / (1.0 - np.cos(angle)) * np.real((1.0 - 1.0 / turn) * transfer(turn))
    place = int(np.argmax(needed))
    return float(needed[place]), float(angle[place] / (2.0 * math.pi * period))


def wall_transfer(stiffness: float, damping: float, period: float, late: int) -> Callable[[np.ndarray], np.ndarray]:
    """H of a virtual wall with a backward difference, by z. [N m^-1]

    Source: colgate1997, virtual wall.
    """
    return lambda z: (stiffness + damping * (1.0 - 1.0 / z) / period) * z**-late


@result
class Passivity(Result):
    """Whether a display is passive, and why, as returned by `passivity`.

    Attributes
    ----------
    display : str             Kind of display.
    passive : bool or None    None where nothing contradicts passivity, which does not prove it.
    reason : str              In a sentence, with the numbers that decide.
    required : float          Damping that the display would need at its handle to be passive; for an admittance display, to
        keep the real part from being negative at the frequencies tried. [N s m^-1]
    available : float         Viscous friction that it has; 0 for an admittance display, in which it is part of the impedance.
    frequency : float         That needs most damping. [Hz]
    """

    display: str = reported()
    passive: bool | None = reported()
    reason: str
    required: float = reported("N s/m", key="required_damping_Ns_m")
    available: float = reported("N s/m", key="available_damping_Ns_m")
    frequency: float = reported("Hz")

    @derived()
    def verdict(self) -> str:
        """One-sentence answer with its reason."""
        said = {True: "Passive", False: "Not passive", None: "Not shown to be passive"}[self.passive]
        return f"{said}: {self.reason}."


def passivity(display: Display) -> Passivity:
    """Whether a display is passive at its handle.

    Parameters
    ----------
    display : AdmittanceDisplay or ImpedanceDisplay

    Returns
    -------
    Passivity   Of the linear display: Coulomb friction, which helps, is left out.

    Raises
    ------
    ParameterError
        If it is no display.

    Source: colgate1997 for an impedance display; a negative real part of the impedance for an admittance display.
    """
    check_display(display)
    return _of_impedance(display) if isinstance(display, ImpedanceDisplay) else _of_admittance(display)


def _of_impedance(display: ImpedanceDisplay) -> Passivity:
    wall, period, late = (display.wall_stiffness, display.wall_damping), display.period, display.samples_late
    needed, b = required_damping(*wall, period, late), display.damping
    frequency = general_required_damping(wall_transfer(*wall, period, late), period)[1]
    passive = b > needed or (needed == 0.0 and wall == (0.0, 0.0))
    form = "K T/2 + |B|" if late == 0 else "the condition for one sample late"
    sign = ">" if b > needed else ("=" if b == needed else "<")
    reason = f"viscous friction of {plain(b, 3)} N s/m {sign} {plain(needed, 3)} N s/m, {form}"
    if b == 0.0 and not passive:
        reason += "; the drive has Coulomb friction only, which is left out"
    friction = required_friction(*wall, period, display.encoder_resolution)
    if friction > display.coulomb_friction:
        reason += f"; encoder counts of {plain(1e6 * display.encoder_resolution, 3)} um need {plain(friction, 3)} N of friction, "
        reason += f"there is {plain(display.coulomb_friction, 3)} N"
        passive = False
    elif math.isfinite(display.series_stiffness):
        reason += ", at the drive; structure, sensor and handle beyond are passive"
        if not passive and display.handle_mass > 0.0:
            real = np.real(impedance(display, np.geomspace(_LOWEST, _HIGHEST, _POINTS) / period))
            passive = None if np.min(real) >= 0.0 else False
            reason += f"; the least real part of the impedance is {plain(float(np.min(real)), 3)} N s/m"
            reason += ", which is negative" if passive is False else ""
    return Passivity(
        display="ImpedanceDisplay", passive=passive, reason=reason, required=needed, available=b, frequency=frequency
    )


def _of_admittance(display: AdmittanceDisplay) -> Passivity:
    frequency = np.geomspace(_LOWEST, _HIGHEST, _POINTS) / display.period
    found = impedance(display, frequency)
    real = np.real(found)
    place = int(np.argmin(real))
    least = float(real[place])
    negative = real < -_ROUNDING * np.abs(found)
    if np.any(negative):
        where = frequency[negative]
        lag = (0.5 + display.samples_late) * display.period
        start = "" if negative[0] else f"from {plain(float(where[0]), 2)} "
        reason = (
            f"the real part of the impedance is negative {start}{'to' if start else 'up to'} {plain(float(where[-1]), 3)} Hz, "
            f"{plain(least, 3)} N s/m at {plain(float(frequency[place]), 3)} Hz; sampling alone lags by {plain(1e3 * lag, 3)} "
            "ms, and a virtual mass that lags is passive at no mass"
        )
    else:
        reason = f"the real part of the impedance is not negative at any of {len(frequency)} frequencies"
    return Passivity(
        display="AdmittanceDisplay",
        passive=False if np.any(negative) else None,
        reason=reason,
        required=max(-least, 0.0),
        available=0.0,
        frequency=float(frequency[place]),
    )
