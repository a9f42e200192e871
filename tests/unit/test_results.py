"""Results stay as they were computed, compare without surprises, and show themselves: as text, page, table and figure."""

import copy
import dataclasses
import pickle

import matplotlib.figure
import numpy as np
import pytest
import xarray

import infinivar as iv
from infinivar import Result
from infinivar.motion import Course, Waypoints
from internals import (
    Duty,
    FrozenDict,
    engine,
    frozen,
    is_labelled,
    presenter,
    shipped_study,
    virtual_rig,
)
from internals import stored_values as stored
from internals import swept_design as sweep
from locks import SAVED, arrays_in, assert_locked
from public_names import public_names
from sampled import sampled

SPEED, FORCE = np.linspace(0.05, 0.5, 5), np.linspace(5.0, 60.0, 4)
DUTY = Duty(cylinder_speed=90.0, link_force=9.0, ratio=8.0)

STUDY = """
title = "small"

[requirement]
force = "20 N"
speed = "0.2 m/s"

[drives.cobotic]
base = "faulring2006.cobotic"

[uncertainty]
draws = 16

[uncertainty.cobotic]
transmission.preload = "5 %"

[duty.shake]
base = "faulring2006.shake"
"""


def _shaken(drive, study):
    (cycle, *_) = study.duty.values()
    return iv.duty_cycle(drive, cycle, samples=80)


def _calibrated(drive, study):
    runs = virtual_rig.experiment(drive, study.rig, virtual_rig.protocol(drive, study.rig), simulated=False).data
    return iv.calibrate(study, "cobotic", runs)


def _calibrated_gear(drive, study):
    points = {"speed": np.linspace(10.0, 60.0, 24), "torque": np.tile([0.05, 0.15, -0.15, 0.25], 6)}
    noise = {"current": 0.005, "voltage": 0.02}
    geared = study.drives["motor1-gear1"]
    return iv.calibrate(study, "motor1-gear1", virtual_rig.dynamometer(geared, study.rig, noise=noise, **points))


def _dynamic(drive):
    return iv.analysis.dynamic_map(drive, np.geomspace(1.0, 4.0, 4), np.linspace(0.2, 1.0, 3), power=5.0, load_mass=0.8)


MAKE = {
    "map": lambda d, s: iv.steady_map(d, SPEED, FORCE),
    "point": lambda d, s: d.operate(speed=0.1, force=FORCE),
    "single point": lambda d, s: d.operate(speed=0.1, force=10.0),
    "element": lambda d, s: d.transmission.operate(cylinder_speed=100.0, steering_angle=-0.1, link_force=FORCE),
    "rolling patch": lambda d, s: iv.contact.RollingPatch(0.8, cells=8).steady(0.1, 0.2, 0.1),
    "duty": _shaken,
    "moving": lambda d, s: _shaken(d, s).point,
    "heat": lambda d, s: next(found for found in _shaken(d, s).heat.values() if found is not None),
    "dynamic map": lambda d, s: _dynamic(d),
    "trend": lambda d, s: sweep(d.transmission, "preload", [600.0, 700.0], [DUTY])[0],
    "sheet": lambda d, s: iv.contact_sheets(s)[0],
    "steering step": lambda d, s: iv.analysis.steering_steps(s, "cobotic")[0],
    "sensitivity": lambda d, s: iv.sensitivity(s, "cobotic", "efficiency", samples=16),
    "calibration": _calibrated,
    "geared calibration": _calibrated_gear,
    "reproduction": lambda d, s: iv.reproduce(7),
    "study": lambda d, s: s,
    "course": lambda d, s: Course(speed=SPEED.copy(), acceleration=np.zeros(5)),
}  # fmt: skip
FROM_COMPARISON = {
    "comparison": lambda c: c,
    "drive result": lambda c: c.results["cobotic"],
    "duty comparison": lambda c: c.duty["shake"],
    "policy": lambda c: c.duty["shake"].policies["cobotic"][0],
    "two ways": lambda c: c.duty["shake"].two_ways["cobotic"],
    "simulation": lambda c: c.duty["shake"].two_ways["cobotic"].simulation,
    "trajectory": lambda c: c.duty["shake"].two_ways["cobotic"].simulation.trajectory,
    "builds": lambda c: c.builds["cobotic"],
    "builds map": lambda c: c.builds["cobotic"].map,
    "duty builds": lambda c: c.builds["cobotic"].duty["shake"],
}
NAMES = [*MAKE, *FROM_COMPARISON]
DRAWN = [name for name in NAMES if name not in ("study", "course")]


@pytest.fixture(scope="module")
def shipped():
    return shipped_study("faulring2006")


@pytest.fixture(scope="module")
def results(shipped, tmp_path_factory):
    drive = shipped.drives["cobotic"]
    found = {name: make(drive, shipped) for name, make in MAKE.items()}
    file = tmp_path_factory.mktemp("study") / "small.toml"
    file.write_text(STUDY)
    compared = iv.compare(iv.load_study(file))
    return found | {name: take(compared) for name, take in FROM_COMPARISON.items()}


@pytest.mark.parametrize("name", [*MAKE, *FROM_COMPARISON])
def test_every_labelled_result_can_be_written_and_read(results, name, tmp_path):
    found = results[name]
    if not isinstance(found, Result):  # what goes in, not a result
        assert not hasattr(found, "to_netcdf")
        return
    if presenter(type(found), "dataset") is None and not is_labelled(type(found)):
        with pytest.raises(TypeError, match="there is no data set"):
            found.to_netcdf(tmp_path / "result.nc")
        return
    found.to_netcdf(tmp_path / "result.nc")
    with xarray.open_dataset(tmp_path / "result.nc", engine="scipy", decode_timedelta=False) as read:
        assert set(read.data_vars) == set(found.to_xarray().data_vars)
        assert read.attrs.get("verdict") == found.to_xarray().attrs.get("verdict")


def test_a_table_of_a_run_has_one_row_per_instant(results):
    run = results["simulation"]
    assert len(run.to_dataframe()) == len(run.trajectory.to_dataframe()) == len(run.trajectory.time)


def test_figures_without_claims_have_an_empty_table():
    assert len(iv.reproduce(3).to_dataframe()) == 0


def test_tolerances_leave_out_residuals_and_must_be_numbers(results):
    one = results["map"]
    other = dataclasses.replace(
        one, audit_residual=2.0 * one.audit_residual + 1e-17, power_in=one.power_in * (1.0 + 1e-9)
    )
    assert one != other
    assert one.equals(other, rtol=1e-6)
    assert not one.equals(other, rtol=1e-12)
    for wrong in (-1.0, float("nan")):
        with pytest.raises(iv.ParameterError, match="rtol must be >= 0"):
            one.equals(one, rtol=wrong)


def test_what_cannot_be_saved_is_named(results, tmp_path):
    for nothing in ((), 3, (results["map"], 3)):
        with pytest.raises(TypeError, match="got"):
            iv.save(nothing, tmp_path)
    with pytest.raises(iv.InputError, match="name must be"):
        iv.save(results["simulation"], tmp_path, name="../elsewhere")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", NAMES)
def test_no_array_of_a_result_can_be_changed(results, name):
    assert_locked(results[name])


@pytest.mark.parametrize("make", [copy.copy, copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))])
def test_arrays_of_parameters_and_data_are_locked_for_good(shipped, make):
    drive = shipped.drives["cobotic"]
    waypoints = Waypoints(file="", time=[0.0, 1.0, 2.0], position=np.array([0.0, 0.1, 0.0]))
    runs = virtual_rig.experiment(drive, shipped.rig, virtual_rig.protocol(drive, shipped.rig), simulated=False).data
    for value in (waypoints, runs):
        assert list(arrays_in(value))
        assert_locked(value)
        assert_locked(make(value))
    assert hash(make(waypoints)) == hash(waypoints)


@pytest.mark.parametrize("name", NAMES)
def test_no_dictionary_of_a_result_can_be_changed(results, name):
    value = results[name]
    for field in type(value).__slots__:
        if isinstance(mapping := getattr(value, field), dict):
            with pytest.raises(TypeError):
                mapping["new"] = 1


@sampled("name", NAMES, every=3)
def test_copies_and_pickles_are_equal_and_locked(results, name):
    value = results[name]
    for other in (copy.copy(value), copy.deepcopy(value), pickle.loads(pickle.dumps(value))):
        assert (other == value) is True
        assert value.equals(other, rtol=1e-12)
        assert_locked(other)


@sampled("name", NAMES, every=3)
def test_loaded_results_are_equal_and_locked(results, name):
    value = results[name]
    loaded = stored.from_arrays(stored.to_arrays(value, name))
    assert loaded == value
    assert repr(loaded) == repr(value)
    assert_locked(loaded)


def test_public_results_are_among_them(results):
    public = {type(one).__name__ for one in results.values() if isinstance(one, Result)}
    assert {*public}.intersection(name.rpartition(".")[2] for name in public_names()) == SAVED


@pytest.mark.parametrize("name", NAMES)
def test_equality_is_a_bool_whatever_the_other(results, name):
    value = results[name]
    for other in (None, 1.0, "text", np.zeros(3), [value], object()):
        assert (value == other) is False
        assert (value != other) is True
    with pytest.raises(TypeError, match="unhashable"):
        hash(value)


@pytest.mark.parametrize("name", NAMES)
def test_repr_is_a_few_lines(results, name):
    text = repr(results[name])
    assert text.startswith(type(results[name]).__name__)
    assert len(text) < 1000
    assert text.count("\n") < 10


@sampled("name", NAMES, every=6, slow=6)
def test_a_notebook_shows_a_table_and_a_figure(results, name):
    page = results[name]._repr_html_()
    assert "<table>" in page
    assert ("data:image/png" in page) == (name in DRAWN or name == "study")  # that of its comparison
    if hasattr(results[name], "verdict"):
        assert "verdict" in page


@sampled("name", DRAWN, every=3)
def test_plot_gives_a_figure_with_labelled_axes(results, name):
    made = results[name].plot()
    assert isinstance(made, matplotlib.figure.Figure)
    labels = [text for ax in made.axes for text in (ax.get_xlabel(), ax.get_ylabel()) if text]
    assert labels
    if name not in (
        "calibration",
        "geared calibration",
        "reproduction",
        "sensitivity",
        "sheet",
    ):  # their axes have words or formulas
        assert any("[" in label for label in labels), labels


@pytest.mark.parametrize("name", DRAWN)
def test_every_result_is_a_data_set_and_a_table(results, name):
    labelled, table = results[name].to_xarray(), results[name].to_dataframe()
    assert isinstance(labelled, xarray.Dataset)
    assert labelled.data_vars
    assert len(table)
    assert len(table.columns)


def test_map_keeps_its_axes_when_the_callers_arrays_change(shipped):
    speed, force = SPEED.copy(), FORCE.copy()
    steady = iv.steady_map(shipped.drives["cobotic"], speed, force)
    speed[:] = 0.0
    force[:] = 0.0
    assert np.array_equal(steady.speed, SPEED)
    assert np.array_equal(steady.force, FORCE)


@pytest.mark.parametrize("call", ["operate", "deliver"])
def test_point_keeps_its_numbers_when_the_callers_arrays_change(shipped, call):
    element = shipped.drives["cobotic"].transmission
    omega, force, given = np.full(4, 90.0), FORCE.copy(), np.full(4, -0.1 if call == "operate" else 0.2)
    name = "steering_angle" if call == "operate" else "link_speed"
    point = getattr(element, call)(cylinder_speed=omega, link_force=force, **{name: given})
    before = copy.deepcopy(point)
    for array in (omega, force, given):
        array[:] = 1.0  # they are still the caller's to change
    assert point == before


def test_values_that_users_make_are_copied():
    speed = np.ones(3)
    course = Course(speed=speed, acceleration=np.zeros(3))
    speed[0] = 5.0
    assert course.speed[0] == 1.0
    assert speed.flags.writeable


def test_views_of_open_memory_are_copied_and_broadcast_axes_stay_small():
    base = np.arange(3.0)
    view = base[:]
    view.flags.writeable = False
    assert frozen(view) is not view
    wide = frozen(np.broadcast_to(base, (1000, 3)))
    base[0] = 9.0
    assert wide[0, 0] == 0.0
    assert wide.strides[0] == 0
    assert frozen(wide) is wide


@pytest.mark.parametrize(
    "array",
    [
        np.array(1.5),
        np.array([True, False]),
        np.array([1, -2], dtype=np.int8),
        np.array([1.0 + 2.0j]),
        np.array(["2020-01-01", "NaT"], dtype="datetime64[s]"),
        np.array(["ab", "c"]),
        np.zeros((0, 3)),
        np.arange(6.0)[::-2],
        np.arange(6.0).reshape(2, 3).T,
        np.broadcast_to(np.arange(3.0), (4, 3)),
        np.array([1, 2], dtype=">i4"),
        np.array([(1.0, 2)], dtype=[("a", "f8"), ("b", "i4")]),
    ],
    ids=lambda array: f"{array.dtype}{array.shape}",
)
def test_locked_copies_of_all_kinds_of_arrays_hold_the_same(array):
    made = frozen(array)
    assert_locked(made)
    assert made.dtype == array.dtype
    assert made.shape == array.shape
    assert made.tobytes() == array.tobytes()
    assert made.flags.fnc == array.flags.fnc
    assert frozen(made) is made


def test_an_array_of_objects_is_locked_as_a_view():
    made = frozen(np.array([None, "text"], dtype=object))
    assert made.tolist() == [None, "text"]
    with pytest.raises(ValueError, match="WRITEABLE"):
        made.flags.writeable = True


def test_an_array_whose_memory_someone_can_write_to_is_copied():
    given = np.arange(3.0)
    for array in (
        given,
        pickle.loads(pickle.dumps(given)),
        np.frombuffer(bytearray(8)),
        memoryview(given).toreadonly(),
    ):
        array = np.asarray(array)
        assert frozen(array) is not array
        assert_locked(frozen(array))


def test_arrays_of_other_libraries_are_left_alone():
    xp = pytest.importorskip("array_api_strict")
    losses = {"creep": xp.asarray([1.0])}
    assert frozen(losses) is losses
    assert isinstance(frozen({"creep": 1.0}), FrozenDict)


def test_equality_sees_every_number_and_takes_nan_for_nan(shipped):
    drive = shipped.drives["cobotic"]
    steady = iv.steady_map(drive, SPEED, [10.0, 1e4])
    assert np.isnan(steady.power_in).any()
    assert steady == iv.steady_map(drive, SPEED, [10.0, 1e4])
    other = iv.steady_map(drive, SPEED * (1.0 + 1e-9), [10.0, 1e4])
    assert steady != other
    assert steady.equals(other, rtol=1e-6, atol=1e-12)  # the residual of the audit is rounding
    assert not steady.equals(other, rtol=1e-12)


@pytest.mark.slow
def test_simulations_of_the_same_run_are_equal(shipped):
    drive, scenario = shipped.drives["cobotic"], shipped.scenarios["step"]
    one, other = (iv.simulate(drive, scenario) for _ in range(2))
    assert one == other
    assert iv.load_study("studies/hand_controller.toml") == iv.load_study("studies/hand_controller.toml")


@pytest.mark.slow
def test_points_of_traced_arrays_compare_without_an_error():
    jax = pytest.importorskip("jax")
    drive = shipped_study("faulring2006").drives["cobotic"]
    seen = []

    def loss(speed):
        point = drive.operate(speed=speed, force=10.0)
        seen.append((point == drive.operate(speed=speed, force=10.0), point == point))
        return point.power_in

    with engine.local(jax):
        jax.grad(loss)(0.1)
    assert seen == [(False, True)]


def test_data_set_of_a_map_holds_its_numbers(results):
    steady, data = results["map"], results["map"].to_xarray()
    assert data.power_in.dims == ("speed", "force")
    for name in ("power_in", "power_out", "efficiency", "limit", "margin"):
        assert np.array_equal(data[name], getattr(steady, name), equal_nan=True)
        assert data[name].attrs["units"]
    for name, loss in steady.losses.items():
        assert np.array_equal(data[f"loss_{name.replace(' ', '_')}"], loss, equal_nan=True)
    row = steady.to_dataframe().loc[(SPEED[2], FORCE[1])]
    assert row.power_in == steady.power_in[2, 1]


def test_tables_hold_the_numbers_of_their_results(results):
    compared, duty = results["comparison"], results["duty comparison"]
    assert compared.to_dataframe().loc["cobotic", "mean_loss_W"] == compared.results["cobotic"].mean_loss
    assert duty.to_dataframe().loc["cobotic", "energy_J"] == duty.results["cobotic"].energy
    fit = results["calibration"].fit
    assert results["calibration"].to_dataframe()["value"].to_dict() == dict(fit.values)
    ranked = results["sensitivity"]
    assert ranked.to_dataframe()["elasticity"].tolist() == [row.elasticity for row in ranked.influences]
    assert results["sheet"].to_dataframe()["value"].size == len(results["sheet"].lines)
    assert np.array_equal(results["builds"].to_dataframe()["margin"], results["builds"].margin)
    claims = results["reproduction"]
    assert claims.to_dataframe()["verdict"].tolist() == [claim.verdict for claim in claims.claims]
    point = results["point"]
    assert np.array_equal(point.to_xarray().power_in, point.power_in)
    run = results["simulation"]
    assert np.array_equal(run.to_xarray().position_m, run.columns["position_m"])


def test_labels_of_axes_stay_with_the_map(shipped):
    speed = xarray.DataArray(
        SPEED, dims="gait", coords={"gait": [10, 20, 30, 40, 50]}, name="walking_speed", attrs={"note": "m/s"}
    )
    force = xarray.DataArray(FORCE, dims="force", coords={"force": FORCE})
    drive = shipped.drives["cobotic"]
    data = iv.steady_map(drive, speed, force).to_xarray()
    assert data.power_in.dims == ("gait", "force")
    assert data.gait.values.tolist() == [10, 20, 30, 40, 50]
    assert data.walking_speed.dims == ("gait",)
    assert data.walking_speed.attrs["note"] == "m/s"
    assert "speed" not in data.coords
    assert np.array_equal(data.power_in, iv.steady_map(drive, SPEED, FORCE).power_in, equal_nan=True)
    one = iv.steady_map(drive, speed, FORCE).to_xarray()
    assert one.power_in.dims == ("gait", "force")
    with pytest.raises(iv.InputError, match="different dimensions"):
        iv.steady_map(drive, speed, xarray.DataArray(FORCE, dims="gait"))


def test_labelled_points_broadcast_by_name(shipped):
    speed = xarray.DataArray(SPEED, dims="v", coords={"v": SPEED}, name="speed")
    force = xarray.DataArray(FORCE, dims="f", coords={"f": FORCE, "side": ("f", list("abcd"))})
    drive = shipped.drives["cobotic"]
    point = drive.operate(speed=speed, force=force)
    data = point.to_xarray()
    assert data.power_in.dims == ("v", "f")
    assert data.side.values.tolist() == list("abcd")
    assert data.speed.dims == ("v",)
    assert np.array_equal(point.power_in, drive.operate(speed=SPEED[:, None], force=FORCE).power_in, equal_nan=True)
    angle = drive.transmission.steer(cylinder_speed=90.0, link_speed=speed, link_force=force)
    assert isinstance(angle, xarray.DataArray)
    assert angle.dims == ("v", "f")
    with pytest.raises(iv.ParameterError, match="label all arrays or none"):
        drive.operate(speed=speed, force=FORCE)
    with pytest.raises(iv.ParameterError, match="differ"):
        drive.operate(speed=speed, force=xarray.DataArray(SPEED, dims="v", coords={"v": SPEED + 1.0}))


def test_what_has_no_figure_says_so():
    class Plain(Result):
        __slots__ = ()

    with pytest.raises(TypeError, match="there is no figure of Plain"):
        Plain().plot()


def test_every_registered_presenter_exists():
    from infinivar import Reproduction
    from internals import presentation

    for kind in ("plot", "save", "dataset", "table"):
        assert presentation.presented(kind)
    assert presentation.presenter(Reproduction, "save") is not None
    for functions in presentation._PRESENTERS.values():
        for where in functions.values():
            module, _, function = where.partition(":")
            assert callable(getattr(__import__(module, fromlist=[function]), function))
