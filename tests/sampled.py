"""Families of cases and examples: all in the slow tests, a spread of them every day."""

from collections.abc import Iterable

import hypothesis
import pytest

MOST = 40
"""Examples of a property in CI; the everyday profile has fewer, and counts of single properties go with it."""


def sampled(names: str | tuple[str, ...], cases: Iterable, *, every: int, **options):
    """`pytest.mark.parametrize` whose cases 0, `every`, 2 `every`, ... run every day; the others are slow."""
    several = not isinstance(names, str) or "," in names
    given = [case if place % every == 0 else _slow(case, several) for place, case in enumerate(cases)]
    return pytest.mark.parametrize(names, given, **options)


def _slow(case, several: bool):
    if hasattr(case, "marks"):
        return pytest.param(*case.values, marks=[*case.marks, pytest.mark.slow], id=case.id)
    return pytest.param(*(case if several else (case,)), marks=pytest.mark.slow)


def examples(count: int) -> hypothesis.settings:
    """Settings of a property with so many examples in CI, and every day the share that the profile has."""
    return hypothesis.settings(max_examples=max(2, count * hypothesis.settings.default.max_examples // MOST))
