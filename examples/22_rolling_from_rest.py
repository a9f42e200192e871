"""
A wheel begins to creep
=======================

A creepage needs rolling to build up its force: particles enter the patch unloaded, and are strained as they pass through it. Here
a patch rolls from rest with a lateral creepage, which is then reversed. The animation shows the tractions, and the force over the
distance rolled.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.collections import PolyCollection

import infinivar as iv

patch = iv.contact.RollingPatch(a_over_b=1.0, cells=12)
distance = np.linspace(0.0, 8.0, 17)[1:]
lateral = np.where(distance <= 4.0, 0.35, -0.35)
run = patch.transient(distance, lateral=lateral, keep=range(len(distance)))
steady = patch.steady(lateral=0.35).fy

grid = patch.grid
x, y, length = np.broadcast_arrays(grid.x, grid.y[:, None], grid.length[:, None])
some = np.s_[::2, ::2]
fig, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.4), dpi=72, layout="constrained")
corners = [(x + i * length / 2, y + j * grid.width / 2) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
cells = left.add_collection(PolyCollection(np.reshape(np.transpose(corners, (2, 3, 0, 1)), (-1, 4, 2)), zorder=0))
arrows = left.quiver(x[some], y[some], *run.traction[0][:, *some], scale=5, width=0.007, pivot="mid")
left.set(xlabel="along rolling, x/c [-]", ylabel="lateral, y/c [-]", title="stick blue, slip orange", aspect="equal")
left.set(xlim=(-1.1, 1.1), ylim=(-1.1, 1.1))
right.axhline(steady, color="grey", ls=":", lw=1)
right.axhline(-steady, color="grey", ls=":", lw=1)
right.plot(np.append(0.0, distance), np.append(0.0, run.fy), color="C0")
(dot,) = right.plot([], [], "o", color="C1")
right.set(xlabel="distance rolled over c [-]", ylabel=r"lateral force over $\mu N$ [-]", title="dotted: steady state")


def show(frame):
    """Draw one state."""
    cells.set_color(np.where(run.slides[frame].ravel(), "#F4C6A8", "#A8CDE8").tolist())
    arrows.set_UVC(*run.traction[frame][:, *some])
    dot.set_data([distance[frame]], [run.fy[frame]])


fig.draw_without_rendering()
fig.set_layout_engine("none")  # all frames have one layout
film = FuncAnimation(fig, show, frames=len(distance), interval=300)
plt.show()

# %%
# After the reversal the strained particles leave through the rear, where they still slide the old way, and tractions of the other
# sign build up from the front. The energy balance of the run, in units of :math:`(\mu N)^2/(Gc)`:

stored = run.energy[-1] - run.start_energy
print(
    f"work {run.work[-1]:.4f} = dissipated {run.dissipated[-1]:.4f} + stored {stored:.4f}, error {run.balance[-1]:.4f}"
)
