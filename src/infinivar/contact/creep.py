r"""Creep laws: lateral creepage under a lateral force, without spin.

A law relates the force ratio ``x = fu/(mu P)`` to the scaled creepage ``xi = (C/(mu P)) u/|v|``; in the linear law they are
equal. All laws are odd, passive (``x xi >= 0``) and saturate at ``|x| = 1``, the slip limit; Polach's law reaches it only
asymptotically. Rolling theory uses ``k = C22 G a b upsilon/(3 mu N)``, which is ``xi/3``.

The laws are "linear", proportional up to slip; "faulring", linear with a loss of link speed above 70 % of the slip force;
"vermeulen-johnson", a cubic; "polach", a closed form; "fastsim", Kalker's simplified theory; "exact", a fit to exact rolling
theory, which depends on the shape of the patch and on Poisson's ratio. Spin, and creepage in
both directions, are added by `infinivar.transmission.spin_law` and `infinivar.transmission.driven_contact`.
"""

from __future__ import annotations

import functools
import math
import numbers
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array, as_floats, common_floats, namespace
from infinivar._core.arrays import shown
from infinivar.contact import exact_law
from infinivar.contact.laws import (
    FASTSIM_SLIP,
    VERMEULEN_JOHNSON_SLIP,
    fastsim_creepage,
    fastsim_force,
    fastsim_slope,
    faulring_flow_factor,
    linear_creepage,
    linear_force,
    linear_slope,
    polach_creepage,
    polach_force,
    polach_slope,
    signed,
    vermeulen_johnson_creepage,
    vermeulen_johnson_force,
    vermeulen_johnson_slope,
)
from infinivar.errors import ParameterError, nearest, require

LAWS: dict[str, CreepLaw] = {}
"""The shipped laws by name."""

_PROBED = (0.4, 0.2)
"""a/b and Poisson's ratio at which an own law that depends on them is probed."""

_RATIOS = np.array([0.0, 0.07, 0.23, 0.41, 0.62, 0.83, 0.96])
"""Force ratios at which an own law is probed; odd ones, away from where a law of pieces is likely to have its joints."""

_STEP = 1e-5
"""Step of the difference that `slope` is compared with."""

_ODD = 1e-9
_INVERSE = 0.005
"""Room for laws that interpolate between points of a table, in which force and creepage are separate curves."""

_STEEP = 0.05
"""The same for slopes, relative."""


class Formulas(NamedTuple):
    """The formulas of a law on one patch, as in `CreepLaw`.

    A law may also have `response`, scaled creepage -> force ratio and its derivative, where one is cheap beside the other.
    """

    creepage: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    force: Callable[[Array], Array]
    slip_creepage: Array
    flow_factor: Callable[[Array], tuple[Array, Array]] | None = None
    response: Callable[[Array], tuple[Array, Array]] | None = None

    def responding(self, creepage: Array) -> tuple[Array, Array]:
        """Force ratio at a scaled creepage, and its derivative."""
        if self.response is not None:
            return self.response(creepage)
        force = self.force(creepage)
        return force, 1.0 / self.slope(force)

    @property
    def straight(self) -> bool:
        """Whether force and creepage are proportional up to slip."""
        return isinstance(self.slip_creepage, (int, float)) and self.slip_creepage == 1.0


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class CreepLaw:
    """One law, by its formulas. A study asks for the shipped ones by name; a wheel takes any, as a value.

    Attributes
    ----------
    name : for reports, and for studies if it is a shipped one
    creepage : force ratio -> scaled creepage; odd, of the sign of the force ratio, and finite beyond slip, too
    slope : force ratio -> derivative of the scaled creepage, finite and >= 0, at 0 it is 1
    force : scaled creepage -> force ratio, the inverse
    slip_creepage : scaled creepage at which gross slip begins, inf if the law reaches it only asymptotically
    flow_factor : force ratio -> factor on the link speed and its derivative, or None for a law without a flow loss
    on_patch : a/b (rolling over lateral semi-axis) and Poisson's ratio -> `Formulas`, for a law that depends on them; the
        other formulas are then those of a circular patch with Poisson's ratio 0.3. None for a law that does not
    approximates : name of the law of the same patch and coefficients that it approximates up to slip; None for a law of its own

    Raises
    ------
    ParameterError
        If the name is empty or that of a shipped law, a formula is not a function, or `slip_creepage` is not positive; if
        the functions, evaluated at a few force ratios, do not have the properties above.
    """

    name: str
    creepage: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    force: Callable[[Array], Array]
    slip_creepage: float
    flow_factor: Callable[[Array], tuple[Array, Array]] | None = None
    on_patch: Callable[[Array, Array], Formulas] | None = None
    approximates: str | None = None

    def __post_init__(self) -> None:
        """Validate the fields."""
        require(
            isinstance(self.name, str) and bool(self.name.strip()), "name", repr(self.name), "text that is not empty"
        )
        for name in ("creepage", "slope", "force"):
            said = getattr(self, name)
            require(callable(said), name, repr(said), "a function")
        for name in ("flow_factor", "on_patch"):
            said = getattr(self, name)
            require(said is None or callable(said), name, repr(said), "a function or None")
        slip = self.slip_creepage
        number = isinstance(slip, numbers.Real) and not isinstance(slip, bool)
        require(number and slip > 0, "slip_creepage", repr(slip), "a number > 0, or inf")
        if LAWS:  # the shipped laws, which fill it, are tested
            self._check_own()

    def _check_own(self) -> None:
        """Probe a law that is not one of the program."""
        shipped = LAWS.get(self.name)
        other = shipped is None or shipped == self
        require(other, "name", repr(self.name), "another than that of a built-in creep law")
        if shipped is None:
            check_law(self.creepage, self.slope, self.force, self.slip_creepage)
        if shipped is None and self.flow_factor is not None:
            check_flow(self.flow_factor)
        if shipped is None and self.on_patch is not None:
            check_law(*self.on_patch(*_PROBED)[:4])

    def on(self, a_over_b: Array, poisson: Array) -> Formulas:
        """The formulas on a patch: rolling over lateral semi-axis, > 0, and Poisson's ratio, 0 to 0.5. [-]"""
        if self.on_patch is not None:
            return self.on_patch(a_over_b, poisson)
        return Formulas(self.creepage, self.slope, self.force, self.slip_creepage, self.flow_factor)

    @property
    def straight(self) -> bool:
        """Whether force and creepage are proportional up to slip."""
        return self.slip_creepage == 1.0

    def __str__(self) -> str:
        """The name alone."""
        return self.name

    def __repr__(self) -> str:
        """The name; formulas are functions and have no short form."""
        return f"CreepLaw({self.name!r})"


LINEAR = CreepLaw(name="linear", creepage=linear_creepage, slope=linear_slope, force=linear_force, slip_creepage=1.0)
FAULRING = replace(LINEAR, name="faulring", flow_factor=faulring_flow_factor)
VERMEULEN_JOHNSON = CreepLaw(
    name="vermeulen-johnson",
    creepage=vermeulen_johnson_creepage,
    slope=vermeulen_johnson_slope,
    force=vermeulen_johnson_force,
    slip_creepage=VERMEULEN_JOHNSON_SLIP,
    approximates="exact",
)
POLACH = CreepLaw(
    name="polach",
    creepage=polach_creepage,
    slope=polach_slope,
    force=polach_force,
    slip_creepage=float("inf"),
    approximates="exact",
)
FASTSIM = CreepLaw(
    name="fastsim",
    creepage=fastsim_creepage,
    slope=fastsim_slope,
    force=fastsim_force,
    slip_creepage=FASTSIM_SLIP,
    approximates="exact",
)


def _exact_on_patch(a_over_b: Array, poisson: Array) -> Formulas:
    """Law "exact" on a patch."""
    curve = exact_law.curve(a_over_b, poisson)
    return Formulas(
        functools.partial(exact_law.exact_creepage, curve=curve),
        functools.partial(exact_law.exact_slope, curve=curve),
        functools.partial(exact_law.exact_force, curve=curve),
        curve.full_slip,
        response=functools.partial(exact_law.exact_response, curve=curve),
    )


EXACT = CreepLaw(
    name="exact",
    creepage=exact_law.exact_creepage,
    slope=exact_law.exact_slope,
    force=exact_law.exact_force,
    slip_creepage=exact_law.STEEL_CIRCLE_SLIP,
    on_patch=_exact_on_patch,
)

LAWS.update({law.name: law for law in (LINEAR, FAULRING, VERMEULEN_JOHNSON, POLACH, FASTSIM, EXACT)})


def law(name: str | CreepLaw) -> CreepLaw:
    """The shipped creep law of that name; a law as it is.

    Raises
    ------
    ParameterError
        If the name is unknown; the message lists the laws.
    """
    if isinstance(name, CreepLaw):
        return name
    if not isinstance(name, str) or name not in LAWS:
        hint = nearest(name, LAWS) if isinstance(name, str) else ""
        raise ParameterError(f"creep_law must be one of {', '.join(LAWS)}, got {name!r}{hint}")
    return LAWS[name]


@functools.lru_cache(maxsize=16)
def pinned(law: CreepLaw, a_over_b: float, poisson: float) -> CreepLaw:
    """A law of one patch only, as a law of its own; a law that does not depend on the patch as it is."""
    if law.on_patch is None:
        return law
    formulas = law.on(a_over_b, poisson)
    return CreepLaw(
        name=f"{law.name}, a/b = {a_over_b:.6g}",
        creepage=formulas.creepage,
        slope=formulas.slope,
        force=formulas.force,
        slip_creepage=float(formulas.slip_creepage),
        flow_factor=formulas.flow_factor,
    )


def law_in_motion(found: CreepLaw) -> CreepLaw:
    """The law itself, if it serves for motion that changes in time.

    Raises
    ------
    ParameterError
        If it has a flow loss, with which two steering angles can give one motion.
    """
    if found.flow_factor is not None:
        lawful = ", ".join(known for known, other in LAWS.items() if other.flow_factor is None)
        raise ParameterError(
            f"creep_law must be one of {lawful} for motion in time, got {found.name!r}: its flow loss is for steady motion only"
        )
    return found


_find = law  # `law` below is a parameter


def lateral_force(law: str | CreepLaw, k: Array, a_over_b: Array = 1.0, poisson: Array = 0.3) -> Array:
    """Lateral force under a lateral creepage, without spin.

    Parameters
    ----------
    law : str or CreepLaw       The law, or the name of a shipped one. The flow loss of "faulring" is no part of it.
    k : (...,) float            C22 G a b upsilon/(3 mu N), may be infinite; or a CasADi expression. [-]
    a_over_b : (...,) float     Rolling over lateral semi-axis of the patch. "exact" is fitted for 0.05 to 20; beyond, it is the
        law at the end of that range. [-]
    poisson : (...,) float      Poisson ratio of the bodies. [-]

    Returns
    -------
    (...,) float   |Fy|/(mu N) with the sign of k; inputs broadcast. Except in "exact", shape and material enter only
        through C22 in k, so `a_over_b` and `poisson` only broadcast. [-]

    Raises
    ------
    ParameterError
        If the law is unknown; with a CasADi expression, if shape or material are no numbers.

    Source: faulring2006, vermeulen1964, polach2005, kalker1982, kalker1990, by law.
    """
    found = _find(law)
    if _symbolic(k, a_over_b=a_over_b, poisson=poisson):
        return found.on(float(a_over_b), float(poisson)).force(3.0 * k)
    k = _broadcast(k=k, a_over_b=a_over_b, poisson=poisson)[0]
    return found.on(a_over_b, poisson).force(3.0 * k)


def lateral_creep(law: str | CreepLaw, force_ratio: Array, a_over_b: Array = 1.0, poisson: Array = 0.3) -> Array:
    """Lateral creepage that a lateral force needs, without spin: the inverse of `lateral_force`.

    Parameters
    ----------
    law : str or CreepLaw          The law, or the name of a shipped one. The flow loss of "faulring" is no part of it.
    force_ratio : (...,) float     Fy/(mu N); or a CasADi expression. [-]
    a_over_b, poisson : (...,) float   As in `lateral_force`. [-]

    Returns
    -------
    (...,) float   C22 G a b upsilon/(3 mu N) with the sign of the force; at gross slip the smallest such creepage
        (infinite for "polach"), nan beyond. [-]

    Raises
    ------
    ParameterError
        As in `lateral_force`.

    Source: faulring2006, vermeulen1964, polach2005, kalker1982, kalker1990, by law.
    """
    if _symbolic(force_ratio, a_over_b=a_over_b, poisson=poisson):
        return _symbolic_creep(_find(law).on(float(a_over_b), float(poisson)), force_ratio)
    law = _find(law)
    ratio = _broadcast(force_ratio=force_ratio, a_over_b=a_over_b, poisson=poisson)[0]
    found = law.on(a_over_b, poisson)
    xp = namespace(ratio)
    size = xp.abs(ratio)
    creepage = xp.where(size < 1.0, found.creepage(ratio), signed(xp, ratio, found.slip_creepage + 0.0 * size))
    return xp.where(size <= 1.0, creepage, xp.nan) / 3.0


def _symbolic(value: Array, **numbers: Array) -> bool:
    """Whether a value is a CasADi expression, which knows no arrays: the others must be numbers then."""
    for name, number in numbers.items():
        if type(number).__module__.startswith("casadi"):
            raise ParameterError(f"{name} must be a number, got a CasADi expression; the patch is fixed")
    if not type(value).__module__.startswith("casadi"):
        return False
    for name, number in numbers.items():
        if namespace(number).ndim(number):
            raise ParameterError(f"{name} must be a number for a CasADi expression, got {shown(number)}")
    return True


def _symbolic_creep(law: Formulas, ratio: Array) -> Array:
    """`lateral_creep` of a CasADi expression."""
    import casadi

    size = casadi.fabs(ratio)
    creepage = casadi.if_else(
        size < 1.0, law.creepage(ratio), casadi.if_else(ratio < 0, -law.slip_creepage, law.slip_creepage)
    )
    return casadi.if_else(size <= 1.0, creepage, math.nan) / 3.0


def _broadcast(**named: Array) -> tuple[Array, ...]:
    """The arguments as floats, broadcast to their common shape."""
    xp = namespace(*named.values())
    try:
        return xp.broadcast_arrays(*as_floats(xp, *named.values()))
    except (TypeError, ValueError):
        if xp.__name__ == "numpy":
            common_floats(xp, **named)  # says which one is wrong
        raise


def directed_flow_factor(law: CreepLaw | Formulas, ratio: Array, link_speed: Array) -> Array:
    """Factor on the link speed that always removes power; 0 at and beyond slip.

    Where the lateral force drives the link (``-fu ldot > 0``), the paper's factor slows the link. Where the load drives,
    the same factor would create power; its reciprocal makes the link faster instead, at the same torque.

    Parameters
    ----------
    law : CreepLaw              A law with a flow factor.
    ratio : (...,) float        Lateral force over mu P. [-]
    link_speed : (...,) float   Link speed before the loss, or any value with its sign. [m s^-1]

    Returns
    -------
    (...,) float   [-]

    Source: faulring2006, Eq 17, made passive in all quadrants.
    """
    assert law.flow_factor is not None
    xp = namespace(ratio, link_speed)
    factor, _ = law.flow_factor(ratio)
    rolls = factor > 0
    drives = ratio * link_speed <= 0
    return xp.where(rolls, xp.where(drives, factor, 1.0 / xp.where(rolls, factor, 1.0)), 0.0)


def before_flow_loss(law: CreepLaw | Formulas, ratio: Array, slope: Array) -> tuple[Array, Array]:
    """Speed ratio that `directed_flow_factor` maps to `slope`, and its derivative by the force ratio; nan beyond slip.

    Parameters
    ----------
    law : CreepLaw         A law with a flow factor.
    ratio : (...,) float   Lateral force over mu P. [-]
    slope : (...,) float   Link speed over surface speed with the loss. [-]

    Returns
    -------
    before, derivative : (...,) float   [-]

    Source: faulring2006, Eq 17, solved for the speed before the loss.
    """
    assert law.flow_factor is not None
    xp = namespace(ratio, slope)
    factor, d_factor = law.flow_factor(ratio)
    rolls = factor > 0
    inverse = xp.where(rolls, 1.0 / xp.where(rolls, factor, 1.0), xp.nan)
    drives = ratio * slope <= 0
    before = slope * xp.where(drives, inverse, factor)
    return before, slope * d_factor * xp.where(drives, -inverse * inverse, 1.0)


def check_law(
    creepage: Callable[[Any], Any], slope: Callable[[Any], Any], force: Callable[[Any], Any], slip_creepage: float
) -> None:
    """Raise ParameterError unless the functions of a creep law fit together; the message names the function and the point.

    Probed are: creepage and force are odd, creepage has the sign of the force, so that creep takes power, slope is the
    derivative of creepage, 1 at 0 and never negative, force is the inverse of creepage, and slip begins at `slip_creepage`.
    """
    x = np.concatenate([-_RATIOS[:0:-1], _RATIOS])
    xi = _values("creepage", creepage, x)
    _hold("creepage", "odd in the force ratio", x, xi, -xi[::-1], _ODD)
    _hold("creepage", "of the sign of the force ratio", x, xi, np.sign(x) * np.abs(xi), 0.0)
    if slip_creepage == 1.0:
        _hold("creepage", "equal to the force ratio, as slip_creepage is 1", x, xi, x, _ODD)
    _hold("creepage", "at most slip_creepage", x, xi, np.clip(xi, -slip_creepage, slip_creepage), _INVERSE)
    steep = _values("slope", slope, x)
    _hold("slope", ">= 0", x, steep, np.abs(steep), 0.0)
    _hold("slope", "1", x[x == 0], steep[x == 0], np.ones(1), _STEEP)
    rise = (_values("creepage", creepage, x + _STEP) - _values("creepage", creepage, x - _STEP)) / (2.0 * _STEP)
    _hold("slope", "the derivative of creepage", x, steep, rise, _STEEP * np.maximum(1.0, np.abs(rise)))
    back = _values("force", force, xi)
    _hold("force", "the inverse of creepage", xi, back, x, _INVERSE, of="scaled creepage")
    if np.isfinite(slip_creepage):
        slip = np.array([-slip_creepage, slip_creepage])
        _hold(
            "force", "+-1 at slip_creepage", slip, _values("force", force, slip), np.sign(slip), _INVERSE, of="creepage"
        )


def check_flow(flow_factor: Callable[[Any], Any]) -> None:
    """Raise ParameterError unless a flow factor is even and within 0 to 1, so that it takes power."""
    x = np.concatenate([-_RATIOS[:0:-1], _RATIOS])
    factor = _values("flow_factor", lambda ratio: flow_factor(ratio)[0], x)
    _hold("flow_factor", "even in the force ratio", x, factor, factor[::-1], _ODD)
    _hold("flow_factor", "from 0 to 1", x, factor, np.clip(factor, 0.0, 1.0), 0.0)


def _values(name: str, function: Callable[[Any], Any], at: np.ndarray) -> np.ndarray:
    try:
        return np.broadcast_to(np.asarray(function(at), dtype=float), at.shape)
    except Exception as problem:  # the code of others may fail in any way
        raise ParameterError(
            f"{name} must be a function of a NumPy array of floats, but fails with {type(problem).__name__}: {problem}"
        ) from problem


def _hold(
    name: str, required: str, at: np.ndarray, found: np.ndarray, right: np.ndarray, room: Any, of: str = "force ratio"
) -> None:
    """Raise ParameterError at the first point at which values are not what they should be; nan never is."""
    off = ~(np.abs(found - right) <= room)
    if off.any():
        place = int(np.argmax(off))
        raise ParameterError(
            f"{name} must be {required}, got {found[place]:.6g} at the {of} {at[place]:.4g}"
            + (f" instead of {right[place]:.6g}" if required != ">= 0" else "")
        )
