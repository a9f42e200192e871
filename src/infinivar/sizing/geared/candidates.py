"""Pairs of motor and gearhead from tables of parts, checked, and as drives: one by one, or many in arrays."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from infinivar._core.bounds import within, words
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.parts.gearhead import Gearhead, LossModel
from infinivar.parts.heat import COPPER, NEEDED, REFERENCE
from infinivar.parts.motor import Motor
from infinivar.parts.stage import OutputStage

LAW = {
    "motor": ("voltage", "resistance", "torque_constant", "no_load_current", "continuous_torque"),
    "gearhead": ("ratio", "efficiency"),
}
"""Fields without which a law cannot be evaluated."""

_OPTIONAL = {
    "motor": ("viscous_friction", "peak_torque", "rotor_inertia", "max_speed", *NEEDED),
    "gearhead": (
        "backdriving_efficiency",
        "rated_torque",
        "continuous_torque",
        "intermittent_torque",
        "max_input_speed",
        "inertia",
    ),
}
_KINDS: Mapping[str, type] = {"motor": Motor, "gearhead": Gearhead}
_BY_MODEL = {"coulomb": ("rated_torque",), "proportional": ("backdriving_efficiency",)}
"""Optional fields of gearheads that only one loss model has."""

LIMIT_FIELDS: Mapping[Demand, tuple[str, tuple[str, ...]]] = {
    (Limit.PEAK, "motor"): ("motor", ("peak_torque",)),
    (Limit.SPEED, "motor"): ("motor", ("max_speed",)),
    (Limit.GEAR, "gearhead"): ("gearhead", ("continuous_torque",)),
    (Limit.GEAR_PEAK, "gearhead"): ("gearhead", ("intermittent_torque",)),
    (Limit.GEAR_SPEED, "gearhead"): ("gearhead", ("max_input_speed",)),
    (Limit.TEMPERATURE, "motor"): ("motor", NEEDED),
}
"""Limits that are checked only where a data sheet states these fields."""

_BEYOND_ALL = 1e140
"""Stands for a limit that is not stated: no demand comes near it, and its square is still a number."""
_NOTHING = 1e-300
"""Stands for an inertia that is not stated, as it must be above 0."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pairs:
    """Pairs of motor and gearhead, and for which of them the laws can be evaluated.

    Attributes
    ----------
    motors, gearheads : name to (n,) float   Fields of `Motor` and `Gearhead` in SI, nan where not stated.
    pairs : (m, 2) int             Row of the motor and of the gearhead.
    names : mapping                Names of "motor" and "gearhead" by row; empty if the tables have none.
    loss_model : str               Of all gearheads: coulomb or proportional.
    usable : (k,) int              Pairs whose laws can be evaluated.
    excluded : reason to int       Number of pairs left out, each counted once under its first reason.
    """

    motors: Mapping[str, np.ndarray]
    gearheads: Mapping[str, np.ndarray]
    pairs: np.ndarray
    names: Mapping[str, np.ndarray]
    loss_model: LossModel
    usable: np.ndarray
    excluded: Mapping[str, int]

    def values(self, kind: str, name: str, rows: np.ndarray) -> np.ndarray:
        """A field of "motor" or "gearhead" for some pairs; nan where it is not stated. (k,)"""
        table, column = (self.motors, 0) if kind == "motor" else (self.gearheads, 1)
        if name not in table:
            return np.full(len(rows), np.nan)
        return table[name][self.pairs[rows, column]]

    def stated(self, demand: Demand, rows: np.ndarray) -> np.ndarray:
        """Whether data sheets state what a limit needs. (k,) bool"""
        if demand not in LIMIT_FIELDS:
            return np.ones(len(rows), dtype=bool)
        kind, fields = LIMIT_FIELDS[demand]
        return np.all([~np.isnan(self.values(kind, name, rows)) for name in fields], axis=0)

    def mass(self, rows: np.ndarray) -> np.ndarray:
        """Mass of motor and gearhead; nan where one is not stated. (k,) [kg]"""
        return self.values("motor", "mass", rows) + self.values("gearhead", "mass", rows)

    def parts(self, rows: np.ndarray) -> tuple[Motor, Gearhead]:
        """Many motors and gearheads as one, whose values are arrays of shape (k, 1).

        A limit that is not stated is out of reach; heat has data only if all rows have it.
        """
        motor: dict[str, Any] = {name: self._column("motor", name, rows) for name in LAW["motor"]}
        gear: dict[str, Any] = {name: self._column("gearhead", name, rows) for name in LAW["gearhead"]}
        for name in ("peak_torque", "max_speed"):
            motor[name] = self._column("motor", name, rows, _BEYOND_ALL)
        for name in ("continuous_torque", "intermittent_torque", "max_input_speed"):
            gear[name] = self._column("gearhead", name, rows, _BEYOND_ALL)
        motor["rotor_inertia"] = self._column("motor", "rotor_inertia", rows, _NOTHING)
        gear["inertia"] = self._column("gearhead", "inertia", rows, _NOTHING)
        viscous = self._column("motor", "viscous_friction", rows, 0.0)
        if viscous.any():
            motor["viscous_friction"] = viscous
        if self.stated((Limit.TEMPERATURE, "motor"), rows).all():
            motor |= {name: self._column("motor", name, rows) for name in NEEDED}
        if self.loss_model == "coulomb":
            gear["rated_torque"] = self._column("gearhead", "rated_torque", rows, motor["continuous_torque"])
        else:
            gear["backdriving_efficiency"] = self._column(
                "gearhead", "backdriving_efficiency", rows, gear["efficiency"]
            )
        return Motor(**motor), Gearhead(**gear, loss_model=self.loss_model)

    def part(self, row: int) -> tuple[Motor, Gearhead]:
        """One motor and gearhead as a study would have them: what is not stated is None."""
        parts: dict[str, dict[str, Any]] = {}
        for kind, column in (("motor", 0), ("gearhead", 1)):
            fields = (*LAW[kind], *_OPTIONAL[kind], "mass", *(("inductance", "diameter") if kind == "motor" else ()))
            found = {name: float(self.values(kind, name, np.array([row]))[0]) for name in fields}
            parts[kind] = {name: value for name, value in found.items() if not math.isnan(value)}
            if kind in self.names:
                parts[kind]["name"] = str(self.names[kind][self.pairs[row, column]])
        for name in {name for model, names in _BY_MODEL.items() if model != self.loss_model for name in names}:
            parts["gearhead"].pop(name, None)
        return Motor(**parts["motor"]), Gearhead(**parts["gearhead"], loss_model=self.loss_model)

    def resistances(self, rows: np.ndarray, coldest: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Which windings' temperatures are known, and the least and largest resistance that each can have.

        Parameters
        ----------
        coldest : float   Lowest temperature of surroundings and start; nan where windings count as at 25 °C. [K]
        """
        cold = self.values("motor", "resistance", rows)
        heated = self.stated((Limit.TEMPERATURE, "motor"), rows) & (coldest == coldest)
        limit = self.values("motor", "max_winding_temperature", rows)
        # Above its limit a winding counts as at it.
        least = np.fmin(coldest, limit)
        low, high = (np.where(heated, cold * (1.0 + COPPER * (one - REFERENCE)), cold) for one in (least, limit))
        return heated, low, high

    def _column(self, kind: str, name: str, rows: np.ndarray, otherwise: Any = None) -> np.ndarray:
        """A field as a column; what is not stated is replaced."""
        found = self.values(kind, name, rows)[:, None]
        return found if otherwise is None else np.where(np.isnan(found), otherwise, found)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidates(Pairs):
    """Pairs as drives with an output stage; `template` has everything but motor and gearhead."""

    template: ConventionalDrive

    def drives(self, rows: np.ndarray, stage: OutputStage) -> ConventionalDrive:
        """Many drives as one, whose values are arrays of shape (k, 1); see `parts`."""
        return self._drive(*self.parts(rows), stage)

    def drive(self, row: int, stage: OutputStage) -> ConventionalDrive:
        """One drive as a study would have it: what is not stated is None."""
        return self._drive(*self.part(row), stage)

    def _drive(self, motor: Motor, gearhead: Gearhead, stage: OutputStage) -> ConventionalDrive:
        return with_stage(replace(self.template, motor=motor, gearhead=gearhead), stage)


def with_stage(drive: ConventionalDrive, stage: OutputStage) -> ConventionalDrive:
    """The drive with another output stage."""
    return replace(drive, **{drive.stage.title: None, stage.title: stage})  # type: ignore[arg-type]


def candidates(
    template: ConventionalDrive,
    motors: Mapping[str, Any],
    gearheads: Mapping[str, Any],
    pairs: Any,
    *,
    loss_model: LossModel,
    moving: bool,
    weighed: bool,
) -> Candidates:
    """Check tables of parts, for drives like a template; other arguments as for `pairs_of`."""
    found = pairs_of(motors, gearheads, pairs, loss_model=loss_model, moving=moving, weighed=weighed)
    return Candidates(template=template, **{one.name: getattr(found, one.name) for one in dataclasses.fields(found)})


def pairs_of(
    motors: Mapping[str, Any],
    gearheads: Mapping[str, Any],
    pairs: Any,
    *,
    loss_model: LossModel,
    moving: bool,
    weighed: bool,
) -> Pairs:
    """Check tables of parts.

    Parameters
    ----------
    motors, gearheads : mapping    Columns by the names of the fields of `Motor` and `Gearhead`, in SI, nan where not stated; a
        column "name" holds texts. Other columns do not matter.
    pairs : (m, 2) int             Row of the motor and of the gearhead.
    loss_model : str               coulomb or proportional, of all gearheads.
    moving, weighed : bool         Whether the rotor inertia and whether the masses are needed.

    Raises
    ------
    ParameterError
        If a column is no vector of numbers, columns differ in length, or a pair names a row that does not exist.
    """
    if loss_model not in _BY_MODEL:
        raise ParameterError(
            f"loss_model must be coulomb or proportional, got {loss_model!r}: friction measured on a gear with its motor cannot "
            "be transferred to other motors"
        )
    tables = {"motor": _table("motors", motors, "motor"), "gearhead": _table("gearheads", gearheads, "gearhead")}
    pairs = np.asarray(pairs)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype.kind not in "iu":
        raise ParameterError(f"pairs must be whole numbers of shape (m, 2), got {pairs.dtype} of shape {pairs.shape}")
    for column, kind in enumerate(("motor", "gearhead")):
        count = len(next(iter(tables[kind].values())))
        wrong = (pairs[:, column] < 0) | (pairs[:, column] >= count)
        if wrong.any():
            place = int(np.argmax(wrong))
            raise ParameterError(
                f"pairs[{place}, {column}] must be a row of the {kind}s, 0 to {count - 1}, got {pairs[place, column]}"
            )
    made = Pairs(
        motors=tables["motor"],
        gearheads=tables["gearhead"],
        pairs=pairs,
        names={
            kind: np.asarray(table["name"])
            for kind, table in (("motor", motors), ("gearhead", gearheads))
            if "name" in table
        },
        loss_model=loss_model,
        usable=np.arange(len(pairs)),
        excluded={},
    )
    usable, excluded = np.ones(len(pairs), dtype=bool), {}
    for reason, bad in _faults(made, moving, weighed):
        if (usable & bad).any():
            excluded[reason] = int(np.sum(usable & bad))
        usable = usable & ~bad
    return replace(made, usable=np.flatnonzero(usable), excluded=excluded)


def _table(name: str, columns: Mapping[str, Any], kind: str) -> dict[str, np.ndarray]:
    """Columns of a table that are fields of a part."""
    required = (*LAW[kind], *_OPTIONAL[kind], "mass", "inductance", "diameter")
    found = {}
    for column in required:
        if column not in columns:
            continue
        try:
            values = np.asarray(columns[column], dtype=float)
        except (TypeError, ValueError):
            raise ParameterError(f"{name}.{column} must be numbers in SI, nan where not stated") from None
        # An infinite limit is no limit, as data sheets of tables have it.
        found[column] = np.where(np.isinf(values), np.nan, values) if column in _MAY_BE_INFINITE else values
    for column in LAW[kind]:
        if column not in found:
            raise ParameterError(f"{name}.{column} is missing: no law of a {kind} can be evaluated without it")
    lengths = {column: values.shape for column, values in found.items()}
    first = next(iter(lengths.values()))
    for column, shape in lengths.items():
        if len(shape) != 1 or shape != first or not shape[0]:
            raise ParameterError(f"{name}.{column} must be a vector as long as the other columns, got shape {shape}")
    return found


_MAY_BE_INFINITE = frozenset(
    {"peak_torque", "max_speed", "continuous_torque", "intermittent_torque", "max_input_speed"}
)


def _faults(made: Pairs, moving: bool, weighed: bool) -> list[tuple[str, np.ndarray]]:
    """Reasons to leave a pair out, and the pairs that have each of them."""
    rows, found = np.arange(len(made.pairs)), []
    needs = [("motor", name) for name in LAW["motor"]] + [("motor", "rotor_inertia")] * moving
    needs += [("gearhead", name) for name in LAW["gearhead"]]
    needs += [("motor", "mass"), ("gearhead", "mass")] * weighed
    found += [(f"{kind} {name} not stated", np.isnan(made.values(kind, name, rows))) for kind, name in needs]
    for kind, part in _KINDS.items():
        for field in dataclasses.fields(part):
            if field.name not in (*LAW[kind], *_OPTIONAL[kind], "mass"):
                continue
            values, bound = made.values(kind, field.name, rows), field.metadata["bound"]
            wrong = ~np.isnan(values) & ~(np.isfinite(values) & within(bound, values))
            found.append((f"{kind} {field.name} not {words(bound)}", wrong))
    volts, ohms, constant, idle, drag = (
        made.values("motor", name, rows)
        for name in ("voltage", "resistance", "torque_constant", "no_load_current", "viscous_friction")
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        found.append(("motor no_load_current not below its stall current", idle >= volts / ohms))
        most = constant * idle / ((volts - ohms * idle) / constant)
        found.append(("motor viscous_friction above its no-load torque", drag > most * (1.0 + 1e-12)))
    return found
