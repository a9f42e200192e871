"""
Motors for a gait table
=======================

Textbooks print gait tables of angle and moment by percent of the stride. Such a file is a duty cycle about a joint. Which motors
of the catalogue can drive a knee orthosis, geared directly to the joint, that supplies a quarter of the moment?
"""

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

# The table is not measured: it is made from the shipped walking data, with noise, and rounded to three digits.
step = iv.motion.Walking(joint="knee", body_mass=1.0, stride_time=1.1)
time = np.linspace(0.0, step.period, 51)
random = np.random.default_rng(1)
angle = np.degrees(step.derivatives(time, 0)[0]) + random.normal(0.0, 0.03, time.size)
torque = -step.push(time, 0)[0] + random.normal(0.0, 0.005, time.size)
lines = [f"{a:.3g},{m:.3g}" for a, m in zip(angle, torque, strict=True)]
Path("knee_table.csv").write_text("\n".join(["Knee angle (deg),Knee torque (N-m/kg)", *lines]) + "\n")

# %%
# The table has the moment of the muscles; a recording states the moment on the load, so its sign is reversed. A quarter of the
# moment of 80 kg is that of 20 kg.

motion = iv.motion.Recording.read("knee_table.csv", cycle_time=1.1, body_mass=20.0, flip=["moment"], cutoff=18.0)
walking = iv.DutyCycle(title="Level walking", motion=motion)
drive = iv.ConventionalDrive(
    motor=iv.motors()["dcx-32-l-24v"],
    gearhead=iv.parts.Gearhead(ratio=60.0, efficiency=0.85, loss_model="proportional"),
    shaft=iv.parts.Shaft(),
    output_inertia=1e-4,
)
found = {
    (key, ratio): iv.duty_cycle(
        replace(drive, motor=motor, gearhead=replace(drive.gearhead, ratio=ratio)), walking, samples=1000
    )
    for key, motor in iv.motors().items()
    for ratio in (40.0, 60.0, 90.0)
}
ranked = sorted(found.items(), key=lambda item: max(item[1].demands.values()))
for (key, ratio), one in ranked[:6]:
    print(f"{key:16} {ratio:3.0f}:1 {one.verdict}")

# %%
# Largest demand on any limit over the energy per stride; below 1 a drive is feasible.

fig, ax = plt.subplots(figsize=(6.5, 4.0), layout="constrained")
for _, one in ranked:
    ax.plot(one.energy, max(one.demands.values()), "o" if one.feasible else "x", color="C0" if one.feasible else "grey")
for ((key, ratio), one), side in zip(ranked[:2], ("top", "bottom"), strict=True):
    ax.annotate(f"  {key}, {ratio:.0f}:1", (one.energy, max(one.demands.values())), fontsize=8, va=side)
ax.axhline(1.0, color="black", lw=0.8)
ax.set(xlim=(0.0, 40.0), ylim=(0.0, 3.0), xlabel="energy per stride [J]", ylabel="largest demand over allowance")
plt.show()

Path("knee_table.csv").unlink()
