"""Calibration of a geared drive on a dynamometer: truth recovered within the intervals, and what the data cannot tell apart."""

import dataclasses

import numpy as np
import pytest

import infinivar as iv
from internals import Dynamometer, NamedColumns, pendulum, virtual_rig
from internals import calibration_plan as plan
from internals import geared_model as model
from internals import save_calibration_data as save_data
from measured import motor_map
from sampled import sampled

NAME = "motor1-gear1"
TRUE = {"resistance": 2.4, "torque_constant": 0.027, "friction": 0.015, "viscous": 1e-4, "load_share": 0.03}
BOTH = {"current": 0.005, "voltage": 0.05}
ALL_ROUND = [part.ravel() for part in np.meshgrid(np.array([-60, -30, -10, 10, 30, 60.0]), np.linspace(-0.25, 0.25, 7))]


def measured(study, noise=BOTH, points=ALL_ROUND, seed=1, **options):
    speed, torque = points
    return virtual_rig.dynamometer(
        study.drives[NAME], study.rig, speed=speed, torque=torque, noise=noise, values=TRUE, seed=seed, **options
    )


def driving(points=ALL_ROUND):
    speed, torque = points
    return speed[speed * torque > 0], torque[speed * torque > 0]


@pytest.fixture(scope="module")
def found(study):
    return iv.calibrate(study, NAME, measured(study))


def test_truth_is_recovered_exactly_without_errors(study):
    rig = dataclasses.replace(study.rig, current_gain_deviation=0.0, torque_gain_deviation=0.0)
    exact = iv.calibration.calibrate_geared(dataclasses.replace(study, rig=rig), NAME, measured(study, seed=None))
    for name, value in TRUE.items():
        assert exact.fit.values[name] == pytest.approx(value, rel=1e-5), name


def test_truth_is_within_the_intervals(found):
    # 3.3 standard deviations: one in a thousand for each of five.
    for name, value in TRUE.items():
        assert abs(found.fit.values[name] - value) < 3.3 * found.fit.deviations[name], name
    assert found.fit.identifiable == tuple(TRUE)
    for signal, size in BOTH.items():
        assert found.to_dict()["noise"][signal] == pytest.approx(size, rel=0.35)  # 42 rows: 11 %, three times


def test_the_calibrated_drive_gives_the_readings_of_the_true_one(study, found):
    """The fitted drive, operated by itself, against the formula of resistance and load-dependent friction."""
    speed, torque = ALL_ROUND
    drive, ratio = found.calibrated, study.drives[NAME].gearhead.ratio
    gear = drive.gearhead.operate(
        output_torque=torque, output_speed=speed, motor_rated_torque=drive.motor.continuous_torque
    )
    point = drive.motor.operate(torque=gear.motor_torque, speed=gear.motor_speed)
    base = TRUE["friction"] + TRUE["viscous"] * np.abs(speed)
    share, way = TRUE["load_share"], np.sign(speed)
    load = way * torque
    # f = F + c|w| + k|2 tau_o + f sgn w|, by cases of the sign of the last term.
    friction = np.where(load > 0, (base + 2 * share * load) / (1 - share), 0.0)
    friction = np.where(load <= 0, (base - 2 * share * load) / (1 + share), friction)
    small = (load <= 0) & (2 * load + friction > 0)
    friction = np.where(small, (base + 2 * share * load) / (1 - share), friction)
    idle = study.drives[NAME].motor.friction_torque
    current = ((torque + way * friction) / ratio + way * idle) / TRUE["torque_constant"]
    voltage = TRUE["resistance"] * current + TRUE["torque_constant"] * ratio * speed
    assert np.sqrt(np.mean((point.current - current) ** 2)) < 0.02 * np.sqrt(np.mean(current**2))
    assert np.sqrt(np.mean((point.voltage - voltage) ** 2)) < 0.02 * np.sqrt(np.mean(voltage**2))


@pytest.mark.parametrize(
    ("sessions", "least"),
    [pytest.param(20, 0.8, marks=pytest.mark.slow), pytest.param(200, 0.9, marks=pytest.mark.full)],
)
def test_intervals_cover_the_truth_in_95_percent_of_sessions(study, sessions, least):
    """3.3 standard deviations of a count of 200 at 95 % are 5 %; of 20, more than four miss with a probability of 0.3 %."""
    inside = dict.fromkeys(TRUE, 0)
    for seed in range(sessions):
        fit = iv.calibration.calibrate_geared(study, NAME, measured(study, seed=seed)).fit
        for name, value in TRUE.items():
            low, high = fit.interval(name)
            inside[name] += low <= value <= high
    for name, count in inside.items():
        assert least <= count / sessions <= 1.0, (name, count)


def test_load_dependent_friction_needs_several_loads(study):
    speed = np.linspace(10.0, 60.0, 30)
    found = iv.calibrate(study, NAME, measured(study, points=(speed, np.full(30, 0.2))))
    assert {"friction", "load_share"}.isdisjoint(found.fit.identifiable)
    said = " ".join(found.remarks)
    assert "Not identifiable separately: friction and load_share." in said
    assert "the same points at half the load" in said
    (combination,) = (one for one in found.fit.combinations if len(one.weights) > 1)
    # At one load T they act as F + 2 k T/(1 - k), here linearised; the sum is as known as a single friction.
    true = TRUE["friction"] + combination.weights["load_share"] * TRUE["load_share"]
    assert combination.weights["load_share"] == pytest.approx(0.42, rel=0.05)
    assert abs(combination.value - true) < 4.0 * combination.deviation


def test_torque_constant_needs_voltage_or_current(study):
    found = iv.calibrate(study, NAME, measured(study, noise={"power": 0.05}))
    assert {"resistance", "torque_constant"}.isdisjoint(found.fit.identifiable)
    said = " ".join(found.remarks)
    assert "The data determine only resistance / torque_constant^2" in said
    assert "a column of voltage, or a column of current" in said
    value = found.fit.values["resistance"] / found.fit.values["torque_constant"] ** 2
    assert value == pytest.approx(TRUE["resistance"] / TRUE["torque_constant"] ** 2, rel=0.1)


@pytest.mark.slow
def test_advised_data_identify_what_they_promise(study):
    """The number of combinations that stay open after each remedy, against a calibration of a bench that has these data."""
    speed = np.linspace(10.0, 60.0, 30)
    points = (speed, np.full(30, 0.2))
    found = iv.calibrate(study, NAME, measured(study, points=points))
    advised = {one.words: one.left for one in plan.remedies(found.fit)}
    more = {
        "the same points while the load drives": (speed, -points[1]),
        "the same points at half the load": (speed, 0.5 * points[1]),
        "the same points at half the speed": (0.5 * speed, points[1]),
    }
    left = {}
    for said, further in more.items():
        both = tuple(np.concatenate(pair) for pair in zip(points, further, strict=True))
        left[said] = iv.calibrate(study, NAME, measured(study, points=both)).fit.unidentifiable.shape[1]
    least = min(left.values())
    assert least < max(left.values())
    assert advised == {said: one for said, one in left.items() if one == least}


@pytest.mark.slow
def test_current_alone_tells_torque_constant_from_load_share_only_if_the_load_drives(study):
    one_way = iv.calibrate(study, NAME, measured(study, noise={"current": 0.005}, points=driving()))
    assert {"torque_constant", "load_share"}.isdisjoint(one_way.fit.identifiable)
    assert "the same points while the load drives" in " ".join(one_way.remarks)
    both_ways = iv.calibrate(study, NAME, measured(study, noise={"current": 0.005}))
    assert {"torque_constant", "load_share"} <= set(both_ways.fit.identifiable)


def test_resistance_needs_more_than_the_current(study):
    with pytest.raises(iv.InputError, match="requires a column voltage, power or efficiency"):
        iv.calibrate(study, NAME, measured(study, noise={"current": 0.005}), parameters=["resistance"])


def test_a_bench_without_the_gearhead_gives_the_motor(study):
    true = {"resistance": 2.4, "torque_constant": 0.027, "motor_friction": 2e-3, "motor_viscous": 2e-6}
    speed, torque = ALL_ROUND
    data = virtual_rig.dynamometer(
        study.drives[NAME],
        study.rig,
        speed=11 * speed,
        torque=torque / 11,
        noise=BOTH,
        values=true,
        geared=False,
        seed=2,
    )
    found = iv.calibrate(study, NAME, data)
    for name, value in true.items():
        assert abs(found.fit.values[name] - value) < 3.3 * found.fit.deviations[name], name
    assert found.calibrated.gearhead == study.drives[NAME].gearhead
    assert found.calibrated.motor.friction_torque == pytest.approx(found.fit.values["motor_friction"])
    with pytest.raises(iv.InputError, match="load_share belongs to the gearhead"):
        iv.calibrate(study, NAME, data, parameters=["load_share"])


def test_the_map_of_a_real_motor_gives_the_fit_of_the_docs(study):
    """The same least squares by another path: efficiencies of equal weight, resistance and constant friction alone."""
    whole = motor_map.published()
    used = whole.loaded & (whole.efficiency > 0)
    data = Dynamometer(
        speed=whole.speed[used],
        torque=whole.torque[used],
        geared=False,
        read=whole.efficiency[used][:, None],
        signals=("efficiency",),
        lines=tuple(range(2, 2 + int(used.sum()))),
    )
    motor = dataclasses.replace(
        study.drives[NAME].motor, resistance=0.05, torque_constant=0.03, no_load_current=0.5, voltage=48.0
    )
    drive = dataclasses.replace(study.drives[NAME], motor=motor)
    rig = dataclasses.replace(study.rig, torque_gain_deviation=0.0)
    own = dataclasses.replace(study, drives={NAME: drive}, rig=rig)
    found = iv.calibrate(own, NAME, data, parameters=["resistance", "motor_friction"])
    kept = np.setdiff1d(np.flatnonzero(used), np.flatnonzero(used)[[one.row for one in found.left_out]])
    again = motor_map.fit(
        motor_map.MotorMap(
            speed=whole.speed[kept], torque=whole.torque[kept], efficiency=whole.efficiency[kept], row=whole.row[kept]
        )
    )
    assert found.fit.values["resistance"] / 0.03**2 == pytest.approx(again.values[0], rel=1e-3)
    assert found.fit.values["motor_friction"] == pytest.approx(again.values[1], rel=1e-3)
    wider = found.fit.deviations["motor_friction"] / again.deviations[1]
    assert 0.98 < wider < 1.05  # Student's distribution


@sampled(
    ("place", "factor", "signal"),
    [(0, 1.5, "current"), (0, 0.9, "current"), (1, 1.5, "voltage"), (1, 0.9, "voltage")],
    every=4,
)
def test_an_outlier_is_named_and_left_out(study, place, factor, signal):
    data = measured(study)
    read = data.read.copy()
    read[40, place] *= factor
    found = iv.calibrate(study, NAME, dataclasses.replace(data, read=read))
    (one,) = found.left_out
    assert one.line == 42
    assert f"{signal} is" in one.reason
    assert "standard deviations off" in one.reason
    for name, value in TRUE.items():
        assert abs(found.fit.values[name] - value) < 4.0 * found.fit.deviations[name], name


def test_reversed_torque_is_refused(study):
    data = measured(study, points=driving())
    with pytest.raises(iv.InputError, match="check units and signs"):
        iv.calibrate(study, NAME, dataclasses.replace(data, read=-data.read * [1, -1]))


def test_a_speed_at_the_motor_with_a_torque_at_the_output(study, tmp_path):
    data = measured(study)
    save_data(data, tmp_path / "a.csv")
    text = (tmp_path / "a.csv").read_text("utf-8").splitlines()
    assert text[0].startswith("speed [rad/s]")
    rows = [line.split(",") for line in text[1:]]
    ratio = study.drives[NAME].gearhead.ratio
    moved = [",".join([repr(float(row[0]) * ratio), *row[1:]]) for row in rows]
    (tmp_path / "b.csv").write_text("\n".join([text[0].replace("speed", "motor_speed"), *moved]), "utf-8")
    one, other = (iv.calibrate(study, NAME, tmp_path / file).fit.values for file in ("a.csv", "b.csv"))
    assert dict(one) == pytest.approx(dict(other), rel=1e-6)


def test_known_values_of_a_proportional_gear_give_its_efficiency(study):
    gear = iv.parts.Gearhead(ratio=10.0, efficiency=0.8, loss_model="proportional")
    drive = dataclasses.replace(study.drives[NAME], gearhead=gear)
    same = model.gearhead_with(gear, model.known_values(drive))
    where = {"output_torque": 3.0, "output_speed": 2.0, "motor_rated_torque": 1.0}
    assert same.operate(**where).motor_torque == pytest.approx(gear.operate(**where).motor_torque)


PENDULUM = {"pendulum_mass": 0.15, "pendulum_length": 0.2, "pendulum_inertia": 6.6e-3}
SWUNG = {**TRUE, "viscous": 1e-3}
HEARD = {"angle": 2e-4, "current": 0.02, "voltage": 0.05}


def hanging(study, **changes):
    return dataclasses.replace(study, rig=dataclasses.replace(study.rig, **PENDULUM, **changes))


def swung(study, seed=0, noise=HEARD, amplitudes=None, duration=12.0):
    found = virtual_rig.swing(
        study.drives[NAME],
        study.rig,
        duration=duration,
        rate=250.0,
        amplitudes=amplitudes or {0.5: 1.0, 1.3: 0.3},
        noise=noise,
        values=SWUNG,
        seed=seed,
    )
    return {heading.partition(" ")[0]: values for heading, values in found.items()}


def windows(study, columns, method="weak"):
    lines = np.arange(2, 2 + len(columns["time"]))
    return pendulum.pendulum_of("swing", NamedColumns(columns, lines, {}), study.rig, study.drives[NAME], method=method)


@pytest.mark.slow
def test_a_pendulum_gives_the_truth_by_the_weak_form_and_by_inverse_dynamics(study):
    own = hanging(study)
    columns = swung(own, seed=4)
    found = {
        one: iv.calibration.calibrate_geared(own, NAME, windows(own, columns, one)).fit for one in ("weak", "inverse")
    }
    for fit in found.values():
        assert fit.identifiable == tuple(SWUNG)
        for name, value in SWUNG.items():
            assert abs(fit.values[name] - value) < 3.3 * fit.deviations[name], name
    for name in SWUNG:  # the same readings: the two differ by less than one interval's half
        apart = abs(found["weak"].values[name] - found["inverse"].values[name])
        assert apart < found["weak"].deviations[name], name


def test_the_weak_form_needs_no_derivative_of_the_angle(study):
    """Of a parabola, the weak second derivative is exact, and of a harmonic that of the window's mean."""
    time = np.linspace(0.0, 0.25, 60)
    weight, slope, bend = pendulum._window(time, 0.0, 0.25)
    assert weight.sum() == pytest.approx(1.0)
    assert bend @ (3.0 * time**2 - 2.0 * time + 7.0) == pytest.approx(6.0, rel=1e-9)
    assert -slope @ (4.0 - 2.0 * time) == pytest.approx(2.0 * -1.0, rel=1e-9)
    turn = 2.0 * np.pi
    assert bend @ np.sin(turn * time) == pytest.approx(weight @ (-(turn**2) * np.sin(turn * time)), rel=1e-4)
    assert -slope @ np.sin(turn * time) == pytest.approx(weight @ (turn * np.cos(turn * time)), rel=1e-4)


@pytest.mark.slow
def test_a_pendulum_without_voltage_gives_the_torque_constant_but_no_resistance(study):
    own = hanging(study)
    data = windows(own, swung(own, noise={"angle": 1e-4, "current": 0.01}))
    found = iv.calibration.calibrate_geared(own, NAME, data)
    assert "resistance" not in found.fit.names
    assert abs(found.fit.values["torque_constant"] - 0.027) < 3.3 * found.fit.deviations["torque_constant"]
    with pytest.raises(iv.InputError, match="requires a column voltage"):
        iv.calibration.calibrate_geared(own, NAME, data, parameters=["resistance"])


@pytest.mark.slow
def test_rest_of_a_pendulum_is_left_out(study):
    own = hanging(study)
    columns = swung(own, noise={"angle": 1e-5, "current": 0.01})
    still = columns["time"] > 10.0
    columns["angle"][still] = columns["angle"][still][0]
    found = iv.calibration.calibrate_geared(own, NAME, windows(own, columns))
    assert any("the pendulum rests" in one.reason for one in found.left_out)


@pytest.mark.parametrize(
    ("sessions", "least"),
    [pytest.param(10, 0.7, marks=pytest.mark.slow), pytest.param(60, 0.86, marks=pytest.mark.full)],
)
def test_intervals_of_a_pendulum_cover_the_truth(study, sessions, least):
    """3.3 standard deviations of a count of 60 at 95 % are 9 %; of 10, more than three miss with a probability of 0.1 %."""
    own = hanging(study)
    inside = dict.fromkeys(SWUNG, 0)
    for seed in range(sessions):
        fit = iv.calibration.calibrate_geared(own, NAME, windows(own, swung(own, seed=seed))).fit
        for name, value in SWUNG.items():
            low, high = fit.interval(name)
            inside[name] += low <= value <= high
    for name, count in inside.items():
        assert least <= count / sessions <= 1.0, (name, count)


@pytest.mark.full
def test_noise_of_the_angle_counts_once_though_two_signals_show_it(study):
    """Its error in the expected current is in the expected voltage, too: deviations state the scatter of the estimates.

    Taken as independent, the torque constant scatters by 0.63 of the stated deviation and the load share by 1.31 of it, and 95 %
    intervals of the load share contain the truth in 87 % of 60 recordings.
    """
    own = hanging(study, current_gain_deviation=0.0)
    off = {name: [] for name in SWUNG}
    for seed in range(40):
        columns = swung(own, seed=seed, noise={**HEARD, "angle": 3e-3})
        fit = iv.calibration.calibrate_geared(own, NAME, windows(own, columns)).fit
        for name, value in SWUNG.items():
            off[name].append((fit.values[name] - value) / fit.deviations[name])
    for name, several in off.items():  # 2.7 standard deviations of a scatter of 40: 30 %
        assert 0.7 < np.std(several) < 1.3, name


@pytest.mark.full
def test_noise_of_the_angle_biases_inverse_dynamics_more_than_the_weak_form(study):
    """As the docs say: what is left of the noise in the smoothed acceleration is an error of the regressors."""
    own = hanging(study)
    off = {"weak": [], "inverse": []}
    for seed in range(20):
        columns = swung(own, seed=seed, noise={**HEARD, "angle": 3e-3}, duration=16.0)
        for method, found in off.items():
            fit = iv.calibration.calibrate_geared(own, NAME, windows(own, columns, method)).fit
            found.append((fit.values["load_share"] - SWUNG["load_share"]) / fit.deviations["load_share"])
    assert abs(np.mean(off["weak"])) < 0.6
    assert np.mean(off["inverse"]) > np.mean(off["weak"]) + 0.3


def test_the_gain_of_a_current_counts_only_where_current_was_read(study):
    """5 % of a current that was read; none of one that was not."""
    rig = dataclasses.replace(study.rig, current_gain_deviation=0.05)
    read = measured(study)
    assert read.errors(rig)["current"].deviation == 0.05
    without = dataclasses.replace(read, signals=("voltage",), read=read.read[:, [read.signals.index("voltage")]])
    assert without.errors(rig)["current"].deviation == 0.0
