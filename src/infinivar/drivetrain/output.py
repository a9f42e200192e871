"""What lies between a drive's output and its load: springs, and a linkage to a joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from infinivar._core.fields import check, component
from infinivar.parts.linkage import Linkage
from infinivar.parts.spring import Spring, TorsionSpring


class Place(NamedTuple):
    """One element of the chain between load and drive."""

    kind: str
    """parallel, series or linkage."""
    part: Spring | TorsionSpring | Linkage
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

    @property
    def chain(self) -> tuple[Place, ...]:
        """The elements in order, from the load to the drive; empty if the drive moves the load directly."""
        return (
            *_layer(self.parallel_torsion_spring, self.series_torsion_spring, "torsion spring"),
            *([Place("linkage", self.linkage, "linkage")] if self.linkage is not None else []),
            *_layer(self.parallel_spring, self.series_spring, "spring"),
        )


def _layer(parallel: Spring | TorsionSpring | None, series: Spring | TorsionSpring | None, name: str) -> list[Place]:
    """Springs of one line or joint, from the load to the drive."""
    beside = [] if parallel is None else [Place("parallel", parallel, f"parallel {name}")]
    within = [] if series is None else [Place("series", series, f"series {name}")]
    return [*within, *beside] if parallel is not None and parallel.at == "drive" else [*beside, *within]
