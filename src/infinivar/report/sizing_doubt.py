"""Lines and page section on the builds of designs within their tolerances."""

from __future__ import annotations

from collections.abc import Iterator

from infinivar._core.text import counted
from infinivar.analysis.robustness.verdicts import percent
from infinivar.sizing.builds.result import Doubt

_LISTED = 5
"""Most runners-up that are printed in a terminal."""


def text(doubt: Doubt) -> Iterator[str]:
    """Yield the lines for a terminal."""
    yield f"Within tolerances, {counted(doubt.count, 'builds')}:"
    yield f"  {doubt.designs[0].name}: {doubt.verdict}"
    for one in doubt.runners_up[:_LISTED]:
        yield f"  {one.name}: least {doubt.objective} in {percent(one.best_share, one.count)}; {one.verdict}"
    more = len(doubt.runners_up) - _LISTED
    if more > 0:
        yield f"  ... and {more} more that {'is' if more == 1 else 'are'} best in some builds"
    never = len(doubt.designs) - 1 - len(doubt.runners_up)
    if never:
        yield f"  ... and {never} more that {'is' if never == 1 else 'are'} best in no build"
    if doubt.stated:
        yield f"  spreads stated in the study: {'; '.join(doubt.stated)}"
    if doubt.assumed:
        yield f"  spreads assumed, as the study states none: {', '.join(doubt.assumed)}"
