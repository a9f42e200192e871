"""
Calibration from a rig
======================

A rig measures current, voltage, travel and angle while the link lifts and lowers masses. The fit estimates the losses of
the transmission with intervals, and reports which parameters are not identifiable. Here a virtual rig with sensor errors
provides the measurements.
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv
from infinivar.calibration import virtual_rig

study = iv.load_study("hand_controller")
drive = study.drives["cobotic"]
settings = virtual_rig.protocol(drive, study.rig)
measured = virtual_rig.experiment(drive, study.rig, settings, simulated=False).data
found = iv.calibrate(study, "cobotic", measured)
print(found.fit.identifiable)

# %%
# Measured efficiencies with their 95 % intervals, and the calibrated drive:

fig, ax = plt.subplots(figsize=(6.5, 4.2), layout="constrained")
runs, ivt = found.efficiencies, found.calibrated.transmission
ratio = np.geomspace(1.0, 100.0, 200)
for colour, load in (("C0", 0.15), ("C1", 0.5)):
    for lifts, marker, filled in ((True, "o", colour), (False, "s", "white")):
        chosen = (runs.load == load) & (runs.lifts == lifts) & np.isfinite(runs.value)
        way = "lifting" if lifts else "lowering"
        interval = 1.96 * runs.deviation[chosen]
        label = f"{way}, load {load:g}"
        ax.errorbar(
            runs.ratio[chosen], runs.value[chosen], interval, fmt=marker, ms=5, color=colour, mfc=filled, label=label
        )
        angle = -np.arctan(1 / ratio) * (1 if lifts else -1)
        force = load * ivt.slip_force
        point = ivt.operate(cylinder_speed=14.0, steering_angle=angle, link_force=force)
        ax.plot(ratio, point.efficiency, color=colour, ls="-" if lifts else "--", lw=1.2)
ax.set(xscale="log", xlabel="reduction ratio [-]", ylabel="efficiency [-]", ylim=(0, 1.02))
ax.legend(loc="lower left")
plt.show()

# %%
# The true values, which only a virtual rig can provide:

truth, fitted = drive.transmission.groups(14.0), ivt.groups(14.0)
print(f"creep stiffness: true {truth.creep_stiffness:.0f} N, fitted {fitted.creep_stiffness:.0f} N")
torques = [1e3 * (group.rolling_torque + group.bearing_torque) for group in (truth, fitted)]
print(f"rolling and bearing torque: true {torques[0]:.2f} mN m, fitted {torques[1]:.2f} mN m")
