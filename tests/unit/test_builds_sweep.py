"""Samples of a drive in chunks: those that `compare` draws."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import draw_samples as draw
from internals import low_discrepancy

SLIDE = """
title = "Slide"
[requirement]
force = "131 N"
speed = "0.3 m/s"
power = "20 W"
[drives.geared]
type = "conventional"
motor = { part = "dcx-32-l-24v" }
gearhead = { part = "gpx-32-up-16", loss_model = "coulomb" }
pulley = { radius = "12 mm" }
[duty.shake]
shape = "sinusoid"
distance = "50 mm"
frequency = "1.4 Hz"
load_mass = "1 kg"
[uncertainty]
draws = 128
[uncertainty.geared.motor]
resistance = "5 %"
torque_constant = { deviation = "2 %" }
[uncertainty.geared.gearhead]
efficiency = "4 %"
[[correlations]]
drive = "geared"
between = ["motor.resistance", "motor.torque_constant"]
value = 0.5
"""


@pytest.fixture(scope="module")
def slide(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "slide.toml"
    path.write_text(SLIDE, "utf-8")
    return iv.load_study(path)


@pytest.fixture(scope="module")
def swept(slide, tmp_path_factory):
    problem = iv.sweeps.builds_sweep(slide, draws=128, size=32)
    return problem, iv.sweep(problem, tmp_path_factory.mktemp("swept") / "s")


@pytest.mark.parametrize("start", [1, 16, 32, 48])
def test_a_part_of_the_sequence_is_that_of_the_whole(start):
    whole = low_discrepancy(64, 5, seed=3)
    np.testing.assert_array_equal(low_discrepancy(16, 5, seed=3, start=start), whole[start : start + 16])


@pytest.mark.slow
def test_samples_and_results_are_those_of_compare(slide, swept):
    problem, found = swept
    mine, whole = problem.result(found), iv.compare(slide).builds["geared"]
    assert found.chunks == 4
    assert mine.spreads == whole.spreads
    for name in ("values", "coverage", "margin", "loss"):
        np.testing.assert_allclose(getattr(mine, name), getattr(whole, name), rtol=1e-13)
    assert mine.equals(whole, rtol=1e-9, atol=1e-12)
    assert mine.verdict == whole.verdict
    assert mine.map.within.min() < mine.map.within.max() == 1.0
    assert 0.0 < mine.covering < 1.0
    assert np.ptp(mine.duty["shake"].energy) > 0.0


@pytest.mark.slow
def test_what_is_kept_can_be_read_without_the_study(slide, swept):
    _, found = swept
    rows = iv.load_sweep(found.folder).rows
    spreads = slide.uncertainty.spreads["geared"]
    expected = draw(spreads, slide.uncertainty.correlation("geared"), 128)
    for place, spread in enumerate(spreads):
        np.testing.assert_allclose(rows[f"value: {spread.path}"], expected[:, place], rtol=1e-13)
    np.testing.assert_array_equal(rows["draw"], np.arange(128))


def test_more_draws_or_other_spreads_do_not_continue_a_sweep(slide, swept):
    problem, found = swept
    for other, message in (
        (replace(problem, draws=256), "draws: 128 there, 256 here"),
        (replace(problem, study=replace(slide, requirement=None)), "requirement: the content differs"),
    ):
        with pytest.raises(iv.InputError, match=message):
            iv.sweep(other, found.folder, resume=True)


def test_what_cannot_be_sampled_is_refused(slide, study):
    with pytest.raises(iv.InputError, match="the study states no spreads"):
        iv.sweeps.builds_sweep(replace(slide, uncertainty=iv.Uncertainty()))
    with pytest.raises(iv.InputError, match=r"draws must be a power of two from 16 to \d+, got 100"):
        iv.sweeps.builds_sweep(slide, draws=100)
    with pytest.raises(iv.InputError, match="the study has no drive 'gear'"):
        iv.sweeps.builds_sweep(slide, "gear")
