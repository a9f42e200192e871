"""The front of designs with two values of which less is better."""

from __future__ import annotations

import numpy as np


def front(mass: np.ndarray, power: np.ndarray) -> np.ndarray:
    """Places of the values of which no other is lower in both, or in one and equal in the other, by power. (k,) int"""
    order = np.lexsort((mass, power))
    light = mass[order]
    # Of equal powers the first is the lightest; an equal pair of values is no better.
    before = np.concatenate([[np.inf], np.minimum.accumulate(light)[:-1]])[: len(light)]
    kept = order[light < before]
    same = np.isin(mass + 1j * power, (mass + 1j * power)[kept])
    places = np.flatnonzero(same)
    return places[np.lexsort((places, power[places]))]
