"""A design that a search found: parts, values chosen from ranges, and what it demands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from infinivar._core.result import Frozen, result
from infinivar.drivetrain.drive import Drive
from infinivar.limits import Demand
from infinivar.sizing.geared.sampled import TaskDemand
from infinivar.sizing.pool import ChosenPart
from infinivar.units import plain, show, show_in


@result
class FreeValue(Frozen):
    """A value that the search chose from a range.

    Attributes
    ----------
    value          Chosen.
    low, high      Between these all limits are kept, with all else as chosen; nan if the design keeps them nowhere.
    unit           In SI.
    """

    value: float
    low: float
    high: float
    unit: str

    @property
    def words(self) -> str:
        """Value and range."""
        if math.isnan(self.low):
            return _shown(self.value, self.unit)
        return f"{_shown(self.value, self.unit)} (feasible from {_shown(self.low, self.unit)} to {_shown(self.high, self.unit)})"


@result
class SizedDrive(Frozen):
    """A candidate as a drive.

    Attributes
    ----------
    template       Drive of the study whose other parts it has.
    parts          Parts chosen, by role: "motor", "gearhead".
    free           Values chosen from a range, by their path in the drive, such as "pulley.radius".
    drive          Ready for `duty_cycle`, `steady_map` and `simulate`.
    mass           Of the parts chosen; nan if one does not state it. [kg]
    power          Mean power from the supply over all motions; nan without a motion. [W]
    demands        Demand over allowance, by motion or "requirement", limit and part. [-]
    unchecked      Limits that the data sheets do not state.
    """

    template: str
    parts: Mapping[str, ChosenPart]
    free: Mapping[str, FreeValue]
    drive: Drive
    mass: float
    power: float
    demands: Mapping[TaskDemand, float]
    unchecked: tuple[Demand, ...]

    @property
    def title(self) -> str:
        """The parts by name."""
        return ", ".join(part.name for part in self.parts.values())

    @property
    def tightest(self) -> TaskDemand | None:
        """Motion, limit and part with the largest demand; None if no limit is loaded."""
        return max(self.demands, key=lambda key: self.demands[key], default=None)

    @property
    def margin(self) -> float:
        """Allowance over demand of the tightest limit. [-]"""
        worst = max(self.demands.values(), default=0.0)
        return 1.0 / worst if worst > 0.0 else math.inf

    @property
    def exceeded(self) -> dict[TaskDemand, float]:
        """Demand over allowance of the limits exceeded, the worst first."""
        beyond = {key: demand for key, demand in self.demands.items() if not demand <= 1.0}
        return dict(sorted(beyond.items(), key=lambda item: -item[1]))

    @property
    def verdict(self) -> str:
        """One line: what it needs, weighs and keeps."""
        said = [self.title, *(f"{path_words(path)} {value.words}" for path, value in self.free.items())]
        said += [show(self.power, "W", 3)] if math.isfinite(self.power) else []
        said.append("mass not stated" if math.isnan(self.mass) else show(self.mass, "kg", 3))
        if self.tightest is not None:
            said.append(f"margin {plain(self.margin, 3)} ({limit_words(self.tightest)})")
        return "; ".join(said)

    def to_dict(self) -> dict[str, Any]:
        """The same as plain numbers and texts."""
        return {
            "template": self.template,
            "title": self.title,
            "parts": {
                role: {
                    "part": part.part,
                    **{
                        name: getattr(part, name) for name in ("name", "manufacturer", "order_number", "source", "date")
                    },
                }
                for role, part in self.parts.items()
            },
            "free": {
                path: {"value": value.value, "low": value.low, "high": value.high, "unit": value.unit}
                for path, value in self.free.items()
            },
            "mass_kg": self.mass,
            "power_W": self.power,
            "margin": self.margin,
            "tightest": None if self.tightest is None else limit_words(self.tightest),
            "demands": [
                {"task": task, "limit": limit.name, "part": part, "demand_over_allowance": demand}
                for (task, limit, part), demand in self.demands.items()
            ],
            "unchecked": [limit.name for limit, _ in self.unchecked],
        }


def limit_words(key: TaskDemand) -> str:
    """Limit and part of a motion or the requirement, such as "motor continuous torque, walking"."""
    task, limit, _ = key
    return f"{limit.words}, {task}"


def exceeded_words(design: SizedDrive) -> str:
    """Limits that a design exceeds, and by how much."""
    said = [f"{limit_words(key)}: {_times(demand)}" for key, demand in design.exceeded.items()]
    return "; ".join(said[:3]) + (f"; {len(said) - 3} more" if len(said) > 3 else "")


def _times(demand: float) -> str:
    return f"{plain(demand, 3)} times the allowance" if math.isfinite(demand) else "out of reach"


def _shown(value: float, unit: str) -> str:
    return show_in(value, "m", "mm") if unit == "m" else show(value, unit)


def path_words(path: str) -> str:
    """Path of a value in a drive, in words."""
    return path.replace(".", " ").replace("_", " ")
