"""
Machines in motion: a guided cart and a tool on six legs
========================================================

A session at the handle of a machine is shown as it moves, in real time or slower.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

leg = iv.load_study("hand_controller").drives["cobotic"]
wheel = iv.transmission.RollingContact(
    wheel_radius=0.02, preload=500.0, friction=0.2, creep_stiffness=2e4, rolling_torque=0.005, bearing_torque=0.002
)
cart = iv.machines.PlanarMachine(
    cobot=iv.transmission.PlanarCobot(
        contacts=wheel, positions=[(0.3, 0.0), (-0.15, 0.2), (-0.15, -0.2)], mass=10.0, inertia=0.8
    ),
    steering=replace(leg.steering, patch_half_length=3e-4),
)
points = np.array([[0.0, 0.0], [0.1, 0.03], [0.25, -0.02], [0.4, 0.05]])
path = iv.motion.VirtualPath(curve=iv.motion.PointCurve.through(points), settling_length=0.02)
start = 0.4 * np.asarray(path.curve.at(0.0)[1])
guided = iv.session(cart, path, user=[4.0, 6.0], duration=0.6, rates=[*start, 0.0], title="Cart on a curved path")
print(guided.verdict)

# %%
# The user pushes with a constant force. The wheels steer, so that the handle follows the path:

moving = guided.animation(speed=0.5, frame_rate=12)

# %%
# How far the handle leaves the path:

fig, ax = plt.subplots(figsize=(6.5, 2.4), layout="constrained")
ax.plot(guided.time, 1e3 * guided.path_offset)
ax.set(xlabel="time [s]", ylabel="offset from the path [mm]")
plt.show()

# %%
# A tool on six legs may move in a plane only. The cylinder turns, and the wheels of the legs steer to lift and lower their rods:

platform = iv.machines.PlatformMachine(
    leg=leg, platform=iv.transmission.Platform.hexapod(), mass=1.0, inertia=[1e-3, 1e-3, 2e-3]
)
plane = iv.motion.Fixture(allowed=iv.motion.InPlane(normal=[0.4, 0.0, 1.0]))
slid = iv.session(platform, plane, user=[8.0, 2.0, -20.0], duration=0.08, title="Tool on six legs, in a plane")
moving_legs = slid.animation(speed=0.1, frame_rate=8)

# %%
# `save_video` writes the same as a file, `to_mujoco` a scene for MuJoCo.
