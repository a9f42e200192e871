"""
Steering angle for a motion
===========================

Steering a wheel sets the transmission ratio. Without losses the angle follows from the speeds alone. Under load the wheel
creeps and must be steered further. `steer` is the inverse of `operate` and accounts for creep.
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

study = iv.load_study("hand_controller")
ivt = study.drives["cobotic"].transmission
omega = 14.0  # cylinder speed in rad/s

speed = np.linspace(-1.0, 1.0, 201)
ideal = -np.arctan(speed / (ivt.cylinder_radius * omega))
shares = (-0.9, -0.5, 0.0, 0.5, 0.9)

fig, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.6), layout="constrained")
for share in shares:
    angle = ivt.steer(cylinder_speed=omega, link_speed=speed, link_force=share * ivt.slip_force)
    left.plot(speed, np.degrees(angle), label=f"{share:+.1f}" if share else "0")
    right.plot(speed, np.degrees(angle - ideal))
left.set_ylabel("steering angle [deg]")
right.set_ylabel("angle in excess of the ideal ratio [deg]")
for ax in (left, right):
    ax.set_xlabel("link speed [m/s]")
left.legend(title="link force\nover slip force")
plt.show()

# %%
# The lines end where the wheel slips. Operating at the angle found gives the requested speed:

angle = ivt.steer(cylinder_speed=omega, link_speed=0.4, link_force=30.0)
point = ivt.operate(cylinder_speed=omega, steering_angle=angle, link_force=30.0)
print(f"{np.degrees(angle):.3f} deg: {point.link_speed:.6f} m/s, margin to slip {point.margin:.2f}")

# %%
# A locked link (angle 0) still creeps under load:

held = ivt.operate(cylinder_speed=omega, steering_angle=0.0, link_force=30.0)
print(f"locked under 30 N: {1e3 * held.link_speed:.3f} mm/s")
