"""Controllers of machines in compiled C: the same runs as with the same controllers in Python."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import SampledSteps, SessionSetup, c_library
from machine_runs import DRIVE, STEERING
from machines import HEXAPOD, LEG, MACHINES, REAL_WHEEL, cart
from sampled import sampled

pytestmark = pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler on this machine")

CART = cart(REAL_WHEEL, steering=STEERING)
ARC = iv.motion.ArcCurve(centre=[0.0, 0.0], radius=0.5)
POINTS = iv.motion.PointCurve.through(np.array([[0.5, 0.0], [0.52, 0.05], [0.5, 0.1], [0.47, 0.15]]))


def sensed(random):
    """Sensors with resolution, differences, filters and noise, each with even odds."""
    rough = {
        "angle_resolution": 1e-6,
        "position_resolution": 1e-7,
        "steering_resolution": 1e-5,
        "differenced": True,
        "speed_filter": 100.0,
        "force_filter": 80.0,
        "force_noise": 0.01,
    }
    return iv.machines.Sensing(seed=int(random.integers(100)), **{k: v for k, v in rough.items() if random.integers(2)})


def pushed(random, count):
    """A force that turns and, half the time, jumps."""
    size, pace, jumps = random.normal(size=count) * 5.0, random.uniform(2.0, 20.0), random.integers(2)
    return lambda at: size * np.cos(pace * at + np.arange(count)) * (1.0 if at < 0.0213 or not jumps else -0.5)


def on_wheels(random, task, **more):
    """A cart of a random mass that moves to the left, along x and turned, pushed at a handle off its centre."""
    cobot = replace(CART.cobot, mass=random.uniform(5.0, 20.0))
    start = {"pose": [0.5, 0.0, 0.0], "rates": [0.0, random.uniform(0.2, 0.6), 0.0]}
    return {"machine": replace(CART, cobot=cobot), "task": task, "user": pushed(random, 2), **start, **more}


def on_legs(random, machine, axes, home, **guide):
    """A machine with legs in the hand of an arm that swings."""
    size, pace = random.normal(size=axes) * 0.01, random.uniform(3.0, 10.0)
    return {
        "machine": machine,
        "controller": iv.machines.AdmittanceGuide(mass=random.uniform(1.0, 4.0), damping=5.0, **guide),
        "user": iv.motion.ArmModel.named("vanbeek2015"),
        "intention": lambda at: home + size * np.sin(pace * at),
        "force": pushed(random, axes),
    }


def geared(random, task):
    """A slide with a geared motor, pushed."""
    machine = iv.machines.GearedSlideMachine(drive=DRIVE, masses=[random.uniform(0.3, 1.0), 0.5])
    return {"machine": machine, "task": task, "user": pushed(random, 2)}


def half_space(point, direction, **more):
    return iv.motion.VirtualWall(surface=iv.motion.HalfSpace(point=point, direction=direction), **more)


ARM = MACHINES["arm"][0]
SLIDE = iv.machines.SlideMachine(leg=LEG, masses=[0.5, 0.7])
END = np.asarray(ARM.arm.end_point(np.array([0.3, 0.8])))[:2]
KINDS = {
    "cart on a circle": lambda r: on_wheels(r, iv.motion.VirtualPath(curve=ARC), handle=(0.05, 0.02)),
    "cart on a spline": lambda r: on_wheels(r, iv.motion.VirtualPath(curve=POINTS, settling_length=0.02)),
    "cart on casters": lambda r: on_wheels(r, iv.motion.Caster(), servos=r.choice(["real", "ideal"])),
    "cart at a wall": lambda r: on_wheels(r, half_space([0.0, 0.008], [0.3, -1.0])),
    "cart beside a wall": lambda r: on_wheels(r, half_space([0.5, 0.0], [1.0, 0.1], sides="two")),
    "cart about a point": lambda r: on_wheels(
        r, iv.motion.Fixture(allowed=iv.motion.AboutPoint(point=[0.1, 0.0])), handle=(0.05, 0.0)
    ),
    "cart coasting": lambda r: on_wheels(r, iv.motion.Coasting()),
    "cart held": lambda r: on_wheels(r, iv.motion.HoldingTask(), rates=None),
    "platform": lambda r: on_legs(r, HEXAPOD, 3, HEXAPOD.home[:3], slip_feedforward=bool(r.integers(2))),
    "platform at least loss": lambda r: on_legs(r, HEXAPOD, 3, HEXAPOD.home[:3], cylinder="least loss"),
    "platform at a wall": lambda r: on_legs(
        r,
        HEXAPOD,
        3,
        HEXAPOD.home[:3],
        wall=iv.motion.HalfSpace(point=[1e-4, 0.0, 0.0], direction=[-1.0, *r.normal(size=2)]),
    ),
    "arm": lambda r: {**on_legs(r, ARM, 2, END), "pose": [0.3, 0.8]},
    "slide on legs": lambda r: on_legs(r, SLIDE, 2, np.zeros(2)),
    "slide on a line": lambda r: {
        **on_legs(r, SLIDE, 2, np.zeros(2), constraint=iv.motion.AlongLine(direction=[1.0, 0.4, 0.0]))
    },
    "geared at a wall": lambda r: geared(r, half_space([0.001, 0.0], [-1.0, 0.3])),
    "geared on a line": lambda r: geared(
        r, iv.motion.VirtualPath(curve=iv.motion.LineCurve(start=[0.0, 0.0], end=[0.05, 0.03]))
    ),
    "geared in a fixture": lambda r: geared(
        r, iv.motion.Fixture(allowed=iv.motion.AlongLine(direction=[1.0, 0.4, 0.0]))
    ),
    "geared held": lambda r: geared(r, iv.motion.HoldingTask()),
}


def checked(monkeypatch):
    """From now on each sample that C computes is compared with what Python makes of it; its list grows by each."""
    within, counted = SampledSteps.over, []

    def over(self, bounds, state):
        controller = self.controller
        before = controller.acting, controller.memory
        known = controller.ahead(bounds[:200])
        segments = list(within(self, bounds, state))
        feel = getattr(controller, "acceleration", lambda *now: None)
        after = controller.acting, controller.memory, dict(controller.saturated)
        if segments:
            controller.acting, controller.memory = before
        for place, one in enumerate(segments):
            now = known.row(place)
            found = [*one.inputs, one.saturated.values()]
            expected = [*controller.act(now, state, feel(now, state)), controller.saturated.values()]
            for each, like in zip(found, expected, strict=True):
                each, like = (
                    np.array([*values]) if isinstance(values, type({}.values())) else values for values in (each, like)
                )
                np.testing.assert_allclose(each, like, rtol=1e-7, atol=1e-9)
            state = one.state
        if segments:
            for each, like in zip(after[1], controller.memory, strict=True):
                np.testing.assert_allclose(each, like, rtol=1e-9, atol=1e-12)
            controller.acting, controller.memory = after[:2]
            controller.saturated.update(after[2])
        counted.extend(segments)
        yield from segments

    monkeypatch.setattr(SampledSteps, "over", over)
    return counted


@sampled(("name", "seed"), [(name, seed) for seed in range(6) for name in KINDS], every=5)
def test_samples_in_c_are_those_of_python(name, seed, monkeypatch):
    """Random users, masses and sensors; C computes all samples but the first, and those at which several limits bind."""
    random = np.random.default_rng(seed)
    counted = checked(monkeypatch)
    setup = SessionSetup(duration=0.04, sensing=sensed(random), **KINDS[name](random))
    assert setup.over(lambda share: None).outcome == ""
    assert len(counted) >= 20


@sampled("name", KINDS, every=5)
def test_a_session_is_the_same_with_its_controller_in_c(name, monkeypatch):
    """To rounding, with ideal sensors, and the same events."""
    setup = SessionSetup(duration=0.04, **KINDS[name](np.random.default_rng(7)))
    found = setup.over(lambda share: None)
    with monkeypatch.context() as patched:
        patched.setattr(SampledSteps, "over", lambda *_: iter(()))
        expected = setup.over(lambda share: None)
    assert found.outcome == expected.outcome == ""
    for column in setup.system.mechanics.configuration:
        np.testing.assert_allclose(found.columns[column], expected.columns[column], rtol=1e-9, atol=1e-9)
    assert [(one.limit, one.what) for one in found.events] == [(one.limit, one.what) for one in expected.events]
    np.testing.assert_allclose(*([one.start for one in each.events] for each in (found, expected)), atol=1e-6)


@pytest.mark.parametrize("name", ["platform", "arm"])
def test_samples_of_a_run_in_c_are_those_of_python(name, monkeypatch):
    """Servos along a motion of the load: C computes all samples but the first."""
    machine, given = MACHINES[name]
    counted = checked(monkeypatch)
    assert iv.simulate_machine(machine, iv.motion.MachineScenario(**given)).outcome == ""
    assert len(counted) == round(given["duration"] * machine.control.sample_rate) - 1
