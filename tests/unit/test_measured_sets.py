"""Measured sets: the folder format, faults that are named, and laws against those of the parts."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.calibration import measured_report
from internals import (
    BACKDRIVE,
    MeasuredAt,
    heated_temperatures,
    read_measured_rows,
    read_set,
    shipped_sets,
)

SET = """
title = "Made"
bench = "no_load"
source = "made up"
licence = "CC0"
[known]
torque_constant = "50 mN m/A"
[start]
motor_friction = "8 mN m"
motor_viscous = "2e-5 N m s"
"""


def made(
    folder, toml=SET, change=lambda current, speed: (current, speed), head="speed [rad/s],current [A]", noise=0.003
):
    random = np.random.default_rng(3)
    speed = random.permutation(np.linspace(10, 200, 40))
    current = (8e-3 + 2e-5 * speed) / 0.05 + noise * random.standard_normal(speed.size)
    current, speed = change(current, speed)
    (folder / "measured.toml").write_text(toml, "utf-8")
    lines = [f"{one:.8g},{other:.8g}" for one, other in zip(speed, current, strict=True)]
    (folder / "rows.csv").write_text("\n".join([head, *lines]), "utf-8")
    return folder


def test_known_parameters_are_found_again(tmp_path):
    part = measured_report(made(tmp_path)).parts[0]
    assert part.form == "viscous"
    for name, true in (("motor_friction", 8e-3), ("motor_viscous", 2e-5)):
        low, high = part.fit.interval(name)
        assert low < true < high
    assert 0.9 <= part.residuals[0].coverage <= 1.0
    assert part.residuals[0].rms == pytest.approx(0.003, rel=0.3)


def test_a_needless_term_is_left_out(tmp_path):
    part = measured_report(made(tmp_path, change=lambda current, speed: (current - 4e-4 * speed, speed))).parts[0]
    assert part.form == "constant"


ROWS = np.arange(40)


def of_row(row, factor):
    def change(current, speed):
        current = current.copy()
        current[row] *= factor
        return current, speed

    return change


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda current, speed: (speed, current), "speed and current fit if their columns are exchanged"),
        (lambda current, speed: (1e3 * current, speed), "current fits if divided by 1000"),
        (lambda current, speed: (current, speed * 30 / np.pi), "speed fits if divided by 9.549: is it in rpm?"),
        (lambda current, speed: ((-1) ** ROWS * current, (-1) ** ROWS * speed), "current fits without its sign"),
        (lambda current, speed: (current + np.linspace(0, 0.2, 40), speed), "current drifts by 0.1"),
        (of_row(6, 1e3), "line 8: current is"),
    ],
)
def test_misread_files_are_named(tmp_path, change, said):
    found = measured_report(made(tmp_path, change=change)).faults
    assert len(found) == 1
    assert said in found[0]


def test_a_sound_file_has_no_faults(tmp_path):
    assert not measured_report(made(tmp_path)).faults


def test_celsius_under_kelvin_is_named(tmp_path):
    source = shipped_sets()["motor_heating"]
    text = (source / "rows.csv").read_text("utf-8").replace("winding [degC]", "winding [K]")
    (tmp_path / "rows.csv").write_text(text, "utf-8")
    with pytest.raises(iv.InputError, match="winding fall below 150 K"):
        measured_report("motor_heating", rows=tmp_path / "rows.csv")


def test_degrees_are_read_as_kelvin():
    table = read_measured_rows(read_set("motor_heating"))
    assert 290.0 < table.numbers["ambient"].min() < table.numbers["ambient"].max() < 300.0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('bench = "no_load"', 'bench = "noload"', "bench 'noload' is unknown.*no_load"),
        ('licence = "CC0"', "", "licence is missing"),
        ("[known]", "[knows]", "unknown key 'knows'"),
        ('torque_constant = "50 mN m/A"', "", "known.torque_constant is missing, in N m/A"),
        ('motor_friction = "8 mN m"', 'motor_friction = "8 mN"', "start"),
        ("[known]", "every = 0\n[known]", "every must be at least 1"),
        ("[known]", '[goal]\nvoltage = "1 V"\n[known]', "goal.voltage is unknown"),
    ],
)
def test_wrong_descriptions_are_refused(tmp_path, old, new, said):
    with pytest.raises(iv.InputError, match=said):
        measured_report(made(tmp_path, SET.replace(old, new)))


def test_missing_columns_and_bad_cells_are_named(tmp_path):
    with pytest.raises(iv.InputError, match="has no column current; it has speed"):
        measured_report(made(tmp_path, head="speed [rad/s],amps [A]"))
    mapped = SET.replace("[known]", '[columns]\ncurrent = "amps [A]"\n[known]')
    assert measured_report(made(tmp_path, mapped, head="speed [rad/s],amps")).sound
    file = made(tmp_path) / "rows.csv"
    file.write_text(file.read_text("utf-8") + "\n3,x", "utf-8")
    with pytest.raises(iv.InputError, match=r"line 42, column 'current"):
        measured_report(tmp_path)


def test_a_set_without_rows_says_where_they_are():
    with pytest.raises(iv.InputError, match=r"GPL-3\.0.*neurobionics2026"):
        measured_report("ak80_9_steady")


def test_further_rows_are_predicted(tmp_path):
    folder = made(tmp_path)
    (tmp_path / "more").mkdir()
    more = made(tmp_path / "more", change=lambda current, speed: (current + 0.001, speed)) / "rows.csv"
    (other,) = measured_report(folder, predict=more).parts[0].others
    assert (other.signal, other.rows) == ("current", 40)
    assert other.rms == pytest.approx(0.003, rel=0.4)


def test_friction_under_constant_current_is_that_of_a_gear():
    """The law inverted: a gear of the program needs the input torque at the output torque that the bench expects."""
    current = np.linspace(-10, 10, 21)
    for way in (1.0, -1.0):
        form = BACKDRIVE.forms["load"]
        at = MeasuredAt({"current": current, "speed": np.full(21, way)}, {}, form, np.zeros(21, int), {})
        values = {"torque_per_current": 0.8, "offset": 0.0, "friction": 0.25, "load_share": 0.04, "saturation": 0.0}
        torque = BACKDRIVE.expected(at, values, {"gain": np.zeros(21)})["torque"]
        friction = iv.parts.GearFriction(friction=0.25, load_motor=0.04, load_output=0.04)
        gear = iv.parts.Gearhead(ratio=1.0, loss_model="stribeck", friction=friction)
        point = gear.operate(output_torque=torque, output_speed=np.full(21, way), motor_rated_torque=1.0)
        assert_allclose(point.motor_torque, 0.8 * current, atol=1e-12)


def test_heating_settles_where_heat_balances():
    """After many time constants at constant power: resistances alone give the temperatures."""
    time = np.arange(0.0, 40_000.0, 10.0)
    history = {"time": time, "power": np.full(time.size, 100.0), "ambient": np.full(time.size, 300.0)}
    start = {"winding": np.full(time.size, 300.0), "body": np.full(time.size, 300.0)}
    found = heated_temperatures(
        {**history, **start},
        winding_capacity=100.0,
        body_capacity=800.0,
        inner=0.1,
        outer=2.0,
        body_lag=20.0,
        body_power=30.0,
    )
    assert_allclose(found["body"][-1], 300.0 + 2.0 * 100.0, rtol=1e-6)
    assert_allclose(found["winding"][-1], 500.0 + 0.1 * 70.0, rtol=1e-6)
