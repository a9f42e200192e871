"""The shipped measured sets: fits of the program against a few lines of SciPy on the same rows, goals, and rows left out."""

import csv
import functools
import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

import infinivar as iv
from infinivar.calibration import measured_report
from internals import read_set, shipped_sets
from internals import rows_of_measured as table_rows

REFERENCE = Path(os.environ.get("INFINIVAR_REFERENCE") or Path(__file__).parents[3] / "shared" / "reference")
needs_rows = pytest.mark.skipif(not REFERENCE.is_dir(), reason="needs the rows under the GPL")


@functools.cache
def report(name):
    gpl = REFERENCE / f"actuator_{name}.csv"
    return measured_report(name, rows=gpl if name.startswith("ak80") else None)


@functools.cache
def rows(file):
    """Columns of a CSV file by the word before the unit."""
    with Path(file).open(encoding="utf-8") as opened:
        read = list(csv.DictReader(opened))
    found = {}
    for heading in read[0]:
        texts = [row[heading] for row in read]
        try:
            found[heading.split(" ")[0]] = np.array([float(text) if text else np.nan for text in texts])
        except ValueError:
            found[heading.split(" ")[0]] = np.array(texts)
    return found


def shipped(name):
    return rows(shipped_sets()[name] / "rows.csv")


def part(name, word=""):
    return next(one for one in report(name).parts if one.name == word)


def agrees(found, expected):
    """The other fit's values lie in the program's 95 % intervals."""
    for name, value in expected.items():
        low, high = found.fit.interval(name)
        assert low <= value <= high, (name, value, low, high)


def solved(residual, start):
    return least_squares(residual, start, x_scale=np.maximum(np.abs(start), 1e-9)).x


@pytest.mark.parametrize("motor", ["1", "2", "3"])
def test_no_load_current_is_a_line(motor):
    data = shipped("robot_motors")
    mine = data["motor"] == float(motor)
    line = np.polyfit(np.abs(data["speed"][mine]), data["current"][mine], 1)
    found = part("robot_motors", motor)
    agrees(found, {"motor_friction": 0.0514 * line[1], "motor_viscous": 0.0514 * line[0]})
    off = data["current"][mine] - np.polyval(line, np.abs(data["speed"][mine]))
    assert_allclose(found.residuals[0].rms, np.sqrt(np.mean(off**2)), rtol=1e-6)


@pytest.mark.parametrize(("drive", "stribeck"), [("lead screw", 2), ("lead screw antibacklash", 0), ("worm", 2)])
def test_friction_of_screws(drive, stribeck):
    data = shipped("screws_and_worm")
    mine = data["drive"] == drive
    speed, way, torque = data["speed"][mine], data["direction"][mine], 1e-3 * data["torque"][mine]

    def residual(x):
        slow = np.exp(-speed / x[4]) if stribeck else 0.0
        return 1e3 * (x[0] + x[1] * speed + x[2] * way + slow * (x[3] + way * x[5]) - torque)

    names = ["friction", "viscous", "load", "friction_stribeck", "stribeck_speed", "load_stribeck"]
    found = dict(zip(names, solved(residual, np.array([2e-3, 3e-5, 3e-4, 3e-4, 1.0, 1e-4])), strict=True))
    agrees(part("screws_and_worm", drive), {name: found[name] for name in part("screws_and_worm", drive).fit.names})


def test_waves_of_a_strain_wave_gear():
    data = shipped("strain_wave_turn")
    angle, way = np.radians(data["rotor_angle"]), data["direction"]
    waves = {"mean": np.ones_like(angle), "mean_detent": way}
    for count in range(1, 5):
        waves |= {f"cos{count}": np.cos(count * angle), f"sin{count}": np.sin(count * angle)}
    for count in range(1, 3):
        waves |= {f"detent_cos{count}": way * np.cos(count * angle), f"detent_sin{count}": way * np.sin(count * angle)}
    found = np.linalg.lstsq(np.stack(list(waves.values()), axis=1), data["torque"], rcond=None)[0]
    agrees(part("strain_wave_turn"), dict(zip(waves, found, strict=True)))


def test_heating_by_an_integrator():
    """Day 1 with the fitted parameters, by an adaptive integrator at power interpolated between samples: within 0.1 K."""
    one = part("motor_heating", "1")
    values = {**one.rows.known(), **one.fit.values}
    offsets = one.fit.unknowns[len(one.fit.names) :] * 4.0
    data = shipped("motor_heating")
    names = sorted(set(data["run"][data["day"] == 1].astype(int).astype(str)))
    for place, name in enumerate(names):
        mine = data["run"] == float(name)
        time, power = data["time"][mine], data["power"][mine]
        read = {key: data[key][mine] for key in ("winding", "body", "ambient")}

        def slope(now, state, time=time, power=power, read=read, offset=offsets[place]):
            winding, body, shown, felt = state
            whole = np.interp(now - offset, time, power)
            aside = min(whole, values["body_power"])
            flow, ambient = (winding - body) / values["inner"], np.interp(now, time, read["ambient"])
            return [
                (whole - aside - flow) / values["winding_capacity"],
                (aside + flow - (body - ambient) / values["outer"]) / values["body_capacity"],
                (winding - shown) / values["winding_lag"],
                (body - felt) / values["body_lag"],
            ]

        begin = [read["winding"][:4].mean(), read["body"][:4].mean()] * 2
        along = solve_ivp(slope, time[[0, -1]], begin, t_eval=time, max_step=0.5, rtol=1e-6).y[2:]
        used = one.rows.run == place
        at = np.searchsorted(time, one.rows.known_columns["time"][used])
        assert_allclose(one.expected[used] - 273.15, along.T[at], atol=0.1)


def stepped(read, values, offset):
    """Temperatures that sensors on winding and body read, by Euler's steps of a second."""
    time, ambient = read["time"], read["ambient"]
    power = np.interp(time - offset, time, read["power"])
    winding, body = shown, felt = read["winding"][:4].mean(), read["body"][:4].mean()
    found = [(shown, felt)]
    for now, step in enumerate(np.diff(time), 1):
        aside, flow = min(power[now], values["body_power"]), (winding - body) / values["inner"]
        winding += step * (power[now] - aside - flow) / values["winding_capacity"]
        body += step * (aside + flow - (body - ambient[now]) / values["outer"]) / values["body_capacity"]
        shown = winding + (shown - winding) * math.exp(-step / values["winding_lag"])
        felt = body + (felt - body) * math.exp(-step / values["body_lag"])
        found.append((shown, felt))
    return np.array(found)


@pytest.mark.parametrize("day", [pytest.param("1", marks=pytest.mark.slow), "2"])
def test_heating_by_least_squares(day):
    """The whole fit repeated: what a day identifies lies in its intervals, and about as much is left."""
    found, data = part("motor_heating", day), shipped("motor_heating")
    mine = data["day"] == float(day)
    reads = [{name: data[name][mine & (data["run"] == run)] for name in data} for run in np.unique(data["run"][mine])]
    without = {"body_power": 0.0, "winding_lag": 1e-9, "body_lag": 1e-9}
    sizes = np.array([found.fit.problem.known[name] for name in found.fit.names])

    def residual(x):
        values = {**without, **dict(zip(found.fit.names, sizes * np.exp(x[len(reads) :]), strict=True))}
        off = [
            (stepped(read, values, 4.0 * x[place])[::20] - np.c_[read["winding"], read["body"]][::20]).ravel()
            for place, read in enumerate(reads)
        ]
        # The offset is known to 4 s, and a temperature to the residual.
        return np.concatenate([*off, 1.5 * x[: len(reads)]])

    x = least_squares(residual, np.zeros(len(reads) + len(sizes)), diff_step=1e-4, max_nfev=60).x
    values = dict(zip(found.fit.names, sizes * np.exp(x[len(reads) :]), strict=True))
    agrees(found, {name: values[name] for name in found.fit.identifiable})
    assert np.sqrt(np.mean(residual(x)[: -len(reads)] ** 2)) == pytest.approx(
        np.sqrt(np.mean([one.rms**2 for one in found.residuals])), rel=0.05
    )


@pytest.mark.parametrize("surface", ["brown", "gray", "green", "table"])
def test_creep_of_omni_wheels(surface):
    """Vermeulen and Johnson's law, the linear one, or exact rolling interpolated in curves of another program.

    Where the growth with load is not identified, forces agree within a third of the residual.
    """
    data = shipped("omni_wheels")
    mine = data["surface"] == surface
    creepage, load, along, across, force = (
        data[name][mine] for name in ("creepage", "load", "along", "across", "force")
    )
    found = part("omni_wheels", surface)
    if "exact" in found.form and not REFERENCE.is_dir():
        pytest.skip("needs the curves of exact rolling")

    def law(k):
        if "exact" in found.form:
            curve = rows(REFERENCE / "creep_lateral.csv")
            round_patch = curve["a_over_b"] == 1.0
            return np.interp(k, curve["k"][round_patch], curve["fy"][round_patch])
        return 1.0 - (1.0 - np.minimum(k, 1.0)) ** 3

    def expected(x):
        creep, most = x[0] * (load / 40.0) ** x[1] * creepage, abs(x[2]) * load
        creep = creep if found.form.startswith("linear") else most * law(creep / (3.0 * most))
        return creep + x[3] * along - (x[4] * across if "rollers" in found.form else 0.0)

    x = solved(lambda x: expected(x) - force, np.array([50.0, 0.1, 0.5, 2.0, 0.5]))
    if "exponent" in found.fit.identifiable:
        names = ["stiffness", "exponent", "friction", "drag", "help"]
        agrees(found, {n: v for n, v in zip(names, x, strict=True) if n in found.fit.identifiable})
    apart = expected(x) - found.expected[:, 0]
    assert np.sqrt(np.mean(apart**2)) < found.residuals[0].rms / 3.0


@needs_rows
def test_constant_current_driving_and_driven():
    """The friction solved by iteration; run c has a gain of its own, and its set point of 15 A is left out."""
    data = rows(REFERENCE / "actuator_ak80_9_backdrive.csv")
    used = np.abs(data["current_A"]) < 11.0
    current, torque, way = data["current_A"][used], data["torque_out_Nm"][used], np.sign(data["speed_out_rad_s"][used])
    of_c = data["run"][used] == "c"

    def residual(x):
        entering = np.where(of_c, x[5], x[0]) * current * (1.0 - x[4] * np.abs(current))
        friction = 0.3
        for _ in range(200):
            friction = x[2] + x[3] * (np.abs(entering) + np.abs(entering - way * friction))
        return entering + x[1] - way * friction - torque

    x = solved(residual, np.array([0.8, 0.1, 0.25, 0.04, 0.004, 1.1]))
    found = part("ak80_9_backdrive")
    agrees(found, dict(zip(("torque_per_current", "offset", "friction", "load_share", "saturation"), x, strict=False)))
    assert_allclose(found.residuals[0].rms, np.sqrt(np.mean(residual(x) ** 2)), rtol=0.01)
    # The reason given for the missed goal: the torque ripples more than that.
    error = (data["torque_sd_Nm"] / np.sqrt(data["samples"]))[used]
    assert 0.02 < error.min() < error.max() < 0.17
    assert 0.05 < np.sqrt(np.mean(error**2)) < 0.07


@needs_rows
def test_steady_current_and_power():
    data = rows(REFERENCE / "actuator_ak80_9_steady.csv")
    found = part("ak80_9_steady")
    used = np.abs(data["speed_rad_s"]) >= 6.0
    used[[line - 2 for line in (one.line for one in found.left_out)]] = False
    speed, torque = 9.0 * data["speed_rad_s"][used], data["torque_Nm"][used] / 9.0
    noise = found.fit.problem.noise

    def residual(x):
        current = (torque + x[2] / 9.0) / x[0]
        power = x[1] * current**2 + x[0] * current * speed
        return np.r_[(current - data["iq_A"][used]) / noise[0], (power - data["dq_power_W"][used]) / noise[1]]

    x = solved(residual, np.array([0.08, 0.12, 1.5]))
    agrees(found, dict(zip(("torque_constant", "resistance", "friction"), x, strict=True)))


AK80_9 = """
[duty.run]
shape = "file"
file = "run.csv"
closed = false
cutoff = "20 Hz"
load_inertia = "1e-9 kg m^2"
[drives.ak]
type = "conventional"
output_inertia = "1e-9 kg m^2"
shaft = {{}}
amplifier = {{ storage_efficiency = 1 }}
[drives.ak.motor]
voltage = "48 V"
resistance = "{resistance!r} ohm"
torque_constant = "{torque_constant!r} N m/A"
no_load_current = "0 A"
continuous_torque = "1 N m"
rotor_inertia = "1e-12 kg m^2"
[drives.ak.gearhead]
ratio = 9
loss_model = "stribeck"
friction = {{ friction = "{friction!r} N m" }}
inertia = "1e-12 kg m^2"
"""
"""The fitted actuator as a study, without inertia, as the steady windows show none; all harmonics of the 20 Hz log pass."""

ENERGIES = {"r04": (-1.6, -1.2, 10.1), "r05": (2.6, 7.6, 12.3)}
"""Error of the energy of each run: by the fit to all windows, to those of other runs, and to those of neither run. [%]"""


@needs_rows
@pytest.mark.parametrize("run", ["r04", "r05"])
def test_energy_of_a_run_from_its_speed_and_torque(run, tmp_path):
    """Within 5 % of 1.5 vq iq by the steady model in a few lines, and by `compare` of the same motion within 1 % of that."""
    data = rows(REFERENCE / "actuator_ak80_9_series.csv")
    mine = data["run"] == run
    time, speed, torque = (data[name][mine] for name in ("time_s", "speed_rad_s", "torque_Nm"))
    measured = np.trapezoid((1.5 * data["vq_V"] * data["iq_A"])[mine], time)
    values = part("ak80_9_steady").fit.values

    def energy(values):
        motor = (torque + np.sign(speed) * values["friction"]) / 9.0
        copper = values["resistance"] * (motor / values["torque_constant"]) ** 2
        return np.trapezoid(copper + 9.0 * motor * speed, time)

    assert abs(energy(values) / measured - 1.0) < 0.05
    lines = [f"{a:.6g},{b:.8g},{-c:.8g}" for a, b, c in zip(time, speed, torque, strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(["time [s],angular speed [rad/s],torque [N m]", *lines]), "utf-8")
    (tmp_path / "ak.toml").write_text(AK80_9.format(**values), "utf-8")
    compared = iv.compare(iv.load_study(tmp_path / "ak.toml"), quick=True).duty["run"].results["ak"].energy
    assert compared == pytest.approx(energy(values), rel=0.01)
    assert abs(compared / measured - 1.0) < 0.05
    found = [100.0 * (compared / measured - 1.0)]
    text = (REFERENCE / "actuator_ak80_9_steady.csv").read_text("utf-8").splitlines()
    for gone in ((run,), ("r04", "r05")):
        kept = [line for line in text if line.split(",")[0] not in gone]
        (tmp_path / "rest.csv").write_text("\n".join(kept), "utf-8")
        rest = measured_report("ak80_9_steady", rows=tmp_path / "rest.csv").parts[0].fit.values
        found.append(100.0 * (energy(rest) / measured - 1.0))
    assert_allclose(found, ENERGIES[run], atol=0.1)
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text("utf-8")
    assert f"| {run} | {measured:.0f} J | {' | '.join(f'{one:+.1f} %' for one in ENERGIES[run])} |" in page


GOALS = {
    "robot_motors": [True],
    "strain_wave_turn": [True],
    "omni_wheels": [True],
    "motor_heating": [True, None],
    "ak80_9_backdrive": [False],
    "ak80_9_steady": [False, False],
}
"""Whether the goals are met; missed ones state the reason."""


@pytest.mark.parametrize("name", GOALS)
def test_goals(name):
    if name.startswith("ak80") and not REFERENCE.is_dir():
        pytest.skip("needs the rows under the GPL")
    totals = report(name).totals
    assert [one.met for one in totals] == GOALS[name]
    assert all(one.reason for one in totals if one.met is False)


def test_goals_of_screws():
    met = {one.name: one.residuals[0].met for one in report("screws_and_worm").parts}
    assert met == {"lead screw": True, "lead screw antibacklash": False, "worm": True}


@pytest.mark.parametrize("name", ["robot_motors", "screws_and_worm", "strain_wave_turn", "omni_wheels"])
def test_intervals_hold_what_was_left_out(name):
    """90 to 98 % of the rows left out lie in the 95 % intervals from the other groups."""
    assert all(0.90 <= one.coverage <= 0.98 for one in report(name).totals)


def test_two_runs_are_too_few_for_intervals():
    """Each run of the first day is predicted from one other, at another power: fewer than 90 % are held, and said to be."""
    winding = report("motor_heating").totals[0]
    assert 0.7 < winding.coverage < 0.9
    assert winding.left_out_rms > 2.0 * winding.rms


def test_the_simplest_model_of_heating_fits_worse_and_predicts_better():
    """As docs/measurements.md states: neither form meets 3 K fitted and 4 K left out, and rows of a run are not independent."""
    measured = read_set("motor_heating")
    law = replace(measured.law, forms={"two nodes": measured.law.forms["two nodes"]})
    simple = measured_report(replace(measured, law=law)).parts[0].residuals[0]
    chosen = part("motor_heating", "1")
    assert simple.rms > 3.0 > chosen.residuals[0].rms
    assert 4.0 < simple.left_out_rms < chosen.residuals[0].left_out_rms
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text("utf-8")
    assert f"leave {simple.rms:.1f} K, and predict the run left out to {simple.left_out_rms:.1f} K" in page
    off = (chosen.rows.read - chosen.expected)[chosen.rows.run == 0]
    for signal in (off - off.mean(axis=0)).T:
        assert signal[1:] @ signal[:-1] > 0.3 * (signal @ signal)


@pytest.mark.parametrize(
    "name", ["robot_motors", "screws_and_worm", "strain_wave_turn", "omni_wheels", "motor_heating"]
)
def test_a_shipped_set_has_no_misread_rows(name):
    assert report(name).sound


def misread_in(name, folder, change):
    """Faults of columns of a set whose cells are changed, by heading without unit."""
    file = REFERENCE / f"actuator_{name}.csv" if name.startswith("ak80") else shipped_sets()[name] / "rows.csv"
    heads, *cells = csv.reader(file.read_text("utf-8").splitlines())
    columns = dict(zip([head.split(" ")[0] for head in heads], map(list, zip(*cells, strict=True)), strict=True))
    columns |= change(columns)
    lines = [heads, *zip(*columns.values(), strict=True)]
    (folder / "rows.csv").write_text("\n".join(",".join(line) for line in lines), "utf-8")
    return [said for one in measured_report(name, rows=folder / "rows.csv").parts for said in one.misread]


def exchanged(one, other):
    return lambda columns: {one: columns[other], other: columns[one]}


def times(name, factor):
    return lambda columns: {name: [f"{factor * float(cell):.8g}" if cell else "" for cell in columns[name]]}


def drifting(name, size):
    return lambda columns: {
        name: [f"{float(cell) + size * place / len(columns[name]):.8g}" for place, cell in enumerate(columns[name])]
    }


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("robot_motors", exchanged("speed", "current"), "speed and current fit if their columns are exchanged"),
        ("robot_motors", times("speed", 30 / math.pi), "speed fits if divided by 9.549: is it in rpm?"),
        ("robot_motors", drifting("current", 0.2), "current drifts by"),
        ("screws_and_worm", exchanged("speed", "direction"), "direction reads 0.2241 to 20.84, but must be -1 to 1"),
        ("screws_and_worm", exchanged("speed", "torque"), "speed and torque fit if their columns are exchanged"),
        ("screws_and_worm", times("speed", 1e3), "speed fits if divided by 1000"),
        ("strain_wave_turn", exchanged("rotor_angle", "direction"), "direction reads 5 to 355, but must be -1 to 1"),
        ("strain_wave_turn", times("rotor_angle", 180 / math.pi), "but must be -12.57 to 12.57 rad"),
        pytest.param(
            "motor_heating",
            times("ambient", 10.0),
            "K, but must be 220 to 350 K",
            marks=pytest.mark.slow,
        ),
        ("omni_wheels", exchanged("creepage", "load"), "creepage and load fit if their columns are exchanged"),
        ("omni_wheels", times("load", 1e-3), "load fits if divided by 0.001"),
        pytest.param(
            "ak80_9_steady",
            exchanged("speed_rad_s", "torque_Nm"),
            "0.049 with two columns exchanged: speed and torque",
            marks=needs_rows,
        ),
        pytest.param(
            "ak80_9_steady", times("speed_rad_s", 30 / math.pi), "speed fits if divided by 9.549", marks=needs_rows
        ),
        pytest.param("ak80_9_steady", drifting("iq_A", 12.0), "current drifts by", marks=needs_rows),
        pytest.param(
            "ak80_9_backdrive", exchanged("current_A", "torque_out_Nm"), "current and torque fit if", marks=needs_rows
        ),
        pytest.param("ak80_9_backdrive", drifting("torque_out_Nm", 4.0), "torque drifts by", marks=needs_rows),
    ],
)
def test_misread_files_of_each_bench_are_named(name, change, said, tmp_path):
    found = misread_in(name, tmp_path, change)
    assert any(said in one for one in found), found


def test_time_that_does_not_increase_is_refused(tmp_path):
    with pytest.raises(iv.InputError, match=r"rows\.csv: line 3: time does not increase"):
        misread_in("motor_heating", tmp_path, exchanged("time", "power"))


def test_what_minutes_of_heating_do_not_show():
    assert "outer" not in part("motor_heating", "2").fit.identifiable


def test_each_set_names_source_and_licence():
    for name in shipped_sets():
        text = (shipped_sets()[name] / "measured.toml").read_text("utf-8")
        assert 'licence = "' in text
        assert (shipped_sets()[name] / "rows.csv").is_file() == ("GPL" not in text)
        assert math.isfinite(len(text))


@needs_rows
@pytest.mark.parametrize("name", ["ak80_9_backdrive", "ak80_9_steady"])
def test_the_page_states_these_residuals(name):
    """Rows under the GPL are not there when the page is built: its lines on them are compared here."""
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text("utf-8")
    for cells in table_rows(report(name)):
        kept = [*cells[:2], *cells[3:8], cells[8].split(":")[0]]
        assert f"| {' | '.join(kept)} |" in page
