"""Every result is saved and loaded again, equal to what it was; what cannot be saved or trusted is named."""

import functools
import tomllib
from dataclasses import dataclass, replace

import numpy as np
import pytest

import infinivar as iv
import machine_runs
import machine_studies
from infinivar import Result
from internals import compare_machines, mixed_use
from internals import stored_values as stored
from locks import SAVED, assert_locked
from made import parameter_study
from public_names import public_names
from sampled import sampled
from small_catalogue import SLIDE, slides

WHEEL = iv.transmission.RollingContact(
    wheel_radius=0.03, preload=200.0, friction=0.2, creep_stiffness=4000.0, rolling_torque=0.009, bearing_torque=0.006
)
BALL = iv.SphericalIVT(sphere_radius=0.03, drive=replace(WHEEL, surface="sphere"))
CART = iv.transmission.PlanarCobot(
    contacts=WHEEL, positions=((0.4, 0.0), (-0.2, 0.25), (-0.2, -0.25)), mass=20.0, inertia=1.5
)
PLATFORM = iv.transmission.Platform.hexapod()
HOME = PLATFORM.at([0.0, 0.0, PLATFORM.home])
RISING = np.array([0.0, 0.0, 0.05, 0.0, 0.0, 0.0])
ARM = iv.motion.ArmModel.named("vanbeek2015")
STUDY = parameter_study("faulring2006")
LEG, SEPARATE = STUDY.drives["cobotic"], STUDY.drives["motor2-gear4"]
LEGS = iv.machines.LeggedDrive.of(LEG, 6)


@functools.cache
def machines(name="arm"):
    return iv.Study.from_dict(tomllib.loads(machine_studies.EVERY[name]), name=name)


def _task_point(folder):
    drive = machines().drives["cobotic"]
    return drive.perform(pose=np.array(drive.home), twist=np.array([0.05, 0.0]), wrench=np.array([3.0, 0.0]))


def _walk(folder):
    time = np.linspace(0.0, 5.0, 501)
    rows = "".join(f"{t:.2f},{20.0 * np.sin(2.0 * np.pi * t):.6f}\n" for t in time)
    (folder / "walk.csv").write_text("time [s],position [mm]\n" + rows)
    return folder / "walk.csv"


def _averaged(folder):
    return iv.motion.Recording.read(str(_walk(folder)), strides="average")


def _sized(folder):
    study = iv.load_study(slides(folder, SLIDE) / "slide.toml")
    return iv.size(study, sets=folder / "shelf.toml", top=1)


def _swept(folder):
    problem = iv.sweeps.sessions_sweep(
        iv.load_study("hand_controller"), "cobotic", ratios=(20.0, 4.0), loads=(0.2, 0.5), creep_laws=("linear",),
        sessions=2, size=2,
    )  # fmt: skip
    return problem, iv.sweep(problem, folder / "sweep")


def _run_builds(folder):
    path = folder / "mine.toml"
    path.write_text(
        'extends = "hand_controller"\n[uncertainty.cobotic.motor]\nresistance = "10 %"\n'
        '[scenarios.short]\nbase = "faulring2006.hold"\nduration = "0.02 s"\n',
        "utf-8",
    )
    problem = iv.sweeps.runs_sweep(iv.load_study(path), draws=16, scenario="short", size=16)
    return problem.result(iv.sweep(problem, folder / "sweep"))


def _mixed(folder):
    shake = iv.duty_cycle(LEG, next(iter(STUDY.duty.values())), samples=80)
    return mixed_use({"one": {"cobotic": shake}, "other": {"cobotic": shake}}, {"one": 0.4, "other": 0.6})


MAKE = {
    "CommonSpeed": lambda folder: iv.analysis.best_cylinder_speed(LEGS, HOME, wrench=np.zeros((1, 6)), twist=RISING[None]),
    "Configuration": lambda folder: HOME,
    "DisplayClaims": lambda folder: iv.paper.display_claims(),
    "DisplayComparison": lambda folder: iv.displays.compare_displays(
        iv.displays.DisplayPair(cobotic=LEG, conventional=SEPARATE), axes=(1,)
    ),
    "DirectionLimits": lambda folder: iv.displays.worst_direction(
        iv.displays.AdmittanceDisplay(drive=LEG, virtual_mass=1.0, filter_frequency=100.0), np.eye(2), ARM
    ),
    "Doubt": lambda folder: iv.doubt(_sized(folder), builds=16),
    "GuidanceLimits": lambda folder: iv.displays.guidance_limits(LEG, speed=0.3, push=20.0),
    "Hanging": lambda folder: iv.compare(machines(), quick=True).hangs_on,
    "LeastLoss": lambda folder: iv.analysis.least_loss(
        replace(STUDY, drives={"cobotic": LEG, "geared": SEPARATE}), speed=np.linspace(0.05, 0.4, 5), force=[10.0, 30.0]
    ),
    "LegsPoint": lambda folder: iv.transmission.Legs(transmission=LEG.transmission, count=6).operate(
        HOME, wrench=10.0 * RISING, twist=RISING, cylinder_speed=LEG.cylinder_speed
    ),
    "MachineComparison": lambda folder: compare_machines(machines()),
    "MachinePoint": lambda folder: LEGS.operate(HOME, wrench=100.0 * RISING, twist=RISING),
    "MachineRun": lambda folder: machine_runs.run("planar"),
    "MeasuredReport": lambda folder: iv.calibration.measured_report("robot_motors"),
    "MechanismPoint": lambda folder: CART.mechanism.solve(
        heading=[0.0, 0.0, 0.0], rates={"x": 0.5}, applied={"y": 0.0, "angle": 0.0}
    ),
    "MixedUse": _mixed,
    "MotionSummary": lambda folder: iv.inspect_motion(_walk(folder)),
    "Passivity": lambda folder: iv.displays.passivity(
        iv.displays.ImpedanceDisplay(drive=SEPARATE, wall_stiffness=2000.0, viscous_friction=2.0)
    ),
    "RunBuilds": lambda folder: _run_builds(folder),
    "Session": lambda folder: machine_runs.slide(1),
    "Sessions": lambda folder: (lambda problem, swept: problem.result(swept))(*_swept(folder)),
    "SharedMotor": lambda folder: iv.analysis.share_motor(LEG, SEPARATE, force=[10.0], legs=[1, 2]),
    "Sizing": _sized,
    "SphereMap": lambda folder: iv.analysis.sphere_map(BALL, [0.1, 0.2], [1.0, 2.0], sphere_speed=1.0),
    "SphericalPoint": lambda folder: BALL.operate(steering_angle=0.1, input_speed=1.0, output_torque=0.1),
    "StabilityMap": lambda folder: iv.displays.stability_map(
        iv.displays.AdmittanceDisplay(drive=LEG, virtual_mass=1.0, filter_frequency=100.0),
        ARM,
        {"virtual_mass": [0.5, 1.0, 2.0], "wall_stiffness": [1e3, 1e4]},
    ),
    "StaticPoints": lambda folder: iv.analysis.static_points(LEGS, PLATFORM, position=[0.0, 0.0, 0.1], wrench=np.zeros(6)),
    "StrideEnergies": lambda folder: iv.analysis.stride_energies(LEG, iv.DutyCycle(motion=_averaged(folder), load_mass=1.0)),
    "Strides": lambda folder: _averaged(folder).averaged,
    "Sweep": lambda folder: _swept(folder)[1],
    "TaskPoint": _task_point,
    "TransientRolling": lambda folder: iv.contact.RollingPatch(0.8, cells=8).transient([0.1, 0.2], 0.1),
    "WorkspaceMap": lambda folder: iv.analysis.workspace_map(
        LEGS, PLATFORM, x=[0.0, 0.01], y=[0.0, 0.01], z=[PLATFORM.home], wrench=np.zeros(6)
    ),
    "WrenchSet": lambda folder: iv.transmission.WrenchSet.of(iv.transmission.Configuration(jacobian=np.eye(3)), [1.0, 2.0, 3.0]),
    "ZWidth": lambda folder: iv.displays.z_width(
        iv.displays.AdmittanceDisplay(drive=LEG, virtual_mass=1.0, filter_frequency=100.0), ARM, frequency=[0.5, 1.0]
    ),
}  # fmt: skip
"""One of each public result that `test_results` does not make."""


def test_every_public_result_is_among_those_saved():
    public = {
        one.__name__
        for one in public_names().values()
        if isinstance(one, type) and issubclass(one, Result) and one is not Result
    }
    assert public == {*MAKE, *SAVED}


MARKS = {"DisplayClaims": pytest.mark.full, "Doubt": pytest.mark.slow, "Sizing": pytest.mark.slow}


@sampled("name", [pytest.param(name, marks=MARKS.get(name, [])) for name in MAKE], every=3)
def test_a_loaded_result_equals_the_saved_one(name, tmp_path):
    found = MAKE[name](tmp_path)
    assert type(found).__name__ == name
    loaded = stored.from_arrays(stored.to_arrays(found, name))
    assert loaded == found
    assert repr(loaded) == repr(found)
    assert_locked(loaded)


SMALL = {
    "requirement": {"force": "20 N", "speed": "0.2 m/s"},
    "drives": {"one": {"base": "faulring2006.cobotic"}},
}


def test_a_session_along_a_curve_computes_the_splines_of_the_curve_again():
    found = machine_runs.planar()
    loaded = stored.from_arrays(stored.to_arrays(found, "session"))
    assert loaded == found
    assert repr(loaded) == repr(found)


POINT = LEG.operate(speed=0.1, force=[10.0, 20.0])


def test_a_result_without_a_report_is_saved_and_loaded(tmp_path):
    (file,) = iv.save(POINT, tmp_path / "new")
    assert file == tmp_path / "new" / "drivepoint.result.npz"
    for place in (file, str(file.parent)):
        assert iv.load_result(place) == POINT


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_a_report_comes_with_the_result_and_what_it_was_computed_from(tmp_path):
    """The study comes back whole: the loaded comparison computes what the saved one does."""
    study = iv.Study.from_dict(SMALL, name="small")
    files = iv.save(iv.compare(study), tmp_path)
    assert files[0].name == "report.html"
    loaded = iv.load_result(tmp_path)
    assert loaded.study == study
    assert iv.compare(loaded.study) == loaded
    sheets = iv.contact_sheets(study)
    iv.save(list(sheets), tmp_path)
    assert iv.load_result(tmp_path, "contactsheet") == tuple(sheets)
    with pytest.raises(iv.InputError, match="holds several results; name one of comparison, contactsheet"):
        iv.load_result(tmp_path)
    with pytest.raises(iv.InputError, match=r"holds no result 'comparson' \(did you mean 'comparison'\?\); it has"):
        iv.load_result(tmp_path, "comparson")


@dataclass(frozen=True)
class Own:
    """A part of somebody else."""

    value: float


def held(value):
    """A result with something of others among its states."""
    return replace(POINT, states={"own": value})


def test_what_cannot_be_saved_is_named_with_its_place_and_nothing_is_written(tmp_path):
    with pytest.raises(iv.InputError, match=r"DrivePoint.states\['own'\]: .*<lambda> cannot be saved, as its module"):
        iv.save(held(lambda: 1.0), tmp_path)
    with pytest.raises(iv.InputError, match=r"DrivePoint.states\['own'\]: a generator cannot be saved"):
        iv.save(held(one for one in ()), tmp_path)
    for other in (Own(1.0), 3.0, "text"):
        with pytest.raises(TypeError, match="must be a result of infinivar, got"):
            iv.save(other, tmp_path)
    assert not list(tmp_path.iterdir())


def test_classes_of_others_are_restored_only_if_their_package_is_trusted(tmp_path):
    package = __name__.partition(".")[0]
    (file,) = iv.save(held(Own(1.0)), tmp_path)
    with pytest.raises(
        iv.InputError, match=rf"drivepoint.result.npz: holds .*:Own of another package.*packages=\['{package}'\]"
    ):
        iv.load_result(file)
    assert iv.load_result(file, packages=[package]) == held(Own(1.0))


def rewritten(file, change):
    """A saved file whose text was changed."""
    with np.load(file) as found:
        arrays = dict(found)
    arrays["tree"] = np.frombuffer(change(arrays["tree"].tobytes()), np.uint8)
    np.savez(file, **arrays)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (b'"power_in"', b'"power_on"', "was saved by version .* whose infinivar.drivetrain.drive:DrivePoint had other fields"),
        (b":DrivePoint", b":DrivePint", "whose infinivar.drivetrain.drive:DrivePint this version does not have"),
        (b"infinivar.drivetrain.drive:DrivePoint", b"os:system", "holds os:system of another package"),
        (b"infinivar.drivetrain.drive:DrivePoint", b"infinivar._core.files:os.system", "this version does not have"),
        (b"infinivar.drivetrain.drive:DrivePoint", b"infinivar.nowhere:DrivePoint", "which cannot be imported"),
        (b'["array",0', b'["array",9', "is no saved result, or a damaged one"),
        (b'["array",0', b'["arr",0', "'arr' is no kind of object"),
        (b'{"objects"', b'"objects"', "is no saved result, or a damaged one"),
    ],
)  # fmt: skip
def test_damaged_strange_and_older_files_are_refused(tmp_path, old, new, said):
    (file,) = iv.save(POINT, tmp_path)
    rewritten(file, lambda text: text.replace(old, new))
    with pytest.raises(iv.InputError, match=rf"drivepoint.result.npz: .*{said}"):
        iv.load_result(file)


def test_other_files_are_refused(tmp_path):
    with pytest.raises(iv.InputError, match="holds no saved result; "):
        iv.load_result(tmp_path)
    with pytest.raises(iv.InputError, match="no such file"):
        iv.load_result(tmp_path / "nothing.npz")
    (tmp_path / "text.npz").write_text("text")
    with pytest.raises(iv.InputError, match="is no saved result"):
        iv.load_result(tmp_path / "text.npz")
    np.savez(tmp_path / "other.npz", x=np.arange(3))
    with pytest.raises(iv.InputError, match="a NumPy archive of something else"):
        iv.load_result(tmp_path / "other.npz")
