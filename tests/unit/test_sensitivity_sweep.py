"""Sobol's indices in chunks: those of `sensitivity` with as many samples."""

from dataclasses import replace

import pytest

import infinivar as iv


@pytest.fixture(scope="module")
def problem(study):
    return iv.sweeps.sensitivity_sweep(study, "motor1-gear1", "loss", samples=128, size=32)


@pytest.fixture(scope="module")
def swept(problem, tmp_path_factory):
    return iv.sweep(problem, tmp_path_factory.mktemp("swept") / "s")


def test_indices_are_those_of_sensitivity(problem, swept, study):
    found, whole = problem.result(swept), iv.sensitivity(study, "motor1-gear1", "loss", samples=128)
    assert swept.chunks == 4
    assert swept.candidates == 128 * (2 + sum(row.total is not None for row in whole.influences))
    assert found.equals(whole, rtol=1e-9, atol=1e-12)
    assert found.ranking == whole.ranking
    assert max(row.total for row in found.influences if row.total is not None) > 0.1


def test_more_samples_or_another_drive_do_not_continue_a_sweep(problem, swept):
    with pytest.raises(iv.InputError, match="samples: 128 there, 256 here"):
        iv.sweep(replace(problem, samples=256), swept.folder, resume=True)


def test_numbers_that_are_no_powers_of_two_are_refused(study):
    with pytest.raises(iv.ParameterError, match="samples must be a power of two from 16"):
        iv.sweeps.sensitivity_sweep(study, "motor1-gear1", "loss", samples=100)
