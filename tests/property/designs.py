"""Random machines and operating points: hypothesis draws the machine, NumPy fills it with points.

With 40 examples of 500 points each property is checked at 20,000 points.
"""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

import infinivar as iv

POINTS = 500

seeds = st.integers(0, 2**32 - 1)
laws = st.sampled_from(["linear", "faulring"])


@st.composite
def elements(draw, law=laws, largest_h=0.05, smallest_k=20.0):
    """An element from groups: H up to `largest_h`, K from `smallest_k` (a soft wheel) to 2000 (hard and small)."""
    preload, friction, wheel = draw(st.floats(1, 5000)), draw(st.floats(0.02, 1.2)), draw(st.floats(0.002, 0.2))
    h, share = draw(st.floats(0, largest_h)), draw(st.floats(0, 1))
    slip = preload * friction
    return iv.RotaryLinearIVT(
        cylinder_radius=draw(st.floats(0.005, 0.5)),
        wheel_radius=wheel,
        preload=preload,
        friction=friction,
        creep_stiffness=slip * draw(st.floats(smallest_k, 2000)),
        rolling_torque=h * slip * wheel * share,
        bearing_torque=h * slip * wheel * (1 - share),
        creep_law=draw(law),
    )


@st.composite
def motors(draw):
    """A motor that its supply can turn."""
    voltage, resistance = draw(st.floats(6, 60)), draw(st.floats(0.05, 30))
    motor = iv.parts.Motor(
        voltage=voltage,
        resistance=resistance,
        torque_constant=draw(st.floats(0.005, 0.1)),
        no_load_current=draw(st.floats(0, 0.9)) * voltage / resistance,
        continuous_torque=draw(st.floats(0.002, 0.5)),
    )
    iron = draw(st.sampled_from([0.0, 0.3, 1.0])) * motor.no_load_torque / motor.no_load_speed
    return replace(motor, viscous_friction=iron or None)


@st.composite
def gearheads(draw, loss_model=None):
    """A gearhead of either loss model."""
    return iv.parts.Gearhead(
        ratio=draw(st.floats(0.5, 500)),
        efficiency=draw(st.floats(0.2, 1)),
        loss_model=loss_model or draw(st.sampled_from(["coulomb", "proportional"])),
    )


@st.composite
def amplifiers(draw):
    """An amplifier of any policy."""
    policy = draw(st.sampled_from(["burn", "store", "none"]))
    return iv.parts.Amplifier(
        regeneration=policy,
        storage_efficiency=draw(st.floats(0, 1)) if policy == "store" else None,
        efficiency=draw(st.floats(0.5, 1)),
        standby_power=draw(st.floats(0, 2)),
    )


def states(element, seed, largest_angle=1.55):
    """Operating points in all four quadrants up to the slip force: cylinder speed, steering angle, link force."""
    random = np.random.default_rng(seed)
    angle = random.uniform(-largest_angle, largest_angle, POINTS)
    speed = random.uniform(0.01, 100, POINTS) * random.choice([-1, 1], POINTS)
    ratio = random.uniform(-1, 1, POINTS)  # of lateral force to slip force
    rolling = -np.sign(speed) * element.groups(speed).rolling_force
    force = -ratio * element.slip_force * np.cos(angle) - rolling * np.sin(angle)
    return speed, angle, force


@st.composite
def screws(draw):
    """A screw whose friction is stated in any way, from free-running to self-locking."""
    ball = draw(st.booleans())
    diameter = draw(st.floats(4e-3, 40e-3))
    how = draw(st.sampled_from(["friction_coefficient", "friction_angle", "efficiency", "both"]))
    values = {
        "friction_coefficient": {"friction_coefficient": draw(st.floats(0, 0.4))},
        "friction_angle": {"friction_angle": draw(st.floats(0, 0.4))},
        "efficiency": {"efficiency": draw(st.floats(0.1, 1))},
        "both": {"efficiency": draw(st.floats(0.1, 1)), "backdriving_efficiency": draw(st.floats(-3, 1))},
    }[how]
    if how == "friction_coefficient" and not ball:
        values["flank_angle"] = draw(st.floats(0, 0.6))
    return iv.parts.Screw(
        shape="ball" if ball else "lead",
        lead=diameter * draw(st.floats(0.05, 2.0)),
        diameter=diameter,
        friction_torque=draw(st.floats(0, 0.05)),
        **values,
    )


@st.composite
def output_stages(draw):
    """Any output stage of a geared drive."""
    friction = draw(st.floats(0, 0.05))
    lossy = {
        "efficiency": draw(st.floats(0.3, 1)),
        "backdriving_efficiency": draw(st.floats(0, 1)),
        "friction_torque": friction,
    }
    teeth = draw(st.integers(10, 60))
    return draw(
        st.sampled_from(
            [
                iv.parts.Pulley(radius=draw(st.floats(0.001, 0.1)), friction_torque=friction),
                iv.parts.Belt(pitch=draw(st.floats(2e-3, 8e-3)), teeth=teeth, **lossy),
                iv.parts.Rack(module=draw(st.floats(0.5e-3, 4e-3)), teeth=teeth, **lossy),
                iv.parts.Shaft(friction_torque=friction),
                draw(screws()),
                draw(screws()),
            ]
        )
    )
