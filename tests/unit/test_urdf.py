"""Robots from URDF files: against `PlanarArm`, finite differences and a computation by hand; and messages."""

import copy
import pickle
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from made import loaded

LEG = loaded("hand_controller").drives["cobotic"]
RNG = np.random.default_rng(7)
NO_PIN = "pin is not installed: the extra infinivar[robots] has it"


def link(name):
    return f'<link name="{name}"/>'


def joint(name, kind, parent, child, origin="0 0 0", axis="0 0 1", turned="0 0 0", more=None):
    ends = (
        f'<origin xyz="{origin}" rpy="{turned}"/><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>'
    )
    limit = '<limit lower="-3" upper="3" effort="1" velocity="1"/>' if kind in ("revolute", "prismatic") else ""
    return f'<joint name="{name}" type="{kind}">{ends}{limit if more is None else more}</joint>'


def planar(lengths):
    """An arm in the plane of x and y: joints "j0", "j1", ..., and the link "hand" at its end."""
    count = len(lengths)
    links = "".join(link(f"l{place}") for place in range(count + 1)) + link("hand")
    joints = "".join(
        joint(f"j{place}", "revolute", f"l{place}", f"l{place + 1}", f"{lengths[place - 1] if place else 0.0} 0 0")
        for place in range(count)
    )
    end = joint("end", "fixed", f"l{count}", "hand", f"{lengths[-1]} 0 0")
    return f'<robot name="arm">{links}{joints}{end}</robot>'


SPATIAL = "".join(
    [
        '<robot name="spatial">',
        *(link(name) for name in ("base", "turret", "boom", "slide", "wrist", "hand", "finger")),
        joint("turn", "continuous", "base", "turret", "0.1 0 0.3", "0 0 1", "0.2 0 0.4"),
        joint("lift", "revolute", "turret", "boom", "0 0 0.2", "0 1 0"),
        joint("reach", "prismatic", "boom", "slide", "0.4 0 0", "1 0 0"),
        joint("roll", "revolute", "slide", "wrist", "0.2 0 0", "0.6 0 0.8", "0 0.5 0"),
        joint("tip", "fixed", "wrist", "hand", "0.1 0.02 0", "0 0 0"),  # as exporters write it
        joint("grip", "revolute", "hand", "finger"),
        "</robot>",
    ]
)
LEGS = ("roll", "turn", "reach", "lift")


@pytest.fixture
def read(tmp_path):
    """Reads a robot up to where pin is needed."""

    def loaded(text, **given):
        path = tmp_path / "robot.urdf"
        path.write_text(text)
        return iv.transmission.load_urdf(path, **given)

    return loaded


@pytest.fixture
def load(read):
    pytest.importorskip("pinocchio", reason=NO_PIN)
    return read


@pytest.mark.parametrize("lengths", [(0.3,), (0.3, 0.25), (0.3, 0.25, 0.1)])
def test_planar_arms(load, lengths):
    """Jacobian, end point, torques and the machine of legs are those of `PlanarArm`."""
    legs = [f"j{place}" for place in range(len(lengths))]
    arm, robot = (
        iv.transmission.PlanarArm(lengths=lengths),
        load(planar(lengths), legs=legs, frame="hand", pulley_radius=0.05),
    )
    angles = RNG.uniform(-3.0, 3.0, (5, 4, len(lengths)))
    place, axes = robot.pose(angles)
    end = arm.end_point(angles)
    assert_allclose(place[..., :2], end[..., :2], atol=1e-14)
    assert_allclose(axes[..., 0, 0], np.cos(end[..., 2]), atol=1e-14)
    jacobian = robot.jacobian(angles)
    assert_allclose(jacobian[..., [0, 1, 5], :], arm.jacobian(angles), atol=1e-14)
    assert_allclose(jacobian[..., 2:5, :], 0.0, atol=1e-15)
    push = RNG.normal(size=(5, 4, 3))
    whole = np.zeros((5, 4, 6))
    whole[..., [0, 1, 5]] = push
    assert_allclose(robot.joint_torques(angles, whole), arm.joint_torques(angles, push), atol=1e-14)
    own, known = robot.at(angles), arm.parallel(0.05)
    assert_allclose(own.jacobian, np.broadcast_to(known.jacobian, own.jacobian.shape))
    assert_allclose(own.utilisation[iv.Limit.TRAVEL], np.abs(angles).max(-1) / 3.0, rtol=1e-14)
    assert_allclose(own.link_position, 0.05 * angles)


def test_components_and_joint_rates_are_one_machine(load):
    """The same push and motion, as wrench and twist of the hand or as torques and rates of the joints."""
    robot = load(planar((0.3, 0.25)), legs=("j0", "j1"), frame="hand", pulley_radius=(0.05, 0.04))
    angles, push, speed = np.array([[0.4, 1.1], [-0.2, 0.9]]), np.array([3.0, -1.5]), np.array([0.1, -0.2])
    drive = iv.machines.LeggedDrive.of(LEG, 2)
    by_hand = drive.operate(robot.at(angles, ("x", "y")), wrench=push, twist=speed)
    jacobian = robot.jacobian(angles)[:, :2]
    rates = np.linalg.solve(jacobian, speed)
    torques = robot.joint_torques(angles, np.append(push, np.zeros(4)))
    by_joint = drive.operate(robot.at(angles), wrench=torques, twist=rates)
    assert np.all(by_hand.limit == iv.Limit.OK)
    assert_allclose(by_hand.power_in, by_joint.power_in, rtol=1e-12)
    assert_allclose(by_hand.legs.link_speed, by_joint.legs.link_speed, rtol=1e-12)
    assert_allclose(by_hand.power_out, speed @ push, rtol=1e-12)


def test_spatial_robot_against_differences(load):
    """Oblique axes, a sliding joint, legs in another order than joints, and a joint beyond the end frame."""
    robot = load(SPATIAL, legs=LEGS, frame="hand", pulley_radius=0.05)
    at = np.array([0.3, -0.7, 0.15, 0.4])
    jacobian = robot.jacobian(at)
    for column in range(4):
        step = 1e-6 * np.eye(4)[column]
        (high, turned), (low, before) = robot.pose(at + step), robot.pose(at - step)
        assert_allclose(jacobian[:3, column], (high - low) / 2e-6, atol=1e-9)
        rate = (turned - before) / 2e-6 @ robot.pose(at)[1].T
        assert_allclose(jacobian[3:, column], [rate[2, 1], rate[0, 2], rate[1, 0]], atol=1e-9)
    assert_allclose(robot.levers, [0.05, 0.05, 1.0, 0.05])
    found = robot.at(at, ("x", "y", "z", "rx"))
    twist = RNG.normal(size=4)
    rates = np.linalg.solve(jacobian[:4], twist)
    assert_allclose(found.link_speeds(twist), robot.levers * rates, rtol=1e-12)


def test_singular_poses_and_ranges_are_limits(load):
    robot = load(planar((0.3, 0.25)), legs=("j0", "j1"), frame="hand", pulley_radius=0.05)
    found = robot.at([[0.4, 0.0], [0.4, 1.0], [0.4, 3.5]], ("x", "y"))
    point = iv.machines.LeggedDrive.of(LEG, 2).operate(found, wrench=[1.0, 0.0], twist=[0.05, 0.0])
    assert list(point.limit) == [iv.Limit.LINKAGE, iv.Limit.OK, iv.Limit.TRAVEL]


def test_robots_are_values(load):
    robot = load(SPATIAL, legs=LEGS, frame="hand", pulley_radius=0.05)
    for other in (copy.deepcopy(robot), pickle.loads(pickle.dumps(robot))):
        assert other == robot
        assert hash(other) == hash(robot)
        assert_allclose(other.jacobian(np.zeros(4)), robot.jacobian(np.zeros(4)))


def test_page(load, tmp_path, monkeypatch, capsys):
    """What the page on machines shows of this is true."""
    page = (Path(__file__).parents[2] / "docs" / "machines.md").read_text("utf-8")
    blocks = re.search(r"```xml\n(.*?)```\n.*?```py\n(.*?)```\n.*?```text\n(.*?)```", page, re.DOTALL)
    file, code, shown = blocks.groups()
    (tmp_path / "crane.urdf").write_text(file)
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "page", "exec"), {})
    assert capsys.readouterr().out == shown


# ---- messages

ARM = planar((0.3, 0.25))
GOOD = {"legs": ("j0", "j1"), "frame": "hand", "pulley_radius": 0.05}
WIDE = '<limit lower="1" upper="0" effort="1" velocity="1"/>'


def chained(kind, more=None):
    """A moving joint of a kind between the base and an arm."""
    return (
        f'<robot name="x">{link("base")}{link("l0")}{link("hand")}{joint("first", kind, "base", "l0", more=more)}'
        f"{joint('j0', 'revolute', 'l0', 'hand')}</robot>"
    )


TEXTS = {
    "urdf is not XML: unclosed token": ("<robot name='x'><link", GOOD),
    "urdf must have the root element robot, got sdf": ("<sdf/>", GOOD),
    "frame has an unknown link 'hands' (did you mean 'hand'?); links: l0, l1, l2, hand": (ARM, {"frame": "hands"}),
    "legs has an unknown joint 'joint1'; joints: j0, j1": (ARM, {"legs": ("j0", "joint1")}),
    "legs must be joints of type revolute, continuous, prismatic, got 'end', a fixed joint": (
        ARM,
        {"legs": ("j0", "j1", "end")},
    ),
    "legs must name all joints that move 'hand': 'j1', a revolute joint is missing, and it needs a leg": (
        ARM,
        {"legs": ("j0",)},
    ),
    "legs must be a row of different names, got ('j0', 'j0')": (ARM, {"legs": ("j0", "j0")}),
    "legs must be a row of different names, got 'j0'": (ARM, {"legs": "j0"}),
    "legs must be joints of type revolute, continuous, prismatic, got 'first', a floating joint": (
        chained("floating"),
        {"legs": ("first", "j0")},
    ),
    "legs must name all joints that move 'hand': 'first', a planar joint is missing, and a leg cannot move it": (
        chained("planar"),
        {"legs": ("j0",)},
    ),
    "legs must be joints that move on their own, got 'first', which mimics 'j0'": (
        chained("continuous", '<mimic joint="j0"/>'),
        {"legs": ("first", "j0")},
    ),
    "legs must be joints between the base and 'hand', got 'grip' of another branch": (
        SPATIAL,
        {"legs": (*LEGS, "grip")},
    ),
    "limit of joint 'first' is missing: a prismatic joint needs lower, upper, effort and velocity": (
        chained("prismatic", ""),
        {"legs": ("first", "j0")},
    ),
    "limit of joint 'first' must be a range from lower to upper, got 1 to 0": (
        chained("revolute", WIDE),
        {"legs": ("first", "j0")},
    ),
    "type of joint 'first' must be one of revolute, continuous, prismatic, fixed, floating, planar, got 'screw'": (
        chained("screw"),
        {"legs": ("first", "j0")},
    ),
    "child of joint 'j1' must be a link of the URDF, got l2": (ARM.replace(link("l2"), ""), GOOD),
    "urdf must give each link a name of its own, got 'l1' twice": (ARM.replace(link("l1"), link("l1") * 2), GOOD),
    "urdf must have one link that is no child of a joint, got l0, spare": (
        ARM.replace("</robot>", link("spare") + "</robot>"),
        GOOD,
    ),
    "xyz of the axis of joint 'first' must not be 0, such as '0 0 1', got '0 0 0'": (
        chained("revolute").replace("0 0 1", "0 0 0", 1),
        {"legs": ("first", "j0")},
    ),
    "xyz of the axis of joint 'first' must be three numbers, such as '0 0 1', got '0 0 up'": (
        chained("revolute").replace("0 0 1", "0 0 up", 1),
        {"legs": ("first", "j0")},
    ),
    "xyz of the origin of joint 'j1' must be three numbers, such as '0 0 1', got 'nan 0 0'": (
        ARM.replace("0.3 0 0", "nan 0 0", 1),
        GOOD,
    ),
    "pulley_radius must be given: 2 of the joints turn, got None": (ARM, {"pulley_radius": None}),
    "pulley_radius must be one number, or 2 of them, got shape (3,)": (ARM, {"pulley_radius": [0.1, 0.1, 0.1]}),
    "pulley_radius must be > 0 m, got [0.]": (ARM, {"pulley_radius": [0.1, 0.0]}),
}


@pytest.mark.parametrize("message", TEXTS)
def test_malformed_robots(read, message):
    text, given = TEXTS[message]
    with pytest.raises(iv.InputError) as caught:
        read(text, **GOOD | given)
    assert "robot.urdf: " + message in str(caught.value)


QUESTIONS = {
    "positions must be of shape (..., 2), one for each leg, got shape (3,)": lambda robot: robot.at([0.0, 0.0, 0.0]),
    "positions must be finite, got nan or inf": lambda robot: robot.pose([0.0, np.nan]),
    "components must be 2 different ones, as many as there are legs, got ('x',)": lambda robot: robot.at(
        [0.0, 1.0], ("x",)
    ),
    "components must be of x, y, z, rx, ry, rz, got 'rzz' (did you mean 'rz'?)": lambda robot: robot.at(
        [0.0, 1.0], ("x", "rzz")
    ),
    "wrench must be of shape (..., 6), got shape (2,)": lambda robot: robot.joint_torques([0.0, 1.0], [1.0, 2.0]),
}


@pytest.mark.parametrize("message", QUESTIONS)
def test_wrong_questions(load, message):
    robot = load(ARM, **GOOD)
    with pytest.raises(iv.InputError) as caught:
        QUESTIONS[message](robot)
    assert str(caught.value) == message


def test_missing_file(tmp_path):
    with pytest.raises(iv.InputError, match=r"none\.urdf: no such file"):
        iv.transmission.load_urdf(tmp_path / "none.urdf", **GOOD)


def test_without_pin(tmp_path, monkeypatch):
    path = tmp_path / "robot.urdf"
    path.write_text(ARM)
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(iv.InputError) as caught:
        iv.transmission.load_urdf(path, **GOOD)
    said = "a robot from URDF needs pinocchio; install it with: pip install 'infinivar[robots]'"
    assert str(caught.value) == f"{path}: {said}"
