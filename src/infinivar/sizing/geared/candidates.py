"""Pairs of motor and gearhead from tables of parts, checked, and as drives: one by one, or many in arrays."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from infinivar._core.bounds import within, words
from infinivar.drivetrain.body import own_mass
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.envelope import Envelope
from infinivar.drivetrain.layout import estimated_size
from infinivar.drivetrain.masses import shaft_demand
from infinivar.drivetrain.service import NO_SERVICE, Service
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.parts.gearhead import LAWS, PARTS_OF_LAWS, Gearhead, LossModel
from infinivar.parts.heat import COPPER, NEEDED, REFERENCE
from infinivar.parts.motor import Motor
from infinivar.parts.stage import OutputStage
from infinivar.parts.structure.structure import Structure
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.tables import Objective

LAW = {
    "motor": ("voltage", "resistance", "torque_constant", "no_load_current", "continuous_torque"),
    "gearhead": ("ratio",),
}
"""Fields without which no law can be evaluated; of gearheads, their own law has more."""

_KINDS: Mapping[str, type[Motor | Gearhead]] = {"motor": Motor, "gearhead": Gearhead}
_ALLOWANCES = {
    (limit, kind): name
    for kind, part in _KINDS.items()
    for limit, name in part.ALLOWANCES.items()
    if name not in LAW[kind]
}
"""Fields of limits that a data sheet need not state."""
_MAY_BE_INFINITE = frozenset({*Motor.ALLOWANCES.values(), *Gearhead.ALLOWANCES.values()} - {"voltage"})
_OPTIONAL = {
    kind: (*others, *(name for (_, of), name in _ALLOWANCES.items() if of == kind))
    for kind, others in {
        "motor": ("viscous_friction", "rotor_inertia", *NEEDED),
        "gearhead": ("backdriving_efficiency", "rated_torque", "inertia"),
    }.items()
}
_SEARCHED = {word: law for word, law in LAWS.items() if law.SEARCHED}
"""Laws that gearheads of tables may have."""

_SIZES, _PRICE = ("diameter", "length"), "price"

ENVELOPE, STRUCTURE = "envelope", "structure"
"""Names under which limits appear that size and mass of a drive can exceed, and that its structure can."""

LIMIT_FIELDS: Mapping[Demand, tuple[str, tuple[str, ...]]] = {
    **{demand: (demand[1], (name,)) for demand, name in _ALLOWANCES.items()},
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

    def allowance(self, limit: Limit, rows: np.ndarray) -> np.ndarray:
        """What motors or gearheads allow of a limit; nan where it is not stated. (k,)"""
        kind = "motor" if limit in Motor.ALLOWANCES else "gearhead"
        return self.values(kind, _KINDS[kind].ALLOWANCES[limit], rows)

    def mass(self, rows: np.ndarray) -> np.ndarray:
        """Mass of motor and gearhead; nan where one is not stated. (k,) [kg]"""
        return self.values("motor", "mass", rows) + self.values("gearhead", "mass", rows)

    def price(self, rows: np.ndarray) -> np.ndarray:
        """Price of motor and gearhead; nan where one is not stated. (k,)"""
        return self.values("motor", _PRICE, rows) + self.values("gearhead", _PRICE, rows)

    def parts(self, rows: np.ndarray) -> tuple[Motor, Gearhead]:
        """Many motors and gearheads as one, whose values are arrays of shape (k, 1).

        A limit that is not stated is out of reach; heat has data only if all rows have it.
        """
        column = functools.partial(self._column, rows=rows)
        motor: dict[str, Any] = {name: column("motor", name) for name in LAW["motor"]}
        gear: dict[str, Any] = {name: column("gearhead", name) for name in LAW["gearhead"]}
        for (_, kind), name in _ALLOWANCES.items():
            (motor if kind == "motor" else gear)[name] = column(kind, name, _BEYOND_ALL)
        motor["rotor_inertia"] = column("motor", "rotor_inertia", _NOTHING)
        gear["inertia"] = column("gearhead", "inertia", _NOTHING)
        viscous = column("motor", "viscous_friction", 0.0)
        if viscous.any():
            motor["viscous_friction"] = viscous
        if self.stated((Limit.TEMPERATURE, "motor"), rows).all():
            motor |= {name: column("motor", name) for name in NEEDED}
        law = LAWS[self.loss_model]
        gear |= law.columns(functools.partial(self.column_of, rows=rows), motor["continuous_torque"])
        return Motor(**motor), Gearhead(**gear, loss_model=self.loss_model)

    def part(self, row: int) -> tuple[Motor, Gearhead]:
        """One motor and gearhead as a study would have them: what is not stated is None."""
        parts: dict[str, dict[str, Any]] = {}
        for kind, column in (("motor", 0), ("gearhead", 1)):
            further = (*["inductance"] * (kind == "motor"), *_SIZES, _PRICE)
            fields = (*_needed(kind, self.loss_model), *_optional(kind, self.loss_model), "mass", *further)
            found = {name: float(self.values(kind, name, np.array([row]))[0]) for name in fields}
            parts[kind] = _nested({name: value for name, value in found.items() if not math.isnan(value)})
            if kind in self.names:
                parts[kind]["name"] = str(self.names[kind][self.pairs[row, column]])
        own = LAWS[self.loss_model].MAY
        for name in {name for law in _SEARCHED.values() for name in law.MAY if name not in own}:
            parts["gearhead"].pop(name, None)
        return Motor(**parts["motor"]), Gearhead(**parts["gearhead"], loss_model=self.loss_model)

    def sizes(self, rows: np.ndarray, structure: Structure) -> list[dict[str, np.ndarray]]:
        """Mass, diameter and length of motors and of gearheads, as stated or estimated. (k, 1) [kg], [m], [m]"""
        found = []
        for kind in ("motor", "gearhead"):
            mass, *stated = (self.values(kind, name, rows)[:, None] for name in ("mass", *_SIZES))
            length, diameter = estimated_size(mass, stated[0], stated[1], structure)
            found.append({"mass": mass, "diameter": diameter, "length": length})
        return found

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

    def column_of(self, name: str, otherwise: Any = None, *, rows: np.ndarray) -> np.ndarray:
        """A field of gearheads as a column; what is not stated is replaced, or out of reach if that is inf. (k, 1)"""
        return self._column("gearhead", name, _BEYOND_ALL if otherwise is np.inf else otherwise, rows=rows)

    def _column(self, kind: str, name: str, otherwise: Any = None, *, rows: np.ndarray) -> np.ndarray:
        """A field as a column; what is not stated is replaced."""
        found = self.values(kind, name, rows)[:, None]
        return found if otherwise is None else np.where(np.isnan(found), otherwise, found)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidates(Pairs):
    """Pairs as drives with an output stage; `template` has everything but motor and gearhead.

    `service` is what the structure has to carry.
    """

    template: ConventionalDrive
    service: Service
    envelope: Envelope | None = None

    def sized(self, rows: np.ndarray, stage: OutputStage) -> dict[TaskDemand, np.ndarray]:
        """Demand over allowance of structure and envelope, with a stage whose values may be columns (k, 1). (k,) [-]"""
        built = shaft_demand(with_stage(self.template, stage), self.service)
        found = {(STRUCTURE, *key): demand for key, demand in built.items()}
        if self.envelope is not None:
            sized = self.envelope.of(self._bodies(rows, stage), self.service)
            found |= {(ENVELOPE, *key): demand for key, demand in sized.items()}
        return {key: np.broadcast_to(np.ravel(demand), (len(rows),)) for key, demand in found.items()}

    def _bodies(self, rows: np.ndarray, stage: OutputStage) -> ConventionalDrive:
        """Many drives as one by their sizes and masses, whose values are columns. (k, 1)"""
        motor, gearhead = self.sizes(rows, self.template.structure)
        template = with_stage(self.template, stage)
        return replace(
            template, motor=replace(template.motor, **motor), gearhead=replace(template.gearhead, **gearhead)
        )

    def measure(self, objective: Objective, rows: np.ndarray, stage: OutputStage) -> np.ndarray:
        """Price, volume, or else mass of drives with a stage, whose values may be columns (k, 1). (k,) [-], [m^3] or [kg]"""
        if objective == "price":
            return self.price(rows)
        if objective == "space":
            found = np.ravel(self._bodies(rows, stage).layout(self.service).space.volume)
        else:
            found = self.mass(rows) + np.ravel(self.structure(stage))
        return found + np.zeros(len(rows))

    def structure(self, stage: OutputStage) -> Any:
        """Mass of all but motor and gearhead with a stage, whose values may be arrays. [kg]"""
        return own_mass(with_stage(self.template, stage).bodies(self.service))

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
    stated: Sequence[str],
    service: Service = NO_SERVICE,
    envelope: Envelope | None = None,
) -> Candidates:
    """Check tables of parts, for drives like a template; other arguments as for `pairs_of`."""
    found = pairs_of(motors, gearheads, pairs, loss_model=loss_model, moving=moving, stated=stated)
    own = {one.name: getattr(found, one.name) for one in dataclasses.fields(found)}
    return Candidates(template=template, service=service, envelope=envelope, **own)


def pairs_of(
    motors: Mapping[str, Any],
    gearheads: Mapping[str, Any],
    pairs: Any,
    *,
    loss_model: LossModel,
    moving: bool,
    stated: Sequence[str],
) -> Pairs:
    """Check tables of parts.

    Parameters
    ----------
    motors, gearheads : mapping    Columns by the names of the fields of `Motor` and `Gearhead`, in SI, nan where not stated; a
        column "name" holds texts. Other columns do not matter.
    pairs : (m, 2) int             Row of the motor and of the gearhead.
    loss_model : str               coulomb or proportional, of all gearheads.
    moving : bool                  Whether the rotor inertia is needed.
    stated : sequence              What else every part must state: mass, price.

    Raises
    ------
    ParameterError
        If a column is no vector of numbers, columns differ in length, or a pair names a row that does not exist.
    """
    if loss_model not in _SEARCHED:
        *others, last = _SEARCHED
        raise ParameterError(
            f"loss_model must be {', '.join(others)} or {last}, got {loss_model!r}: friction measured on a gear with its motor "
            "cannot be transferred to other motors"
        )
    tables = {
        "motor": _table("motors", motors, "motor", loss_model),
        "gearhead": _table("gearheads", gearheads, "gearhead", loss_model),
    }
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
    for reason, bad in _faults(made, moving, stated):
        if (usable & bad).any():
            excluded[reason] = int(np.sum(usable & bad))
        usable = usable & ~bad
    return replace(made, usable=np.flatnonzero(usable), excluded=excluded)


def _needed(kind: str, loss_model: LossModel) -> tuple[str, ...]:
    """Columns without which a law cannot be evaluated."""
    return (*LAW[kind], *(LAWS[loss_model].SEARCHED if kind == "gearhead" else ()))


def _optional(kind: str, loss_model: LossModel) -> tuple[str, ...]:
    own = LAWS[loss_model].MORE if kind == "gearhead" else ()
    return (*_OPTIONAL[kind], *(name for name in own if name not in _OPTIONAL[kind]))


def _nested(values: Mapping[str, float]) -> dict[str, Any]:
    """Fields of a part, those of its components, such as ``strain_wave.efficiency``, as these."""
    found: dict[str, Any] = {name: value for name, value in values.items() if "." not in name}
    for outer, part in PARTS_OF_LAWS.items():
        inner = {name.removeprefix(f"{outer}."): one for name, one in values.items() if name.startswith(f"{outer}.")}
        if inner:
            found[outer] = part(**inner)
    return found


def _table(name: str, columns: Mapping[str, Any], kind: str, loss_model: LossModel) -> dict[str, np.ndarray]:
    """Columns of a table that are fields of a part."""
    required = (*_needed(kind, loss_model), *_optional(kind, loss_model), "mass", "inductance", *_SIZES, _PRICE)
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
    for column in _needed(kind, loss_model):
        if column not in found:
            raise ParameterError(f"{name}.{column} is missing: no law of a {kind} can be evaluated without it")
    lengths = {column: values.shape for column, values in found.items()}
    first = next(iter(lengths.values()))
    for column, shape in lengths.items():
        if len(shape) != 1 or shape != first or not shape[0]:
            raise ParameterError(f"{name}.{column} must be a vector as long as the other columns, got shape {shape}")
    return found


def _faults(made: Pairs, moving: bool, stated: Sequence[str]) -> list[tuple[str, np.ndarray]]:
    """Reasons to leave a pair out, and the pairs that have each of them."""
    rows, found = np.arange(len(made.pairs)), []
    needs = [("motor", name) for name in LAW["motor"]] + [("motor", "rotor_inertia")] * moving
    needs += [("gearhead", name) for name in _needed("gearhead", made.loss_model)]
    needs += [(kind, name) for name in stated for kind in _KINDS]
    found += [(f"{kind} {name} not stated", np.isnan(made.values(kind, name, rows))) for kind, name in needs]
    for kind, part in _KINDS.items():
        judged = (*_needed(kind, made.loss_model), *_optional(kind, made.loss_model), "mass")
        for name, bound in _bounds(part):
            if name in judged:
                values = made.values(kind, name, rows)
                wrong = ~np.isnan(values) & ~(np.isfinite(values) & within(bound, values))
                found.append((f"{kind} {name} not {words(bound)}", wrong))
    volts, ohms, constant, idle, drag = (
        made.values("motor", name, rows)
        for name in ("voltage", "resistance", "torque_constant", "no_load_current", "viscous_friction")
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        found.append(("motor no_load_current not below its stall current", idle >= volts / ohms))
        most = constant * idle / ((volts - ohms * idle) / constant)
        found.append(("motor viscous_friction above its no-load torque", drag > most * (1.0 + 1e-12)))
        column = functools.partial(made.column_of, rows=rows)
        found += [(why, np.ravel(bad)) for why, bad in LAWS[made.loss_model].contradictions(column)]
    return found


def _bounds(part: type) -> Iterator[tuple[str, Any]]:
    """Names and bounds of the numbers of a part and of components that only some kinds have."""
    for field in dataclasses.fields(part):
        inner = PARTS_OF_LAWS.get(field.name) if part is Gearhead else None
        if inner is not None:
            yield from ((f"{field.name}.{one.name}", one.metadata["bound"]) for one in dataclasses.fields(inner))
        elif "bound" in field.metadata:
            yield field.name, field.metadata["bound"]
