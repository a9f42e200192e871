"""Reproduce the paper: check every claim that can be checked by computation."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from infinivar._core.processes import apart
from infinivar._core.result import Result, result
from infinivar.errors import InputError
from infinivar.paper.claims import contact, design, element, plants, shaking, system
from infinivar.paper.claims.claim import Checked, Claim, Finding, PaperMachine, counted, row, statements, turned
from infinivar.paper.displays import display_claims
from infinivar.paper.figures import FIGURES
from infinivar.parts.bearing import Bearing
from infinivar.parts.shaft_bearings import CylinderBearings
from infinivar.study.build import built_part

EXACT = "exact"
"""Creep law of exact rolling theory, with which every check is repeated."""

_BY_LAW = f"creep law {EXACT}"
_BY_SPIN = "steering as spin"
_BY_BEARINGS = "friction of the cylinder's bearings, two 6004"

CHECKS: dict[str, Callable[[PaperMachine], Checked]] = {
    **element.CHECKS,
    **contact.CHECKS,
    **system.CHECKS,
    **shaking.CHECKS,
    **design.CHECKS,
    **plants.CHECKS,
}

STEERED = (*shaking.CHECKS, "S5")
"""Checks of drives that steer while they move, which are repeated with steering as spin."""


DISPLAYS = "H"
"""First letter of the claims about displays."""

_LONGEST = f"D{DISPLAYS}SCBEG"
"""First letters of claims, those that take longest first."""

HELD = ("B1", "B2", "B3", "B4", *shaking.CHECKS)
"""Checks of the cobotic drive, which are repeated with friction of the cylinder's bearings."""


@result
class Reproduction(Result):
    """The paper's claims with their verdicts, and the machine on which they were checked."""

    claims: tuple[Claim, ...]
    machine: PaperMachine

    @property
    def verdict(self) -> str:
        """One sentence: how many claims have each verdict; empty if no claim was checked."""
        return counted([claim.verdict for claim in self.claims])

    @property
    def with_exact_law(self) -> str:
        """What the creep law exact, in place of the paper's, changes: claims and verdicts."""
        return self._changed(_BY_LAW, f"With the creep law {EXACT} instead of the paper's")

    @property
    def with_spin(self) -> str:
        """What steering as spin, in place of the paper's constant torque, changes; empty if no claim is about steering."""
        if not any(claim.id in STEERED for claim in self.claims):
            return ""
        return self._changed(_BY_SPIN, "With steering as spin instead of a constant torque")

    @property
    def with_bearings(self) -> str:
        """What the cylinder's bearings change, which the paper names without a value; empty if no claim is about the drive."""
        if not any(claim.id in HELD for claim in self.claims):
            return ""
        return self._changed(_BY_BEARINGS, "With the friction of two 6004 that hold the cylinder")

    def _changed(self, assuming: str, words: str) -> str:
        changed = {
            claim.id: variant.verdict != claim.shown
            for claim in self.claims
            for variant in claim.variants
            if variant.assuming == assuming
        }
        if not changed:
            return f"{words}, no computed value changes."
        turned = [name for name, turns in changed.items() if turns]
        verdicts = f"so does the verdict on {', '.join(turned)}" if turned else "no verdict does"
        return f"{words}, the computed values of {', '.join(changed)} change; {verdicts}."

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


def _beside(
    check: Callable[[PaperMachine], Checked], machine: PaperMachine, others: Mapping[str, PaperMachine]
) -> Finding:
    """The finding of a check; among its variants those on machines with other laws, if their results differ.

    The paper states its creep law and its resistance to steering, so other laws do not count in the verdict. Of the cylinder's
    bearings it states nothing but that they lose power: they count as a value that it leaves open.
    """
    found = check(machine).settled()
    for assuming, changed in others.items():
        other = row("value" if assuming == _BY_BEARINGS else "contrary", assuming, check(changed).found)
        if (other.computed, other.verdict) != (found.computed, found.shown):
            found = found._replace(variants=(*found.variants, other))
            if found.verdict == found.shown and turned(found.shown, [other]):
                found = found._replace(verdict="undecidable", why=f"Not with {assuming}. {found.why}")
    return found


def two_6004() -> CylinderBearings:
    """Two deep groove bearings for a shaft of 20 mm, by a constant coefficient of friction as the machine's axle."""
    return CylinderBearings(bearing=replace(built_part(Bearing, "6004"), friction_model="coefficient"))


def reproduce(figure: int | None = None, *, progress: Callable[[str, float], None] | None = None) -> Reproduction:
    """Check the paper's claims on the shipped machine (parameter set ``faulring2006``).

    Parameters
    ----------
    figure : int or None   Check only the claims that belong to this figure; some figures have none. Without it, the claims
        about displays are among them, as `display_claims` returns them.
    progress               Called with what is done and the share of the work done, 0 to 1.

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
    required = [said for said in statements() if figure is None or said.get("figure") == figure]
    groups: dict[str, list[dict[str, Any]]] = {DISPLAYS: []} if figure is None else {}
    for said in required:
        groups.setdefault(said["id"][0], []).append(said)
    longest = sorted(groups.items(), key=lambda group: _LONGEST.index(group[0]))
    made: dict[str, Claim] = {}
    if progress is not None:
        progress("claims", 0.0)
    for place, claims in enumerate(apart(_claims, longest), start=1):
        if progress is not None:
            progress("claims", place / len(longest))
        made.update((claim.id, claim) for claim in claims)
    order = [*(said["id"] for said in required), *made]
    return Reproduction(claims=tuple(made[name] for name in dict.fromkeys(order)), machine=PaperMachine())


def _claims(group: tuple[str, Sequence[Mapping[str, Any]]]) -> list[Claim]:
    """The claims whose ids begin with a letter, which have most of their computations in common, from their statements."""
    letter, required = group
    if letter == DISPLAYS:
        return list(display_claims().claims)
    machine, exact, spinning = PaperMachine(), PaperMachine(EXACT), PaperMachine(steering_model="spin")
    held = PaperMachine(cylinder_bearings=two_6004())
    claims = []
    for said in required:
        others = {_BY_LAW: exact} | ({_BY_SPIN: spinning} if said["id"] in STEERED else {})
        others |= {_BY_BEARINGS: held} if said["id"] in HELD else {}
        found = _beside(CHECKS[said["id"]], machine, others)
        claims.append(Claim(**{"figure": None, **said}, **found._asdict()))
    return claims
