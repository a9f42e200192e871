"""What lies between a drive's output and its load: springs, and a linkage to a joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from infinivar._core.fields import check, component
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.errors import ParameterError
from infinivar.parts.linkage import Linkage
from infinivar.parts.spring import Spring, TorsionSpring


class Place(NamedTuple):
    """One element of the chain between load and drive."""

    kind: str
    """parallel, series or linkage; of a drive also guideway."""
    part: Any  # Spring, TorsionSpring, Linkage or Guideway
    name: str
    """Key of its loss and stored power in results, such as "series spring"."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Output:
    """Springs and linkage between a drive and its load; by default none: the drive moves the load directly.

    Springs of a joint are torsion springs, springs of a line are `Spring`. Seen from the load, the order is: parallel torsion
    spring, series torsion spring, linkage, parallel spring, series spring; a parallel spring with ``at = "drive"`` acts on the
    drive's side of the series spring.
    """

    linkage: Linkage | None = component("Linkage to a joint", default=None)
    parallel_spring: Spring | None = component("Spring parallel to the drive's line", default=None)
    series_spring: Spring | None = component("Spring between the drive's line and the load or linkage", default=None)
    parallel_torsion_spring: TorsionSpring | None = component("Spring parallel to the joint or shaft", default=None)
    series_torsion_spring: TorsionSpring | None = component("Spring in series with the joint or shaft", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        for key in ("series_spring", "series_torsion_spring"):
            spring = getattr(self, key)
            if spring is None:
                continue
            if spring.at != "load":
                raise ParameterError(f"{key}.at does not apply: only a parallel spring has a side; remove it")
            if spring.absent:
                raise ParameterError(
                    f"{key}.stiffness must be > 0, got 0: nothing would carry the load; leave {key} out"
                )

    @property
    def chain(self) -> tuple[Place, ...]:
        """The elements in order, from the load to the drive; empty if the drive moves the load directly."""
        return (
            *_layer(self.parallel_torsion_spring, self.series_torsion_spring, "torsion spring"),
            *([Place("linkage", self.linkage, "linkage")] if self.linkage is not None else []),
            *_layer(self.parallel_spring, self.series_spring, "spring"),
        )

    @property
    def has_series_spring(self) -> bool:
        """Whether a spring lies between drive and load, so that the drive's motion depends on the force."""
        return self.series_spring is not None or self.series_torsion_spring is not None

    @property
    def stores(self) -> bool:
        """Whether a spring stores energy."""
        return any(place.kind != "linkage" for place in self.chain)

    def axis(self, inner: Axis) -> Axis:
        """Axis of the load of a drive whose own output moves along or about `inner`."""
        return inner if self.linkage is None else ROTARY

    def check_axis(self, inner: Axis) -> None:
        """Raise ParameterError unless springs and linkage fit a drive whose own output moves along or about `inner`."""
        if self.linkage is not None and self.linkage.rotary_drive is not inner.rotary:
            turns, suited = (
                ("about a shaft", "lever, table or crank")
                if self.linkage.rotary_drive
                else ("along a line", "four-bar")
            )
            raise ParameterError(
                f"output.linkage.shape = {self.linkage.shape!r} needs a drive that moves {turns}; use {suited} with this one"
            )
        for name, spring_axis in (("spring", LINEAR), ("torsion_spring", ROTARY)):
            for way in ("parallel", "series"):
                key = f"{way}_{name}"
                if getattr(self, key) is not None and spring_axis not in (inner, self.axis(inner)):
                    raise ParameterError(f"output.{key} does not apply: {_WHY[spring_axis.rotary]}")


_WHY = {
    True: "the drive moves along a line and has no linkage to a joint; use output.{parallel,series}_spring",
    False: "the drive turns; use output.{parallel,series}_torsion_spring",
}


def _layer(parallel: Spring | TorsionSpring | None, series: Spring | TorsionSpring | None, name: str) -> list[Place]:
    """Springs of one line or joint, from the load to the drive."""
    beside = [] if parallel is None or parallel.absent else [Place("parallel", parallel, f"parallel {name}")]
    within = [] if series is None else [Place("series", series, f"series {name}")]
    return [*within, *beside] if parallel is not None and parallel.at == "drive" else [*beside, *within]
