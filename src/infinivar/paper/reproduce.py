"""Reproduce the paper: check every claim that can be checked by computation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from infinivar._core.result import Result, result
from infinivar.errors import InputError
from infinivar.paper.claims import design, element, shaking, system
from infinivar.paper.claims.claim import Claim, Machine, statements
from infinivar.paper.claims.verdict import Finding
from infinivar.paper.figures import FIGURES

CHECKS: dict[str, Callable[[Machine], Finding]] = {
    **element.CHECKS,
    **system.CHECKS,
    **shaking.CHECKS,
    **design.CHECKS,
}


@result
class Reproduction(Result):
    """The paper's claims with their verdicts, and the machine on which they were checked."""

    claims: tuple[Claim, ...]
    machine: Machine

    def to_list(self) -> list[dict[str, Any]]:
        """Claims as plain values: all fields of `Claim` except the figure, with ranges and variants as lists of dicts."""
        keys = (
            "id",
            "section",
            "claim",
            "paper",
            "computed",
            "unit",
            "threshold",
            "verdict",
            "shown",
            "by_construction",
            "why",
        )
        return [
            {
                **{key: getattr(claim, key) for key in keys},
                "ranges": [held._asdict() for held in claim.ranges],
                "variants": [variant._asdict() for variant in claim.variants],
            }
            for claim in self.claims
        ]


def reproduce(figure: int | None = None, *, progress: Callable[[str, float], None] | None = None) -> Reproduction:
    """Check the paper's claims on the shipped machine (parameter set ``faulring2006``).

    Parameters
    ----------
    figure : int or None   Check only the claims that belong to this figure; some figures have none.
    progress               Called with the current claim and the share of the work done, 0 to 1.

    Returns
    -------
    Reproduction

    Raises
    ------
    InputError
        If the paper has no such figure.
    """
    if figure is not None and (isinstance(figure, bool) or not isinstance(figure, int)):
        raise InputError(f"figure must be a whole number from {min(FIGURES)} to {max(FIGURES)}, got {figure!r}")
    if figure is not None and figure not in FIGURES:
        raise InputError(f"figure {figure}: must be from {min(FIGURES)} to {max(FIGURES)}")
    machine = Machine()
    wanted = [said for said in statements() if figure is None or said.get("figure") == figure]
    claims = []
    for index, said in enumerate(wanted):
        if progress is not None:
            progress(f"claim {said['id']}", index / len(wanted))
        claims.append(Claim(**{"figure": None, **said}, **CHECKS[said["id"]](machine)._asdict()))
    return Reproduction(claims=tuple(claims), machine=machine)
