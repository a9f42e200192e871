"""What a check finds, and when it decides: not where a choice of ours, or a value the paper leaves open, turns it round."""

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
        "definition": "definition that the paper leaves open",
        "value": "value that the paper does not print",
        "contrary": "contrary to the paper, for comparison only",
    }
)
"""What a variant changes. The first three must not turn a verdict round; the last does not count."""

FACTOR = 1.5
"""Assumed values are moved by this factor either way: they are not known any better."""

_NAMED = 4
"""Variants named in a reason; the table has all."""


class Found(NamedTuple):
    """One value with its verdict and the threshold that decides between them."""

    computed: float | str | None
    threshold: str
    verdict: Verdict


class Variant(NamedTuple):
    """What is found under another choice, definition or value."""

    kind: Kind
    assuming: str
    computed: float | str | None
    threshold: str
    verdict: Verdict


class Range(NamedTuple):
    """Values of one parameter, all others as shipped, over which a claim keeps its verdict; None: as far as looked."""

    parameter: str
    unit: str
    shipped: float
    low: float | None
    high: float | None


class Finding(NamedTuple):
    """What a check found: the value (a number, or a few words), threshold and verdict, and why in one or two sentences.

    `shown` is the verdict by the shipped choices, definitions and values alone; `variants` what is found under others,
    `ranges` how far parameters that the paper leaves open may move before `shown` changes. `by_construction` marks a claim
    that the machine was fitted to: it says that such a machine exists, and tests nothing.
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
    """The verdict on a claim that is true or false."""
    return "holds" if condition else "does not hold"


def _spaced(text: str) -> str:
    """Percent signs apart from their numbers, as everywhere else."""
    return re.sub(r"(?<=\d)%", " %", text)


def near(value: float, printed: float, tolerance: float) -> Found:
    """Whether a computed value agrees with a printed one."""
    return Found(value, f"within {tolerance:g} of {printed:g}", yes(abs(value - printed) <= tolerance))


def row(kind: Kind, assuming: str, found: Found) -> Variant:
    """A variant from what is found under it."""
    computed = _spaced(found.computed) if isinstance(found.computed, str) else found.computed
    return Variant(kind, _spaced(assuming), computed, _spaced(found.threshold), found.verdict)


def turned(verdict: Verdict, variants: Iterable[Variant]) -> list[Variant]:
    """Variants that count and come to the opposite verdict."""
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
    """The finding, undecidable if any variant that counts turns the verdict round; the reason then names such variants.

    Parameters
    ----------
    found : Found        With the shipped choices, definitions and values.
    why : str            Reason, one or more whole sentences.
    by_construction      The machine was fitted to the claim: variants then only tell how closely.
    """
    variants = tuple(variants)
    against = [] if by_construction else turned(found.verdict, variants)
    verdict = found.verdict
    if against:
        named = [variant.assuming for variant in against[:_NAMED]]
        more = f" and {len(against) - _NAMED} more" if len(against) > _NAMED else ""
        turns = {"holds": "Holds as shown, but not with", "does not hold": "Does not hold as shown, but would with"}
        why = f"{turns[verdict]}: {'; '.join(named)}{more}. {why}"
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
