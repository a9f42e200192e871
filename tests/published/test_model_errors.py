"""Default spreads: the shipped file against measurements, the same numbers by SciPy alone, and what they do to verdicts."""

import csv
import math
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import curve_fit

import infinivar as iv
from internals import default_spread_rules, default_spreads, shipped_sets
from measured import gear_laws, model_errors, motor_map, verdicts, wanted


def test_the_shipped_file_is_what_the_measurements_give():
    assert model_errors.FILE.read_text("utf-8") == model_errors.text()
    names = {"resistance", "no_load_current", "winding_to_housing", "housing_time_constant", "efficiency", "thread"}
    assert set(tomllib.loads(model_errors.text())) == names


@pytest.mark.source("duclusaud2025")
def test_gear_loss_by_the_mean_friction():
    """The Coulomb law leaves the standard deviation of the friction about its mean: one line of NumPy for each actuator."""
    shares = []
    for key in gear_laws.actuators():
        friction = gear_laws.compare(key).friction
        shares.append(np.var(friction) / np.mean(friction**2))
    assert model_errors.gear_loss("coulomb") == pytest.approx(math.sqrt(np.mean(shares)), rel=1e-9)


@pytest.mark.source("parsons2019")
def test_resistance_by_a_fit_of_the_input_power():
    """Another fit (of the power, not of the efficiency) and another noise (third differences along each load): within 30 %."""
    data = motor_map.published()
    used = data.loaded

    def power(x, per_torque, friction):
        speed, torque = x
        return torque * speed + per_torque * (torque + friction) ** 2 + friction * speed

    x = np.array([data.speed[used], data.torque[used]])
    (per_torque, friction), _ = curve_fit(power, x, data.power_in[used], p0=[50.0, 0.05])
    off = data.power_in[used] - power(x, per_torque, friction)
    squares = []
    for row in range(1, 9):
        line = off[data.row[used] == row][np.argsort(data.speed[used][data.row[used] == row])]
        squares.append((line[:-3] - 3 * line[1:-2] + 3 * line[2:-1] - line[3:]) ** 2 / 20.0)
    left = np.mean(off**2) - np.mean(np.concatenate(squares))
    copper = per_torque * (x[1] + friction) ** 2
    assert model_errors.resistance() == pytest.approx(math.sqrt(left / np.mean(copper**2)), rel=0.3)


def shipped_rows(name):
    with (shipped_sets()[name] / "rows.csv").open(encoding="utf-8") as opened:
        return list(csv.DictReader(opened))


def share_left(of, by):
    """Share that is left by least squares on some columns."""
    return math.sqrt(np.mean((of - by @ np.linalg.lstsq(by, of, rcond=None)[0]) ** 2) / np.mean(of**2))


@pytest.mark.source("robotino2026")
def test_no_load_current_by_linear_least_squares():
    read = shipped_rows("robot_motors")
    speed, current = (np.array([float(row[name]) for row in read]) for name in ("speed [rad/s]", "current [A]"))
    one = np.ones_like(speed)
    assert model_errors.no_load("constant") == pytest.approx(share_left(current, one[:, None]), rel=1e-3)
    assert model_errors.no_load("viscous") == pytest.approx(share_left(current, np.c_[one, np.abs(speed)]), rel=1e-3)


@pytest.mark.source("mablekos2021")
def test_friction_of_screws_by_linear_least_squares():
    shares = []
    for drive in ("lead screw", "lead screw antibacklash", "worm"):
        mine = [row for row in shipped_rows("screws_and_worm") if row["drive"] == drive]
        way, torque = (np.array([float(row[name]) for row in mine]) for name in ("direction [1]", "torque [mN m]"))
        shares.append(share_left(torque, np.c_[np.ones_like(way), way]))
    # The program compares forms without the one row that one of them leaves out.
    assert model_errors.thread() == pytest.approx(math.sqrt(np.mean(np.square(shares))), rel=0.02)


MOTOR = {"voltage": "24 V", "resistance": "1 ohm", "torque_constant": "30 mN m/A", "continuous_torque": "0.1 N m"}
HOT = {
    "winding_to_housing": "3 K/W",
    "housing_to_ambient": "9 K/W",
    "winding_time_constant": "20 s",
    "housing_time_constant": "500 s",
    "max_winding_temperature": "155 degC",
}


@pytest.mark.parametrize(
    ("motor", "screw", "paths"),
    [
        ({}, {"friction_coefficient": 0.15}, ["motor.no_load_current", "screw.friction_coefficient"]),
        (
            {"viscous_friction": "0.1 uN m s"},
            {"friction_angle": "8 deg"},
            ["motor.no_load_current", "screw.friction_angle"],
        ),
        (
            HOT,
            {"shape": "ball", "friction_angle": "1 deg"},
            ["motor.housing_time_constant", "motor.winding_to_housing"],
        ),
    ],
)
def test_defaults_of_heating_no_load_current_and_screws(motor, screw, paths):
    """Each with the size of its model; a ball screw, whose friction rolls, has none."""
    motor = {**MOTOR, "no_load_current": "0.1 A", **motor}
    screw = {"lead": "2 mm", "diameter": "11 mm", **screw}
    slide = {"type": "conventional", "output_inertia": "0.02 g m^2", "motor": motor, "screw": screw}
    duty = {"shake": {"shape": "sinusoid", "distance": "20 mm", "frequency": "1 Hz", "load_mass": "1 kg"}}
    tables = {"drives": {"slide": {**slide, "gearhead": {"ratio": 5, "efficiency": 1.0}}}, "duty": duty}
    made = iv.Study.from_dict(tables, name="slide")
    rules = default_spread_rules()
    law = f"no_load_current.{'viscous' if 'viscous_friction' in motor else 'constant'}"
    spreads = {one.path: one for one in default_spreads("slide", made.drives["slide"])}
    assert {*paths} <= {*spreads}
    assert any(path.startswith("screw.") for path in spreads) == (screw.get("shape") != "ball")
    for path, one in spreads.items():
        rule = rules.get({"motor.no_load_current": law}.get(path, "thread" if "screw." in path else path.split(".")[1]))
        assert one.where == rule.where
        if rule.source:
            assert one.deviation == pytest.approx(rule.size * one.value)


def test_every_default_has_a_source_or_says_that_it_is_assumed():
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text("utf-8")
    for rule in default_spread_rules().values():
        assert (rule.source and f"`{rule.source}`" in page) or rule.where.startswith("assumed")


def test_a_stated_spread_comes_before_the_default():
    study = iv.load_study("reach_and_hold")
    whole = iv.compare(study.with_drives("geared"), default_spreads=True)
    varied = {one.path: one for one in whole.builds["geared"].spreads}
    assert set(varied) == {one.path for one in default_spreads("geared", study.drives["geared"])}
    stated = iv.Study.from_dict(
        {
            "drives": {
                "geared": {
                    "type": "conventional",
                    "output_inertia": "0.02 g m^2",
                    "motor": {"part": "dcx-32-l-24v"},
                    "gearhead": {"part": "gpx-32-up-16", "loss_model": "proportional"},
                    "pulley": {"radius": "8 mm"},
                }
            },
            "duty": {"shake": {"shape": "sinusoid", "distance": "60 mm", "frequency": "3 Hz", "load_mass": "1 kg"}},
            "uncertainty": {"draws": 64, "geared": {"gearhead": {"efficiency": "2 %"}}},
        },
        name="slide",
    )
    assert [one.path for one in iv.compare(stated).builds["geared"].spreads] == ["gearhead.efficiency"]
    found = iv.compare(stated, default_spreads=True).builds["geared"]
    by = {one.path: one for one in found.spreads}
    assert by["gearhead.efficiency"].deviation is None
    assert by["motor.resistance"].kind == "derived"
    assert iv.compare(stated.with_drives("geared"), default_spreads=True, quick=True).builds == {}


@pytest.mark.slow
@pytest.mark.parametrize("study", verdicts.STUDIES)
def test_verdicts_of_shipped_studies_are_those_of_the_page(study):
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text("utf-8")
    before, now = verdicts.compared(study)
    for line in verdicts.lines(study):
        assert line in page
    assert [before.best is one for one in before.results.values()] == [now.best is one for one in now.results.values()]
    for found, sizes in ((before, verdicts.ROUND), (now, None)):
        one = next(spread for spread in next(iter(found.builds.values())).spreads if spread.path == "motor.resistance")
        assert (one.high / one.value - 1.0 == pytest.approx(sizes["resistance"])) if sizes else one.deviation > 0.0


@pytest.mark.slow
def test_which_drive_needs_less_energy_in_how_many_pairs_of_builds():
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text("utf-8")
    before, now = verdicts.wins("knee_walking", "cobotic", "geared")
    assert f"in {100 * now:.0f} % of pairs (round numbers: {100 * before:.0f} %)" in " ".join(page.split())
    assert f"in {100 * verdicts.wins('reach_and_hold', 'geared', 'cobotic-b')[1]:.2f} % of pairs" in page


@pytest.mark.slow
def test_the_sheet_for_the_rig_is_computed():
    """Its lines are on the page, and the rig reaches what each quantity needs."""
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text("utf-8")
    for line in wanted.lines():
        assert line in page
    found = wanted.sheet()
    assert f"after {found.runs} runs" in page
    assert (math.degrees(found.settings[0]), found.settings[2]) == pytest.approx((45.0, 650.0))
    rows = {row.name: row for row in found.rows}
    assert min(rows.values(), key=lambda row: row.needed).name == "nominal_torque"
    assert all(row.reached < row.needed for row in rows.values())


def test_the_sheet_for_other_benches_is_computed():
    """Its lines are on the page; the loss of a gear counts for the energy, and must be known better than its default spread."""
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text("utf-8")
    lines = list(wanted.part_lines())
    assert all(line in page for line in lines)
    study = iv.load_study("knee_walking")
    drive = study.drives["geared"]
    energy = {
        loss: iv.duty_cycle(
            replace(drive, gearhead=replace(drive.gearhead, efficiency=1.0 - loss)), study.duty["walking"]
        ).energy
        for loss in (0.0665, 0.07, 0.0735)
    }
    slope = (energy[0.0735] - energy[0.0665]) / (0.1 * energy[0.07])
    row = next(line for line in lines if "| geared | 1 - `gearhead.efficiency`" in line)
    assert float(row.split(" | ")[4]) == pytest.approx(slope, rel=0.05)
    assert 0.01 / slope < default_spread_rules()[f"efficiency.{drive.gearhead.loss_model}"].size
