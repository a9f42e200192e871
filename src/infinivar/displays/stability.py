"""Coupled stability of a display and a named arm: eigenvalues of the sampled loop over two parameters, with refined boundaries.

What is stable with one arm need not be with another. A virtual mass that is too small makes an admittance display unstable, a
wall that is too stiff makes either kind unstable. The least mass is not monotone in the bandwidth of the steering servo: with a
slow filter of the force sensor it is largest where both are about as fast, and a slow servo needs a large mass at a wall.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from infinivar._core.arrays import real_array
from infinivar._core.described import derived, finite, reported
from infinivar._core.fields import with_values
from infinivar._core.result import Result, result
from infinivar.displays.kinds import AdmittanceDisplay, Display, ImpedanceDisplay
from infinivar.displays.plants import Held
from infinivar.displays.sampled_loop import NEUTRAL, growths, sampled_loop
from infinivar.errors import ParameterError, nearest, require
from infinivar.motion.users import ArmModel
from infinivar.units import plain

_LOOP = {"sample_rate": "Hz", "steering_bandwidth": "Hz", "link_bandwidth": "Hz"}
"""Parameters of the drive's control, and their units."""

_UNITS = {
    "virtual_mass": "kg",
    "virtual_damping": "N s/m",
    "wall_stiffness": "N/m",
    "wall_damping": "N s/m",
    "viscous_friction": "N s/m",
    "handle_mass": "kg",
    "filter_frequency": "Hz",
    "force_gain": "1",
    "structure_stiffness": "N/m",
    "structure_damping": "N s/m",
    "sensor_stiffness": "N/m",
    **_LOOP,
}

_USUAL: dict[type, dict[str, np.ndarray]] = {
    AdmittanceDisplay: {"virtual_mass": np.geomspace(0.1, 10.0, 50), "wall_stiffness": np.geomspace(100.0, 1e5, 50)},
    ImpedanceDisplay: {"wall_stiffness": np.geomspace(100.0, 1e6, 50), "sample_rate": np.geomspace(500.0, 1e4, 50)},
}

_MORE_IS_SAFER = {"virtual_mass", "virtual_damping", "viscous_friction", "sample_rate", "filter_frequency"}
"""Parameters whose least stable value a verdict states; of the others it is the largest."""

_STEPS = 60
"""Most steps to a boundary; 8 to 15 suffice."""

_CLOSE = 1e-11
"""Largest error of the growth at a boundary. [-]"""

_SEARCHED = 120
"""Values tried of one parameter, in a search."""

MASSES = (1e-3, 1e3)
"""Virtual masses searched. [kg]"""

WALLS = (1.0, 1e8)
"""Stiffnesses searched. [N m^-1]"""

GAINS = (1e-3, 1e3)
"""Force gains searched. [-]"""


@result
class StabilityMap(Result):
    """Growth per sample over two parameters, as returned by `stability_map`.

    Attributes
    ----------
    display, held : str          Kind of display; the arm, "free" or "clamped".
    first, second : str          The parameters.
    x, y : (X,), (Y,)            Their values; SI.
    growth : (Y, X)              Largest growth per sample; stable up to 1. [-]
    boundary : (n, 2)            Values of both parameters where the growth is 1: one between each two neighbours of the map,
        along either axis, of which only one is stable.
    least : (Y,)                 Value of the first parameter from which all larger ones are stable; nan if the largest is
        not, the smallest one if all are.
    most : (Y,)                  Value up to which all smaller ones are stable; nan if the smallest is not, the largest one if all
        are.
    """

    display: str = reported(attribute="display")
    held: str = reported(attribute="held")
    first: str = reported()
    second: str = reported()
    x: np.ndarray = reported(convert=finite)
    y: np.ndarray = reported(convert=finite)
    growth: np.ndarray = reported()
    boundary: np.ndarray = reported()
    least: np.ndarray = reported(convert=finite)
    most: np.ndarray = reported(convert=finite)

    @property
    def stable(self) -> np.ndarray:
        """Where the loop is stable. (Y, X) bool"""
        return np.asarray(self.growth) <= 1.0 + NEUTRAL

    @derived()
    def units(self) -> tuple[str, str]:
        """Of both parameters."""
        return _UNITS[self.first], _UNITS[self.second]

    @derived()
    def verdict(self) -> str:
        """One-sentence answer: how much is stable, and the boundary at both ends of the second parameter."""
        share = 100.0 * float(np.mean(self.stable))
        side, bound = ("least", self.least) if self.first in _MORE_IS_SAFER else ("largest", self.most)
        words = [self._at(bound, place) for place in (0, -1)]
        name = self.first.replace("_", " ")
        return f"Stable in {share:.0f} % of the map with {self.held}: {side} stable {name} {words[0]}, {words[1]}."

    def _at(self, bound: np.ndarray, place: int) -> str:
        value, unit, other = float(bound[place]), *self.units
        end = float(self.x[0] if self.first in _MORE_IS_SAFER else self.x[-1])
        said = "none" if np.isnan(value) else f"{plain(value, 3)} {unit}"
        if value == end:
            said = f"beyond {plain(end, 3)} {unit}"
        return f"{said} at a {self.second.replace('_', ' ')} of {plain(float(self.y[place]), 3)} {other}"


def stability_map(
    display: Display, held: Held, over: Mapping[str, Sequence[float] | np.ndarray] | None = None
) -> StabilityMap:
    """Stability over two parameters of a display.

    Parameters
    ----------
    display : AdmittanceDisplay or ImpedanceDisplay
    held : ArmModel, "free" or "clamped"   What is at the handle.
    over : mapping   Two parameters and their rising values: fields of the display such as "virtual_mass" or "wall_stiffness", or
        "sample_rate", "steering_bandwidth" or "link_bandwidth". By default virtual mass and wall stiffness of an admittance
        display, wall stiffness and sample rate of an impedance display, 50 values each.

    Returns
    -------
    StabilityMap   Boundaries are refined to rounding along the first parameter, between the values of the map.

    Raises
    ------
    ParameterError
        If an argument is out of range; a value that the display or its drive does not permit is named.

    Source: franklin1998; eigenvalues of `sampled_loop`.
    """
    check_display(display)
    given = _USUAL[type(display)] if over is None else over
    if not isinstance(given, Mapping) or len(given) != 2:
        raise ParameterError(f"over must hold two parameters, got {given!r}")
    (first, x), (second, y) = ((name, _values(display, name, values)) for name, values in given.items())
    known: dict = {}
    rows: dict[float, Any] = {}

    def growing(points: np.ndarray) -> np.ndarray:
        for value in points[:, 1].tolist():
            if value not in rows:
                rows[value] = _changed(display, second, value)
        return growths(
            sampled_loop(_changed(rows[other], first, value), held, known) for value, other in points.tolist()
        )

    grid = np.stack(np.meshgrid(x, y), axis=-1)
    growth = growing(grid.reshape(-1, 2)).reshape(len(y), len(x))
    stable = growth <= 1.0 + NEUTRAL
    across = _crossings(growing, grid, growth, 1)
    along = _crossings(growing, grid, growth, 0)
    least, most = _ends(x, stable, across)
    return StabilityMap(
        display=type(display).__name__,
        held=held.name if isinstance(held, ArmModel) else held,
        first=first,
        second=second,
        x=x,
        y=y,
        growth=growth,
        boundary=np.concatenate([across[np.isfinite(across[..., 0])], along[np.isfinite(along[..., 0])]]),
        least=least,
        most=most,
    )


def least_stable_mass(display: AdmittanceDisplay, held: Held, between: tuple[float, float] = MASSES) -> float:
    """Least stable virtual mass, with the wall of the display.

    Too large a mass can be unstable as well: a display that lags by t feels as damped by -k t to an arm of stiffness k. The
    least mass is then the lower end of the widest range of stable ones.

    Parameters
    ----------
    display : AdmittanceDisplay   Its virtual mass does not matter.
    held : ArmModel, "free" or "clamped"
    between : (2,) float          Masses searched. [kg]

    Returns
    -------
    float   [kg]; the smallest one searched if that is stable and in the widest range, nan if none is stable.

    Raises
    ------
    ParameterError
        If the display has no virtual mass, or the range does not rise.
    """
    check_display(display)
    if not isinstance(display, AdmittanceDisplay):
        raise ParameterError(f"display must be an AdmittanceDisplay, got an {type(display).__name__}")
    return _searched(display, held, "virtual_mass", between)[0]


def largest_force_gain(display: ImpedanceDisplay, held: Held, between: tuple[float, float] = GAINS) -> float:
    """Largest force gain up to which all smaller ones are stable: how much lighter a force sensor can make a geared drive feel.

    Parameters
    ----------
    display : ImpedanceDisplay   With the corner of its sensor's filter; its force gain does not matter.
    held : ArmModel, "free" or "clamped"
    between : (2,) float          Gains searched. [-]

    Returns
    -------
    float   [-]; the largest one searched if all are stable, nan if the smallest is not.

    Raises
    ------
    ParameterError
        If the display has no force gain, or the range does not rise.
    """
    check_display(display)
    if not isinstance(display, ImpedanceDisplay):
        raise ParameterError(f"display must be an ImpedanceDisplay, got an {type(display).__name__}")
    return _searched(display, held, "force_gain", between)[1]


def stiffest_wall(display: Display, held: Held, between: tuple[float, float] = WALLS) -> float:
    """Stiffest wall up to which all softer ones are stable.

    Parameters
    ----------
    display : AdmittanceDisplay or ImpedanceDisplay   Its wall stiffness does not matter.
    held : ArmModel, "free" or "clamped"
    between : (2,) float          Stiffnesses searched. [N m^-1]

    Returns
    -------
    float   Of the wall at the drive; at the handle it is ``display.at_handle`` of that. [N m^-1]; the largest one searched if all
        are stable, nan if the smallest is not.

    Raises
    ------
    ParameterError
        If the range does not rise.
    """
    check_display(display)
    return _searched(display, held, "wall_stiffness", between)[1]


def check_display(display: Any) -> None:
    """Raise ParameterError unless it is a display."""
    if not isinstance(display, AdmittanceDisplay | ImpedanceDisplay):
        raise ParameterError(
            f"display must be an AdmittanceDisplay or an ImpedanceDisplay, got a {type(display).__name__}"
        )


def _searched(display: Display, held: Held, name: str, between: tuple[float, float]) -> tuple[float, float]:
    """Lower end of the widest range of stable values, and the value up to which all smaller ones are stable."""
    ends = real_array("between", between)
    require(ends.shape == (2,) and bool(0.0 < ends[0] < ends[1] < np.inf), "between", between, "two rising values > 0")
    values, known = np.geomspace(ends[0], ends[1], _SEARCHED), {}

    def growing(points: np.ndarray) -> np.ndarray:
        return growths(sampled_loop(_changed(display, name, value), held, known) for value in points[:, 0].tolist())

    grid = np.stack([values, np.zeros_like(values)], axis=-1)[None]
    growth = growing(grid[0])[None]
    stable, crossings = growth <= 1.0 + NEUTRAL, _crossings(growing, grid, growth, 1)
    return _lowest(values, stable[0], crossings[0, :, 0]), float(_ends(values, stable, crossings)[1][0])


def _lowest(x: np.ndarray, stable: np.ndarray, crossings: np.ndarray) -> float:
    """Lower end of the widest range of stable values; nan if there is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stable, [False]]).astype(int)))
    if not edges.size:
        return np.nan
    starts, stops = edges[::2], edges[1::2]
    start = int(starts[np.argmax(stops - starts)])
    return float(crossings[start - 1] if start else x[0])


def _crossings(
    growing: Callable[[np.ndarray], np.ndarray], grid: np.ndarray, growth: np.ndarray, axis: int
) -> np.ndarray:
    """Points of the boundary between neighbours along an axis of the map; nan where both are stable, or neither is.

    By regula falsi as modified in the Illinois method, with a bisection every third step: the growth has kinks.
    """
    excess = growth - (1.0 + NEUTRAL)
    one, other = (np.take(grid, range(start, grid.shape[axis] + start - 1), axis) for start in (0, 1))
    low, high = (np.take(excess, range(start, grid.shape[axis] + start - 1), axis) for start in (0, 1))
    found = np.full(one.shape, np.nan)
    places = (low <= 0.0) != (high <= 0.0)
    one, other, low, high = one[places], other[places], low[places], high[places]
    # Shares of the way from the one to the other, on a logarithmic scale where that is possible.
    left, right = np.zeros(len(low)), np.ones(len(low))
    powers = (one > 0.0) & (other > 0.0)
    ratio = np.where(powers, other, 1.0) / np.where(powers, one, 1.0)

    def at(share: np.ndarray) -> np.ndarray:
        return np.where(powers, one * ratio ** share[:, None], one + (other - one) * share[:, None])

    middle = 0.5 * (left + right)
    for step in range(_STEPS if len(low) else 0):
        secant = (left * high - right * low) / np.where(high == low, 1.0, high - low)
        usable = (high != low) & (step % 3 != 2) & (secant > left) & (secant < right)
        middle = np.where(usable, secant, 0.5 * (left + right))
        value = growing(at(middle)) - (1.0 + NEUTRAL)
        if np.all((np.abs(value) <= _CLOSE) | (right - left <= 1e-14)):
            break
        same = (value <= 0.0) == (low <= 0.0)
        # The end that stays counts half from then on, so that it is left soon.
        left, right = np.where(same, middle, left), np.where(same, right, middle)
        low, high = np.where(same, value, 0.5 * low), np.where(same, 0.5 * high, value)
    found[places] = at(middle)
    return found


def _ends(x: np.ndarray, stable: np.ndarray, crossings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the stable values that reach to the last, and from the first, in each row."""
    places = np.isfinite(crossings[..., 0])
    rows = np.arange(len(stable))
    every = stable.all(axis=1)
    last = places.shape[1] - 1 - np.argmax(places[:, ::-1], axis=1)
    first = np.argmax(places, axis=1)
    least = np.where(stable[:, -1], crossings[rows, last, 0], np.nan)
    most = np.where(stable[:, 0], crossings[rows, first, 0], np.nan)
    return np.where(every, x[0], least), np.where(every, x[-1], most)


def _changed(display: Display, name: str, value: float) -> Any:
    return with_values(display, {f"drive.control.{name}" if name in _LOOP else name: float(value)})


def _values(display: Display, name: str, values: Any) -> np.ndarray:
    known = [one for one in _UNITS if hasattr(display, one) or (one in _LOOP and hasattr(display.drive.control, one))]
    if name not in known:
        hint = nearest(name, known) if isinstance(name, str) else ""
        raise ParameterError(f"over has an unknown parameter {name!r}{hint}; known: {', '.join(known)}")
    found = real_array(f"over.{name}", values)
    fits = found.ndim == 1 and found.size > 1
    require(fits, f"over.{name}", f"shape {found.shape}", "a row of two values or more")
    finite = bool(np.all(np.isfinite(found)))
    require(finite, f"over.{name}", "nan or infinity", "finite", _UNITS[name])
    require(bool(np.all(np.diff(found) > 0)), f"over.{name}", "values that do not rise", "rising")
    for value in found[[0, -1]]:
        _changed(display, name, value)
    return found
