"""
Stiffness of a series spring for an ankle
=========================================

A spring between drive and load changes the motion of the motor but not the force. Which stiffness is best depends on what counts:
the peak power of the motor, or the energy per stride. Both are computed here over stiffness, for a screw and for a cobotic drive
that supply the whole ankle moment in level walking.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

study = iv.load_study("ankle_walking")
walking = study.duty["walking"]


def with_spring(drive, stiffness):
    """The drive with a series spring of another stiffness [N/m]."""
    return replace(drive, output=replace(drive.output, series_spring=iv.parts.Spring(stiffness=stiffness)))


# %%
# The sweep. Without a spring, the duty cycle gives the dashed lines of the figure.

stiffness = {"geared": np.geomspace(70e3, 2e6, 36), "cobotic": np.geomspace(18e3, 5e5, 36)}
rigid = {name: iv.duty_cycle(study.drives[name], walking) for name in stiffness}
swept = {
    name: [iv.duty_cycle(with_spring(study.drives[name], each), walking) for each in row]
    for name, row in stiffness.items()
}

SHAFT = "motor_shaft_power_peak_W"
fig, (power, energy) = plt.subplots(1, 2, figsize=(9.5, 3.8), layout="constrained")
for colour, name in zip(("C0", "C1"), swept, strict=True):
    per_millimetre = 1e-3 * stiffness[name]
    peaks = np.array([found.powers[SHAFT] for found in swept[name]])
    energies = np.array([found.energy for found in swept[name]])
    for ax, values, without, unit in (
        (power, peaks, rigid[name].powers[SHAFT], "W"),
        (energy, energies, rigid[name].energy, "J"),
    ):
        best = int(np.argmin(values))
        print(
            f"{name}: at best {values[best]:.0f} {unit} at {per_millimetre[best]:.0f} N/mm, rigid {without:.0f} {unit}"
        )
        ax.semilogx(per_millimetre, values, color=colour, label={"geared": "screw", "cobotic": "cobotic"}[name])
        ax.plot(per_millimetre[best], values[best], "o", color=colour)
        ax.axhline(without, color=colour, lw=0.8, ls="--")
for ax, label in ((power, "peak power at the motor shaft [W]"), (energy, "energy per stride [J]")):
    ax.set(xlabel="stiffness of the series spring [N/mm]", ylabel=label, ylim=(0.0, None))
    ax.legend()
plt.show()

# %%
# One stride with the spring of least peak power: it is loaded slowly while the body moves over the foot, and unloads at push-off.

best = swept["geared"][int(np.argmin([found.powers[SHAFT] for found in swept["geared"]]))]
fig, ax = plt.subplots(figsize=(7.0, 3.6), layout="constrained")
time = best.columns["time_s"]
ax.plot(time, best.columns["power_to_load_W"], color="black", label="to the ankle")
for found, colour, label in ((rigid["geared"], "C0", "motor shaft, rigid"), (best, "C3", "motor shaft, series spring")):
    ax.plot(time, found.columns["motor_torque_Nm"] * found.columns["motor_speed_rad_s"], color=colour, label=label)
ax.set(xlabel="time in the stride [s]", ylabel="power [W]")
ax.legend()
plt.show()
