"""Platforms on omniwheels: balances of power at rest and along courses, inertia, limits on the ground, and simulation."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from internals import moving_machine
from sampled import sampled

STUDY = "omniwheel_platform"


def drives():
    return iv.load_study(STUDY).drives


def drawn(rng, count):
    return rng.uniform(-2, 2, (count, 3)), rng.normal(0, 0.2, (count, 3)), rng.normal(0, 3.0, (count, 3))


@pytest.mark.parametrize("name", ["three-motors", "one-motor", "mecanum"])
def test_power_balances_at_random_points(name):
    """Power in is power out and losses, in all quadrants; tolerance: rounding of powers of some watts."""
    pose, twist, wrench = drawn(np.random.default_rng(1), 5000)
    point = drives()[name].perform(pose=pose, twist=twist, wrench=wrench)
    fine = np.isfinite(point.power_in)
    assert fine.mean() > (0.15 if name == "one-motor" else 0.99)  # beyond slip a leg has no steady motion
    assert_allclose((point.power_in - point.power_out - point.loss)[fine], 0.0, atol=1e-9)
    assert_allclose(point.power_out[fine], np.sum(wrench * twist, axis=-1)[fine], atol=1e-12)
    assert all(np.all(loss[fine] >= -1e-12) for loss in point.losses.values())
    assert {"wheels", "rollers"} <= set(point.losses)


def test_friction_of_wheels_and_rollers_by_hand():
    """Sideways on four mecanum wheels all rims and rollers turn: v = v_y, s = sqrt2 v_y; straight ahead no roller does."""
    drive = drives()["mecanum"]
    load = 20.0 * 9.80665 / 4
    for twist, wheels, rollers in (((0.4, 0, 0), 0.4, 0.0), ((0, 0.4, 0), 0.4, np.sqrt(2) * 0.4)):
        point = drive.perform(pose=np.zeros(3), twist=twist, wrench=np.zeros(3))
        assert_allclose(point.losses["wheels"], 4 * 0.01 * load * wheels, rtol=1e-12)
        assert_allclose(point.losses["rollers"], 4 * 0.02 * load * rollers, rtol=1e-12, atol=1e-12)


def test_slip_on_the_ground_by_hand():
    """A push of 15 N along x, held: three rims at 120 degrees share 2/3 of it; no friction acts at rest."""
    point = drives()["three-motors"].perform(pose=np.zeros(3), twist=np.zeros(3), wrench=[15.0, 0, 0])
    expected = 2 / 3 * 15.0 * np.abs(np.cos(np.radians([90, 210, 330]))) / (0.4 * 20.0 * 9.80665 / 3)
    for place, demand in enumerate(expected, 1):
        assert_allclose(point.demands[iv.Limit.SLIP, f"wheel {place} on the ground"], demand, atol=1e-12)


@pytest.mark.parametrize("name", ["three-motors", "mecanum"])
def test_the_ground_carries_the_wrench(name):
    """Forces of the ground on all wheels hold what the machine exerts on its load, whatever rubs; tolerance: rounding."""
    pose, twist, wrench = drawn(np.random.default_rng(3), 2000)
    drive = drives()[name]
    along, across = drive.on_ground(drive.perform(pose=pose, twist=twist, wrench=wrench), pose, twist)
    axle = pose[:, 2, None] + np.add(drive.headings, drive.wheels.roller_angles)
    force = along * np.array([np.cos(axle), np.sin(axle)]) + across * np.array([-np.sin(axle), np.cos(axle)])
    points, turn = np.asarray(drive.wheels.positions), pose[:, 2, None]
    arm = np.array([np.cos(turn) * points[:, 0] - np.sin(turn) * points[:, 1],
                    np.sin(turn) * points[:, 0] + np.cos(turn) * points[:, 1]])  # fmt: skip
    moment = arm[0] * force[1] - arm[1] * force[0]
    total = np.stack([force[0].sum(-1), force[1].sum(-1), moment.sum(-1)], axis=-1)
    assert_allclose(total, wrench, atol=1e-10)


def test_kinetic_energy_changes_by_the_forces_alone():
    """nu (dM/dt / 2) nu = nu h for a mass matrix that turns with the body; differences of 1e-6 s."""
    load = drives()["mecanum"].moving().load
    rng = np.random.default_rng(2)
    pose, twist = rng.uniform(-2, 2, (50, 3)), rng.normal(size=(50, 3))
    step = 1e-6
    later, before = (load.at(pose + sign * step * twist, twist).moved.inertia for sign in (1, -1))
    change = np.einsum("mi,mij,mj->m", twist, (later - before) / (2 * step), twist)
    bias = np.sum(load.at(pose, twist).moved.bias * twist, axis=-1)
    assert_allclose(0.5 * change, bias, atol=1e-8)


def test_links_accelerate_as_their_speeds_change():
    load = drives()["three-motors"].moving().load
    pose, twist = np.array([[0.1, 0.2, 0.7]]), np.array([[0.3, -0.2, 1.1]])
    step = 1e-6
    later, before = (load.at(pose + sign * step * twist, twist).speed for sign in (1, -1))
    assert_allclose(load.at(pose, twist).bias, (later - before) / (2 * step), rtol=1e-7)


def test_a_course_balances_with_what_it_stores():
    """Along the path of the study: power in is power out, losses and power stored; relative to the largest power."""
    found = iv.compare(iv.load_study(STUDY))
    for name, one in found.results.items():
        point = one.paths["aside"].point
        stored = sum(point.stored.values())
        scale = np.max(np.abs(point.power_in))
        assert_allclose(point.power_in - point.power_out - point.loss - stored, 0.0, atol=2e-4 * scale, err_msg=name)


@pytest.mark.full
def test_the_path_takes_what_a_simulation_draws():
    """Inverse dynamics against simulation with servos: within 2 %, as the pauses settle."""
    study = iv.load_study(STUDY)
    judged = iv.compare(study).results["three-motors"].paths["aside"]
    run = iv.simulate(study.drives["three-motors"], study.paths["aside"])
    assert run.feasible
    period = judged.period
    drawn_energy = run.supplied["supply"] if "supply" in run.supplied else sum(run.supplied.values())
    half = np.interp(run.time[-1] - period, run.time, drawn_energy)
    assert_allclose((drawn_energy[-1] - half) / period, judged.mean_power, rtol=0.02)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mass": None}, "rolling_friction"),
        ({"headings": (0.0, 0.0, 0.0)}, "headings leave a motion that turns no wheel"),
        ({"headings": (0.0, 1.0)}, "headings"),
        ({"roller_angles": (1.5,)}, "roller_angles"),
        ({"wheel_radius": 0.0}, "wheel_radius"),
        ({"positions": (iv.motion.Point(x=0.1), iv.motion.Point(x=-0.1))}, "positions"),
        (
            {"positions": (iv.motion.Point(x=0.1, z=0.2), iv.motion.Point(x=-0.1), iv.motion.Point(y=0.1))},
            "z does not apply",
        ),
    ],
)
def test_faults_name_the_field(change, said):
    with pytest.raises(iv.ParameterError, match=said):
        dataclasses.replace(drives()["three-motors"], **change)


@sampled("name", ["three-motors", "one-motor"], every=2)
def test_a_platform_moves_and_is_drawn(name, tmp_path):
    """A short motion: the balance closes, frames have each wheel along its rolling direction, the scene is written."""
    drive = drives()[name]
    time = np.linspace(0.0, 0.05, 21)
    away = np.sin(20.0 * time) ** 2
    motion = iv.motion.VectorHistory(time=time, values=np.stack([2e-3 * away, 0.0 * away, 0.01 * away], axis=-1))
    run = iv.simulate_machine(drive.moving(), iv.motion.MachineScenario(duration=0.05, motion=motion))
    assert run.complete
    assert run.closure < 1e-6
    assert {"wheels", "rollers"} <= set(run.lost)
    frame = moving_machine.data(run, np.array([0.0, 0.05]))["frame"]
    wheels = np.array([one.points for one in frame(1) if one.look == "wheel"])
    turn = run.columns["angle_rad"][-1] + np.asarray(drive.headings)
    expected = drive.wheel_radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    assert_allclose(0.5 * (wheels[:, 0] + wheels[:, 1]) - wheels.mean(axis=1), expected, atol=1e-12)
    pytest.importorskip("mujoco")
    run.to_mujoco(tmp_path / "platform.xml")
    assert (tmp_path / "platform.xml").read_text("utf-8").count("zaxis") >= 3


def test_a_machine_without_a_graph_says_so():
    with pytest.raises(iv.ParameterError, match="there is none of a platform on omniwheels"):
        iv.machine_graph(drives()["one-motor"].moving())


def test_a_wheel_that_rounding_turns_stands():
    """Driven along x, the wheel that heads along y does not roll: its motor spends nothing, as it does turned by 90 degrees."""
    drive = drives()["three-motors"]
    ahead = drive.perform(pose=[0.0, 0.0, 0.0], twist=[0.3, 0.0, 0.0], wrench=[15.0, 0.0, 0.0])
    turned = dataclasses.replace(
        drive,
        headings=tuple(one - np.pi / 2 for one in drive.headings),
        positions=tuple(iv.motion.Point(x=one.y or 0.0, y=-one.x) for one in drive.positions),
    )
    across = turned.perform(pose=[0.0, 0.0, 0.0], twist=[0.0, -0.3, 0.0], wrench=[0.0, -15.0, 0.0])
    assert float(ahead.power_in) == pytest.approx(float(across.power_in), rel=1e-9)
    assert float(ahead.part_speeds[0]) == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("twist", [(0.3, 0.0, 0.0), (0.0, 0.0, 0.8)], ids=["along", "turning"])
def test_a_task_takes_what_a_simulation_draws(twist):
    """Within 1 %: what remains is the ripple of the cylinder's speed after half a second."""
    study = iv.load_study(STUDY)
    drive = study.drives["one-motor"]
    wrench = np.sign(twist) * (15.0, 15.0, 3.0)
    rates, loads = (dict(zip(drive.coordinates, map(float, row), strict=True)) for row in (twist, wrench))
    task = dataclasses.replace(
        study.tasks["push"], twist=iv.motion.Twist(**rates), wrench=iv.motion.Wrench(**loads), box=None
    )
    power = sum(iv.simulate(drive, task).mean_powers.values())
    steady = drive.perform(pose=task.pose.row(drive.coordinates, drive.home), twist=twist, wrench=wrench)
    assert power == pytest.approx(float(steady.power_in), rel=0.01)
