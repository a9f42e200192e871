"""
Screw, belt or pulley
=====================

One motor lifts one load by a cable, a timing belt, a ball screw and a lead screw. Each stage comes with the gear ratio that
gives the same travel per motor turn, so that only the stages differ: what they lose, what they store, and whether they hold
the load when the motor is off.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

motor = iv.parts.Motor(
    voltage=48.0,
    resistance=0.6,
    torque_constant=0.05,
    no_load_current=0.15,
    continuous_torque=0.15,
    rotor_inertia=1e-5,
)
travel = 4e-3 / (2.0 * np.pi)  # m per radian of the motor
stages = {
    "cable on a pulley": iv.parts.Pulley(radius=0.01, friction_torque=5e-3),
    "timing belt": iv.parts.Belt(pitch=3e-3, teeth=20, efficiency=0.97, specific_stiffness=2e5, span=0.4),
    "ball screw": iv.parts.Screw(
        shape="ball", lead=5e-3, diameter=16e-3, efficiency=0.9, friction_torque=0.02, inertia=3e-5,
        length=0.6, root_diameter=12.5e-3, ends="fixed-supported",
    ),
    "lead screw": iv.parts.Screw(
        lead=4e-3, diameter=14e-3, friction_coefficient=0.12, flank_angle=np.radians(15.0), inertia=2e-5,
        length=0.6, root_diameter=11e-3, ends="fixed-supported",
    ),
}  # fmt: skip


def drive(stage):
    ratio = float(stage.travel_per_radian) / travel
    gear = iv.parts.Gearhead(ratio=ratio, efficiency=1.0 if ratio < 2.0 else 0.8, loss_model="proportional")
    return iv.ConventionalDrive(
        motor=motor,
        gearhead=gear,
        guideway=iv.parts.Guideway(friction=5.0),
        output_inertia=1e-6,
        **{stage.title: stage},
    )


# %%
# Up and down by 0.3 m four times a minute with 12 kg, and a rest at both ends: energy per cycle, and the current that holds
# the load.

lift = iv.motion.Reaches(
    distance=0.3, time=2.5, pause=5.0, profile="smooth"
)  # no jumps of the jerk, which the belt would pass on
duty = iv.DutyCycle(motion=lift, force=-12.0 * 9.81, load_mass=12.0)
results = {name: iv.duty_cycle(drive(stage), duty) for name, stage in stages.items()}
for name, result in results.items():
    held = float(drive(stages[name]).operate(speed=0.0, force=12.0 * 9.81).states["motor_current_A"])
    print(f"{name:18} {result.energy:5.1f} J per cycle; holds with {held:5.2f} A, {result.verdict.split(';')[1]}")

# %%
# The lead screw holds without current, and pays for it while it lifts: friction beyond the lead angle takes more than half of
# the work. The critical speed limits both screws long before they buckle.

fig, (left, right) = plt.subplots(1, 2, figsize=(8.8, 3.4), layout="constrained")
parts = ("winding", "motor friction", "gearhead", "stage", "guideway", "amplifier")
height = np.zeros(len(results))
for part in parts:
    lost = [
        float(np.mean(result.point.losses[drive(stages[name]).stage.title if part == "stage" else part])) * duty.period
        for name, result in results.items()
    ]
    left.bar(range(len(results)), lost, bottom=height, label=part)
    height += lost
left.set_xticks(range(len(results)), list(results), rotation=20, ha="right")
left.set_ylabel("loss per cycle [J]")
left.legend(fontsize=7)

angle = np.radians(np.linspace(0.5, 45.0, 200))
for friction in (2.0, 6.0, 10.0):
    lead = np.pi * 14e-3 * np.tan(angle)
    part = replace(
        stages["lead screw"], friction_coefficient=None, flank_angle=None, friction_angle=np.radians(friction)
    )
    pairs = np.array([replace(part, lead=float(one)).efficiencies for one in lead])
    (line,) = right.plot(np.degrees(angle), pairs[:, 0], label=rf"friction angle {friction:g}°")
    right.plot(np.degrees(angle), np.clip(pairs[:, 1], 0.0, None), ls="--", color=line.get_color())
right.set(xlabel="lead angle [°]", ylabel="efficiency (dashed: driven back)", ylim=(0, 1))
right.legend(fontsize=7)
plt.show()
