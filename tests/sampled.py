"""Families of cases and examples: a spread of them every day, more in CI, and all before a release."""

from collections.abc import Iterable

import hypothesis
import pytest

MOST = 40
"""Examples of a property in CI; the everyday profile has fewer, and counts of single properties go with it."""


def sampled(names: str | tuple[str, ...], cases: Iterable, *, every: int | None = None, slow: int = 1, **options):
    """`pytest.mark.parametrize` whose cases 0, `every`, 2 `every`, ... run every day, or none without `every`.

    Of the others each `slow`-th, from the first on, is a slow test, which CI runs; the rest runs before a release.
    """
    several = not isinstance(names, str) or "," in names
    return pytest.mark.parametrize(names, spread(cases, every=every, slow=slow, several=several), **options)


def spread(cases: Iterable, *, every: int | None = None, slow: int = 1, several: bool = False) -> list:
    """The cases of `sampled`, for the parameters of a fixture."""
    given, left = [], 0
    for place, case in enumerate(cases):
        if every is None or place % every:
            case = _marked(case, several, pytest.mark.full if left % slow else pytest.mark.slow)
            left += 1
        given.append(case)
    return given


def _marked(case, several: bool, mark):
    if hasattr(case, "marks"):
        return pytest.param(*case.values, marks=[*case.marks, mark], id=case.id)
    return pytest.param(*(case if several else (case,)), marks=mark)


def examples(count: int) -> hypothesis.settings:
    """Settings of a property with so many examples in CI, and every day the share that the profile has."""
    return hypothesis.settings(max_examples=max(2, count * hypothesis.settings.default.max_examples // MOST))
