"""
Softest and stiffest: two haptic displays in one hand
=====================================================

A display by steering (cobotic) measures the force and moves as a virtual mass would. A geared display measures the position and
applies the force of a virtual wall. Which masses and walls are stable in the hand of a named arm, and what range of impedances
can each show?
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

drives = iv.load_study("hand_controller").drives
arm = iv.motion.ArmModel.named("vanbeek2015")
cobotic = iv.displays.AdmittanceDisplay(drive=drives["cobotic"], virtual_mass=1.0, filter_frequency=100.0)
geared = iv.displays.ImpedanceDisplay(drive=drives["motor2-gear4"], viscous_friction=2.0)

stability = iv.displays.stability_map(cobotic, arm)
print(stability.verdict)
fig, ax = plt.subplots(figsize=(4.6, 3.4), layout="constrained")
ax.contourf(stability.x, stability.y, stability.stable, levels=[0.5, 1.5], colors=["C0"], alpha=0.2)
ax.plot(*stability.boundary.T, ".", ms=4)
ax.set(
    xscale="log", yscale="log", xlabel="virtual mass [kg]", ylabel="wall stiffness [N/m]", title="stable with this arm"
)
plt.show()

# %%
# The cobotic display is limited by the least mass that it can make the user feel, the geared one by its walls. Between the two
# curves of a display lies what it can show: its Z-width.

fig, axes = plt.subplots(1, 2, figsize=(8.5, 3.2), sharey=True, layout="constrained")
for ax, display, title in zip(axes, (cobotic, geared), ("cobotic", "geared"), strict=True):
    width = iv.displays.z_width(display, arm)
    print(width.verdict)
    low, high = np.abs(width.softest), np.abs(width.stiffest)
    ax.fill_between(width.frequency, low, high, where=high > low, color="C0", alpha=0.2, lw=0)
    ax.loglog(width.frequency, high, label=f"wall, {width.wall / 1e3:.1f} N/mm")
    ax.loglog(width.frequency, low, label=f"free, {width.mass_felt[0]:.2f} kg")
    ax.set_xlabel("frequency [Hz]")
    ax.set_title(title)
    ax.legend()
axes[0].set_ylabel("impedance, magnitude [N s/m]")
plt.show()

# %%
# Coupled stability is that with this arm. A passive display is stable with every passive arm. No cobotic display is passive.

for display in (geared, cobotic):
    print(iv.displays.passivity(display).verdict)
