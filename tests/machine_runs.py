"""Short sessions and runs of each machine that is drawn in motion."""

import functools
from dataclasses import replace

import numpy as np

import infinivar as iv
from internals import ArmLoad, PlatformLoad, SeparateMachine
from machines import HEXAPOD, LEG, MACHINES, PLATFORM, REAL_WHEEL, cart
from made import loaded

DRIVE = loaded("hand_controller").drives["motor1-gear1"]
STEERING = replace(LEG.steering, patch_half_length=3e-4)


@functools.cache
def planar():
    """Along a curve, held beside the centre of mass."""
    points = np.array([[0.05, 0.02], [0.1, 0.03], [0.25, -0.02]])
    path = iv.motion.VirtualPath(curve=iv.motion.PointCurve.through(points), settling_length=0.02)
    start = [0.4, 0.08, 0.0]
    machine = cart(REAL_WHEEL, steering=STEERING)
    return iv.session(
        machine, path, user=[4.0, 6.0], duration=0.03, rates=start, handle=(0.05, 0.02), title="cart & path"
    )


@functools.cache
def slide(count, geared=False):
    """At a wall, on some axes; two have the same mass."""
    masses = [0.5, 0.7, 0.5, 0.3][:count]
    machine = (
        iv.machines.GearedSlideMachine(drive=DRIVE, masses=masses)
        if geared
        else iv.machines.SlideMachine(leg=LEG, masses=masses)
    )
    task = iv.motion.Caster()
    if count <= 3:
        towards = [-1.0] + [0.0] * (count - 1)
        task = iv.motion.VirtualWall(
            surface=iv.motion.HalfSpace(point=[0.001] + [0.0] * (count - 1), direction=towards)
        )
    return iv.session(machine, task, user=[20.0] + [5.0] * (count - 1), duration=0.02)


@functools.cache
def platform():
    """In a plane."""
    plane = iv.motion.Fixture(allowed=iv.motion.InPlane(normal=[0.0, 0.0, 1.0], turning="any"))
    return iv.session(HEXAPOD, plane, user=[6.0, 2.0, -20.0], duration=0.02)


@functools.cache
def geared(name):
    """A platform or arm with a motor for each link, pushed."""
    if name == "platform":
        load, home = PlatformLoad(platform=PLATFORM, mass=1.0, inertia=np.array([1e-3, 1e-3, 2e-3])), HEXAPOD.home
    else:
        arm = iv.transmission.PlanarArm(lengths=[0.3, 0.25])
        load = ArmLoad(arm=arm, pulleys=np.array([0.05, 0.04]), masses=np.array([1.0, 0.6]), tip_mass=0.5)
        home = np.array([0.2, 0.4])
    machine = SeparateMachine(separate=DRIVE, load=load, home=home)
    return iv.session(machine, user=[6.0, -20.0, -8.0][: 3 if name == "platform" else 2], duration=0.01)


@functools.cache
def run(name):
    """A run of one of the machines that tests move."""
    machine, given = MACHINES[name]
    return iv.simulate_machine(machine, iv.motion.MachineScenario(**{**given, "duration": 0.01}))


SHOWN = {
    "planar": planar,
    "slide": lambda: slide(1),
    "geared slide": lambda: slide(1, geared=True),
    "three axes": lambda: slide(3),
    "four axes": lambda: slide(4),
    "platform": platform,
    "geared platform": lambda: geared("platform"),
    "geared arm": lambda: geared("arm"),
    "arm": lambda: run("arm"),
    "serial arm": lambda: run("serial arm"),
    "run of a platform": lambda: run("platform"),
    "run of a cart": lambda: run("planar"),
}
