"""Recordings that may be misread: what is in doubt is refused or said, never guessed."""

import numpy as np
import pytest

import infinivar as iv
from infinivar import InputError, ParameterError

TIME = np.linspace(0.0, 1.0, 101)
WAVE = np.sin(2.0 * np.pi * TIME)


def table(path, headings, *columns):
    """A file with the given headings and columns."""
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=headings, comments="", fmt="%.6f")
    return path


@pytest.mark.parametrize(
    "heading", ["ankle_moment_Nm/kg", "ankle moment Nm/kg", "Ankle moment per kg", "ankle_moment_kg"]
)
def test_a_moment_per_kilogram_by_its_name_is_not_read_as_another(tmp_path, heading):
    """Advice, followed to the letter, leads to a moment per kilogram, which needs a body mass."""
    for unit in ("", " [N m]"):
        file = table(tmp_path / "gait.csv", f"%GC,ankle_angle_deg,{heading}{unit}", 100.0 * TIME, WAVE, WAVE)
        with pytest.raises(InputError, match="kg"):
            iv.read_table(file)
    columns = {"phase": "%GC", "angle": "ankle_angle_deg", "moment": f"{heading} [N m]"}
    file = table(tmp_path / "gait.csv", f"%GC,ankle_angle_deg,{heading}", 100.0 * TIME, WAVE, WAVE)
    with pytest.raises(InputError, match="kg"):
        iv.read_table(file, columns=columns)
    if "/kg" not in heading or " " in heading:
        columns["moment"] = f"{heading} [N m/kg]"
    else:
        columns["moment"] = heading
    found = iv.read_table(file, columns=columns, body_mass=75.0).columns["moment"].values
    np.testing.assert_allclose(found, 75.0 * WAVE, atol=1e-4)


@pytest.mark.parametrize("mass", [0.0, -75.0, float("nan")])
def test_a_body_mass_is_positive(tmp_path, mass):
    file = table(tmp_path / "gait.csv", "%GC,ankle_angle_deg,ankle_moment_Nm/kg", 100.0 * TIME, WAVE, WAVE)
    with pytest.raises(ParameterError, match="body_mass must be > 0 kg"):
        iv.read_table(file, body_mass=mass)


def test_percent_of_the_gait_cycle_keeps_its_sign(tmp_path):
    file = table(tmp_path / "gait.csv", "%GC,ankle_angle_deg", 100.0 * TIME, WAVE)
    assert iv.read_table(file).columns["phase"].heading == "%GC"
    mapped = iv.read_table(file, columns={"phase": "%GC", "angle": "ankle_angle_deg"})
    np.testing.assert_allclose(mapped.columns["phase"].values, TIME, atol=1e-7)


def test_a_sign_reversed_twice_over_is_said_once(tmp_path):
    file = table(tmp_path / "log.csv", "Time / s,POSITION_MM", TIME, WAVE)
    found = iv.read_table(file, flip=("position", "position"))
    assert found.remarks == ("sign of the position reversed",)
    np.testing.assert_allclose(found.columns["position"].values, -1e-3 * WAVE, atol=1e-9)
