"""
Contact patch from geometry
===========================

How large is the contact patch of a crowned wheel on a cylinder, how high is its pressure, and how stiff is it laterally?
Hertz's theory gives the patch, Kalker's coefficients give the creep stiffness ``C = C22 G a b``.
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

study = iv.load_study("hand_controller")
ivt = study.drives["cobotic"].transmission
patch = ivt.contact.patch
print(f"semi-axes: {1e3 * patch.a:.3f} mm rolling, {1e3 * patch.b:.3f} mm lateral")
print(f"peak pressure: {1e-9 * patch.peak_pressure:.2f} GPa")
print(f"creep stiffness: {1e-3 * ivt.contact.creep_stiffness:.1f} kN")
print(f"smallest margin: {1 / max(ivt.utilisation.values()):.2f}")

# %%
# The crown radius trades pressure against rolling loss. `dataclasses.replace` makes a modified copy and recomputes
# everything that depends on the geometry.

from dataclasses import replace

crowns = np.geomspace(3e-3, 60e-3, 40)
wheels = [replace(ivt, geometry=replace(ivt.geometry, crown_radius=crown)) for crown in crowns]
pressure = [wheel.contact.patch.peak_pressure for wheel in wheels]
groups = [wheel.groups(14.0) for wheel in wheels]

fig, axes = plt.subplots(1, 3, figsize=(9.5, 3.0), layout="constrained")
curves = (
    (1e-9 * np.array(pressure), "peak pressure [GPa]"),
    ([1e-3 * group.creep_stiffness for group in groups], "creep stiffness [kN]"),
    ([1e3 * group.rolling_torque for group in groups], "hysteresis torque [mN m]"),
)
for ax, (values, label) in zip(axes, curves, strict=True):
    ax.semilogx(1e3 * crowns, values)
    ax.set_xticks([3, 10, 30, 60], ["3", "10", "30", "60"])
    ax.minorticks_off()
    ax.axvline(1e3 * ivt.geometry.crown_radius, color="grey", ls=":")
    ax.set_xlabel("crown radius [mm]")
    ax.set_ylabel(label)
plt.show()
