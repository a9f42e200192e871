"""What a simulation shows and writes is what its trajectory says."""

import csv
import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
import xarray

import infinivar as iv
from infinivar import Scenario
from infinivar.motion import ConstantForce, Sinusoid, Step, StepForce
from internals import RunEvent as Event
from internals import energy_flow, run_limits, time_history
from rendering import rendered


@pytest.fixture(scope="module")
def step(study):
    scenario = Scenario(
        title="step",
        duration=0.2,
        output_step=0.002,
        load_mass=0.8,
        motion=Step(distance=0.05, start=0.05),
        force=ConstantForce(size=-5.0),
    )
    return iv.simulate(study.drives["cobotic"], scenario, title="Cobotic")


@pytest.fixture(scope="module")
def slip(study):
    scenario = Scenario(
        title="slip",
        duration=0.1,
        output_step=0.001,
        steering="locked",
        load_mass=0.8,
        force=StepForce(size=-90.0, start=0.03),
    )
    return iv.simulate(study.drives["cobotic"], scenario, title="Cobotic")


@pytest.fixture(scope="module")
def saved(step, tmp_path_factory):
    folder = tmp_path_factory.mktemp("saved")
    with rendered(()):
        files = iv.save(step, folder, name="run", reconstruction=("Everything is assumed.",))
    return {file.name: file for file in files}


def test_history_shows_the_columns(step):
    numbers = time_history.data(step)
    panels = numbers["panels"]
    np.testing.assert_array_equal(numbers["time"], step.trajectory.time)
    np.testing.assert_allclose(panels["position\n[mm]"]["link"], 1e3 * step.trajectory.signals["l"])
    np.testing.assert_allclose(panels["steering\nangle [deg]"]["wheel"], np.degrees(step.trajectory.signals["phi"]))
    assert set(panels["current\n[A]"]) == {"motor", "steering motor"}


def test_limits_are_shown_where_they_belong(step, slip):
    assert [words for _, _, words in time_history.data(slip)["limits"]["lateral over\nslip force [-]"]] == [
        "wheel slip (wheel)"
    ]
    shown = time_history.data(step)["limits"]["current\n[A]"]
    assert {words for _, _, words in shown} == {
        "motor continuous torque (steering motor)",
        "supply voltage (steering motor)",
    }


def test_slip_begins_with_the_force(slip):
    (event,) = slip.events
    assert event.limit == iv.Limit.SLIP
    assert event.start == pytest.approx(0.03, abs=0.001)
    assert event.end == pytest.approx(0.1)
    assert slip.exceeded == ("wheel slip (wheel)",)
    assert not slip.feasible
    # All that the contact loses from then on is the slip's own loss, mu P times the sliding speed.
    run = slip.trajectory
    assert run.lost["slip"][-1] > 100 * run.lost["creep"][-1] >= 0.0
    fast = run.time > 0.05
    sliding = run.at("transmission.creep")[1][fast]
    power = np.gradient(run.lost["slip"], run.time)[fast]
    np.testing.assert_allclose(power[1:-1], 78.0 * np.abs(sliding[1:-1]), rtol=1e-3)


def test_energy_in_and_out_agree(step, slip):
    for simulation in (step, slip):
        numbers = energy_flow.data(simulation)
        came, went = sum(numbers["came"].values()), sum(numbers["went"].values())
        assert came == pytest.approx(went, rel=1e-4)  # what is too small to show is left out
        assert all(value > 0.0 for side in ("came", "went") for value in numbers[side].values())


def test_energy_that_goes_back_counts_as_going_out(step):
    """The surroundings pull against the motion: the load's source takes energy."""
    assert step.trajectory.supplied["load"][-1] < 0.0
    assert energy_flow.data(step)["went"]["work on the load"] == pytest.approx(-step.trajectory.supplied["load"][-1])


def test_csv_has_the_columns(step, saved):
    with saved["run.csv"].open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == list(step.columns)
    table = np.array(rows, dtype=float)
    assert table.shape == (len(step.trajectory.time), len(header))
    np.testing.assert_allclose(table[:, header.index("speed_m_s")], step.columns["speed_m_s"], rtol=1e-8, atol=1e-12)


def test_netcdf_has_energies_by_name(step, saved):
    with xarray.open_dataset(saved["run.nc"], engine="scipy") as dataset:
        assert dataset["position_m"].attrs["units"] == "m"
        lost = dataset["energy_lost_J"].sel(lost="winding").values
        np.testing.assert_allclose(lost, step.trajectory.lost["winding"])
        assert float(np.abs(dataset["energy_residual"]).max()) == pytest.approx(step.trajectory.closure)


def test_json_says_what_happened(step, saved):
    content = json.loads(saved["run.json"].read_text("utf-8"))
    assert content["complete"] is True
    assert content["closure"] < 1e-6
    total = sum(content["supplied_J"].values()) - sum(content["lost_J"].values()) - sum(content["stored_J"].values())
    assert total == pytest.approx(0.0, abs=1e-6)
    assert content["events"][0]["limit"] == "THERMAL"


def test_the_page_stands_alone_and_names_the_reconstruction(saved):
    page = saved["run.html"].read_text("utf-8")
    assert "Everything is assumed." in page
    assert page.count("data:image/svg+xml;base64,") == 2
    assert "http" not in page.replace("http-equiv", "")
    assert "supply voltage" in page
    assert "root mean square / limit" in page
    assert "permitted for a short time" in page
    assert "counts as on the limit" in page
    assert {"run-history.svg", "run-energy.png"} <= set(saved)


@pytest.mark.slow
def test_the_page_speaks_of_a_cylinder_only_where_there_is_one(study, saved, tmp_path):
    assert "; cylinder running;" in saved["run.html"].read_text("utf-8")
    scenario = Scenario(duration=0.02, load_mass=0.8, force=ConstantForce(size=-5.0))
    with rendered(("svg",)):
        page, *_ = iv.save(iv.simulate(study.drives["motor2-gear4"], scenario, title="Geared"), tmp_path)
    assert "cylinder" not in page.read_text("utf-8")


@pytest.mark.slow
def test_power_of_the_supply_is_the_rate_of_its_energy(study):
    """Amplifier losses and standby included, the supply's power adds up to the energy that the audit counts."""
    drive = replace(study.drives["cobotic"], amplifier=iv.parts.Amplifier(efficiency=0.9, standby_power=0.5))
    scenario = Scenario(
        duration=0.2,
        output_step=0.0005,
        load_mass=0.8,
        motion=Sinusoid(distance=0.01, frequency=5.0),
    )
    result = iv.simulate(drive, scenario)
    energy = result.trajectory.supplied["supply"] + result.trajectory.supplied["steering supply"]
    power = result.columns["supply_power_W"]
    integral = np.trapezoid(power, result.trajectory.time)
    assert energy[-1] == pytest.approx(integral, rel=5e-3)  # held currents jump within a step of the rule
    assert result.trajectory.lost["amplifier"][-1] > 0.5 * 0.2


def test_an_unfinished_run_says_so(step):
    stopped = replace(step, trajectory=replace(step.trajectory, outcome="stopped at 0.1 s: too stiff. Try Radau."))
    assert stopped.verdict == "stopped at 0.1 s: too stiff. Try Radau."
    assert not stopped.feasible


def test_an_event_in_words():
    shown = str(Event(limit=iv.Limit.SLIP, what="wheel", start=0.1, end=0.25, worst=math.inf))
    assert shown == "wheel slip (wheel) exceeded from 0.1 s to 0.25 s"


def test_events_begin_and_end_between_results():
    """Where a straight line between the results passes the allowance; at the ends of a run, at its ends."""
    time = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    demand = np.array([0.0, 2.0, 0.5, 0.5, 3.0])
    first, second = run_limits.events(time, {(iv.Limit.GEAR_PEAK, "gearhead"): demand})
    assert (first.start, first.end, first.worst) == pytest.approx((0.5, 1.0 + 2.0 / 3.0, 2.0))
    assert (second.start, second.end, second.worst) == pytest.approx((3.2, 4.0, 3.0))
    assert run_limits.events(time, {(iv.Limit.GEAR, "gearhead"): np.ones(5)}) == ()


def test_root_mean_squares_are_of_the_continuous_torques():
    time = np.linspace(0.0, 1.0, 2001)
    sine = 3.0 * np.sin(2 * np.pi * time)
    keys = (iv.Limit.GEAR, "gearhead"), (iv.Limit.THERMAL, "motor"), (iv.Limit.PEAK, "motor")
    demands = dict.fromkeys(keys, sine)
    found = run_limits.root_mean_squares(time, demands)
    assert found == pytest.approx({key: 3.0 / math.sqrt(2) for key in keys[:2]}, rel=1e-5)
    assert run_limits.root_mean_squares(time[:1], {(iv.Limit.GEAR, "gearhead"): np.array([-2.0])}) == {
        (iv.Limit.GEAR, "gearhead"): 2.0
    }


def judged(demand, limit=iv.Limit.GEAR_PEAK, settled=0, settling=None):
    """Names of limits exceeded, verdict and lines of a demand at 1001 instants of a second."""
    time, key = np.linspace(0.0, 1.0, 1001), (limit, "gearhead")
    demands = {key: demand(time)}
    events = run_limits.events(time, demands, settled)
    means = run_limits.root_mean_squares(time, demands, settled)
    said = run_limits.verdict(events, means, 1.0, settling)
    return run_limits.exceeded(events, means), said, run_limits.lines(events, means)


@pytest.mark.parametrize(
    ("size", "names"), [(1.0, 0), (1.0009, 0), (1.0011, 1)], ids=["on the limit", "within tolerance", "beyond"]
)
@pytest.mark.parametrize("limit", [iv.Limit.GEAR_PEAK, iv.Limit.GEAR])
def test_a_demand_on_its_limit_is_not_beyond_it(limit, size, names):
    exceeded, said, lines = judged(lambda time: np.full_like(time, size), limit)
    assert len(exceeded) == names
    assert said.startswith("limit exceeded: gearhead" if names else "within limits")
    assert [("1.001 times the allowance" in line) for line in lines] == [True] * names


def test_slip_has_no_tolerance():
    exceeded, _, _ = judged(lambda time: np.full_like(time, 1.0 + 1e-6), iv.Limit.SLIP)
    assert exceeded == ("wheel slip (gearhead)",)


def test_continuous_torque_counts_by_its_root_mean_square():
    """Half the time at twice the allowance is beyond it, a tenth is not; the explanation agrees with the verdict."""
    words = r"gearhead continuous torque \(gearhead\)"
    exceeded, said, (line,) = judged(lambda time: np.where(time % 0.2 < 0.02, 2.0, 0.5), iv.Limit.GEAR)
    assert (exceeded, said) == ((), "within limits")
    counts = "of the allowance, which is what counts; momentarily up to 2 times"
    (share,) = re.fullmatch(rf"{words}: root mean square (.*) {counts}", line).groups()
    assert float(share) == pytest.approx(math.sqrt(0.1 * 4.0 + 0.9 * 0.25), rel=0.01)
    exceeded, said, (line,) = judged(lambda time: np.where(time % 0.2 < 0.1, 2.0, 0.5), iv.Limit.GEAR)
    assert exceeded == ("gearhead continuous torque (gearhead)",)
    assert said == f"limit exceeded: {exceeded[0]}"
    (share,) = re.fullmatch(
        rf"{words} exceeded: root mean square (.*) times the allowance, at most 2 times", line
    ).groups()
    assert float(share) == pytest.approx(math.sqrt(0.5 * 4.0 + 0.5 * 0.25), rel=0.01)


def start(time):
    return np.where(time < 0.02, 1.07, 0.9)


def test_a_limit_exceeded_at_the_start_alone_is_called_so():
    exceeded, said, (line,) = judged(start)
    assert exceeded == ("gearhead intermittent torque (gearhead)",)
    assert said == "limit exceeded only in the first 0.0194 s: gearhead intermittent torque (gearhead)"
    assert line.endswith("exceeded from 0 s to 0.01941 s, up to 1.07 times the allowance")
    _, said, _ = judged(lambda time: start(time % 0.5))
    assert said == "limit exceeded: gearhead intermittent torque (gearhead)"


def test_a_run_is_judged_after_its_settling_time():
    exceeded, said, (line,) = judged(start, settled=100, settling=0.1)
    assert exceeded == ()
    assert said == (
        "within limits after 0.1 s of settling; only while settling: gearhead intermittent torque (gearhead)"
    )
    assert line.startswith("gearhead intermittent torque (gearhead) exceeded while settling, from 0 s to ")
    exceeded, said, lines = judged(lambda time: start(time % 0.5), settled=100, settling=0.1)
    assert exceeded == ("gearhead intermittent torque (gearhead)",)
    assert said == "limit exceeded after 0.1 s of settling: gearhead intermittent torque (gearhead)"
    assert len(lines) == 3  # and one at the very end, which begins a third cycle
    # The root mean square is that after settling as well, and an interval across its end is two.
    exceeded, _, _ = judged(lambda time: np.where(time < 0.5, 3.0, 0.5), iv.Limit.GEAR, 500, 0.5)
    assert exceeded == ()
    _, _, lines = judged(lambda time: np.where(time < 0.6, 3.0, 0.5), settled=500, settling=0.5)
    assert [" while settling" in line for line in lines] == [True, False]


def test_the_settling_time_of_a_scenario(study):
    """Only what it leaves counts; the energy after it is stated, and it must leave something of the run."""
    motion = Sinusoid(distance=0.01, frequency=5.0)
    whole = Scenario(duration=0.4, output_step=0.001, load_mass=0.8, motion=motion)
    drive = study.drives["motor2-gear4"]
    run, later = iv.simulate(drive, whole), iv.simulate(drive, replace(whole, settling_time=0.2))
    time, energy = run.trajectory.time, run.trajectory.supplied["supply"]
    half = len(time) // 2
    current = run.columns["motor_current_A"][half:] / drive.motor.continuous_current
    expected = math.sqrt(np.trapezoid(current**2, time[half:]) / 0.2)
    # The trapezoidal rule over outputs is less exact than the quadrature between them.
    assert later.heating == {"motor": pytest.approx(expected, rel=1e-8)}
    found = later.to_dict()
    assert found["settling_time_s"] == 0.2
    assert found["supplied_after_settling_J"] == pytest.approx(energy[-1] - energy[half], rel=1e-9)
    assert "J of it after settling;" in later.verdict
    assert later.verdict.startswith("within limits after 0.2 s of settling; ")
    assert "settling" not in run.verdict
    with pytest.raises(iv.ParameterError, match=r"settling_time must be < duration \(0.4 s\), got 0.4 s"):
        replace(whole, settling_time=0.4)


def test_netcdf_holds_the_labelled_data(saved, step):
    """What SciPy writes is what xarray holds: names, labels, units and numbers."""
    with xarray.open_dataset(saved["run.nc"], engine="scipy") as written:
        xarray.testing.assert_identical(written.load(), step.to_xarray())


@pytest.mark.slow
def test_limits_between_outputs_count(study):
    """A reach too fast for the motor, between two outputs half a second apart, is judged as with outputs every 2 ms."""
    times = np.linspace(0.0, 2.0, 2001)

    def reached(start):
        share = np.clip((times - start) / 0.12, 0.0, 1.0)
        return 0.2 * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)

    motion = iv.motion.Waypoints(file="reach.csv", time=times, position=reached(1.1) - reached(1.3))
    drive = study.drives["motor2-gear4"]
    fine, coarse = (
        iv.simulate(drive, Scenario(duration=2.0, output_step=step, load_mass=0.5, motion=motion))
        for step in (0.002, 0.5)
    )
    assert "supply voltage (motor)" in fine.exceeded
    assert coarse.exceeded == fine.exceeded
    worst = [max(one.worst for one in run.events if one.limit == iv.Limit.VOLTAGE) for run in (fine, coarse)]
    assert worst[1] == pytest.approx(worst[0], rel=1e-3)  # both by the nearest node of their quadratures
    assert coarse.heating["motor"] == pytest.approx(fine.heating["motor"], rel=1e-5)
    assert coarse.largest_error == pytest.approx(fine.largest_error, rel=1e-3)
    assert len(coarse.trajectory.time) == 5


def test_a_force_may_change_at_a_sample_of_the_controller(study, tmp_path):
    """Times of a file, of samples and of outputs that are equal but for rounding are one instant."""
    file = tmp_path / "pulse.csv"
    file.write_text("time,force\n0,0\n0.016,0\n0.018,-200\n0.02,0\n0.1,0\n", "utf-8")
    still = Sinusoid(distance=0.001, frequency=1.0)
    scenario = Scenario(
        duration=0.1, output_step=0.005, load_mass=0.5, motion=still, force=iv.motion.RecordedForce.read(str(file))
    )
    run = iv.simulate(study.drives["motor2-gear4"], scenario)
    assert run.complete, run.verdict


@pytest.mark.parametrize("count", [1, 2, 7, 12])
def test_every_limit_of_a_panel_is_shaded_and_named(count):
    """However many limits a panel has, none is left out, and no two share a shade."""
    from matplotlib.figure import Figure

    limits = [(0.05 * place, 0.9, f"limit {place}") for place in range(count)]
    numbers = {
        "time": np.linspace(0.0, 1.0, 11),
        "panels": {"current\n[A]": {"motor": np.zeros(11)}},
        "limits": {"current\n[A]": limits},
    }
    ax = Figure().subplots()
    time_history.draw(ax, numbers, "current\n[A]")
    named = ax.get_legend().get_texts()
    shades = {one.get_facecolor() for one in ax.patches}
    assert {one.get_text() for one in named} == {words for _, _, words in limits}
    assert len(shades) == count
