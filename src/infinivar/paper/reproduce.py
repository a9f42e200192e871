"""Reproduce the paper: check every claim that can be checked by computation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from infinivar._core.result import Result, result
from infinivar.errors import InputError
from infinivar.paper.claims import design, element, shaking, system
from infinivar.paper.claims.claim import Claim, Machine, Varied, statements
from infinivar.paper.claims.verdict import Finding, Found, row
from infinivar.paper.figures import FIGURES

EXACT = "exact"
"""Creep law of exact rolling theory, with which every check is repeated."""

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

    @property
    def with_exact_law(self) -> str:
        """What the creep law exact, in place of the paper's, changes: claims and verdicts."""
        changed = {
            claim.id: variant.verdict != claim.shown
            for claim in self.claims
            for variant in claim.variants
            if variant.assuming == f"creep law {EXACT}" and variant.kind == "contrary"
        }
        if not changed:
            return f"With the creep law {EXACT} instead of the paper's, no computed value changes."
        turned = [name for name, turns in changed.items() if turns]
        verdicts = f"so does the verdict on {', '.join(turned)}" if turned else "no verdict does"
        values = f"the computed values of {', '.join(changed)}"
        return f"With the creep law {EXACT} instead of the paper's, {values} change; {verdicts}."

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


def _beside_exact(check: Callable[[Machine], Finding], machine: Machine, exact: Machine) -> Finding:
    """The finding of a check; among its variants that with the law exact, if its result differs.

    The paper states its creep law, so the law exact does not count in the verdict.
    """
    found = check(machine)
    other = row("contrary", f"creep law {EXACT}", _shown(check, exact))
    if (other.computed, other.verdict) == (found.computed, found.shown):
        return found
    return found._replace(variants=(*found.variants, other))


def _shown(check: Callable[[Machine], Finding], machine: Machine) -> Found:
    """What a check finds with the shipped choices, definitions and values."""
    if isinstance(check, Varied):
        return check.shown(machine)
    found = check(machine)
    return Found(found.computed, found.threshold, found.shown)


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
    machine, exact = Machine(), Machine(EXACT)
    wanted = [said for said in statements() if figure is None or said.get("figure") == figure]
    claims = []
    for index, said in enumerate(wanted):
        if progress is not None:
            progress(f"claim {said['id']}", index / len(wanted))
        found = _beside_exact(CHECKS[said["id"]], machine, exact)
        claims.append(Claim(**{"figure": None, **said}, **found._asdict()))
    return Reproduction(claims=tuple(claims), machine=machine)
