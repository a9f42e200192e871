"""Findings and verdicts: a claim is undecidable if a choice of ours, or a value the paper leaves open, reverses the verdict."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Literal, NamedTuple

Verdict = Literal["holds", "by construction", "does not hold", "undecidable"]
"""By construction: the machine was fitted to the claim, or every law of the program implies it. That is no test, and no pass."""

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
    ones, `ranges` how far parameters that the paper leaves open may change before `shown` does.
    """

    computed: float | str | None
    threshold: str
    verdict: Verdict
    shown: Verdict
    why: str
    ranges: tuple[Range, ...] = ()
    variants: tuple[Variant, ...] = ()


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


_COUNTED: Mapping[Verdict, tuple[str, str]] = MappingProxyType(
    {
        "holds": ("holds", "hold"),
        "by construction": ("holds by construction", "hold by construction"),
        "does not hold": ("does not hold", "do not hold"),
        "undecidable": ("is undecidable", "are undecidable"),
    }
)
"""Each verdict as the predicate of one claim and of several."""


def counted(verdicts: Sequence[Verdict]) -> str:
    """One sentence: how many claims have each verdict; empty without claims."""
    if not verdicts:
        return ""
    found = [
        f"{count} {words[count != 1]}" for verdict, words in _COUNTED.items() if (count := verdicts.count(verdict))
    ]
    return f"Of {len(verdicts)} claim{'s' if len(verdicts) != 1 else ''}, {', '.join(found)}."


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

    A claim that holds by construction is not decided by variants: they only show how closely it does.

    Parameters
    ----------
    found : Found        Finding with the shipped choices, definitions and values.
    why : str            Reason, in one or more full sentences.
    by_construction      The machine was fitted to the claim, or no law of the program permits anything else; `why` says which.
    """
    variants = tuple(variants)
    built = by_construction and found.verdict == "holds"
    against = [] if built else turned(found.verdict, variants)
    verdict = "by construction" if built else found.verdict
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
    )
