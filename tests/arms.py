"""Arms with members of any mass, and the same arms in Pinocchio and MuJoCo."""

import numpy as np
import pytest

from infinivar.machines import ArmDrive
from internals import System, SystemInputs
from made import loaded

LEG, MOTOR = loaded("hand_controller").drives["cobotic"], loaded("hand_controller").drives["motor2-gear4"]
GRAVITY = (1.3, -9.7)
BODY = {
    "lengths": (0.3, 0.25, 0.12),
    "member_masses": (0.4, 0.3, 0.1),
    "member_centres": (0.12, 0.15, -0.02),
    "member_offsets": (0.01, -0.03, 0.02),
    "member_inertias": (4e-3, 2e-3, 3e-4),
    "payload_mass": 0.25,
    "payload_centre": (0.05, -0.02),
    "payload_inertia": 2e-4,
}
STATES = 1000


def of(count, drive=None, **changes):
    """An arm of `BODY` with its first members."""
    known = {name: value[:count] if name.startswith(("lengths", "member")) else value for name, value in BODY.items()}
    return ArmDrive(pulley_radius=0.05, **(drive or {"separate": MOTOR}), **(known | {"gravity": GRAVITY} | changes))


def states(count):
    """Random angles, rates and accelerations of some joints."""
    rng = np.random.default_rng(count)
    return rng.uniform(-3.0, 3.0, (STATES, count)), *rng.normal(0.0, 4.0, (2, STATES, count))


def pin_model(arm):
    """The arm with its payload as a body of its own, in Pinocchio."""
    pin = pytest.importorskip("pinocchio", reason="the extra infinivar[robots] has pin")
    model = pin.Model()
    model.gravity.linear = np.array([*(arm.gravity or (0.0, 0.0)), 0.0])
    parent, place = 0, 0.0
    for length, mass, along, across, inertia in zip(
        arm.lengths, arm.member_masses, arm.member_centres, arm.member_offsets, arm.member_inertias, strict=True
    ):
        at = pin.SE3(np.eye(3), np.array([place, 0.0, 0.0]))
        parent, place = model.addJoint(parent, pin.JointModelRZ(), at, f"q{model.njoints}"), length
        turned = np.diag([inertia] * 3)
        model.appendBodyToJoint(parent, pin.Inertia(mass, np.array([along, across, 0.0]), turned), pin.SE3.Identity())
    ahead, left = arm.payload_centre
    held = pin.Inertia(arm.payload_mass, np.array([ahead, left, 0.0]), np.diag([arm.payload_inertia] * 3))
    model.appendBodyToJoint(parent, held, pin.SE3(np.eye(3), np.array([place, 0.0, 0.0])))
    return pin, model, model.createData()


def mujoco_model(arm):
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is an extra")

    def body(mass, along, across, inertia, inside):
        turned = " ".join([f"{inertia!r}"] * 3)
        return f'<inertial pos="{along!r} {across!r} 0" mass="{mass!r}" diaginertia="{turned}"/>{inside}'

    ahead, left = arm.payload_centre
    inside = f'<body pos="{arm.lengths[-1]} 0 0">{body(arm.payload_mass, ahead, left, arm.payload_inertia, "")}</body>'
    for place in reversed(range(arm.links)):
        start = arm.lengths[place - 1] if place else 0.0
        rows = (arm.member_masses, arm.member_centres, arm.member_offsets, arm.member_inertias)
        within = body(*(row[place] for row in rows), f'<joint axis="0 0 1"/>{inside}')
        inside = f'<body pos="{start} 0 0">{within}</body>'
    x, y = arm.gravity
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="{x} {y} 0"/><worldbody>{inside}</worldbody></mujoco>'
    )
    return mujoco, model, mujoco.MjData(model)


def system_of(machine):
    """A machine with its motors and servos, and a load on its joints."""
    mechanics = machine.mechanics(1e-4)
    return System(
        mechanics=mechanics,
        motor=machine.power_motor(1e-4),
        links=machine.link_motors(1e-4),
        servo=machine.servo(1e-4),
        wrench=lambda time: np.full(mechanics.load.links, 0.3),
    )


def balanced_in_all_quadrants(system, home, *, each, farthest, fastest):
    """Yield inputs, what acts from outside, state and motion at random states; powers must be the rate of the energies.

    The derivative of the energies along the motion is exact, by a step in the complex plane.
    """
    count = system.mechanics.load.links
    random, idle, start = np.random.default_rng(count), system.idle(), np.zeros(1)
    residual, peak, quadrants = 0.0, 0.0, set()
    for rate, pull in ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)):
        for _ in range(each):
            state = random.uniform(-farthest, farthest, len(system.begun(home, np.zeros(system.places[1] - count))))
            state[count : 2 * count] = rate * random.uniform(0.1, fastest, count)
            inputs = SystemInputs(*(pull * random.uniform(0.1, 1.0, one.shape) for one in idle))
            outside = system.outside(start)
            outside = outside._replace(pushed=-pull * outside.pushed)
            moved = system.moved(inputs, outside, state[None])
            balance = moved.balance()
            along = system.energies(start, state + 1e-30j * moved.derivative).imag.sum() / 1e-30
            assert balance.stored[0] == pytest.approx(system.energies(start, state[None]).sum(), rel=1e-12)
            residual = max(residual, abs(float(system.balance @ balance.power[0]) - along))
            peak = max(peak, np.abs(balance.power).max())
            quadrants.add((balance.power[0, 0] > 0.0, rate > 0.0))
            yield inputs, outside, state, moved
    assert residual < 1e-9 * peak
    assert len(quadrants) == 4
