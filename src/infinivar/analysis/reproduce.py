"""Reproduce the paper: check every claim that a steady computation can check."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from infinivar.analysis.claims import design, element, system
from infinivar.analysis.claims.claim import Claim, Finding, Machine, statements
from infinivar.errors import InputError

CHECKS: dict[str, Callable[[Machine], Finding]] = {**element.CHECKS, **system.CHECKS, **design.CHECKS}

_LATER = {
    "D": "Needs motion in time: inertias and steering effort are not in the steady model.",
    "S": "Needs motion in time: a lighter part loses less only where it is accelerated.",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Reproduction:
    """The paper's claims with their verdicts, and the machine they were checked on."""

    claims: tuple[Claim, ...]
    machine: Machine

    def to_list(self) -> list[dict[str, Any]]:
        """Claims as plain values: id, section, claim, paper, computed, verdict, why."""
        keys = ("id", "section", "claim", "paper", "computed", "verdict", "why")
        return [{key: getattr(claim, key) for key in keys} for claim in self.claims]

    def save(self, directory: str | Path, figure: int | None = None) -> list[Path]:
        """Write ``reproduction.html``, ``claims.json`` and the figures (PNG, SVG, PDF); returns their paths."""
        from infinivar.report import reproduction

        return reproduction.save(self, Path(directory), figure)


def reproduce(figure: int | None = None, *, progress: Callable[[str, float], None] | None = None) -> Reproduction:
    """Check the paper's claims on its machine as shipped (parameter set ``faulring2006``).

    Parameters
    ----------
    figure : int or None   Only the claims that belong to this figure of the paper.
    progress               Called with the claim at work and the share of the work done, 0 to 1.

    Returns
    -------
    Reproduction
        A claim nothing here can check yet has the verdict "not computed".

    Raises
    ------
    InputError
        If no claim belongs to the figure.
    """
    figures = sorted({said["figure"] for said in statements() if "figure" in said})
    if figure is not None and figure not in figures:
        raise InputError(f"figure {figure}: must be one of {', '.join(map(str, figures))}")
    machine = Machine()
    wanted = [said for said in statements() if figure is None or said.get("figure") == figure]
    claims = []
    for index, said in enumerate(wanted):
        if progress is not None:
            progress(f"claim {said['id']}", index / len(wanted))
        check = CHECKS.get(said["id"])
        found = check(machine) if check else Finding(None, "not computed", _LATER[said["id"][0]])
        claims.append(Claim(**{"figure": None, **said}, **found._asdict()))
    return Reproduction(claims=tuple(claims), machine=machine)
