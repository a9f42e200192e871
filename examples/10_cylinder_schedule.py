"""
Scheduling the cylinder
=======================

The cylinder of a cobotic drive turns continuously, and idling costs power. How much does a slower cylinder save over a
duty cycle, and how much more does a speed that varies over the cycle?
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

study = iv.load_study("reach_and_hold")
duty = study.duty["reach-and-hold"]
found = iv.analysis.policies(study.drives["cobotic"], duty)
for policy in found:
    limits = "within limits" if policy.feasible else "infeasible"
    print(f"{policy.name:24} {policy.power_in:5.2f} W  {limits}")

# %%
# Steering the wheel further raises the link speed, so the cylinder must turn fast only while the link moves fast.

feasible = [policy for policy in found if policy.feasible]
fig, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.4), layout="constrained", width_ratios=(2, 3))
left.barh([policy.name for policy in feasible], [policy.power_in for policy in feasible], color=["C0", "C1", "C2"])
left.invert_yaxis()
left.set_xlabel("mean power from the supply [W]")
for colour, policy in zip(("C0", "C1", "C2"), feasible, strict=True):
    speed = np.atleast_1d(policy.slowest if policy.cylinder_speed is None else policy.cylinder_speed.value)
    time = np.linspace(0.0, duty.period, max(2, speed.size))
    right.plot(time, np.broadcast_to(speed, time.shape), color=colour, label=policy.name)
right.set(xlabel="time [s]", ylabel="cylinder speed [rad/s]", ylim=(0, None))
right.legend()
plt.show()
