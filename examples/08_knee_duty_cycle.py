"""
Energy of a knee exoskeleton per stride
=======================================

A duty cycle is a periodic motion. Inverse dynamics gives the energy per cycle, the losses, and the steady temperature of
each motor winding. Here the drive supplies a quarter of the knee torque in level walking.
"""

import matplotlib.pyplot as plt

import infinivar as iv

study = iv.load_study("knee_walking")
walking = study.duty["walking"]
results = {name: iv.duty_cycle(drive, walking) for name, drive in study.drives.items()}

for name, found in results.items():
    print(f"{name}: {found.energy:.2f} J per stride, {found.power_in:.2f} W on average")

# %%
# Power at the load and from the supply over one stride. When the load drives, power flows back, and the amplifiers of these
# drives turn it into heat.

fig, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.7), layout="constrained", width_ratios=(3, 2))
for colour, (name, found) in zip(("C0", "C1"), results.items(), strict=True):
    columns = found.columns
    left.plot(columns["time_s"], columns["power_from_supply_W"], color=colour, lw=1.2, label=f"{name}, from the supply")
left.plot(columns["time_s"], columns["power_to_load_W"], color="black", lw=1.4, label="to the load")
left.axhline(0.0, color="grey", lw=0.6)
left.set(xlabel="time [s]", ylabel="power [W]")
left.legend()

causes = sorted({cause for found in results.values() for cause in found.losses})
bottom = [0.0] * len(results)
for number, cause in enumerate(causes):
    heights = [found.losses.get(cause, 0.0) for found in results.values()]
    right.bar(list(results), heights, bottom=bottom, width=0.55, label=cause, color=plt.get_cmap("tab20")(number))
    bottom = [low + high for low, high in zip(bottom, heights, strict=True)]
right.set_ylabel("mean loss [W]")
right.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
plt.show()

# %%
# The verdict names the tightest limit and the winding temperatures:

for found in results.values():
    print(found.verdict)
