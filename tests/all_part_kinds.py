"""Drives with every kind of part, and cycles and regions that suit them."""

import functools
from dataclasses import replace

import infinivar as iv
from internals import is_machine, shipped_studies

JOINT = iv.DutyCycle(motion=iv.motion.Sinusoid(angle=0.25, frequency=1.0), load_inertia=0.2, moment=-2.0)
LINE = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.03, frequency=1.0), load_mass=1.0, force=-20.0)
REGIONS = {
    True: iv.study.JointRequirement(moment=3.0, angular_speed=1.0).requirement,
    False: iv.Requirement(force=20.0, speed=0.2),
}


def _geared(**parts):
    motor = replace(iv.motors()["dcx-32-l-24v"], viscous_friction=2e-6)
    gear = iv.parts.Gearhead(ratio=4.0, efficiency=0.9, loss_model="proportional")
    return iv.ConventionalDrive(**{"motor": motor, "gearhead": gear, **parts})


SCREW = {"lead": 0.004, "diameter": 0.012}
FRICTION = iv.parts.GearFriction(
    friction=0.02, viscous=1e-4, friction_stribeck=0.01, stribeck_exponent=0.8, load_motor=0.1
)
DRIVES = {
    "lever": _geared(
        screw=iv.parts.Screw(**SCREW, efficiency=0.85, friction_torque=0.01, inertia=3e-6),
        output=iv.Output(
            linkage=iv.parts.Linkage(arm=0.05),
            parallel_torsion_spring=iv.parts.TorsionSpring(
                shape="one-sided", stiffness=20.0, rest=0.05, contact_width=0.01, side="negative", preload=0.2
            ),
            series_spring=iv.parts.Spring(stiffness=3e4),
        ),
    ),
    "crank": _geared(
        screw=iv.parts.Screw(**SCREW, friction_coefficient=0.1, flank_angle=0.2, length=0.3, root_diameter=0.01),
        output=iv.Output(linkage=iv.parts.Linkage(shape="crank", arm=0.05, base=0.2, offset=1.57)),
    ),
    "crank with equal bars": _geared(
        screw=iv.parts.Screw(**SCREW, friction_angle=0.1, shape="ball", dynamic_load=3e3, life=1e6),
        output=iv.Output(
            linkage=iv.parts.Linkage(shape="crank", arm=0.1, base=0.1, offset=1.57),
            series_torsion_spring=iv.parts.TorsionSpring(stiffness=150.0),
        ),
    ),
    "table": _geared(
        rack=iv.parts.Rack(module=0.001, teeth=20.0, efficiency=0.9, permissible_force=500.0),
        output=iv.Output(
            linkage=iv.parts.Linkage(shape="table", angles=(-0.6, -0.2, 0.2, 0.6), arms=(0.04, 0.05, 0.05, 0.03)),
            parallel_spring=iv.parts.Spring(stiffness=2e3, at="drive", hysteresis=3.0),
            series_spring=iv.parts.Spring(
                shape="progressive", deflections=(-0.01, 0.0, 0.01, 0.02), forces=(-300.0, 0.0, 400.0, 1000.0)
            ),
        ),
    ),
    "four-bar": _geared(
        gearhead=iv.parts.Gearhead(ratio=20.0, loss_model="stribeck", friction=FRICTION),
        shaft=iv.parts.Shaft(friction_torque=0.01, permissible_torque=20.0),
        output=iv.Output(
            linkage=iv.parts.Linkage(shape="four-bar", arm=0.1, base=0.2, crank=0.08, coupler=0.19, offset=1.5),
        ),
    ),
    "elastic gear": _geared(
        gearhead=iv.parts.Gearhead(ratio=20.0, efficiency=0.9, stiffness=300.0),
        shaft=iv.parts.Shaft(),
        output=iv.Output(series_torsion_spring=iv.parts.TorsionSpring(stiffness=100.0)),
    ),
    "strain wave": _geared(
        gearhead=iv.parts.Gearhead(
            ratio=20.0,
            loss_model="strain wave",
            strain_wave=iv.parts.StrainWave(
                efficiency=0.8,
                rated_torque=5.0,
                starting_torque=0.008,
                running_torque=0.02,
                backdriving_torque=0.2,
                torque_1=1.0,
                stiffness_2=400.0,
                torque_2=3.0,
                stiffness_3=500.0,
                momentary_torque=30.0,
                ratcheting_torque=50.0,
                temperature=280.0,
            ),
            stiffness=300.0,
        ),
        shaft=iv.parts.Shaft(),
    ),
    "belt": _geared(
        belt=iv.parts.Belt(pitch=0.003, teeth=20.0, efficiency=0.9, specific_stiffness=2e4, span=0.5, other_span=0.3),
        guideway=iv.parts.Guideway(friction=5.0),
    ),
}


@functools.cache
def one_axis_studies():
    """Names and contents of the shipped studies of one axis: those without a machine."""
    loaded = ((name, iv.load_study(name)) for name in shipped_studies())
    return tuple((name, study) for name, study in loaded if not any(map(is_machine, study.drives.values())))
