"""Sensitivities of all shipped drives, and of drives with every kind of part, against differences."""

from dataclasses import replace

import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from all_part_kinds import DRIVES, JOINT, LINE, REGIONS, one_axis_studies
from internals import OUTCOME_KINDS as KINDS
from internals import value_at, varied
from sampled import sampled


def _shipped(long):
    """Every drive of every shipped study with every outcome: those that take long or not.

    Those of cobotic drives over a region or cycle take seconds, of the ankle's over its cycle minutes.
    """
    for name, study in one_axis_studies():
        for drive, made in study.drives.items():
            for kind in KINDS:
                if long is (isinstance(made, iv.CoboticDrive) and kind not in ("efficiency", "loss")):
                    yield pytest.param(name, drive, kind, id=f"{name}-{drive}-{kind}")


def _check(study, name, kind, method="complex", count=3):
    """Elasticities of the strongest parameters against a step so small that the outcome is smooth across it."""
    found = iv.sensitivity(study, name, kind, samples=0, method=method)
    drive, of = study.drives[name], found.outcome.of
    inside = [
        row for row in found.influences if row.low < row.value < row.high and not row.path.endswith("teeth")
    ]  # not at a bound, nor a whole number
    chosen = sorted(inside, key=lambda row: -abs(row.elasticity))[:count]
    assert chosen or kind == "coverage"
    for row in chosen:
        value, step = value_at(drive, row.path), 1e-5
        ends = [float(of(varied(drive, {row.path: value * (1.0 + way * step)}))) for way in (1.0, -1.0)]
        assert_allclose(row.elasticity, (ends[0] - ends[1]) / (2.0 * step * found.value), rtol=1e-4, atol=1e-6)


@sampled(("study", "drive", "kind"), _shipped(long=False), every=12, slow=8)
def test_every_outcome_of_every_shipped_drive(study, drive, kind):
    _check_shipped(study, drive, kind)


@sampled(("study", "drive", "kind"), _shipped(long=True), slow=9)
def test_every_outcome_that_takes_long(study, drive, kind):
    _check_shipped(study, drive, kind)


def _check_shipped(study, drive, kind):
    loaded = iv.load_study(study)
    if loaded.requirement is None:
        loaded = replace(loaded, requirement=REGIONS[loaded.axis.rotary])
    if not loaded.duty:
        loaded = replace(loaded, duty={"cycle": JOINT if loaded.axis.rotary else LINE})
    _check(loaded, drive, kind)


def _own_study(drive):
    rotary = drive.axis.rotary
    return iv.Study(
        name="parts", requirement=REGIONS[rotary], drives={"g": drive}, duty={"d": JOINT if rotary else LINE}
    )


@sampled("kind", ["loss", "coverage", "energy"], every=3, slow=2)
@pytest.mark.parametrize("name", DRIVES)
def test_every_part_carries_derivatives(name, kind):
    _check(_own_study(DRIVES[name]), "g", kind, count=5)


@sampled("name", ["crank", "four-bar", "table"], slow=3)
def test_linkages_go_through_jax(name):
    pytest.importorskip("jax")
    _check(_own_study(DRIVES[name]), "g", "energy", method="jax")
