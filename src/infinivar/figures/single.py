"""Figures of single results: `Result.plot` draws them for results without a figure in a report."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.compare import DriveResult
from infinivar.analysis.cycles.cylinder_policy import Policy
from infinivar.analysis.cycles.duty_comparison import DutyComparison
from infinivar.analysis.cycles.duty_result import DutyResult
from infinivar.analysis.cycles.shaking import DynamicMap
from infinivar.analysis.cycles.tracking import TwoWays
from infinivar.analysis.design_trends import Trend
from infinivar.analysis.robustness.verdicts import Builds, BuildsMap, DutyBuilds
from infinivar.analysis.steady_map import SteadyMap
from infinivar.bondgraph.audit import Trajectory
from infinivar.drivetrain.drive import DrivePoint, MovingPoint
from infinivar.errors import InputError
from infinivar.figures import duty_cycle, energy_flow, losses, operating_map, style
from infinivar.limits import Limit
from infinivar.parts.heat import Heat
from infinivar.transmission.operating_point import OperatingPoint

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BINS = 40


def steady_map(found: SteadyMap, title: str = "") -> Figure:
    """Efficiency over speed and force, with the limits."""
    if min(found.speed.size, found.force.size) < 2:
        raise InputError("a map of one row or column has no contours: plot its to_xarray() instead")
    with style.styled():
        made, ax = style.figure(5.6, 4.0)
        drawn = operating_map.draw(ax, operating_map.data(found, None), title)
        operating_map.colour_bar(made, drawn, ax)
    return made


def drive_result(found: DriveResult) -> Figure:
    """The map of the drive."""
    return steady_map(found.map, found.title)


def point(found: DrivePoint | OperatingPoint) -> Figure:
    """Losses: bars of a single point, areas along one axis.

    Raises
    ------
    InputError
        If the point has more than one axis.
    """
    limit, power_in = np.broadcast_arrays(found.limit, found.power_in)
    with style.styled():
        if power_in.ndim == 0:
            made, ax = style.figure(6.4, 1.8)
            numbers = {
                "title": "losses at this point",
                "unit": "W",
                "losses": {"": {name: float(loss) for name, loss in found.losses.items()}},
                "power_in": {"": float(power_in)},
                "limit": {"": Limit(int(limit))},
            }
            losses.draw(ax, numbers)
            made.legend(*losses.legend([ax]), loc="outside lower center", ncols=5)
            return made
        if power_in.ndim > 1:
            raise InputError(
                f"points over {power_in.ndim} axes have no figure: use steady_map, or plot the to_xarray() result"
            )
        made, ax = style.figure(6.4, 3.6)
        along, name = _along(found, power_in.size)
        _stacked(ax, along, found.losses, name)
    return made


def _along(found: DrivePoint | OperatingPoint, count: int) -> tuple[np.ndarray, str]:
    """Positions along a single axis: its first labelled coordinate, or point numbers."""
    if found.labels is not None:
        for name, (dims, values, attrs) in found.labels.coords.items():
            if tuple(dims) == found.labels.dims and np.asarray(values).dtype.kind in "fiu":
                return np.asarray(values), f"{name} [{attrs.get('units', '-')}]"
    return np.arange(count), "point [-]"


def _stacked(ax: Axes, along: np.ndarray, parts: Mapping[str, Any], label: str) -> None:
    """Stacked losses over one axis."""
    values = {name: np.nan_to_num(np.broadcast_to(loss, along.shape)) for name, loss in parts.items()}
    shown = {name: loss for name, loss in values.items() if np.any(loss > 0)}
    colours = [style.loss_colour(name) for name in shown]
    if shown:
        ax.stackplot(along, *shown.values(), labels=list(shown), colors=colours)
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    ax.set_xlabel(label)
    ax.set_ylabel("loss [W]")
    ax.margins(x=0.0)


def moving_point(found: MovingPoint) -> Figure:
    """Powers and losses over the instants of a motion.

    Raises
    ------
    InputError
        If there is more than one motion.
    """
    out = np.atleast_1d(np.asarray(found.power_out))
    if out.ndim > 1:
        raise InputError(f"instants over {out.ndim} axes have no figure: plot the to_xarray() result")
    instant = np.arange(out.size)
    with style.styled():
        made, axes = style.figure(7.2, 4.6, 2, 1, sharex=True)
        for name, power in (("from the supply", found.power_in), ("to the load", out)):
            axes[0].plot(instant, np.broadcast_to(power, out.shape), label=name)
        axes[0].set_xlabel("instant [-]")
        axes[0].set_ylabel("power [W]")
        axes[0].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        _stacked(axes[1], instant, found.losses, "instant [-]")
    return made


def dynamic_map(found: DynamicMap) -> Figure:
    """Performance over frequency and share of the maximum power, with the limit of the drive."""
    if min(found.performance.shape) < 2:
        raise InputError("a map of one row or column has no contours: plot its to_xarray() instead")
    with style.styled():
        made, ax = style.figure(6.0, 4.0)
        percent = 100.0 * found.fraction
        filled = ax.contourf(found.frequency, percent, found.performance.T, cmap="viridis")
        margin = np.clip(found.margin, 0.0, 2.0).T
        if margin.min() < 1.0 < margin.max():
            ax.contour(found.frequency, percent, margin, levels=[1.0], colors="black", linewidths=1.4)
        ax.set_xscale("log")
        ax.set_xlabel("frequency [Hz]")
        ax.set_ylabel("RMS power of the load [% of maximum]")
        made.colorbar(filled, ax=ax, label="performance [-]")
    return made


def duty(found: DutyResult) -> Figure:
    """One cycle of the drive, its heat and its losses."""
    named = DutyComparison(duty=found.duty, results={found.name or "drive": found}, policies={}, two_ways={})
    return duty_cycle.draw_all(named)


def two_ways(found: TwoWays) -> Figure:
    """Losses of a cycle prescribed and simulated."""
    ways = {"prescribed": (found.prescribed, found.lost_prescribed), "simulated": (found.followed, found.lost_followed)}
    with style.styled():
        made, ax = style.figure(7.2, 2.4)
        numbers = {
            "title": "energy lost per cycle",
            "unit": "J",
            "losses": {name: dict(lost) for name, (_, lost) in ways.items()},
            "power_in": {name: energy for name, (energy, _) in ways.items()},
            "limit": dict.fromkeys(ways, Limit.OK),
        }
        losses.draw(ax, numbers)
        made.legend(*losses.legend([ax]), loc="outside lower center", ncols=5)
    return made


def policy(found: Policy) -> Figure:
    """Speed of the cylinder over the cycle."""
    speed = found.slowest if found.cylinder_speed is None else found.cylinder_speed.value
    values = np.broadcast_to(speed, (2,)) if np.ndim(speed) == 0 else np.asarray(speed)
    with style.styled():
        made, ax = style.figure(5.6, 3.0)
        ax.plot((np.arange(values.size) + 0.5) / values.size, values)
        ax.set_xlabel("share of the cycle [-]")
        ax.set_ylabel("cylinder speed [rad/s]")
        ax.set_title(found.name)
    return made


def heat(found: Heat) -> Figure:
    """Temperatures over time, from a cold start."""
    with style.styled():
        made, ax = style.figure(5.6, 3.2)
        for name, history in (("winding", found.winding_history), ("housing", found.housing_history)):
            ax.plot(found.time / 60.0, history - 273.15, label=name)
        ax.axhline(found.permissible - 273.15, color="#777777", lw=0.9, ls="dotted", label="permissible, winding")
        ax.set_xlabel("time from a cold start [min]")
        ax.set_ylabel("temperature [°C]")
        ax.legend()
    return made


def trend(found: Trend) -> Figure:
    """Efficiency over the design parameter, with the limits exceeded; bars for materials."""
    with style.styled():
        made, ax = style.figure(5.6, 3.4)
        parameter = found.parameter.replace("_", " ")
        if found.values.dtype.kind in "fiu":
            ax.plot(found.values, found.efficiency)
            style.name_limits(ax, found.values, found.limit, "bottom")
            ax.set_xlabel(f"{parameter} [SI]")
            ax.set_ylabel("efficiency of the element [-]")
        else:
            ax.barh([str(value) for value in found.values], np.nan_to_num(found.efficiency))
            ax.set_xlabel("efficiency of the element [-]")
            ax.set_ylabel(f"{parameter} [-]")
    return made


def trajectory(found: Trajectory) -> Figure:
    """Cumulative energy by source, loss and storage."""
    kinds = {"supplied": found.supplied, "lost": found.lost, "stored": found.stored}
    with style.styled():
        made, axes = style.figure(7.2, 6.4, len(kinds), 1, sharex=True)
        for ax, (kind, group) in zip(axes, kinds.items(), strict=True):
            for place, (name, energy) in enumerate(group.items()):
                ax.plot(found.time, energy, color=energy_flow.line_colour(name, place), label=name)
            ax.set_xlabel("time [s]")
            ax.set_ylabel(f"{kind} [J]")
            ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
            ax.label_outer()
    return made


def builds(found: Builds) -> Figure:
    """Distributions of the tightest margin and the coverage over the samples."""
    with style.styled():
        made, axes = style.figure(8.0, 3.0, 1, 2, sharey=True)
        _histogram(axes[0], found.margin, "tightest margin in the required region [-]")
        axes[0].axvline(1.0, color="black", lw=1.0)
        _histogram(axes[1], found.coverage, "share of the required region covered [-]")
    return made


def duty_builds(found: DutyBuilds) -> Figure:
    """Distribution of the energy per cycle over the samples."""
    with style.styled():
        made, ax = style.figure(5.0, 3.0)
        _histogram(ax, found.energy, f"energy from the supply {found.per} [J]")
    return made


def _histogram(ax: Axes, values: np.ndarray, label: str) -> None:
    known = values[np.isfinite(values)]
    ax.hist(known, bins=_BINS)
    ax.set_xlabel(label)
    ax.set_ylabel("number of samples [-]")


def builds_map(found: BuildsMap) -> Figure:
    """Share of samples within all limits over force and speed."""
    with style.styled():
        made, ax = style.figure(5.6, 4.0)
        filled = ax.contourf(found.force, found.speed, found.within, levels=np.linspace(0.0, 1.0, 11), cmap="viridis")
        style.label_plane(ax, found.axis)
        made.colorbar(filled, ax=ax, label="share of samples within all limits [-]")
    return made
