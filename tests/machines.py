"""Machines of many contacts that tests move."""

import math
from dataclasses import replace

import numpy as np

import infinivar as iv
from infinivar.machines import ArmMachine, PlanarMachine, PlatformMachine, SerialArmMachine, SphereMachine
from infinivar.motion import VectorHistory
from internals import Omniwheels
from made import loaded

LEG = loaded("hand_controller").drives["cobotic"]
PLATFORM = iv.transmission.Platform.hexapod()
HEXAPOD = PlatformMachine(leg=LEG, platform=PLATFORM, mass=1.0, inertia=(1e-3, 1e-3, 2e-3))
IDEAL_WHEEL = iv.transmission.RollingContact(
    wheel_radius=0.02, preload=500.0, friction=0.2, creep_stiffness=1e6, rolling_torque=0.0, bearing_torque=0.0
)
REAL_WHEEL = replace(IDEAL_WHEEL, creep_stiffness=2e4, rolling_torque=0.005, bearing_torque=0.002)


def ring_of_omniwheels(count, radius):
    """Wheels at equal distances on a circle, which roll along it."""
    places = 2 * np.pi * np.arange(count) / count
    return Omniwheels(
        positions=np.stack([radius * np.cos(places), radius * np.sin(places)], axis=-1),
        headings=places + np.pi / 2,
        roller_angles=np.zeros(count),
    )


def ideal_leg(stiffness=1e7):
    element = iv.RotaryLinearIVT(
        cylinder_radius=0.05,
        wheel_radius=0.01,
        preload=650.0,
        friction=0.12,
        creep_stiffness=stiffness,
        rolling_torque=0.0,
        bearing_torque=0.0,
    )
    steering = replace(LEG.steering, patch_half_length=3e-4)
    return replace(LEG, transmission=element, guideway=iv.parts.Guideway(), steering=steering)


def one_joint(leg, mass=0.05, radius=0.05):
    """An arm of one member: a leg that turns an inertia."""
    return ArmMachine(leg=leg, arm=iv.transmission.PlanarArm(lengths=[0.3]), pulley_radius=radius, member_masses=[mass])


def cart(wheel, **given):
    points = [(0.3, 0.0), (-0.15, 0.2), (-0.15, -0.2)]
    return PlanarMachine(
        cobot=iv.transmission.PlanarCobot(contacts=wheel, positions=points, mass=10.0, inertia=0.8), **given
    )


def sphere(layout="cubic", **given):
    wheel = iv.transmission.RollingContact(
        wheel_radius=0.02,
        preload=400.0,
        friction=0.1,
        surface="sphere",
        creep_stiffness=2e4,
        rolling_torque=0.001,
        bearing_torque=0.001,
    )
    ivt = iv.SphericalIVT(sphere_radius=0.05, drive=wheel, layout=layout)
    return SphereMachine(ivt=ivt, input_inertia=5e-4, output_inertia=2e-3, sphere_inertia=1e-3, **given)


def circles(duration):
    home = HEXAPOD.home

    def pose(time):
        swing, rise = math.sin(6.0 * time) ** 3, 1.0 - math.cos(6.0 * time)
        return home + np.array([0.004 * swing, 0.003 * rise, 0.006 * swing, 0.05 * swing, 0.0, 0.06 * rise])

    return VectorHistory.of(pose, duration)


MACHINES = {
    "platform": (
        HEXAPOD,
        {"duration": 0.04, "motion": circles(0.1), "wrench": [-4.0, 0.0, 10.0, 0.0, -0.1, 0.0]},
    ),
    "arm": (
        ArmMachine(
            leg=LEG,
            arm=iv.transmission.PlanarArm(lengths=[0.3, 0.25]),
            pulley_radius=[0.05, 0.04],
            member_masses=[1.0, 0.6],
            tip_mass=0.5,
        ),
        {
            "duration": 0.1,
            "motion": VectorHistory.of(lambda t: [0.3 * (1 - math.cos(4 * t)), 0.5 - 0.2 * math.sin(5 * t) ** 2], 0.2),
            "wrench": [-0.5, 0.3],
        },
    ),
    "serial arm": (
        SerialArmMachine(
            arm=iv.transmission.PlanarArm(lengths=[0.3, 0.25, 0.2]),
            wheel=REAL_WHEEL,
            drum_radius=0.05,
            member_masses=[1.0, 0.6, 0.3],
            motor=LEG.motor,
            gearhead=LEG.gearhead,
            steering=replace(LEG.steering, patch_half_length=3e-4),
        ),
        {"duration": 0.1, "steering": lambda t: [0.4 * math.sin(5 * t), -0.5], "wrench": [0.0, -0.3, 0.2]},
    ),
    "planar": (
        cart(REAL_WHEEL, steering=replace(LEG.steering, patch_half_length=3e-4)),
        {
            "duration": 0.2,
            "motion": VectorHistory.of(lambda t: [0.4 * t, 0.2 * t * t, t], 0.2),
            "wrench": [-3.0, 0.0, -0.1],
            "rates": [0.4, 0.0, 1.0],
        },
    ),
    "sphere": (
        sphere(
            motor=LEG.motor,
            gearhead=LEG.gearhead,
            input_speed=10.0,
            steering=replace(LEG.steering, patch_half_length=3e-4),
        ),
        {"duration": 0.1, "steering": lambda t: [0.7 + 0.3 * math.sin(8 * t)], "wrench": [0.0, 0.1]},
    ),
    "tetrahedral sphere": (
        sphere("tetrahedral"),
        {
            "duration": 0.03,
            "output_step": 0.01,
            "steering": lambda t: [0.7 + 0.3 * math.sin(8 * t)],
            "servos": False,
            "source": "none",
            "wrench": [-0.2, 0.1],
        },
    ),
}
