"""What a study and a URDF file may say of an arm in space: messages, names, and rounded moments of inertia."""

from pathlib import Path

import pytest

import infinivar as iv
from arms import MOTOR
from infinivar.machines import RobotDrive

pytest.importorskip("pinocchio", reason="the extra infinivar[robots] has pin")
SIX = Path(__file__).parents[2] / "studies" / "robots" / "six_joint_robot.urdf"
HOME = (0.0, -1.2, 1.4, -1.77, -1.57, 0.3)


def six(**changes):
    """The robot of six joints."""
    known = {"model": str(SIX), "tool": "tool", "home_angles": HOME, "pulley_radius": 0.05, "separate": MOTOR}
    return RobotDrive(**(known | changes))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"tool": "hand"}, "model = 'six_joint_robot.urdf': tool has an unknown link 'hand'; links: base, "),
        ({"tool": "base"}, "tool must be a link that a joint moves, got 'base', such as shoulder, "),
        ({"home_angles": (0.0,) * 6}, "home_angles must be a pose in which the end point moves along all axes"),
        ({"home_angles": HOME[:5]}, "home_angles must be 6, one for each of shoulder_pan"),
        (
            {"home_angles": (7.0, *HOME[1:])},
            "home_angles must be -6.28 to 6.28 rad for joint 'shoulder_pan', got 7 rad",
        ),
        ({"axes": ("x", "y")}, "axes must be as many as joints that move, 6"),
        ({"axes": ("x", "y", "rz"), "joints": ("elbow", "shoulder_lift", "wrist_1")}, "with all of rx, ry and rz"),
        ({"joints": ("elbow", "shoulder_lift")}, "axes is missing: 2 joints move"),
        (
            {"joints": ("elbows",)},
            "joints has 'elbows', which is no joint between base and 'tool' (did you mean 'elbow'?)",
        ),
        ({"gravity": (0.0, -9.81)}, "gravity must be 3: along x, y and z, got 2 values"),
        ({"payload_centre": (0.1, 0.0, 0.0)}, "payload_mass is missing or 0 kg: payload_centre is stated"),
        ({"payload_inertia": 1e-3}, "payload_mass is missing or 0 kg: payload_inertia is stated"),
        (
            {"home_angles": (*HOME[:4], 0.0, 0.3)},
            "got a singular one, by the places and axes in the model: turning 'shoulder_lift', 'elbow', 'wrist_1' and "
            "'wrist_3' moves it along none of them",
        ),
        ({"model": "none.urdf"}, "model = 'none.urdf': none.urdf: no such file"),
    ],
)
def test_faults_of_fields_are_named(changes, said):
    with pytest.raises(iv.ParameterError) as problem:
        six(**changes)
    assert said in str(problem.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('"wrist_1" type="revolute"', '"wrist_1" type="prismatic"'), "joint 'wrist_1' between base and 'tool' is prismatic"),
        (('<axis xyz="0 0 1"/>\n    <limit lower="-6.28" upper="6.28" effort="150"',
          '<axis xyz="0 0 1"/>\n    <mimic joint="elbow"/> <limit lower="-6.28" upper="6.28" effort="150"'),
         "joint 'shoulder_pan' between base and 'tool' mimics 'elbow'"),
        (('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>'), "xyz of the axis of joint 'shoulder_pan' must not be 0"),
        (('<mass value="8.393"/>', '<mass value="-1"/>'), "mass of link 'upper_arm' must be >= 0 kg, got -1"),
        (('<mass value="8.393"/>', ""), "mass of link 'upper_arm' is missing"),
        (('ixx="0.2269"', 'ixx="-0.2269"'), "inertia of link 'upper_arm' must have moments >= 0"),
        (('ixx="0.2269"', 'ixx="much"'), "ixx of link 'upper_arm' must be a number, got 'much'"),
        (('<inertia ixx="0.2269" ixy="0" ixz="0" iyy="0.2269" iyz="0" izz="0.0151"/>', ""),
         "inertia of link 'upper_arm' is missing: it has a mass of 8.393 kg"),
        (('izz="0.0151"', 'izz="0.4600"'), "inertia of link 'upper_arm' must have two principal moments that add up to no less "
         "than the third, as all bodies have, got 0.227 and 0.227 with 0.46 kg m^2"),
        (('<mass value="8.393"/>', '<mass value="8.393"/><mass value="1"/>'), "inertial of link 'upper_arm' must have one mass"),
        (('<link name="tool"/>', '<link name="tool"><inertial><mass value="0"/></inertial><inertial/></link>'),
         "link 'tool' must have one inertial, got 2"),
        (('</robot>', '<joint name="again" type="fixed"><parent link="base"/><child link="forearm"/></joint></robot>'),
         "link 'forearm' is the child of two joints, 'elbow' and 'again'"),
        (('effort="150"', 'effort="-150"'), "effort of the limit of joint 'shoulder_pan' must be >= 0, got -150"),
        (('effort="150"', 'effort="much"'), "effort of the limit of joint 'shoulder_pan' must be a number, got 'much'"),
    ],
)  # fmt: skip
def test_faults_of_the_file_are_named(tmp_path, change, said):
    file, text = tmp_path / "wrong.urdf", SIX.read_text()
    assert change[0] in text
    file.write_text(text.replace(*change, 1))
    with pytest.raises(iv.ParameterError) as problem:
        six(model=str(file))
    assert said in str(problem.value)


def test_flat_bodies_may_be_rounded_to_three_digits(tmp_path):
    """A plate has Ixx + Iyy = Izz; of these moments, each rounded, the sum falls short of the third."""
    file, text = tmp_path / "flat.urdf", SIX.read_text()
    given = '<inertia ixx="0.2269" ixy="0" ixz="0" iyy="0.2269" iyz="0" izz="0.0151"/>'
    assert given in text
    for moments in ((0.1044, 0.1044, 0.2088), (0.1104, 0.5004, 0.6108), (0.1054, 0.0, 0.1056)):
        ixx, iyy, izz = (f"{one:.3g}" for one in moments)
        plate = f'<inertia ixx="{ixx}" ixy="0" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/>'
        file.write_text(text.replace(given, plate))
        assert six(model=str(file)).links == 6


def test_links_may_have_the_names_of_joints(tmp_path):
    file = tmp_path / "alike.urdf"
    file.write_text(SIX.read_text().replace("_link", ""))
    assert six(model=str(file), joints=("elbow", "shoulder_lift", "shoulder_pan"), home_angles=HOME[:3]).links == 3
    assert six(model=str(file)).home == six().home
