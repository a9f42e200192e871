"""
Simulation of a reach, with its energy audit
============================================

The drive is simulated as a bond graph with controllers: the link moves 100 mm against the inertia of the load. The energy
from the supply equals the energy stored plus the losses of all elements.
"""

import matplotlib.pyplot as plt

import infinivar as iv

study = iv.load_study("hand_controller")
run = iv.simulate(study.drives["cobotic"], study.scenarios["reach"])
print(run.verdict)

# %%
# Position, steering angle and supply power over time:

columns = run.columns
fig, axes = plt.subplots(3, 1, figsize=(6.5, 5.4), sharex=True, layout="constrained")
axes[0].plot(columns["time_s"], 1e3 * columns["position_m"], label="link")
axes[0].plot(columns["time_s"], 1e3 * columns["wanted_position_m"], "k:", label="target")
axes[0].set_ylabel("position [mm]")
axes[0].legend()
axes[1].plot(columns["time_s"], 57.2958 * columns["steering_angle_rad"], color="C2")
axes[1].set_ylabel("steering angle [deg]")
axes[2].plot(columns["time_s"], columns["supply_power_W"], color="C1")
axes[2].set(xlabel="time [s]", ylabel="supply power [W]")
plt.show()

# %%
# Where the energy went:

trajectory = run.trajectory
ledger = {name: energy[-1] for name, energy in trajectory.lost.items() if energy[-1] > 1e-3}
names = sorted(ledger, key=ledger.get)
fig, ax = plt.subplots(figsize=(6.5, 3.4), layout="constrained")
ax.barh(names, [ledger[name] for name in names], color="C0")
ax.set_xlabel("energy lost [J]")
plt.show()

supplied = sum(energy[-1] for energy in trajectory.supplied.values())
lost = sum(energy[-1] for energy in trajectory.lost.values())
stored = sum(energy[-1] - energy[0] for energy in trajectory.stored.values())
print(f"supplied {supplied:.6f} J = lost {lost:.6f} J + {stored:.6f} J increase in stored energy")
print(f"unaccounted share of the energy moved: {trajectory.closure:.1e}")
