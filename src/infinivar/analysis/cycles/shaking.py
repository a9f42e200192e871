"""Dynamic performance: shaking a mass, over frequency and fraction of the maximum power."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from annotated_types import Gt

from infinivar._core.described import reported
from infinivar._core.fields import check_value
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.analysis.cycles import performance
from infinivar.analysis.cycles.performance import PAPER, AnyDrive, Cylinder, Definition
from infinivar.errors import InputError
from infinivar.limits import Demand, Limit, binding_demand
from infinivar.motion.course import Course

SAMPLES = 200
"""Instants per cycle; doubling them changes performance by less than 0.1 %."""

_TILE = 32_768
"""Instants computed at once, so that intermediate arrays fit the processor's caches."""

_GRID = ("frequency", "fraction")


def _codes(found: DynamicMap) -> dict[str, str]:
    names = ", ".join(f"{place} {limit.name} ({what})" for place, (limit, what) in enumerate(found.demands, 1))
    return {"long_name": f"limit exceeded: 0 none, {names}"}


@result
class DynamicMap(Result):
    """Performance over frequency (first axis) and fraction of the maximum power (second axis); SI.

    Attributes
    ----------
    frequency, fraction : (n,), (m,) float    Axes; fraction of the maximum RMS power `power`. [Hz], [-]
    amplitude : (n, m) float                  Displacement amplitude. [m]
    performance : (n, m) float                Performance by `definition`; nan outside limits. [-]
    unlimited : (n, m) float                  Performance regardless of limits; nan where the wheel slips. [-]
    binding : (n, m) int8                     0 within limits, else the position of the limit in `demands`, from 1.
    margin : (n, m) float                     Allowance over demand of the tightest limit. [-]
    demands : (Limit, what) to (n, m) float   Demand over allowance of each limit over the cycle. [-]
    power_in, exchanged : (n, m) float        Mean power from the supply, and mean magnitude between drive and load. [W]
    losses : name to (n, m) float             Mean losses. [W]
    closure : float                           Largest relative residual of a cycle's energy balance. [-]
    """

    frequency: np.ndarray = reported("Hz", dims=("frequency",))
    fraction: np.ndarray = reported("1", "RMS power over the maximum power", ("fraction",))
    amplitude: np.ndarray = reported("m", dims=_GRID)
    performance: np.ndarray = reported("1", dims=_GRID, notes=lambda found: {"long_name": found.definition.words})
    unlimited: np.ndarray
    binding: np.ndarray = reported("1", dims=_GRID, notes=_codes)
    margin: np.ndarray = reported("1", dims=_GRID)
    demands: Mapping[Demand, np.ndarray]
    power_in: np.ndarray = reported("W", dims=_GRID)
    exchanged: np.ndarray = reported("W", dims=_GRID)
    losses: Mapping[str, np.ndarray] = reported("W", dims=_GRID, variable="loss_{}")
    definition: Definition
    power: float = reported("W", attribute="power")
    load_mass: float = reported("kg", attribute="load_mass")
    closure: float

    @property
    def works(self) -> np.ndarray:
        """Mask of the cells within every limit."""
        return self.binding == 0

    def limit_at(self, row: int, column: int) -> Demand | None:
        """The binding limit of a cell, if any."""
        place = int(self.binding[row, column])
        return list(self.demands)[place - 1] if place else None


def amplitude(rms_power: Any, mass: Any, frequency: Any) -> Any:
    r"""Displacement amplitude at which shaking a mass exchanges a given RMS power.

    .. math:: \alpha = \sqrt{\frac{2\sqrt2\,W}{m\,\omega^3}}

    Parameters
    ----------
    rms_power : (...,) float   W, root mean square over time of the power ``m lddot ldot``. [W]
    mass : (...,) float        m, > 0. [kg]
    frequency : (...,) float   > 0. [Hz]

    Returns
    -------
    (...,) float   Amplitude of ``alpha sin(w t)``. [m]

    Source: faulring2006, section VI-C and footnote 8, which calls it an amplitude of speed: see the errata.
    """
    turn = 2.0 * np.pi * np.asarray(frequency, dtype=float)
    return np.sqrt(2.0 * np.sqrt(2.0) * rms_power / (mass * turn**3))


def shaking(distance: Any, frequency: Any, samples: int) -> Course:
    """One cycle of ``distance sin(2 pi frequency t)`` at the midpoints of equal steps, on a new last axis.

    With a multiple of 4 samples, no midpoint lies on a reversal, where friction has no direction.
    """
    turn = 2.0 * np.pi * np.asarray(frequency, dtype=float)[..., None]
    size = np.asarray(distance, dtype=float)[..., None]
    phase = 2.0 * np.pi * (np.arange(samples) + 0.5) / samples
    sine, cosine = np.sin(phase), np.cos(phase)
    speed = size * turn
    jolt = speed * turn * turn
    return Course(
        position=size * sine,
        speed=speed * cosine,
        acceleration=-speed * turn * sine,
        jerk=-jolt * cosine,
        snap=jolt * turn * sine,
        fifth=jolt * turn * turn * cosine,
        sixth=-jolt * turn**3 * sine,
        force_third=0.0,
        force_fourth=0.0,
    )


def dynamic_map(
    drive: AnyDrive,
    frequency: Any,
    fraction: Any,
    *,
    power: float,
    load_mass: float,
    travel: float | None = None,
    definition: Definition = PAPER,
    cylinder: Cylinder = "constant",
    samples: int = SAMPLES,
    progress: Callable[[float], None] | None = None,
) -> DynamicMap:
    """Compute the performance of shaking a mass at every frequency and power, by inverse dynamics.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive   Must have the inertias that motion requires.
    frequency : (n,) float   > 0. [Hz]
    fraction : (m,) float    RMS power over `power`, > 0. [-]
    power : float            Maximum power. [W]
    load_mass : float        The mass shaken, > 0. [kg]
    travel : float           End-to-end travel of the load; unlimited by default. [m]
    definition : Definition  Definition of performance; the paper's by default.
    cylinder                 Cylinder of a cobotic drive: "constant" speed, as in the paper, or a free-running "flywheel".
    samples : int            Instants per cycle, a multiple of 4.
    progress                 Called with the share done, 0 to 1.

    Returns
    -------
    DynamicMap

    Raises
    ------
    InputError
        If an axis is not a vector of positive numbers, or samples is not a multiple of 4.
    ParameterError
        If the drive lacks a value that motion requires, or power or mass is not positive.
    AuditError
        If the energy balance of a cycle does not close.

    Source: faulring2006, section VI-C and Fig 17.
    """
    frequency, fraction = _axis("frequency", frequency), _axis("fraction", fraction)
    check_value("power", power, "W", Gt(0))
    check_value("load_mass", load_mass, "kg", Gt(0))
    if samples < 4 or samples % 4:
        raise InputError(f"samples must be a multiple of 4, got {samples}")
    distance = amplitude(power * fraction[None, :], load_mass, frequency[:, None])
    rows = max(1, _TILE // (fraction.size * samples))
    parts = []
    for top in range(0, frequency.size, rows):
        here = slice(top, top + rows)
        course = shaking(distance[here], frequency[here, None], samples)
        point = performance.follow(
            drive, course, load_mass, definition, cylinder=cylinder, period=1.0 / frequency[here, None]
        )
        shape = np.shape(point.power_out)
        demands = performance.demands(point, definition.torque)
        if travel is not None:
            demands[Limit.TRAVEL, "load"] = 2.0 * distance[here] / travel
        parts.append(
            {
                "performance": performance.performance(point, definition.measure),
                "power_in": performance.mean(point.power_in, shape),
                "exchanged": performance.mean(np.abs(point.power_out), shape),
                "demands": demands,
                "losses": performance.means(point.losses, shape),
                "closure": performance.audit(point, "dynamic map"),
            }
        )
        if progress is not None:
            progress(min(1.0, (top + rows) / frequency.size))

    def whole(values: Callable[[dict[str, Any]], Any]) -> np.ndarray:
        return np.concatenate([values(part) for part in parts])

    demands = {key: whole(lambda part, key=key: part["demands"][key]) for key in parts[0]["demands"]}
    binding, margin = binding_demand(demands)
    unlimited = whole(lambda part: part["performance"])
    return DynamicMap(
        frequency=frequency,
        fraction=fraction,
        amplitude=distance,
        performance=np.where(binding == 0, unlimited, np.nan),
        unlimited=unlimited,
        binding=binding,
        margin=margin,
        demands=FrozenDict(demands),
        power_in=whole(lambda part: part["power_in"]),
        exchanged=whole(lambda part: part["exchanged"]),
        losses=FrozenDict({name: whole(lambda part, name=name: part["losses"][name]) for name in parts[0]["losses"]}),
        definition=definition,
        power=power,
        load_mass=load_mass,
        closure=max(part["closure"] for part in parts),
    )


def _axis(name: str, values: Any) -> np.ndarray:
    axis = np.atleast_1d(np.asarray(values, dtype=float))
    if axis.ndim != 1 or axis.size == 0 or not np.all(np.isfinite(axis) & (axis > 0)):
        raise InputError(f"{name} must be a vector of numbers > 0")
    return axis
