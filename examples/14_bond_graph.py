"""
A bond graph of your own
========================

Bond graphs describe a machine by its elements and the power bonds between them. The graph determines causality, equations,
a simulation and an energy audit. Here a motor winds up a spring against friction.
"""

import matplotlib.pyplot as plt
import numpy as np

from infinivar import bondgraph as bg

graph = bg.BondGraph(
    "Motor on a spring",
    [
        bg.effort_source("supply", "V"),
        bg.one("circuit", "i"),
        bg.resistance("winding", "R", 2.0, "ohm"),
        bg.inertia("coil", "L", 0.5e-3, "H"),
        bg.gyrator("motor", "K", 0.02, "N m/A"),
        bg.one("shaft", r"\omega"),
        bg.inertia("rotor", "J", 2e-6, "kg m^2"),
        bg.compliance("spring", "c", 5.0, "rad/(N m)"),
        bg.resistance("drag", "d", 2e-5, "N m s/rad"),
    ],
    [
        "supply > circuit > motor > shaft > rotor",
        "circuit > winding",
        "circuit > coil",
        "shaft > spring",
        "shaft > drag",
    ],
)
print("states:", *bg.assign(graph).independent)
print(bg.text(bg.derive(graph)))

# %%
# The response to 3 V, and where the energy goes:

run = bg.solve(graph, np.linspace(0.0, 0.15, 601), inputs={"supply": 3.0})
print(f"the audit closes to {run.closure:.0e} of the energy moved")

fig, (left, right) = plt.subplots(1, 2, figsize=(8.8, 3.4), layout="constrained")
left.plot(1e3 * run.time, np.degrees(run.states["spring"]))
left.set(xlabel="time [ms]", ylabel="spring angle [deg]")
for name, energy in (("spring", run.stored["spring"]), ("rotor", run.stored["rotor"]), ("drag", run.lost["drag"])):
    verb = "lost in" if name == "drag" else "stored in"
    right.plot(1e3 * run.time, 1e3 * energy, label=f"{verb} the {name}")
right.set(xlabel="time [ms]", ylabel="energy [mJ]")
right.legend()
plt.show()

# %%
# The winding dissipates nearly all of the energy, because a motor stalled under load only turns current into heat:

print(f"supplied {run.supplied['supply'][-1]:.3f} J, lost in the winding {run.lost['winding'][-1]:.3f} J")
