"""Default spreads of values for which a study states none: model errors that measurements support, and assumed tolerances."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from infinivar._core import files
from infinivar._core.bounds import permitted
from infinivar._core.fields import quantities_of, value_at
from infinivar._core.frozen import FrozenDict
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import Drive
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.parts.screw import Screw
from infinivar.study.spreads import NORMAL_95, Spread, accepted
from infinivar.study.study import Study
from infinivar.units import plain

TORQUE_CONSTANT, FRICTION = 0.05, 0.15
"""Tolerances to either side, relative to the value, that are assumed, as no measured set supports one: torque constant of motors,
and friction coefficient of the rolling contact. [-]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class DefaultSpread:
    """Spread of a kind of value where a study states none.

    Attributes
    ----------
    name        What varies, in words.
    size        Standard deviation if measured, else tolerance to either side: over the value, of an efficiency over the loss. [-]
    source      Reference of the measurements; empty if assumed.
    remainder   What the size is of, in words.
    """

    name: str
    size: float
    source: str = ""
    remainder: str = ""

    @property
    def where(self) -> str:
        """Source of the spread."""
        if not self.source:
            return f"assumed {self.name}, as the study states no spread"
        return f"{self.source}: {self.remainder}, as the study states no spread"

    @property
    def words(self) -> str:
        """The rule, which is the same for all parts."""
        if not self.source:
            return f"{self.name} ± {plain(100.0 * self.size)} %"
        return f"{self.name} ± {plain(100.0 * NORMAL_95 * self.size, 2)} % (95 %, {self.source})"


@functools.cache
def defaults() -> Mapping[str, DefaultSpread]:
    """Default spreads by field, of an efficiency by field and loss model."""
    raw = files.shipped("study", "model_errors")

    def measured(name: str, row: Mapping[str, float | str]) -> DefaultSpread:
        return DefaultSpread(
            name=name, size=float(row["deviation"]), source=str(row["source"]), remainder=str(row["where"])
        )

    return FrozenDict(
        {
            "torque_constant": DefaultSpread(name="torque constant", size=TORQUE_CONSTANT),
            "resistance": measured("winding resistance", raw["resistance"]),
            **{
                f"no_load_current.{law}": measured(f"no-load current with {law} friction", row)
                for law, row in raw["no_load_current"].items()
            },
            "winding_to_housing": measured("thermal resistance winding to housing", raw["winding_to_housing"]),
            "housing_time_constant": measured("thermal time constant", raw["housing_time_constant"]),
            **{f"efficiency.{law}": measured(f"{law} gear loss", row) for law, row in raw["efficiency"].items()},
            "thread": measured("friction of a sliding screw", raw["thread"]),
            "friction": DefaultSpread(name="friction coefficient of the contact", size=FRICTION),
        }
    )


def rule_of(spread: Spread) -> DefaultSpread | None:
    """The default that a spread follows; None if a study states it."""
    return next((one for one in defaults().values() if one.where == spread.where), None)


def default_spreads(owner: str, drive: Drive) -> Iterator[Spread]:
    """Yield default spreads of motors, gearheads, sliding screws and the rolling contact of a drive.

    Parameters
    ----------
    owner : str   Name of the drive, or of the template of a search.
    """
    for path, field in quantities_of(drive).items():
        at, _, name = path.rpartition(".")
        rule = defaults().get(_key(path, value_at(drive, at) if at else drive, name))
        if rule is None:
            continue
        value, ends = value_at(drive, path), permitted(field.metadata["bound"], value_at(drive, path))
        size = rule.size * (1.0 - value if name == "efficiency" else value)
        if size <= 0.0:
            continue  # a gear without loss has none to vary
        if rule.source:
            low, high = (accepted(drive, path, value, end, size) for end in ends)
        else:
            low, high = max(value - size, ends[0]), min(value + size, ends[1])
        yield Spread(
            owner=owner,
            path=path,
            unit=field.metadata["unit"],
            value=value,
            low=low,
            high=high,
            deviation=size if rule.source else None,
            kind="derived" if rule.source else "assumed",
            where=rule.where,
        )


def _key(path: str, part: object, name: str) -> str:
    """Default that a value of a part has, by field and model; "" for none."""
    if isinstance(part, Motor) and name == "no_load_current":
        return f"{name}.{'constant' if part.viscous_friction is None else 'viscous'}"
    if isinstance(part, Gearhead) and name == "efficiency":
        return f"{name}.{part.loss_model}"
    if isinstance(part, Screw) and part.shape == "lead" and name in ("friction_coefficient", "friction_angle"):
        return "thread"
    of_motor = isinstance(part, Motor) and name in (
        "torque_constant",
        "resistance",
        "winding_to_housing",
        "housing_time_constant",
    )
    return name if of_motor or path == "transmission.friction" else ""


def with_default_spreads(study: Study) -> Study:
    """The study with default spreads of the values for which it states none."""
    spreads = dict(study.uncertainty.spreads)
    for name, drive in study.drives.items():
        if isinstance(drive, CoboticDrive | ConventionalDrive):
            stated = spreads.get(name, ())
            known = {one.path for one in stated}
            spreads[name] = (*stated, *(one for one in default_spreads(name, drive) if one.path not in known))
    return replace(study, uncertainty=replace(study.uncertainty, spreads=FrozenDict(spreads)))
