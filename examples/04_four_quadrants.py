"""
Power balance in four quadrants
===============================

The same transmission drives a load, brakes it, and lets the load drive the cylinder. In every quadrant, power in minus
power out equals the sum of three losses.
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

study = iv.load_study("hand_controller")
ivt = study.drives["cobotic"].transmission

speed, force = np.meshgrid(np.linspace(-0.8, 0.8, 161), np.linspace(-60.0, 60.0, 161), indexing="ij")
point = ivt.deliver(cylinder_speed=14.0, link_speed=speed, link_force=force)
lost = sum(point.losses.values())
print(f"worst residual: {np.nanmax(np.abs(point.power_in - point.power_out - lost)):.1e} W")

fig, axes = plt.subplots(1, 2, figsize=(8.8, 3.8), sharey=True, layout="constrained")
bound = np.nanmax(np.abs(point.power_in))
shown = axes[0].pcolormesh(speed, force, point.power_in, cmap="RdBu_r", vmin=-bound, vmax=bound, rasterized=True)
fig.colorbar(shown, ax=axes[0], label="power from the cylinder [W]")
shown = axes[1].pcolormesh(speed, force, lost, cmap="magma_r", rasterized=True)
fig.colorbar(shown, ax=axes[1], label="loss in the transmission [W]")
for ax in axes:
    ax.axhline(0.0, color="black", lw=0.6)
    ax.axvline(0.0, color="black", lw=0.6)
    ax.set_xlabel("link speed [m/s]")
axes[0].set_ylabel("force on the link [N]")
plt.show()

# %%
# One point in each quadrant. The losses hardly depend on the direction of power flow.

print("     speed    force    power in   power out   creep   rolling  bearing")
for v, f in ((0.4, 30.0), (-0.4, 30.0), (-0.4, -30.0), (0.4, -30.0)):
    one = ivt.deliver(cylinder_speed=14.0, link_speed=v, link_force=f)
    losses = "".join(f"{loss:8.3f}" for loss in one.losses.values())
    print(f"{v:6.1f} m/s {f:6.0f} N {one.power_in:9.3f} W {one.power_out:9.3f} W {losses} W")
