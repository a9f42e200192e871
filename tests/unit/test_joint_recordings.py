"""The motion of a joint of a simulated robot as a recording: columns and signs, and what a drive of it costs."""

import numpy as np
import pytest

import infinivar as iv
from made import loaded
from run_cli import run

mujoco = pytest.importorskip("mujoco", reason="no MuJoCo: it comes with the extra robots")

ROBOT = """<mujoco><option timestep="0.001"/><worldbody>
<body name="base"><joint type="free"/><geom size="0.1" mass="5" contype="0" conaffinity="0"/>
<body name="leg"><joint name="hip" type="hinge" axis="0 1 0"/><geom size="0.05" pos="0 0 -0.3"
mass="1" contype="0" conaffinity="0"/>
<body name="foot" pos="0 0 -0.5"><joint name="piston" type="slide" armature="0.3" axis="0 0 1"/><geom size="0.03"
mass="0.2" contype="0" conaffinity="0"/></body></body></body>
<body name="ball" pos="1 0 0"><joint name="wrist" type="ball"/><geom size="0.03" mass="0.2" contype="0" conaffinity="0"/></body>
</worldbody><actuator><motor name="hip" joint="hip"/><motor name="piston" joint="piston"/></actuator></mujoco>"""


@pytest.fixture(scope="module")
def trajectory():
    """Model, and two periods of a driven motion: all of it, and whole states."""
    model = mujoco.MjModel.from_xml_string(ROBOT)
    model.opt.gravity[:] = 0.0
    data = mujoco.MjData(model)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    rows = {name: [] for name in ("time", "qpos", "qvel", "qacc", "qfrc_actuator", "state")}
    for _ in range(2001):
        turn = 2.0 * np.pi * data.time
        data.ctrl = 2.0 * np.cos(turn) - 3.0 * data.joint("hip").qpos[0] - 0.5 * data.joint("hip").qvel[0], np.sin(turn)
        mujoco.mj_forward(model, data)
        for name in ("time", "qpos", "qvel", "qacc", "qfrc_actuator"):
            rows[name].append(np.array(getattr(data, name)))
        state = np.empty(mujoco.mj_stateSize(model, kind))
        mujoco.mj_getState(model, data, state, kind)
        rows["state"].append(state)
        mujoco.mj_step(model, data)
    return model, {name: np.array(values) for name, values in rows.items()}


def test_the_only_joint_of_a_robot_needs_no_second_axis(tmp_path):
    text = '<mujoco><worldbody><body><joint name="one" axis="0 1 0"/><geom size="0.1" mass="1"/></body></worldbody></mujoco>'
    time = np.linspace(0.0, 1.0, 11)
    given = {"time": time, "qpos": time**2}
    file = iv.motion.joint_recording(given, mujoco.MjModel.from_xml_string(text), "one", tmp_path / "one.csv")
    np.testing.assert_allclose(iv.read_table(file).columns["angle"].values, time**2, rtol=1e-11)


def without(found, *names):
    return {name: values for name, values in found.items() if name not in names}


@pytest.mark.parametrize(("joint", "position", "force"), [("hip", "angle", "moment"), ("piston", "position", "force")])
def test_columns_are_those_of_the_joint(trajectory, joint, position, force, tmp_path):
    """Found by MuJoCo's own names; the force from outside is opposite to that of the actuators, less the armature's."""
    model, found = trajectory
    file = iv.motion.joint_recording(without(found, "state"), model, joint, tmp_path / "new" / "joint.csv")
    table = iv.read_table(file)
    at, dof = model.joint(joint).qposadr[0], model.joint(joint).dofadr[0]
    rotor = model.dof_armature[dof] * found["qacc"][:, dof]
    wanted = {"time": found["time"], position: found["qpos"][:, at], force: rotor - found["qfrc_actuator"][:, dof]}
    for role, values in wanted.items():
        np.testing.assert_allclose(table.columns[role].values, values, rtol=1e-10, atol=1e-11)
    assert np.ptp(wanted[position]) > 0.01


@pytest.mark.parametrize("left_out", [("qacc",), ("qacc", "qvel")])
def test_without_accelerations_the_slope_of_the_speed_stands_for_them(trajectory, left_out, tmp_path):
    model, found = trajectory
    given = [without(found, "state"), without(found, "state", *left_out)]
    files = [iv.motion.joint_recording(one, model, "piston", tmp_path / f"{len(one)}.csv") for one in given]
    forces = [iv.read_table(file).columns["force"].values for file in files]
    assert np.ptp(forces[0]) > 0.1
    np.testing.assert_allclose(forces[1][5:-5], forces[0][5:-5], atol=0.01 * np.ptp(forces[0]))


def test_whole_states_give_the_same_as_single_arrays(trajectory, tmp_path):
    model, found = trajectory
    whole = {"state": found["state"][None], "qfrc_actuator": found["qfrc_actuator"]}
    one = iv.motion.joint_recording(without(found, "state"), model, "hip", tmp_path / "one.csv")
    other = iv.motion.joint_recording(whole, model, "hip", tmp_path / "other.csv")
    assert one.read_text("utf-8") == other.read_text("utf-8")


def test_a_drive_gives_the_power_of_the_actuator(trajectory, tmp_path):
    """The work on the joint over the run, and from it, are those of MuJoCo's torque and velocity, but for smoothing at 10 Hz."""
    model, found = trajectory
    file = iv.motion.joint_recording(without(found, "state"), model, "hip", tmp_path / "hip.csv")
    motion = iv.motion.Recording.read(file, closed=False)
    result = iv.duty_cycle(loaded("ankle_walking").drives["geared"], iv.DutyCycle(motion=motion, load_inertia=0.0))
    dof = model.joint("hip").dofadr[0]
    power = found["qfrc_actuator"][:, dof] * found["qvel"][:, dof]
    for sign in (1.0, -1.0):
        work = np.trapezoid(np.maximum(sign * power, 0.0), found["time"])
        assert work > 0.1
        assert 2.0 * float(np.mean(np.maximum(sign * result.point.power_out, 0.0))) == pytest.approx(work, rel=0.01)


def test_the_command_writes_a_recording_and_shows_it(trajectory, tmp_path):
    model, found = trajectory
    (tmp_path / "robot.xml").write_text(ROBOT, "utf-8")
    mujoco.mj_saveModel(model, str(tmp_path / "robot.mjb"), None)
    renamed = {"t": found["time"], "q": found["qpos"], "tau": found["qfrc_actuator"]}
    np.savez(tmp_path / "run.npz", **renamed)
    columns = "time=t, position=q, force=tau"
    for robot in ("robot.xml", "robot.mjb"):
        asked = ("motion", "run.npz", "--model", robot, "--joint", "hip", "--columns", columns, "--out", "out")
        done = run(*asked, folder=tmp_path)
        assert done.code == 0, done.err
        assert "Recording: out/hip.csv" in done.out
        assert "moment        'moment [N m]'" in done.out
        wanted = iv.motion.joint_recording(
            without(found, "state", "qvel", "qacc"), model, "hip", tmp_path / "wanted.csv"
        )
        assert (tmp_path / "out" / "hip.csv").read_bytes() == wanted.read_bytes()


PLUGIN = '<mujoco><extension><plugin plugin="infinivar.missing"/></extension></mujoco>'


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("run.npz",), "run.npz: state the model with --model FILE.xml, and its joint with --joint NAME"),
        (("run.npz", "--joint", "hip"), "state the model with --model FILE.xml"),
        (("log.csv", "--model", "robot.xml"), "--model applies to a trajectory in MuJoCo, a file .npz; got log.csv"),
        (("log.csv", "--joint", "hip"), "--joint applies to a trajectory in MuJoCo"),
        (
            ("run.npz", "--model", "no.xml", "--joint", "hip"),
            "no.xml: no such file; the model must be MJCF (.xml) or MJB",
        ),
        (("run.npz", "--model", "plugin.xml", "--joint", "hip"), "plugin.xml: MuJoCo cannot read the model: "),
        (
            ("run.npz", "--model", "robot.xml", "--joint", "hup"),
            "joint 'hup' is not in the model (did you mean 'hip'?)",
        ),
        (("run.npz", "--model", "robot.xml", "--joint", "hip\x1b"), "joints: hip, piston, wrist"),
        (
            ("run.npz", "--model", "robot.xml", "--joint", "wrist"),
            "is a ball joint of several coordinates; it must be a slide",
        ),
        (
            ("run.npz", "--model", "robot.xml", "--joint", "hip", "--columns", "torque=tau"),
            "columns of a trajectory in MuJoCo are time, position, speed, acceleration, force, got 'torque'",
        ),
        (
            ("run.npz", "--model", "robot.xml", "--joint", "hip", "--columns", "force=tau"),
            "run.npz: has no array 'tau'; arrays: time, qpos, qvel, qacc, qfrc_actuator, state; state the force",
        ),
        (("text.npz", "--model", "robot.xml", "--joint", "hip"), "text.npz: must be an NPZ file of numbers"),
        (("object.npz", "--model", "robot.xml", "--joint", "hip"), "object.npz: must be an NPZ file of numbers"),
        (("one.npz", "--model", "robot.xml", "--joint", "hip"), "one.npz: must be an NPZ file of numbers"),
        (
            ("short.npz", "--model", "robot.xml", "--joint", "hip"),
            "short.npz: qpos must be numbers of the shape (9, 13), got",
        ),
        (("nan.npz", "--model", "robot.xml", "--joint", "hip"), "nan.npz: qpos must be finite, got nan in row 3"),
        (
            ("state.npz", "--model", "robot.xml", "--joint", "hip"),
            "state must have rows of time, 13 positions and 11 velocities",
        ),
        (("none.npz", "--model", "robot.xml", "--joint", "hip"), "none.npz: has no array 'time'; arrays: none"),
        (("row.npz", "--model", "robot.xml", "--joint", "hip"), "row.npz: must have at least two rows, got 1"),
        (("missing.npz", "--model", "robot.xml", "--joint", "hip"), "missing.npz"),
    ],
)
def test_bad_input_is_one_message(trajectory, arguments, said, tmp_path):
    _, found = trajectory
    (tmp_path / "robot.xml").write_text(ROBOT, "utf-8")
    (tmp_path / "plugin.xml").write_text(PLUGIN, "utf-8")
    (tmp_path / "log.csv").write_text("time [s],angle [rad]\n0,0\n1,1\n", "utf-8")
    (tmp_path / "text.npz").write_text("time", "utf-8")
    np.savez(tmp_path / "run.npz", **found)
    np.savez(tmp_path / "object.npz", time=np.array([{}], dtype=object))
    np.save(tmp_path / "one.npy", np.zeros(3))
    (tmp_path / "one.npy").rename(tmp_path / "one.npz")
    np.savez(tmp_path / "short.npz", time=found["time"][:9], qpos=found["qpos"][:9, :3])
    wrong = found["qpos"][:9].copy()
    wrong[3] = np.nan
    np.savez(tmp_path / "nan.npz", time=found["time"][:9], qpos=wrong)
    np.savez(tmp_path / "state.npz", state=np.zeros((2, 9, 25)))
    np.savez(tmp_path / "none.npz")
    np.savez(tmp_path / "row.npz", time=found["time"][:1], qpos=found["qpos"][:1])
    done = run("motion", *arguments, "--out", "out", folder=tmp_path)
    assert done.code == 2
    assert said in done.err
    assert done.err.count("\n") == 1
    assert not list((tmp_path / "out").glob("*"))
