"""Default spreads: the shipped file against measurements, the same numbers by SciPy alone, and what they do to verdicts."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import curve_fit

import infinivar as iv
from internals import default_spread_rules, default_spreads
from measured import gear_laws, model_errors, motor_map, wanted


def test_the_shipped_file_is_what_the_measurements_give():
    assert model_errors.FILE.read_text("utf-8") == model_errors.text()
    assert set(tomllib.loads(model_errors.text())) == {"resistance", "efficiency"}


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


SHARES = {"cobotic": 0.70, "geared": 1.0}
"""Share of builds of the knee's drives that cover the requirement, as docs/measurements.md states."""


@pytest.mark.slow
def test_verdicts_on_the_knee_are_those_of_the_page():
    """With uniform round numbers both drives covered it in every build; pairs of independent builds are a draw."""
    found = iv.compare(iv.load_study("knee_walking"), default_spreads=True)
    assert {name: round(one.covering, 2) for name, one in found.builds.items()} == SHARES
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text("utf-8")
    duty = {name: one.duty["walking"] for name, one in found.builds.items()}
    for name, one in duty.items():
        low, high = np.quantile(one.energy, [0.05, 0.95])
        assert f"{low:.2f} to {high:.2f} J" in next(
            line for line in page.splitlines() if f"| knee_walking, {name} " in line
        )
    wins = np.mean(duty["cobotic"].energy[:, None] < duty["geared"].energy[None, :])
    assert f"{100 * wins:.0f} % of pairs" in page


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
