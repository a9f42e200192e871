"""What each drive of a study weighs, body by body, and how far that hangs on assumed factors."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from infinivar._core.described import derived, reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result
from infinivar.drivetrain.body import Body, open_bodies, total
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import is_machine
from infinivar.drivetrain.envelope import Envelope
from infinivar.drivetrain.layout import Layout
from infinivar.drivetrain.masses import bodies_of
from infinivar.drivetrain.service import Service
from infinivar.limits import Demand
from infinivar.parts.structure.structure import Structure
from infinivar.study.study import Study
from infinivar.units import show, show_in, times

LEFT_OUT = "mounts, couplings, fasteners, covers, cables, sensors and electronics"
"""What is not counted in any drive."""

DOUBT = 1.5
"""Factor by which an assumed factor may be wrong, either way."""

_NEGLIGIBLE = 1e-3
_ROUNDING = 1e-9


def _rows(bodies: tuple[Body, ...]) -> list[dict[str, Any]]:
    return [
        {"body": body.name, "mass_kg": body.mass, "kind": body.kind, "basis": body.basis, "moving": body.moving}
        for body in bodies
    ]


def _space(layout: Layout) -> dict[str, Any]:
    space = layout.space
    sides = {f"{name}_m": float(side) for name, side in space._asdict().items()}
    return {**sides, "diameter_m": float(space.diameter), "open": list(layout.open)}


@result
class WholeMass(Frozen):
    """What a drive weighs.

    Attributes
    ----------
    bodies    Every body, with its mass or what is missing.
    layout    Where the bodies are.
    service   Travel and largest force of the drive's own output, for which the structure is sized.
    factors   Whole mass with an assumed factor divided, and multiplied, by `DOUBT`, by factor; without those that change it by
        less than 0.1 %. [kg]
    """

    bodies: tuple[Body, ...] = reported(convert=_rows)
    layout: Layout = reported(key="space", convert=_space)
    service: Service
    factors: Mapping[str, tuple[float, float]] = reported("kg")

    @derived("kg")
    def total(self) -> float:
        """Of all bodies; nan if one is not known. [kg]"""
        return total(self.bodies)

    @property
    def known(self) -> float:
        """Of the bodies whose mass is known. [kg]"""
        return sum(body.mass for body in self.bodies if body.mass is not None)

    @derived("kg")
    def motors(self) -> float:
        """Of motors and gearheads; nan if one is not known. [kg]"""
        return total(body for body in self.bodies if body.chosen)

    @derived("kg")
    def moving(self) -> float:
        """Of the bodies that move with the link or load; nan if one is not known. [kg]"""
        return total(body for body in self.bodies if body.moving)

    @derived()
    def open(self) -> tuple[str, ...]:
        """Bodies whose mass is not known, and why."""
        return tuple(open_bodies(self.bodies))

    def within(self, envelope: Envelope | None) -> bool:
        """Whether what is known of the drive is within an envelope, if there is one."""
        if envelope is None:
            return True
        sized = bool(self.layout.solids) or envelope.sizes == ()
        return sized and not self.exceeded(envelope)

    def exceeded(self, envelope: Envelope) -> dict[Demand, float]:
        """Demands over allowance above 1 of an envelope; of what is known, at least these. [-]"""
        found = envelope.demands(self.layout.space, self.known)
        return {key: float(demand) for key, demand in found.items() if demand > 1.0 + _ROUNDING}

    def words_on(self, envelope: Envelope) -> str:
        """Whether the drive is within an envelope, in one line."""
        size = f"{self.space_words}; {self.known_words}"
        beyond = self.exceeded(envelope)
        if beyond:
            return f"{size}; exceeds the envelope: {exceeded_words(beyond)}"
        if not self.within(envelope):
            return f"{size}; not known whether within the envelope"
        return f"{size}; within the envelope{'' if self.known_within(envelope) else ', as far as known'}"

    @property
    def known_words(self) -> str:
        """Mass in a word or three: "0.8 kg", or "more than 2.2 kg" where not all is known."""
        return f"more than {show(self.known, 'kg', 3)}" if self.open else show(self.total, "kg", 3)

    def known_within(self, envelope: Envelope) -> bool:
        """Whether all is known that an envelope limits."""
        return not (self.layout.open or (envelope.mass is not None and self.open))

    @property
    def space_words(self) -> str:
        """Size in one line, with what is not placed and why."""
        return self._size(self.layout.open)

    @property
    def size_words(self) -> str:
        """As `space_words`, with the names alone of what is not placed."""
        return self._size([one.partition(" (")[0] for one in self.layout.open])

    def _size(self, unplaced: Sequence[str]) -> str:
        if not self.layout.solids:
            return f"not known: {', '.join(unplaced)}"
        sides = " x ".join(show_in(float(side), "m", "mm", 3).removesuffix(" mm") for side in self.layout.space)
        return f"{sides} mm" + (f" without {', '.join(unplaced)}" if unplaced else "")

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest whole mass as each factor is wrong by `DOUBT`, alone. [kg]"""
        ends = [end for pair in self.factors.values() for end in pair if math.isfinite(end)]
        return min([self.total, *ends]), max([self.total, *ends])

    @property
    def words(self) -> str:
        """Mass in one line."""
        if self.open:
            return f"more than {show(self.known, 'kg', 3)}: not known are {', '.join(self.open)}"
        low, high = (show(end, "kg", 3) for end in self.range)
        motors = "" if math.isnan(self.motors) else f", of it motors and gearheads {show(self.motors, 'kg', 3)}"
        spread = f" ({low} to {high} as one assumed factor is wrong by {DOUBT:g})" if self.factors else ""
        return f"{show(self.total, 'kg', 3)}{spread}{motors}"


def exceeded_words(beyond: Mapping[Demand, float]) -> str:
    """Demands on an envelope in words: "length 1.3 times the allowance"."""
    return ", ".join(f"{what} {times(demand)} the allowance" for (_, what), demand in beyond.items())


def whole_mass(study: Study, drive: str) -> WholeMass | None:
    """What a drive of a study weighs, with a structure for the travel and forces of the study.

    Parameters
    ----------
    study : Study
    drive : str     Name of a drive.

    Returns
    -------
    WholeMass   None for machines, whose structure is not known.
    """
    made = study.drives[drive]
    if not isinstance(made, CoboticDrive | ConventionalDrive):
        return None
    return mass_of(made, study.service(made))


def mass_of(drive: Any, service: Service, *, doubted: bool = True) -> WholeMass:
    """What a drive weighs, or what moves the links of a machine, for a service.

    Not `doubted`, it is without the effect of its factors, which takes most of the time.
    """
    bodies = bodies_of(drive, service)
    whole, factors = total(bodies), {}
    for name in factor_names() if doubted else ():
        ends = [total(bodies_of(with_factor(drive, name, by), service)) for by in (1.0 / DOUBT, DOUBT)]
        if any(abs(end - whole) > _NEGLIGIBLE * whole for end in ends):
            factors[name] = ends[0], ends[1]
    layout = Layout((), ("links of a machine",)) if is_machine(drive) else drive.layout(service)
    return WholeMass(bodies=bodies, layout=layout, service=service, factors=FrozenDict(factors))


def with_factor(drive: Any, name: str, by: float) -> Any:
    """A drive, or what moves the links of a machine, with an assumed factor of its structure multiplied."""
    inner = next((one for one in ("leg", "separate") if getattr(drive, one, None) is not None), None)
    if inner is not None:
        return replace(drive, **{inner: with_factor(getattr(drive, inner), name, by)})
    return replace(drive, structure=replace(drive.structure, **{name: by * getattr(drive.structure, name)}))


def doubts(*, space: bool = False) -> Iterator[tuple[str, float]]:
    """Yield each assumed factor, see `factor_names`, with both numbers by which it may be wrong."""
    for name in factor_names(space=space):
        yield name, 1.0 / DOUBT
        yield name, DOUBT


def factor_names(*, space: bool = False) -> Iterable[str]:
    """Assumed factors that size the bodies of a structure; for the space also those on the size of motors."""
    for field in dataclasses.fields(Structure):
        if (
            "unit" in field.metadata
            and field.name != "travel"
            and (space or not field.name.startswith("motor_"))
            and not field.name.endswith("_mass")
        ):
            yield field.name
