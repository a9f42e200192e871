"""The virtual rig and what is made of its data: Eqs 9 and 18, intervals, what cannot be told apart, what to measure next."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import calibrate
from internals import CALIBRATION_COLUMNS as COLUMNS
from internals import Problem, fitting, virtual_rig
from internals import calibration_model as model
from internals import calibration_plan as plan
from internals import fit_problem as fit
from internals import reduced_data as reduce
from rigs import RATIOS, RIG, session


@pytest.fixture(scope="module")
def drive(study):
    return study.drives["cobotic"]


def without_errors(drive, *, simulated):
    """Runs without errors on the bond graph, or the same by the steady solution."""
    protocol = virtual_rig.protocol(drive, RIG, ratios=(100.0, 2.0))
    return virtual_rig.experiment(drive, RIG, protocol, exact=True, simulated=simulated)


@pytest.fixture(scope="module")
def exact(drive):
    return without_errors(drive, simulated=False)


@pytest.mark.slow
def test_bond_graph_settles_to_the_steady_solution(drive, exact):
    """Simulation in time and steady equations are two codes; friction that sticks smoothly leaves 1e-10."""
    settled = without_errors(drive, simulated=True)
    simulated, steady = ([tuple(truth) for truth in one.truth] for one in (settled, exact))
    assert_allclose(simulated, steady, rtol=1e-9, atol=1e-12)
    assert len(simulated) == 1 + 2 + 2 * 2 * 2
    assert not settled.left_out


@pytest.mark.source("faulring2006", "Eq 9")
def test_eq_9_gives_the_true_creep_stiffness(exact, drive):
    found, _ = reduce.creep_stiffness(drive, RIG, exact.data, drive.guideway.friction_force(650.0))
    locked = found[np.isfinite(found)]
    assert len(locked) == 2
    assert_allclose(locked, drive.transmission.groups(14.0).creep_stiffness, rtol=1e-9)


@pytest.mark.source("faulring2006", "Eq 18")
def test_eq_18_gives_the_true_efficiency(exact, drive):
    data, friction = exact.data, drive.guideway.friction_force(650.0)
    found = reduce.efficiencies(drive, RIG, data, guideway_friction=friction, nominal=math.nan)
    truth = drive.transmission.operate(
        cylinder_speed=14.0,
        steering_angle=data.steering_angle,
        link_force=data.mass * RIG.gravity + np.sign(data.link_travel) * friction,
    ).efficiency
    used = data.steering_angle != 0
    assert np.isfinite(truth[used]).sum() == 7  # lowering little at 100:1, cylinder and load both feed the losses
    assert_allclose(found.value[used], truth[used], rtol=1e-9)
    assert np.isnan(found.value[~used]).all()
    # The ratio of each run is that of its steering angle, in the file and in the figure; locked, there is none.
    assert_allclose(found.ratio[used], 1.0 / np.abs(np.tan(data.steering_angle[used])), rtol=1e-12)
    assert np.isinf(found.ratio[~used]).all()
    assert_allclose(np.unique(found.ratio[used]), [2.0, 100.0], rtol=1e-12)


def test_a_study_that_knows_of_no_loss_finds_all_of_them(drive, exact):
    """From zero, where no value gives a scale, the exact data lead to the values they were made with. Hysteresis and bearing
    brake alike, so that the one that is sought takes both. 1e-5 is what steps of 1e-5 and the fit's own tolerance leave."""
    known = model.known_values(drive)
    element = drive.transmission
    bare = replace(
        drive,
        motor=replace(drive.motor, no_load_current=0.0),
        gearhead=replace(drive.gearhead, efficiency=1.0),
        transmission=iv.RotaryLinearIVT(
            cylinder_radius=element.cylinder_radius,
            wheel_radius=element.wheel_radius,
            preload=element.preload,
            friction=element.friction,
            creep_stiffness=2.0 * known["creep_stiffness"],
            rolling_torque=0.0,
            bearing_torque=0.0,
        ),
        guideway=iv.parts.Guideway(),
        steering=None,
    )
    sought = ("creep_stiffness", "rolling_torque", "guideway_friction", "nominal_torque")
    assert [model.known_values(bare)[name] for name in sought[1:]] == [0.0, 0.0, 0.0]
    found = fit(Problem.of(bare, RIG, exact.data, sought))
    expected = {**known, "rolling_torque": known["rolling_torque"] + known["bearing_torque"]}
    assert found.identifiable == sought
    assert_allclose([found.values[name] for name in sought], [expected[name] for name in sought], rtol=1e-5)


@pytest.mark.parametrize(
    ("sessions", "low", "high", "near"),
    [(20, 0.8, 1.0, 0.15), pytest.param(400, 0.93, 0.97, 0.03, marks=pytest.mark.full)],
)
@pytest.mark.slow
def test_intervals_contain_the_truth_as_often_as_they_say(drive, sessions, low, high, near):
    """400 sessions, each with its own noise, counts, zero, gain, preload and masses.

    Of 1600 intervals (dependent within a session) 95 % +- 2 % is four standard errors; of 20 sessions, more than four miss an
    interval with a probability of 0.3 %.
    """
    known = model.known_values(drive)
    identifiable = ("creep_stiffness", "guideway_friction", "nominal_torque")
    hits, chi_square = dict.fromkeys((*identifiable, "sum"), 0), []
    for seed in range(sessions):
        found = fit(Problem.of(drive, RIG, session(drive, seed), model.USUAL))
        assert found.identifiable == identifiable
        for name in identifiable:
            ends = found.interval(name)
            hits[name] += ends[0] <= known[name] <= ends[1]
        (combination,) = found.combinations
        assert_allclose([combination.weights[name] for name in ("rolling_torque", "bearing_torque")], 1.0, rtol=1e-6)
        off = combination.value - known["rolling_torque"] - known["bearing_torque"]
        hits["sum"] += abs(off) <= 1.96 * combination.deviation
        chi_square.append(found.chi_square / found.freedom)
    share = {name: count / sessions for name, count in hits.items()}
    print(f"95 % intervals that contain the truth: {share}")
    assert all(low <= found <= high for found in share.values()), share
    assert_allclose(np.mean(chi_square), 1.0, atol=near)


def test_residuals_are_those_of_the_sensors_and_derivatives_those_of_the_residuals(drive):
    problem = Problem.of(drive, RIG, session(drive), (*model.USUAL, "resistance"))
    x = problem.start * 1.02 + 0.1
    forward = problem.jacobian(x)
    for column in range(x.size):
        step = np.zeros(x.size)
        step[column] = 1e-4
        difference = (problem.residuals(x + step) - problem.residuals(x - step)) / 2e-4
        assert_allclose(forward[:, column], difference, rtol=1e-5, atol=1e-5 * np.abs(forward).max())


def test_a_fit_to_data_without_errors_gives_the_truth(drive):
    """From a start 30 % off; the sensors' resolution only weighs then."""
    protocol = virtual_rig.protocol(drive, RIG, ratios=RATIOS)
    data = virtual_rig.experiment(drive, RIG, protocol, exact=True, simulated=False).data
    problem = Problem.of(drive, RIG, data, ("creep_stiffness", "bearing_torque", "guideway_friction", "nominal_torque"))
    off = replace(
        problem, known={**problem.known, "creep_stiffness": 4e4, "bearing_torque": 2e-3, "nominal_torque": 6e-3}
    )
    found, known = fit(off), model.known_values(drive)
    for name in found.names:
        assert_allclose(found.values[name], known[name], rtol=1e-6)


def test_motor_constants_from_current_and_voltage(drive):
    names = (*model.USUAL, "torque_constant", "resistance")
    known = model.known_values(drive)
    found = fit(Problem.of(drive, RIG, session(drive, 5), names))
    for name in ("torque_constant", "resistance"):
        assert abs(found.values[name] - known[name]) < 3.5 * found.deviations[name]
        assert found.deviations[name] < 0.01 * known[name]


@pytest.mark.parametrize("friction", ["coefficient", "skf"])
def test_losses_at_other_preloads_are_those_of_the_geometry(drive, friction):
    """What is fitted holds at the study's preload; SKF's bearing friction does not follow a power of it."""
    geometry = drive.transmission.geometry
    bearing = replace(geometry.axle_bearing, friction_model=friction)
    drive = replace(drive, transmission=replace(drive.transmission, geometry=replace(geometry, axle_bearing=bearing)))
    settings = virtual_rig.protocol(drive, RIG, ratios=RATIOS, preloads=(0.4, 1.6))
    truth = virtual_rig.experiment(drive, RIG, settings, exact=True, simulated=False).data
    identifiable = model.predict(drive, RIG, truth, model.known_values(drive))
    assert len(set(truth.preload)) == 3
    assert_allclose(identifiable.link_travel, truth.link_travel, rtol=1e-9, atol=1e-12)
    assert_allclose(identifiable.motor_current, truth.motor_current, rtol=1e-9)
    assert_allclose(identifiable.motor_voltage, truth.motor_voltage, rtol=1e-9)


def test_loads_and_slip_are_of_the_friction_at_the_speed_of_the_rig(drive):
    """With a limit that falls with speed, loads are shares of what the wheel holds there, and the fitted wheel slips there."""
    element = drive.transmission
    falling = replace(element.geometry, fast_friction_ratio=0.4, friction_decay_speed=0.1)
    drive = replace(drive, transmission=replace(element, geometry=falling, creep_law="vermeulen-johnson"))
    slips = drive.transmission.groups(drive.cylinder_speed).slip_force
    assert slips < 0.41 * element.slip_force
    settings = virtual_rig.protocol(drive, RIG, ratios=RATIOS)
    assert max(one.mass for one in settings) * RIG.gravity == pytest.approx(max(virtual_rig.LOADS) * slips)
    made = virtual_rig.experiment(drive, RIG, settings, exact=True, simulated=False)
    assert not made.left_out
    identifiable = model.predict(drive, RIG, made.data, model.known_values(drive))
    assert_allclose(identifiable.link_travel, made.data.link_travel, rtol=1e-9, atol=1e-12)
    assert_allclose(identifiable.motor_current, made.data.motor_current, rtol=1e-9)


@pytest.mark.slow
def test_a_proportional_gearhead_is_taken_into_account(study):
    drive = study.drives["cobotic-b"]
    truth = virtual_rig.experiment(
        drive, RIG, virtual_rig.protocol(drive, RIG, ratios=RATIOS), exact=True, simulated=False
    ).data
    identifiable = model.predict(drive, RIG, truth, model.known_values(drive))
    assert_allclose(identifiable.motor_current, truth.motor_current, rtol=1e-9)
    found = calibrate(study, "cobotic-b", session(drive))
    assert any("proportional to its load" in remark for remark in found.remarks)


def test_preloads_apart_tell_what_one_preload_cannot(drive):
    """With good sensors: hysteresis grows faster with the preload than bearing friction."""
    rig = replace(
        RIG, current_noise=0.002, current_gain_deviation=5e-4, preload_deviation=1e-3, steering_zero_deviation=1e-5
    )
    data = session(drive, 3, rig, preloads=(0.3, 1.0, 2.0))
    names = ("creep_stiffness", "rolling_torque", "bearing_torque", "guideway_friction", "nominal_torque")
    found, known = fit(Problem.of(drive, rig, data, names)), model.known_values(drive)
    assert found.identifiable == names
    assert not found.combinations
    for name in names:
        assert abs(found.values[name] - known[name]) < 3.5 * found.deviations[name]


@pytest.mark.slow
def test_outliers_are_named_and_left_out(drive, study):
    data = session(drive, 1)
    current = data.motor_current.copy()
    current[[4, 9]] += 0.01, -0.02
    found = calibrate(study, "cobotic", replace(data, motor_current=current))
    assert found.fit.outliers == (4, 9)
    assert any("lines 6, 11" in remark for remark in found.remarks)
    clean = calibrate(study, "cobotic", data.chosen(~np.isin(np.arange(len(data)), [4, 9])))
    assert_allclose(list(found.fit.values.values()), list(clean.fit.values.values()), rtol=1e-5)


@pytest.mark.slow
def test_sensors_worse_than_said_widen_the_intervals(drive, study):
    found = calibrate(study, "cobotic", session(drive, 2, replace(RIG, current_noise=0.06)))
    assert 1.3 < found.fit.widened < 3.0
    assert any("worse than stated in [rig]" in remark for remark in found.remarks)


@pytest.mark.slow
def test_runs_proposed_narrow_what_is_told(drive):
    """Made on the virtual rig, they do what was promised, and more than others would."""
    data = session(drive, 7)
    found = fit(Problem.of(drive, RIG, data, ("creep_stiffness", "bearing_torque", "nominal_torque")))
    proposed = plan.propose(found)
    assert len(proposed.settings) == plan.RUNS

    def after(settings):
        more = virtual_rig.experiment(drive, RIG, settings, exact=True, simulated=False).data
        joined = {name: np.concatenate([getattr(data, name), getattr(more, name)]) for name in COLUMNS}
        both = replace(data, **joined, lines=(*data.lines, *range(100, 100 + len(more))))
        return fit(Problem.of(drive, RIG, both, found.names)).deviations

    helped = after(proposed.settings)
    for name in found.names:
        assert helped[name] <= found.deviations[name] * (1 + 1e-6)
        # The promise counts the masses of new runs as known and is made at the fit.
        assert_allclose(helped[name], proposed.deviations[name], rtol=0.05)
    others = virtual_rig.protocol(drive, RIG, ratios=(50.0,), loads=(0.15,))[2:4] * 2
    volume = [math.prod(deviations.values()) for deviations in (helped, after(others))]
    assert volume[0] < volume[1]


def test_what_the_drive_cannot_do_is_left_out(drive):
    weak = replace(drive, motor=replace(drive.motor, voltage=21.5))
    protocol = virtual_rig.protocol(weak, RIG, ratios=(50.0, 1.0), loads=(0.5,))
    done = virtual_rig.experiment(weak, RIG, protocol, simulated=False)
    assert len(done.data) == len(protocol) - 1
    assert (
        done.left_out
        == (f"1:1 at {-45:.3g} deg, {0.5 * 78 / RIG.gravity:.3g} kg, 650 N: the motor requires 23.6 V of 21.5 V",)
        or "the motor requires" in done.left_out[0]
    )
    short = replace(RIG, travel=0.005)
    done = virtual_rig.experiment(drive, short, virtual_rig.protocol(drive, short, ratios=(1.0,)), simulated=False)
    assert all("too short to measure" in said for said in done.left_out)


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        ({"ratios": (0.0,)}, "ratios must be > 0, got 0"),
        ({"loads": (1.0,)}, "loads must be >= 0 and < 1, got 1"),
        ({"preloads": ()}, "preloads must be > 0, got none"),
    ],
)
def test_protocols_that_mean_nothing(drive, wish, said):
    with pytest.raises(ValueError, match=said):
        virtual_rig.protocol(drive, RIG, **wish)


@pytest.mark.slow
def test_the_calibrated_drive_is_the_study_with_what_was_fitted(drive, study):
    found = calibrate(study, "cobotic", session(drive, 4))
    made = found.calibrated
    groups, values = made.transmission.groups(14.0), found.fit.values
    assert groups.creep_stiffness == values["creep_stiffness"]
    assert_allclose(groups.rolling_torque + groups.bearing_torque, found.fit.combinations[0].value)
    assert_allclose(made.guideway.friction_force(650.0), values["guideway_friction"])
    assert_allclose(model.known_values(made)["nominal_torque"], values["nominal_torque"])
    assert made.motor == drive.motor
    maps = [iv.steady_map(one, [0.1, 0.5], [10.0, 30.0]) for one in (made, drive)]
    assert_allclose(maps[0].power_in, maps[1].power_in, rtol=0.02)


@pytest.mark.parametrize(
    ("matrix", "form"),
    [
        ([[0.0, 1.0, 2.0], [3.0, 0.0, 1.0]], [[1.0, 0.0, 1.0 / 3.0], [0.0, 1.0, 2.0]]),
        ([[1e-9, 1.0], [1.0, 1.0]], [[1.0, 0.0], [0.0, 1.0]]),
        ([[1e-9, 1.0], [-1.0, 1.0]], [[1.0, 0.0], [0.0, 1.0]]),
        ([[0.0, 2.0, 4.0], [0.0, 1.0, 2.0]], [[0.0, 1.0, 2.0]]),
    ],
)
def test_sums_are_written_from_the_largest_pivot(matrix, form):
    """A row that begins with zero, or nearly, must not be taken for one that leaves the parameter out."""
    assert_allclose(fitting._echelon(np.asarray(matrix)), form, atol=1e-8)


def test_only_what_is_asked_for_is_fitted(drive, study):
    found = calibrate(study, "cobotic", session(drive), parameters=("nominal_torque",))
    assert found.calibrated.transmission == drive.transmission
    assert [row.path for row in found.rows] == ["gearhead.efficiency"]
