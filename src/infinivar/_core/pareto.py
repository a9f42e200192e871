"""The front of designs with two values of which less is better."""

from __future__ import annotations

import numpy as np

APART = 0.97
"""Mass of a design that is listed over that of the one before, at most."""


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


def spread_front(mass: np.ndarray, power: np.ndarray) -> np.ndarray:
    """Places of the front that are listed: the first, the lightest, and those between that are `APART`. (k,) int"""
    every = front(mass, power)
    kept = every[:1].tolist()
    for place in every[1:]:
        if mass[place] < mass[kept[-1]] * (1.0 if place == every[-1] else APART):
            kept.append(place)
    return np.array(kept, dtype=int)
