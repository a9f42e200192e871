"""The stiffest wall of each display, from eigenvalues, against runs in time beside it: nothing but the equations is the same."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import run_in_time, sampled_loop
from made import loaded

ARM = iv.motion.ArmModel.named("vanbeek2015")
STRUCTURES = {"as stated": None, "100 N/mm": 1e5}
SAMPLES = 8000
"""Faster modes have died away after half of these."""


def displays():
    """The cobotic display and all conventional ones, without what is not linear: counts, noise and dry friction."""
    drives = loaded("hand_controller").drives
    geared = drives["motor2-gear4"]
    for words, structure in STRUCTURES.items():
        pair = iv.displays.DisplayPair(
            cobotic=drives["cobotic"],
            conventional=geared,
            structure_stiffness=structure,
            rivals=iv.displays.usual_rivals(geared),
        )
        mass = 20.0 if structure else 1.0
        found = {"cobotic": pair.admittance(mass), **{name: pair.rival(name, mass) for name in pair.conventionals}}
        for name, display in found.items():
            dry = {"coulomb_friction": 0.0} if isinstance(display, iv.displays.ImpedanceDisplay) else {}
            yield pytest.param(replace(display, **dry), id=f"{name}, {words}")


def growth_over_time(display, wall):
    """Growth of the deflection in a sample, over the second half of a run from a handle that is let go beside rest."""
    at = replace(display, wall_stiffness=wall)
    start = np.zeros(len(at.plant(ARM).states))
    start[0] = 1e-3
    found = run_in_time(at, ARM, start, SAMPLES)
    tenths = np.max(np.abs(found.state[1:, 0]).reshape(10, -1), axis=1)
    return (tenths[9] / tenths[5]) ** (1.0 / (0.4 * SAMPLES))


@pytest.mark.parametrize("display", list(displays()))
def test_a_wall_that_is_softer_settles_and_one_that_is_stiffer_does_not(display):
    """And at the rate of the largest eigenvalue: within a tenth, as the slowest other modes have not died away yet."""
    stiffest = iv.displays.stiffest_wall(display, ARM)
    for share, settles in ((0.95, True), (1.05, False)):
        growth = growth_over_time(display, share * stiffest)
        assert (growth < 1.0) == settles
        expected = sampled_loop(replace(display, wall_stiffness=share * stiffest), ARM).growth
        assert np.log(growth) == pytest.approx(np.log(expected), rel=0.1)
