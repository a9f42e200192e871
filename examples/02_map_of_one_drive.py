"""
Efficiency map of one drive
===========================

`steady_map` evaluates a drive on a grid of speed and force. The map holds input and output power, all losses, the
efficiency within limits, and the limit exceeded. The energy audit checks every point.
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

study = iv.load_study("hand_controller")
drive, wanted = study.drives["cobotic"], study.requirement
maps = iv.steady_map(drive, np.linspace(0.01, 1.3, 130), np.linspace(0.5, 90.0, 120))
print(f"largest residual of the energy balance: {maps.audit_residual:.1e}")
print(f"best efficiency: {np.nanmax(maps.efficiency):.1%}")

# %%
# Efficiency is ``nan`` outside the limits, so the coloured area is the operating range. The line encloses the required
# region, which is bounded by maximum force, maximum speed and maximum power.

fig, ax = plt.subplots(figsize=(6.5, 4.2), layout="constrained")
levels = np.arange(0.0, 0.81, 0.1)
filled = ax.contourf(maps.speed, maps.force, maps.efficiency.T, levels, cmap="viridis")
fig.colorbar(filled, label="efficiency [-]")
speed = np.linspace(0.0, wanted.speed, 400)
with np.errstate(divide="ignore"):
    force = np.minimum(wanted.force, wanted.power / speed)
ax.plot([*speed, wanted.speed], [*force, 0.0], color="black", lw=1.8, label="required region")
ax.set_xlabel("link speed [m/s]")
ax.set_ylabel("link force [N]")
ax.legend(loc="upper right", frameon=True)
plt.show()

# %%
# The limits outside the coloured area, and the share of the grid in which each is exceeded:

for limit in iv.Limit:
    share = np.mean(maps.limit == limit)
    if share > 0:
        print(f"{limit.words}: {share:.0%} of the grid")
