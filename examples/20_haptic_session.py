"""
A run that does not close
=========================

A logged session with semicolons and decimal commas, which neither closes nor repeats: its energy, and the temperatures of the
motors from a warm start.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

# A synthetic log of 20 s at 200 Hz: slow waves with a stop at a virtual wall of 3 N/mm.
random = np.random.default_rng(3)
time = np.arange(0.0, 20.0, 0.005)
position = 25.0 * np.sin(1.9 * time) + 12.0 * np.sin(3.1 * time + 0.4) + random.normal(0.0, 0.01, time.size)
force = np.maximum(3.0 * (position - 20.0), 0.0) + random.normal(0.0, 0.05, time.size)
rows = [";".join(f"{value:.3f}" for value in row).replace(".", ",") for row in zip(time, position, force, strict=True)]
Path("session.csv").write_text("\n".join(["Time (s);Pos (mm);Fz (N)", *rows]) + "\n")

motion = iv.motion.Recording.read("session.csv", closed=False)
session = iv.DutyCycle(title="Session", motion=motion, load_mass=0.8, start_temperature=323.15)
drives = iv.load_study("hand_controller").drives
results = {name: iv.duty_cycle(drives[name], session) for name in ("cobotic", "motor2-gear4")}
for name, found in results.items():
    print(f"{name}: {found.verdict}")

# %%
# Energy from the supply since the start, and winding temperatures:

fig, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
for name, found in results.items():
    columns = found.columns
    step = session.period / len(columns["time_s"])
    left.plot(columns["time_s"], np.cumsum(columns["power_from_supply_W"]) * step, label=name)
    for motor, hot in found.heat.items():
        right.plot(hot.time, hot.winding_history - 273.15, label=f"{name}, {motor}")
left.set(xlabel="time [s]", ylabel="energy from the supply [J]")
right.set(xlabel="time [s]", ylabel="winding temperature [°C]")
left.legend()
right.legend(fontsize=8)
plt.show()

Path("session.csv").unlink()
