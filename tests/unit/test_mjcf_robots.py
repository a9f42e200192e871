"""Arms in space from MJCF files: against MuJoCo itself and against the same robot as a URDF, in a study, and messages."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from arms import MOTOR, STATES, states
from infinivar.machines import RobotDrive
from run_cli import run

mujoco = pytest.importorskip("mujoco", reason="the extra infinivar[robots] has mujoco")
SIX = Path(__file__).parents[2] / "studies" / "robots" / "six_joint_robot.urdf"
HOME = (0.0, -1.2, 1.4, -1.77, -1.57, 0.3)

WRIST = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="stand" pos="0.1 0 0.3" euler="0.2 -0.1 0.4">
      <inertial pos="0 0 0.1" mass="5" diaginertia="0.1 0.1 0.05"/>
      <body name="shoulder" pos="0 0.05 0.2" euler="0.3 0.2 0.1">
        <joint name="yaw" axis="0 0.2 1" pos="0.01 0.02 0" range="-2.8 2.8" limited="true"/>
        <joint name="pitch" axis="0.1 1 0" pos="0 0 0.05"/>
        <inertial pos="0.02 0 0.1" euler="0.1 0.2 0.3" mass="1.5" diaginertia="0.02 0.015 0.01"/>
        <body name="lower" pos="0 0 0.4" euler="-0.2 0.5 0">
          <joint name="elbow" axis="1 0.3 0"/>
          <geom type="capsule" size="0.03" fromto="0 0 0 0 0.1 0.3" mass="0.8"/>
          <site name="flange" pos="0 0.1 0.35" euler="0.4 0 0.2"/>
          <body name="finger" pos="0 0.12 0.3">
            <joint name="grip" type="slide" axis="1 0 0"/>
            <geom size="0.02" mass="0.2"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def drive_of(file, tool, home):
    known = {"model": str(file), "tool": tool, "home_angles": home, "pulley_radius": 0.05, "separate": MOTOR}
    return RobotDrive(**known)


@pytest.fixture
def wrist(tmp_path):
    file = tmp_path / "wrist.xml"
    file.write_text(WRIST, "utf-8")
    return file


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The shipped robot as a URDF, and as MuJoCo writes it."""
    folder = tmp_path_factory.mktemp("six")
    text = SIX.read_text("utf-8").replace("<robot ", '<robot xmlns:m="m" ', 1)
    compiler = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco>'
    (folder / "six.urdf").write_text(re.sub(r"(<robot[^>]*>)", rf"\1{compiler}", text, count=1), "utf-8")
    mujoco.mj_saveLastXML(str(folder / "six.xml"), mujoco.MjModel.from_xml_path(str(folder / "six.urdf")))
    return SIX, folder / "six.xml"


def test_inverse_dynamics_and_poses_are_those_of_mujoco(wrist):
    """Of joints that share a body, axes beside origins and a gripper that stays; at random moving states."""
    drive = drive_of(wrist, "flange", (0.3, -0.5, 0.7))
    assert drive.chain.names == ("yaw", "pitch", "elbow")
    assert drive.chain.ranges == ((-2.8, 2.8), None, None)
    model = mujoco.MjModel.from_xml_path(str(wrist))
    model.opt.gravity[:] = drive.gravity
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    angles, rates, accelerations = states(3)
    forces = drive._members().inertia(angles, rates).forces(accelerations)
    for row in range(0, STATES, 7):
        for own, values in ((data.qpos, angles), (data.qvel, rates), (data.qacc, accelerations)):
            own[:] = [*values[row], 0.0]
        mujoco.mj_inverse(model, data)
        assert_allclose(forces[row], data.qfrc_inverse[:3], atol=1e-9 * (1.0 + np.abs(forces[row]).max()))
        place, turn = drive.chain.tool(drive.chain.standing(angles[row][None]))
        assert_allclose(place[0], data.site("flange").xpos, atol=1e-12)
        assert_allclose(turn[0], data.site("flange").xmat.reshape(3, 3), atol=1e-12)


def test_a_robot_is_the_same_from_both_files(both):
    """Forces of moving states and poses; MuJoCo writes numbers with six digits."""
    pytest.importorskip("pinocchio", reason="the extra infinivar[robots] has pin")
    drives = [drive_of(file, "tool", HOME) for file in both]
    assert drives[0].chain.names == drives[1].chain.names
    angles, rates, accelerations = states(6)
    urdf, mjcf = (one._members().inertia(angles, rates).forces(accelerations) for one in drives)
    assert_allclose(mjcf, urdf, atol=1e-5 * np.abs(urdf).max())
    poses = [one.chain.pose(np.array(HOME)) for one in drives]
    assert_allclose(poses[0], poses[1], atol=1e-5)


def test_a_study_reads_it(both, tmp_path):
    """The shipped study with the other file of the robot: the same verdict and powers."""
    pytest.importorskip("pinocchio", reason="the extra infinivar[robots] has pin")
    text = SIX.with_name("pick_and_place.toml").read_text("utf-8")
    shutil.copy(both[1], tmp_path / "six.xml")
    shutil.copy(both[0], tmp_path)
    for name, model in (("urdf", "six_joint_robot.urdf"), ("mjcf", "six.xml")):
        (tmp_path / f"{name}.toml").write_text(text.replace("six_joint_robot.urdf", model), "utf-8")
    found = [iv.compare(iv.load_study(tmp_path / f"{name}.toml"), quick=True) for name in ("urdf", "mjcf")]
    for one, other in zip(*(each.results.values() for each in found), strict=True):
        assert other.mean_power == pytest.approx(one.mean_power, rel=1e-4)
        assert other.feasible == one.feasible


@pytest.mark.parametrize(
    ("old", "new", "tool", "said"),
    [
        (
            "",
            "",
            "flang",
            "tool has an unknown body or site 'flang' (did you mean 'flange'?); there are stand, shoulder, lower, finger, flange",
        ),
        ("", "", "stand", "tool must be a link that a joint moves, got 'stand'"),
        ("", "", "finger", "joint 'grip' between base and 'finger' is prismatic"),
        ("<mujoco>", "<mujoca>", "flange", "MJCF is not valid"),
        ('mass="1.5"', 'mass="-1.5"', "flange", "MJCF is not valid"),
        ('name="elbow" ', 'name="elbow" ref="0.3" ', "flange", "ref of joint 'elbow' must be 0, got 0.3"),
        (
            "</worldbody>",
            '</worldbody><equality><joint joint1="elbow" joint2="pitch"/></equality>',
            "flange",
            "joint 'elbow' between base and 'flange' mimics 'pitch'",
        ),
    ],
)
def test_bad_files_are_named(wrist, old, new, tool, said):
    wrist.write_text(WRIST.replace(old, new) if old else WRIST, "utf-8")
    with pytest.raises(iv.ParameterError, match=r"^model = 'wrist.xml': ") as problem:
        drive_of(wrist, tool, (0.3, -0.5, 0.7))
    assert said in str(problem.value)


def test_a_missing_file_is_one_line(tmp_path):
    text = SIX.with_name("pick_and_place.toml").read_text("utf-8").replace("six_joint_robot.urdf", "none.xml")
    (tmp_path / "study.toml").write_text(text, "utf-8")
    done = run("check", "study.toml", folder=tmp_path)
    assert (done.code, len(done.err.strip().splitlines())) == (2, 1)
    assert "none.xml" in done.err
