"""Arms in space from URDF files: against Pinocchio, MuJoCo and closed forms, in studies, in motion, and messages."""

import importlib.metadata
import pickle
import re
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from arms import LEG, MOTOR, STATES, balanced_in_all_quadrants, states, system_of
from infinivar.machines import ArmDrive, RobotDrive
from infinivar.motion import MachinePath, MachineScenario, Sinusoid
from internals import (
    TurningChain,
    compiled_motion,
    course_on_path,
    inputs_of,
    rotation_matrix,
    rotation_vector,
)
from run_cli import run

pin = pytest.importorskip("pinocchio", reason="the extra infinivar[robots] has pin")
ROOT = Path(__file__).parents[2]
SIX = ROOT / "studies" / "robots" / "six_joint_robot.urdf"
PICK = SIX.with_name("pick_and_place.toml")
HOME = (0.0, -1.2, 1.4, -1.77, -1.57, 0.3)
PAYLOAD = {"payload_mass": 1.0, "payload_centre": (0.05, -0.02, 0.01), "payload_inertia": 1e-3}

SWAY = MachinePath(**{name: Sinusoid(distance=0.05, frequency=1.0) for name in ("x", "z")})


def link(name, random=None):
    """A link, of random mass and second moments."""
    if random is None:
        return f'<link name="{name}"/>'
    root = random.normal(size=(3, 3))
    second = 1e-2 * root @ root.T + 1e-3 * np.eye(3)
    tensor = np.trace(second) * np.eye(3) - second
    place = " ".join(f"{one:.6f}" for one in random.normal(size=3) * 0.1)
    rows = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), tensor[np.triu_indices(3)], strict=True)
    moments = " ".join(f'{key}="{value:.9f}"' for key, value in rows)
    mass = f'<mass value="{random.uniform(0.2, 3.0):.6f}"/>'
    return f'<link name="{name}"><inertial><origin xyz="{place}"/>{mass}<inertia {moments}/></inertial></link>'


def joint(name, kind, parent, child, random, more=""):
    place, turned, axis = (" ".join(f"{one:.6f}" for one in random.normal(size=3) * size) for size in (0.2, 0.5, 1.0))
    limit = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{place}" rpy="{turned}"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="{axis}"/>{limit}{more}</joint>'
    )


def random_robot(count, seed):
    """Turning joints in any directions, a hand by a fixed joint, and fingers of another branch, one of which mimics the other."""
    random = np.random.default_rng(seed)
    names = [f"l{place}" for place in range(count + 1)]
    parts = [link(name, random) for name in (*names, "hand", "left", "right")] + [link("tool")]
    kinds = ["continuous", "revolute"] * count
    parts += [joint(f"j{one}", kinds[one], names[one], names[one + 1], random) for one in range(count)]
    parts += [joint("flange", "fixed", names[-1], "hand", random), joint("end", "fixed", "hand", "tool", random)]
    parts += [
        joint("squeeze", "prismatic", "hand", "left", random),
        joint("follow", "prismatic", "hand", "right", random, '<mimic joint="squeeze"/>'),
    ]
    return f'<robot name="random">{"".join(parts)}</robot>'


PUBLIC = {
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "tool0", HOME),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", "tool0", HOME),
    "kinova": ("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector", (0.1, 2.0, 2.0, 0.5, 1.0, 0.3)),
}
"""Robots of the package example-robot-data, with tool and home angles."""


def public(name, folder):
    """File of a public robot without its meshes, its tool and home angles."""
    file, tool, home = PUBLIC[name]
    try:
        known = importlib.metadata.files("example-robot-data")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("public robots are in the package example-robot-data, of 131 MB, which is not installed")
    tree = ElementTree.parse(next(one for one in known or () if str(one).endswith(file)).locate())
    for one in tree.iter("link"):
        for drawn in ("visual", "collision"):
            for shape in one.findall(drawn):
                one.remove(shape)
    tree.write(folder / f"{name}.urdf")
    return folder / f"{name}.urdf", tool, home


@pytest.fixture(scope="module")
def robots(tmp_path_factory):
    """Three robots by name: file, joints and home angles."""
    folder = tmp_path_factory.mktemp("robots")
    found = {"six": (SIX, HOME)}
    for count, seed in ((6, 4), (3, 5)):
        file = folder / f"random{count}.urdf"
        file.write_text(random_robot(count, seed))
        found[f"random {count}"] = file, (0.3, -0.5, 0.7, 0.4, 0.9, -0.2)[:count]
    return found


ROBOTS = ["six", "random 6", "random 3"]
EVERY = [*ROBOTS, *PUBLIC]


@pytest.fixture
def of(robots, tmp_path):
    def made(name="six", **changes):
        file, tool, home = public(name, tmp_path) if name in PUBLIC else (robots[name][0], "tool", robots[name][1])
        known = {"model": str(file), "tool": tool, "home_angles": home, "pulley_radius": 0.05, "separate": MOTOR}
        return RobotDrive(**(known | changes))

    return made


def pin_model(drive):
    """The robot with its payload, all other joints locked, in Pinocchio."""
    whole = pin.buildModelFromUrdf(drive.model)
    locked = [place for place, name in enumerate(whole.names) if place and name not in drive.chain.names]
    model = pin.buildReducedModel(whole, locked, pin.neutral(whole))
    tool = model.frames[model.getFrameId(drive.tool, pin.FrameType.BODY)]
    held = pin.Inertia(
        drive.payload_mass, np.array(drive.payload_centre or (0, 0, 0)), drive.payload_inertia * np.eye(3)
    )
    model.appendBodyToJoint(tool.parentJoint, held, tool.placement)
    return model, model.createData()


def in_pin(model, angles):
    """Coordinates of pin: joints without limits have a cosine and a sine."""
    found = pin.neutral(model)
    for place, angle in enumerate(angles, 1):
        one = model.joints[place]
        found[one.idx_q : one.idx_q + one.nq] = [angle] if one.nq == 1 else [np.cos(angle), np.sin(angle)]
    return found


@pytest.mark.parametrize("name", EVERY)
def test_inverse_dynamics_of_moving_states_are_those_of_pinocchio(of, name):
    drive = of(name, **PAYLOAD)
    model, data = pin_model(drive)
    angles, rates, accelerations = states(drive.links)
    found = drive._members().inertia(angles, rates)
    torques, zero = found.forces(accelerations), None
    for place, (q, v, a) in enumerate(zip(angles, rates, accelerations, strict=True)):
        given = in_pin(model, q)
        expected = pin.rnea(model, data, given, v, a)
        assert_allclose(torques[place], expected, atol=1e-9 * (1.0 + np.abs(expected).max()))
        whole = pin.crba(model, data, given)
        assert_allclose(found.inertia[place], np.triu(whole) + np.triu(whole, 1).T, rtol=1e-9, atol=1e-12)
        energy = pin.computePotentialEnergy(model, data, given) - found.potential[place]
        zero = energy if zero is None else zero
        assert energy == pytest.approx(zero, rel=1e-9, abs=1e-9)
    assert found.potential.min() >= 0.0


@pytest.mark.parametrize("name", EVERY)
def test_inverse_dynamics_of_moving_states_are_those_of_mujoco(of, name):
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is an extra")
    drive = of(name)
    model = mujoco.MjModel.from_xml_string(Path(drive.model).read_text())
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_CONTACT
    data, count = mujoco.MjData(model), drive.links
    own = [model.joint(one) for one in drive.chain.names]
    at, to = [int(one.qposadr[0]) for one in own], [int(one.dofadr[0]) for one in own]
    angles, rates, accelerations = states(count)
    torques = drive._members().inertia(angles, rates).forces(accelerations)
    for place in range(STATES):
        data.qpos[at], data.qvel[to], data.qacc[to] = angles[place], rates[place], accelerations[place]
        mujoco.mj_inverse(model, data)
        assert_allclose(torques[place], data.qfrc_inverse[to], atol=1e-9 * (1.0 + np.abs(torques[place]).max()))


@pytest.mark.parametrize("name", EVERY)
def test_tool_and_its_motion_are_those_of_pinocchio(of, name):
    drive = of(name)
    model, data = pin_model(drive)
    frame = model.getFrameId(drive.tool, pin.FrameType.BODY)
    angles, rates, _ = states(drive.links)
    at = drive.chain.standing(angles)
    jacobian, (place, turn), drift = drive.chain.jacobian(at), drive.chain.tool(at), drive.chain.drift(at, rates)
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    for row, (q, v) in enumerate(zip(angles[:100], rates, strict=False)):
        given = in_pin(model, q)
        pin.forwardKinematics(model, data, given, v, 0.0 * v)
        pin.updateFramePlacements(model, data)
        assert_allclose(place[row], data.oMf[frame].translation, atol=1e-12)
        assert_allclose(turn[row], data.oMf[frame].rotation, atol=1e-12)
        assert_allclose(jacobian[row], pin.computeFrameJacobian(model, data, given, frame, axes), atol=1e-12)
        known = pin.getFrameClassicalAcceleration(model, data, frame, axes).vector
        assert_allclose(drift[row], known, atol=1e-11 * (1.0 + np.abs(known).max()))


@pytest.mark.parametrize("name", ROBOTS)
def test_joint_angles_of_a_pose_are_found(of, name):
    drive = of(name)
    random = np.random.default_rng(3)
    angles = np.array(drive.home_angles) + random.uniform(-0.3, 0.3, (300, drive.links))
    place, turn = drive.chain.tool(drive.chain.standing(angles))
    poses = np.concatenate([place, rotation_vector(turn)], axis=-1)[:, drive._rows]
    found = drive.angles(poses)
    reached = np.isfinite(found).all(axis=-1)
    assert reached.mean() > 0.95
    again, turned = drive.chain.tool(drive.chain.standing(found[reached]))
    assert_allclose(again, place[reached], atol=1e-9)
    if drive.links == 6:
        assert_allclose(turned, turn[reached], atol=1e-9)
    assert np.median(np.abs(found - angles)[reached].max(axis=-1)) < 1e-9
    far = np.array([drive.home]) + np.where(np.arange(drive.links) < 3, 5.0, 0.0)
    point = drive.perform(pose=far, twist=0.0 * far, wrench=0.0 * far)
    assert np.isnan(point.power_in).all()
    assert point.utilisation[iv.Limit.LINKAGE][0] > 1.0


def test_rotation_vectors_up_to_half_a_turn():
    random = np.random.default_rng(0)
    axis = random.normal(size=(200, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    for angle in (0.0, 1e-9, 1e-4, 1.0, 3.0, np.pi - 1e-9):
        assert_allclose(rotation_vector(rotation_matrix(angle * axis)), angle * axis, atol=1e-12)
    half = rotation_vector(rotation_matrix(np.pi * axis))
    assert_allclose(np.abs(np.sum(half * axis, axis=-1)), np.pi, rtol=1e-9)


def test_a_robot_in_a_plane_is_a_planar_arm(tmp_path):
    """The same joints, masses and drive: the same powers at points and on a path."""
    lengths, masses, inertias = (0.3, 0.25), (0.4, 0.3), (4e-3, 2e-3)
    arm = ArmDrive(
        lengths=lengths,
        member_masses=masses,
        member_inertias=inertias,
        gravity=(0.0, -9.81),
        pulley_radius=0.05,
        separate=MOTOR,
    )
    links = "".join(
        f'<link name="l{one}"><inertial><origin xyz="{0.5 * length} 0 0"/><mass value="{mass}"/><inertia ixx="{moment}" '
        f'iyy="{moment}" izz="{moment}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for one, (length, mass, moment) in enumerate(zip(lengths, masses, inertias, strict=True), 1)
    )
    joints = "".join(
        f'<joint name="j{one}" type="continuous"><origin xyz="{start} 0 0"/><parent link="l{one - 1}"/>'
        f'<child link="l{one}"/><axis xyz="0 0 1"/></joint>'
        for one, start in ((1, 0.0), (2, 0.3))
    )
    end = '<joint name="e" type="fixed"><origin xyz="0.25 0 0"/><parent link="l2"/><child link="tool"/></joint>'
    file = tmp_path / "flat.urdf"
    file.write_text(f'<robot name="flat"><link name="l0"/>{links}<link name="tool"/>{joints}{end}</robot>')
    robot = RobotDrive(
        model=str(file),
        home_angles=(0.0, 0.5 * np.pi),
        axes=("x", "y"),
        gravity=(0.0, -9.81, 0.0),
        pulley_radius=0.05,
        separate=MOTOR,
    )
    assert_allclose(robot.home, arm.home, atol=1e-12)
    path = MachinePath(
        x=iv.motion.Sinusoid(distance=0.03, frequency=1.0),
        y=iv.motion.Sinusoid(distance=0.04, frequency=1.0, start=0.2),
        load_mass=0.2,
    )
    one, other = (each.follow(course_on_path(path, arm.coordinates, arm.home)[1]) for each in (arm, robot))
    assert_allclose(one.power_in, other.power_in, rtol=1e-6, atol=1e-9)
    assert_allclose(one.part_forces, other.part_forces, rtol=1e-6, atol=1e-9)
    states_ = np.array([[0.4, 0.9]]), np.array([[1.0, -2.0]])
    one, other = (each.moving(0.2, 1e-3).mechanics(1e-4).at(*states_) for each in (arm, robot))
    assert_allclose(one.inertia, other.inertia, rtol=1e-12)
    assert_allclose(one.bias, other.bias, rtol=1e-12)


@pytest.mark.parametrize("drive", [{"separate": None, "leg": LEG}, {"separate": MOTOR}], ids=["leg", "motor"])
@pytest.mark.parametrize("name", ["random 3", pytest.param("six", marks=pytest.mark.slow)])
def test_powers_balance_in_all_quadrants_and_c_has_the_rates_of_python(of, name, drive):
    machine = of(name, **drive, **PAYLOAD).moving(0.5, 1e-3)
    system = system_of(machine)
    motion, found = (
        compiled_motion(system),
        balanced_in_all_quadrants(system, machine.home, each=10, farthest=2.0, fastest=3.0),
    )
    for inputs, outside, state, moved in found:
        if motion is not None:
            rates = motion.called("rates_at", motion.states, state, inputs_of(inputs, outside))
            size = np.abs(moved.derivative).max()
            assert_allclose(rates, moved.derivative[0], rtol=1e-9, atol=1e-12 * size)


@pytest.mark.parametrize("drive", [{"separate": None, "leg": LEG}, {"separate": MOTOR}], ids=["leg", "motor"])
def test_a_steady_point_stores_what_lifts_the_arm(of, drive):
    arm = of(**drive, gravity=(0.0, 0.1, -0.2))
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 2)).reshape(2, -1).T
    twist, wrench = (signs[:, one : one + 1] * size * np.ones(6) for one, size in ((0, 0.02), (1, 0.3)))
    point = arm.perform(pose=arm.home, twist=twist, wrench=wrench)
    assert_allclose(point.power_out, np.sum(twist * wrench, axis=-1), rtol=1e-9, atol=1e-15)
    kept = point.power_out + point.loss + sum(point.stored.values())
    assert_allclose(point.power_in, kept, rtol=1e-9, atol=1e-9)


STUDY = """
[drives.robot]
type = "arm"
model = "robot.urdf"
home_angles = { value = [0.0, -1.2, 1.4, -1.77, -1.57, 0.3], unit = "rad" }
pulley_radius = "50 mm"
payload_mass = "0.2 kg"
[drives.robot.separate]
base = "faulring2006.motor2-gear4"
gearhead = { ratio = 100 }
[tasks.lift]
pose = { z = "0.4 m" }
twist = { z = "0.05 m/s" }
wrench = { z = "2 N" }
[paths.swing]
load_mass = "0.1 kg"
z = { shape = "sinusoid", distance = "40 mm", frequency = "0.5 Hz" }
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "robot.urdf").write_text(SIX.read_text())

    def written(text=STUDY):
        file = tmp_path / "robot.toml"
        file.write_text(text)
        return iv.load_study(file)

    return written


def test_a_study_names_the_file_beside_it(study, tmp_path, monkeypatch):
    made = study()
    drive = made.drives["robot"]
    assert drive.payload_mass == 0.2
    assert drive.home == pytest.approx(drive.chain.pose(np.array(HOME)))
    found = iv.compare(made)
    assert "robot" in found.verdict
    assert found.results["robot"].audit_residual < 1e-9
    monkeypatch.chdir(tmp_path.parent)
    iv.save_study(made, tmp_path / "again.toml")
    again = iv.load_study(tmp_path / "again.toml").drives["robot"]
    assert again == drive
    assert pickle.loads(pickle.dumps(drive)) == drive
    (tmp_path / "over.toml").write_text('extends = "robot.toml"\n[drives.robot]\npayload_mass = "0.3 kg"\n')
    assert iv.load_study(tmp_path / "over.toml").drives["robot"].payload_mass == 0.3


def test_the_example_says_what_the_manual_says_in_a_few_seconds(tmp_path):
    began = time.process_time()
    iv.compare(iv.load_study(PICK))
    assert time.process_time() - began < 5.0
    found, manual = run("compare", PICK, "--quick", folder=tmp_path), ROOT / "docs" / "machines.md"
    printed = found.out.splitlines()[:5]
    assert "\n".join(printed) in manual.read_text("utf-8")


@pytest.mark.slow
def test_a_simulation_draws_the_power_of_the_verdict(study):
    made = study()
    drive = made.drives["robot"]
    for task in (made.tasks["lift"], made.paths["swing"]):
        found = iv.perform_task(drive, task) if task is made.tasks["lift"] else iv.follow_path(drive, task)
        moved = iv.simulate(drive, task)
        assert moved.closure < 1e-6
        known = found.mean_power if task is made.tasks["lift"] else found.controlled_power
        assert sum(moved.mean_powers.values()) == pytest.approx(known, rel=0.03)


def test_meshes_are_not_read_and_links_without_mass_are_named(of, study, tmp_path):
    mesh = '<visual><geometry><mesh filename="package://nowhere/tool.stl"/></geometry></visual>'
    text = SIX.read_text().replace('<link name="tool"/>', f'<link name="tool">{mesh}</link>')
    file = tmp_path / "robot2.urdf"
    file.write_text(text)
    assert of(model=str(file)).lacking == {"masses of links tool": "the model states none"}
    found = iv.compare(study(STUDY.replace("robot.urdf", "robot2.urdf")))
    assert "Not counted: masses of links tool (the model states none)." in found.verdict


def without_masses(tmp_path, *links):
    """The robot of six joints, in whose file some links, or all, have no mass."""
    file, names = tmp_path / "bare.urdf", "|".join(links) or '[^"]*'
    text, count = re.subn(
        f'(<link name="(?:{names})">)\\s*<inertial>.*?</inertial>', r"\1", SIX.read_text(), flags=re.DOTALL
    )
    assert count == (len(links) or 7)
    file.write_text(text)
    return str(file)


def test_a_robot_without_masses_is_massless(of, tmp_path):
    bare = of(model=without_masses(tmp_path))
    links = "masses of links shoulder, upper_arm, forearm, wrist_1_link, wrist_2_link, wrist_3_link"
    assert bare.lacking == {links: "the model states none"}
    assert set(bare.perform(pose=bare.home, twist=np.zeros(6), wrench=np.zeros(6)).part_forces) == {0.0}
    with pytest.raises(iv.ParameterError, match="model must state masses beyond each joint to move in time"):
        bare.moving()
    assert replace(bare, **PAYLOAD).lacking == bare.lacking


MASSLESS = [("wrist_3_link",), ("wrist_2_link",), ("wrist_2_link", "wrist_3_link")]


@pytest.mark.parametrize("links", MASSLESS, ids="+".join)
def test_a_link_without_mass_leaves_the_weight_of_all_others(of, tmp_path, links):
    """As Pinocchio has it, at rest and in motion."""
    drive = of(model=without_masses(tmp_path, *links))
    model, data = pin_model(drive)
    instants, course = course_on_path(SWAY, drive.coordinates, drive.home)
    angles, rates, _, _ = drive._placed(course.pose[1:4], course.twist[1:4], course.wrench[1:4])
    accelerations, carried = (
        course.rate(drive._placed(course.pose, course.twist, course.wrench)[1]),
        drive.carried(course),
    )
    for place in range(0, len(instants), 7):
        at, speed, change = angles[1, place], rates[1, place], accelerations[1, place]
        expected = pin.rnea(model, data, in_pin(model, at), speed, change)
        assert np.abs(expected).max() > 5.0
        assert_allclose(carried.load[1, place], expected, atol=1e-9 * np.abs(expected).max())
    held = iv.perform_task(drive, iv.motion.MachineTask())
    weight = pin.computeGeneralizedGravity(model, data, in_pin(model, np.array(HOME)))
    assert_allclose(np.abs(held.point.part_forces), np.abs(weight), atol=1e-9 * np.abs(weight).max())


@pytest.mark.parametrize("links", [(), *MASSLESS], ids=lambda links: "+".join(links) or "all with mass")
def test_slow_motion_costs_what_its_steady_points_do(of, tmp_path, links):
    """What accelerates falls with the square of the frequency, the power with the first power."""
    drive = of(model=without_masses(tmp_path, *links)) if links else of()
    slow = replace(SWAY, **{name: Sinusoid(distance=0.05, frequency=1e-3) for name in ("x", "z")})
    for found in (iv.follow_path(drive, slow), iv.perform_task(drive, iv.motion.MachineTask())):
        assert found.mean_power == pytest.approx(found.steady_power, rel=1e-3)
        assert_allclose(found.point.part_forces, found.steady.part_forces, rtol=1e-3, atol=1e-3)
        assert found.mean_power > 0.3


def test_a_user_moves_the_tool_of_a_robot(of):
    machine = of("random 3", **PAYLOAD).moving(0.5, 1e-3)
    found = iv.session(machine, iv.motion.Caster(), user=[2.0, 0.0, 1.0], duration=0.02)
    assert found.closure < 1e-6
    assert found.position.shape[-1] == 3
    chain: TurningChain = machine.load.chain
    place, _ = chain.tool(chain.standing(np.array([machine.home])))
    assert_allclose(found.position[0], place[0], atol=1e-12)


def test_a_simulation_starts_at_home_and_stays(of):
    found = iv.simulate_machine(of("random 3", **PAYLOAD).moving(), MachineScenario(duration=0.02))
    assert found.closure < 1e-6
    assert np.ptp(found.columns["q1_rad"]) < 1e-3
