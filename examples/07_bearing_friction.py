"""
Bearing friction: two models
============================

The axle bearings of the wheel lose more power than its contact. A constant coefficient of friction needs only one number.
SKF's model separates rolling and sliding friction and depends on load, speed and viscosity.
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

bearing = {
    "type": "deep_groove",
    "series": "60",
    "bore": 8e-3,
    "outside_diameter": 22e-3,
    "dynamic_rating": 3450.0,
    "static_rating": 1370.0,
}
simple = iv.parts.Bearing(**bearing, friction_model="coefficient")
radial, axial = 325.0, 20.0
speed = np.geomspace(1.0, 600.0, 200)

fig, (left, right) = plt.subplots(1, 2, figsize=(8.8, 3.5), layout="constrained")
left.semilogx(speed, 1e3 * simple.moment(radial, axial, speed).total * np.ones_like(speed), "k--", label="coefficient")
for viscosity in (10e-6, 30e-6, 100e-6):
    skf = iv.parts.Bearing(**bearing, friction_model="skf", viscosity=viscosity)
    left.semilogx(speed, 1e3 * skf.moment(radial, axial, speed).total, label=rf"SKF, {1e6 * viscosity:.0f} mm$^2$/s")
left.set(xlabel="speed [rad/s]", ylabel="friction torque [mN m]", ylim=(0, 10))
left.legend(loc="upper left")

skf = iv.parts.Bearing(**bearing, friction_model="skf", viscosity=30e-6)
parts = skf.moment(radial, axial, speed)
right.stackplot(speed, 1e3 * parts.rolling, 1e3 * parts.sliding, labels=["rolling", "sliding"], alpha=0.8)
right.set(xscale="log", xlabel="speed [rad/s]", ylabel=r"SKF, 30 mm$^2$/s [mN m]", ylim=(0, 10))
right.legend(loc="upper left")
plt.show()

# %%
# Starting needs more torque than turning. Radial and axial load both shorten the life of the bearing:

turning = skf.moment(radial, axial, 50.0).total
starting = skf.starting_moment(radial, axial)
revolutions = skf.life(radial, axial)
print(f"turning at 50 rad/s: {1e3 * turning:.2f} mN m, starting: {1e3 * starting:.2f} mN m")
print(f"rating life: {revolutions / 1e6:.0f} million revolutions")
