"""Machines along random courses: the power balance with steering, rotors and moving masses closes in all quadrants."""

import tomllib
from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import infinivar as iv
from infinivar.motion import MachinePath, MachineTask
from internals import as_machine
from internals import course_on_path as on_path
from internals import course_through as through
from internals import power_audit as audit
from machine_studies import PLANAR, SPHERE
from made import loaded
from sampled import sampled

LEGS = loaded("six_leg_display").drives
ARMS = loaded("two_joint_arm").drives
LINES = loaded("hand_controller").drives
SERVO = loaded("guided_cart").drives["cart"].steering
CART = replace(
    iv.Study.from_dict(tomllib.loads(PLANAR), name="p").drives["cart"], mass=8.0, inertia=0.6, steering=SERVO
)
BALL = replace(
    iv.Study.from_dict(tomllib.loads(SPHERE), name="s").drives["ball"], output_inertia=5e-5, sphere_inertia=3e-4
)
MACHINES = {
    "six legs": LEGS["one-motor-b"],
    "six motors": LEGS["six-motors"],
    "arm on legs": ARMS["one-motor"],
    "arm with motors": ARMS["two-motors"],
    "line, cobotic": LINES["cobotic"],
    "line, geared": LINES["motor2-gear4"],
    "cart": CART,
    "sphere": BALL,
}
SIZES = {"x": (0.02, 15.0), "y": (0.02, 15.0), "z": (0.02, 15.0), "angle": (0.5, 0.05)}
"""Displacement [m], [rad], and wrench [N], [N m]."""
HELD = dict.fromkeys(("rx", "ry", "rz"), (0.15, 0.5))

unit = st.floats(-1.0, 1.0)


def drawn(data, machine):
    """Rates and wrenches of all coordinates, from -1 to 1 of their sizes."""
    sizes = {name: (SIZES | HELD)[name] for name in machine.coordinates}
    moves = {name: data.draw(unit) * size for name, (size, _) in sizes.items()}
    pushes = {name: data.draw(unit) * size for name, (_, size) in sizes.items()}
    return moves, pushes


def balance(machine, course, where):
    point = machine.follow(course)
    if point is None:
        return
    stored = sum(point.stored.values())
    assert audit(point.power_in, point.power_out + stored, point.losses, where) < 1e-9
    held = np.sum(course.wrench[2] * course.twist[2], axis=-1)
    known = np.isfinite(point.power_in)
    assert np.allclose(np.broadcast_to(point.power_out, known.shape)[known], np.broadcast_to(held, known.shape)[known])


@sampled("name", MACHINES, every=5)
@given(data=st.data())
def test_balance_closes_in_tasks(name, data):
    machine = as_machine(MACHINES[name])
    moves, pushes = drawn(data, machine)
    pose = {"x": 0.3, "y": 0.25} if name.startswith("arm") else {}
    task = MachineTask(
        pose=iv.motion.Pose(**pose),
        twist=iv.motion.Twist(**{one: 5.0 * size for one, size in moves.items()}),
        wrench=iv.motion.Wrench(**pushes),
    )
    names = machine.coordinates
    rows = task.pose.row(names, machine.home), task.twist.row(names), names, task.corners(names)
    balance(machine, through(*rows), name)


@sampled("name", MACHINES, every=5)
@given(data=st.data(), frequency=st.floats(0.3, 3.0))
def test_balance_closes_on_paths(name, data, frequency):
    machine = as_machine(MACHINES[name])
    moves, pushes = drawn(data, machine)
    pose = {"x": 0.3, "y": 0.25} if name.startswith("arm") else {}
    motions = {}
    for place, (one, size) in enumerate(moves.items()):
        way = {"angle": abs(size) + 1e-3} if one[0] in "ra" else {"distance": abs(size) + 1e-3}
        motions[one] = iv.motion.Sinusoid(**way, frequency=frequency, start=place * 0.3 / frequency)
    path = MachinePath(pose=iv.motion.Pose(**pose), wrench=iv.motion.Wrench(**pushes), **motions)
    _, course = on_path(path, machine.coordinates, machine.home)
    few = slice(None, None, 40)
    balance(
        machine,
        replace(course, **{row: getattr(course, row)[:, few] for row in ("pose", "twist", "acceleration", "wrench")}),
        name,
    )
