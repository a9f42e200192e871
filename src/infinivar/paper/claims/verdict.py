"""Findings and verdicts: a claim is undecidable if a choice of ours, or a value the paper leaves open, reverses the verdict."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Literal, NamedTuple

Verdict = Literal["holds", "does not hold", "undecidable"]

Kind = Literal["choice", "definition", "value", "contrary"]

KINDS: Mapping[Kind, str] = MappingProxyType(
    {
        "choice": "our choice",
        "definition": "definition the paper leaves open",
        "value": "value the paper does not print",
        "contrary": "contradicts the paper; for comparison only",
    }
)
"""What a variant changes. If any of the first three reverses a verdict, the claim is undecidable; the last does not count."""

FACTOR = 1.5
"""Assumed values are varied by this factor either way, which is how well they are known."""

_NAMED = 4
"""Most variants named in a reason; the table lists them all."""


class Found(NamedTuple):
    """A computed value, the threshold it is compared with, and the resulting verdict."""

    computed: float | str | None
    threshold: str
    verdict: Verdict


class Variant(NamedTuple):
    """The finding under another choice, definition or value."""

    kind: Kind
    assuming: str
    computed: float | str | None
    threshold: str
    verdict: Verdict


class Range(NamedTuple):
    """Range of one parameter, all others as shipped, over which the verdict stays the same; None: no limit within the search."""

    parameter: str
    unit: str
    shipped: float
    low: float | None
    high: float | None


class Finding(NamedTuple):
    """Result of a check: value (a number or a few words), threshold, verdict, and the reason in one or two sentences.

    `shown` is the verdict with the shipped choices, definitions and values alone. `variants` holds the findings under other
    ones, `ranges` how far parameters that the paper leaves open may change before `shown` does. `by_construction` marks a
    claim that the machine was fitted to: the verdict shows that such a machine exists, but tests nothing.
    """

    computed: float | str | None
    threshold: str
    verdict: Verdict
    shown: Verdict
    why: str
    ranges: tuple[Range, ...] = ()
    variants: tuple[Variant, ...] = ()
    by_construction: bool = False


def yes(condition: bool) -> Verdict:
    """The verdict on a claim that is either true or false."""
    return "holds" if condition else "does not hold"


def _spaced(text: str) -> str:
    """The text with a space before each percent sign, as everywhere else."""
    return re.sub(r"(?<=\d)%", " %", text)


def near(value: float, printed: float, tolerance: float) -> Found:
    """Whether a computed value agrees with a printed one."""
    return Found(value, f"within {tolerance:g} of {printed:g}", yes(abs(value - printed) <= tolerance))


def row(kind: Kind, assuming: str, found: Found) -> Variant:
    """Make a variant from its finding."""
    computed = _spaced(found.computed) if isinstance(found.computed, str) else found.computed
    return Variant(kind, _spaced(assuming), computed, _spaced(found.threshold), found.verdict)


def turned(verdict: Verdict, variants: Iterable[Variant]) -> list[Variant]:
    """Variants that count and reverse the verdict."""
    opposite = {"holds": "does not hold", "does not hold": "holds"}.get(verdict)
    return [variant for variant in variants if variant.kind != "contrary" and variant.verdict == opposite]


def settle(
    found: Found,
    why: str,
    variants: Iterable[Variant] = (),
    ranges: Iterable[Range] = (),
    *,
    by_construction: bool = False,
) -> Finding:
    """The finding: undecidable if any variant that counts reverses the verdict; the reason then names those variants.

    Parameters
    ----------
    found : Found        Finding with the shipped choices, definitions and values.
    why : str            Reason, in one or more full sentences.
    by_construction      The machine was fitted to the claim: variants then only show how closely.
    """
    variants = tuple(variants)
    against = [] if by_construction else turned(found.verdict, variants)
    verdict = found.verdict
    if against:
        named = [variant.assuming for variant in against[:_NAMED]]
        more = f" and {len(against) - _NAMED} more" if len(against) > _NAMED else ""
        reversal = {"holds": "Holds as shown, but not with", "does not hold": "Does not hold as shown, but would with"}
        why = f"{reversal[verdict]}: {'; '.join(named)}{more}. {why}"
        verdict = "undecidable"
    return Finding(
        computed=_spaced(found.computed) if isinstance(found.computed, str) else found.computed,
        threshold=_spaced(found.threshold),
        verdict=verdict,
        shown=found.verdict,
        why=_spaced(why),
        ranges=tuple(ranges),
        variants=variants,
        by_construction=by_construction,
    )
