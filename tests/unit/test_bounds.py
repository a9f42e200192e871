"""Bounds of fields: in words, as a test of numbers and arrays, and as ends of a range."""

import math

import numpy as np
import pytest
from annotated_types import Ge, Gt, Interval, Le, Lt

from infinivar import ParameterError
from internals import FINITE, QUARTER_TURN, NonZero, check_value
from internals import bounds_in_words as words
from internals import fits_bounds as fits
from internals import permitted_bounds as permitted
from internals import within_bounds as within


@pytest.mark.parametrize(
    ("bound", "said", "inside", "outside"),
    [
        (Gt(0), "> 0", [1e-300, 5], [0.0, -1.0]),
        (Ge(0), ">= 0", [0, 2.0], [-1e-300]),
        (Lt(3), "< 3", [2.9], [3.0]),
        (Le(3), "<= 3", [3.0], [3.1]),
        (Interval(gt=0, le=1), "> 0 and <= 1", [1.0, 0.1], [0.0, 1.0 + 1e-15]),
        (Interval(ge=0, le=0.5), ">= 0 and <= 0.5", [0.0, 0.5], [0.6, -0.1]),
        (Interval(gt=0, le=1e-3), "> 0 and <= 1e-3", [1e-3], [2e-3]),
        (Interval(gt=0, le=QUARTER_TURN), "> 0 and <= pi/2", [math.pi / 2, 0.1], [1.571]),
        (NonZero(), "!= 0", [-1.0, 1e-9], [0.0]),
        (FINITE, "finite", [-1e300, 0.0], []),
    ],
)
def test_words_and_numbers_agree(bound, said, inside, outside):
    assert words(bound) == said
    assert all(fits(bound, value) for value in inside)
    assert not any(fits(bound, value) for value in [*outside, math.inf, -math.inf, math.nan])
    assert within(bound, np.array([*inside, *outside])).tolist() == [True] * len(inside) + [False] * len(outside)
    for value in inside:
        low, high = permitted(bound, value)
        assert low <= value <= high
        assert all(end in (-math.inf, math.inf) or fits(bound, end) for end in (low, high))


def test_message_names_field_value_and_unit():
    with pytest.raises(ParameterError, match=r"^resistance must be > 0 ohm, got -2\.14$"):
        check_value("resistance", -2.14, "ohm", Gt(0))
    with pytest.raises(ParameterError, match=r"^efficiency must be > 0 and <= 1, got \[1\.2\]$"):
        check_value("efficiency", np.array([0.5, 1.2]), "1", Interval(gt=0, le=1))
