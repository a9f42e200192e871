"""
Stick and slip in a rolling contact
===================================

Where does a rolling patch stick, and where does it slip? Under lateral creepage, as by a lateral load, its rear slips. Spin, as
by steering, causes a lateral force and a moment as well, so that it adds to lateral creepage or acts against it.
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

patch = iv.contact.RollingPatch(a_over_b=1.0, cells=24)
states = {
    "lateral creepage": patch.steady(lateral=0.25),
    "spin": patch.steady(spin=0.4),
    "lateral creepage and spin": patch.steady(lateral=0.25, spin=0.4),
    "lateral creepage, spin reversed": patch.steady(lateral=0.25, spin=-0.4),
}

grid = patch.grid
x, y, length = np.broadcast_arrays(grid.x, grid.y[:, None], grid.length[:, None])
some = np.s_[1::2, 1::2]
fig, axes = plt.subplots(2, 2, figsize=(6.4, 6.4), sharex=True, sharey=True, layout="constrained")
for ax, (name, state) in zip(axes.flat, states.items(), strict=True):
    for where, colour in ((~state.slides, "#A8CDE8"), (state.slides, "#F4C6A8")):
        left = x[where] - length[where] / 2
        ax.barh(y[where], length[where], grid.width, left, color=colour, edgecolor=colour, lw=0.3)
    # Tractions on the track, of which the longest is mu times the peak pressure.
    qx, qy = state.traction
    ax.quiver(x[some], y[some], qx[some], qy[some], scale=5.5, width=0.006, pivot="mid")
    ax.set_title(
        f"{name}\nforce {state.fy:.2f}, moment {state.mz:.2f}, slip in {100 * state.slip_share:.0f} %", fontsize=9
    )
    ax.set_aspect("equal")
for ax in axes[1]:
    ax.set_xlabel("along rolling, forwards to the right, x/c [-]")
for ax in axes[:, 0]:
    ax.set_ylabel("lateral y/c [-]")
fig.suptitle("stick blue, slip orange; arrows: traction on the track", fontsize=9)
plt.show()

# %%
# Creepages, forces and moments are scaled; see :doc:`/contact`. The power that friction takes is the work of the
# creepages against force and moment. `state.plot()` draws a state with the traction along its middle row.

for name, state in states.items():
    print(f"{name}: {state.power:.4f}")
