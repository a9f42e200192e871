"""
Duty cycle from a recording
===========================

A recorded motion can serve as a duty cycle. The file holds one cycle, with the columns ``time`` and ``position`` (or
``speed``) and, optionally, the ``force`` on the load. Frequencies above ``cutoff`` are filtered out.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

# One cycle of two seconds at 200 Hz: a synthetic motion with sensor noise stands in for a measurement.
random = np.random.default_rng(1)
time = np.linspace(0.0, 2.0, 401)
phase = np.pi * time
position = 0.04 * np.sin(phase) + 0.009 * np.sin(2 * phase + 0.6) + random.normal(0.0, 2e-5, time.size)
position[-1] = position[0]
force = -12.0 * np.cos(phase + 0.3) - 5.0 * np.sin(2 * phase)
rows = np.column_stack([time, position, force])
np.savetxt("recorded_cycle.csv", rows, delimiter=",", header="time [s],position [m],force [N]", comments="", fmt="%.6f")

# %%
# The study extends a shipped study with the duty cycle:

Path("recorded.toml").write_text("""
extends = "../studies/hand_controller.toml"

[duty.recorded]
title = "Recorded hand motion"
shape = "file"
file = "recorded_cycle.csv"
cutoff = "8 Hz"
""")
study = iv.load_study("recorded.toml")
results = {name: iv.duty_cycle(study.drives[name], study.duty["recorded"]) for name in ("cobotic", "motor2-gear4")}
for name, found in results.items():
    print(f"{name}: {found.energy:.2f} J per cycle, largest current {max(found.columns['motor_current_A']):.2f} A")

# %%
# The recording, the filtered motion that the drives follow, and the motor current it requires:

fig, (upper, lower) = plt.subplots(2, 1, figsize=(6.5, 4.6), sharex=True, layout="constrained")
upper.plot(time, 1e3 * position, ".", ms=2, color="grey", label="recorded")
columns = results["cobotic"].columns
upper.plot(columns["time_s"], 1e3 * columns["position_m"], label="filtered at 8 Hz")
upper.set_ylabel("position [mm]")
upper.legend()
for name, found in results.items():
    lower.plot(found.columns["time_s"], found.columns["motor_current_A"], label=name)
lower.set(xlabel="time [s]", ylabel="motor current [A]")
lower.legend()
plt.show()

Path("recorded.toml").unlink()
Path("recorded_cycle.csv").unlink()
