"""Every way to evaluate a Fourier series gives the sum of its waves."""

import numpy as np
import pytest

from internals import FourierSeries as Series

PERIOD = 7.3


@pytest.mark.parametrize(
    "time",
    [
        (np.arange(3000) + 0.5) * PERIOD / 3000,  # a whole cycle
        0.4 + np.arange(1500) * PERIOD / 4500,  # part of a cycle, whose steps fill one
        0.4 + np.arange(3000) * 1e-3,  # equal steps of another length, many of them
        np.sort(np.random.default_rng(1).uniform(0.0, PERIOD, 60)),
        np.array([0.3, 0.3]),
        np.array([0.3]),
        np.array([]),
        np.array(0.2),
    ],
    ids=["cycle", "part", "equal steps", "any", "twice", "one", "none", "number"],
)
def test_all_ways_give_the_sum(time):
    random = np.random.default_rng(0)
    series = Series(PERIOD, random.normal(size=400), random.normal(size=400))
    turns = 2.0 * np.pi * np.arange(400) / PERIOD
    waves = np.exp(1j * np.multiply.outer(time, turns))
    for order, found in enumerate(series.derivatives(time, 6)):
        terms = (series.cosine - 1j * series.sine) * (1j * turns) ** order
        assert found.shape == time.shape
        np.testing.assert_allclose(found, np.real(waves @ terms), atol=1e-12 * np.sum(np.abs(terms)))
