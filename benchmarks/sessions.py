"""Sessions of a user at a handle: processor time of a planar cobot and of six legs, two seconds at 1 kHz each.

The planar cobot follows a circle with real servos on its three wheels. The legs move a platform by admittance under the force
of an arm; a shorter session stands for two seconds, as the time grows with the number of samples. Reading the study and
importing what sessions need are not counted.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

import infinivar as iv
from benchmarks._measure import STUDY, Line

PLANAR, LEGS = 0.5, 2.0
"""Most processor time of a session of two seconds. [s]"""

_DURATION = 2.0
_SHARE = 0.25
"""Of two seconds that the legs move."""


def planar(duration: float = _DURATION) -> iv.Session:
    """A cart with three wheels on a circle."""
    leg = iv.load_study(STUDY).drives["cobotic"]
    assert isinstance(leg, iv.CoboticDrive)
    wheel = iv.transmission.RollingContact(
        wheel_radius=0.02,
        preload=500.0,
        friction=0.2,
        creep_stiffness=2e4,
        rolling_torque=0.005,
        bearing_torque=0.002,
    )
    points = [(0.3, 0.0), (-0.15, 0.2), (-0.15, -0.2)]
    assert leg.steering is not None
    machine = iv.machines.PlanarMachine(
        cobot=iv.transmission.PlanarCobot(contacts=wheel, positions=points, mass=10.0, inertia=0.8),
        steering=replace(leg.steering, patch_half_length=3e-4),
    )
    circle = iv.motion.ArcCurve(centre=[0.0, 0.0], radius=0.5)
    return iv.session(
        machine,
        iv.motion.VirtualPath(curve=circle),
        user=lambda at: [-6.0 * math.sin(at), 6.0 * math.cos(at)],
        duration=duration,
        pose=[0.5, 0.0, 0.0],
        rates=[0.0, 0.5, 0.0],
    )


def legs(duration: float = _SHARE * _DURATION) -> iv.Session:
    """A platform on six legs that an arm moves."""
    leg = iv.load_study(STUDY).drives["cobotic"]
    assert isinstance(leg, iv.CoboticDrive)
    machine = iv.machines.PlatformMachine(
        leg=leg, platform=iv.transmission.Platform.hexapod(), mass=1.0, inertia=[1e-3, 1e-3, 2e-3]
    )
    home = machine.home[:3]
    return iv.session(
        machine,
        controller=iv.machines.AdmittanceGuide(mass=2.0, damping=5.0),
        user=iv.motion.ArmModel.named("vanbeek2015"),
        intention=lambda at: home + np.array([0.01 * math.sin(6.0 * at), 0.0, -0.005 * math.sin(5.0 * at)]),
        duration=duration,
    )


def run() -> Iterator[Line]:
    """Measure both."""
    yield _line("planar cobot, three wheels with servos", planar, 1.0, PLANAR)
    yield _line("six legs with servos", legs, 1.0 / _SHARE, LEGS)


def _line(what: str, made: Callable[..., iv.Session], times: float, target: float) -> Line:
    made(duration=0.005)
    start = time.process_time()
    found = made()
    spent = times * (time.process_time() - start)
    assert found.complete
    assert found.closure < 1e-6
    return Line(
        what=f"session of 2 s at 1 kHz, {what}",
        ours=f"{spent:.3g} s",
        theirs="",
        ratio="",
        target=f"<= {target:g} s",
        passed=spent <= target,
    )
