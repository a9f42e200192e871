"""
Back-driven gears
=================

A gear with 80 % efficiency does not return 80 % when the load drives it, and must never return more than it receives. The
loss model and the back-driving efficiency determine how much power returns, and whether the gear is self-locking.
"""

import matplotlib.pyplot as plt
import numpy as np

import infinivar as iv

rated = 0.03  # N m at the motor
gears = {
    "constant torque (coulomb)": iv.parts.Gearhead(ratio=57.0, efficiency=0.8, loss_model="coulomb"),
    "proportional, 80 % both ways": iv.parts.Gearhead(ratio=57.0, efficiency=0.8, loss_model="proportional"),
    "proportional, 60 % back": iv.parts.Gearhead(
        ratio=57.0, efficiency=0.8, loss_model="proportional", backdriving_efficiency=0.6
    ),
    "self-locking": iv.parts.Gearhead(
        ratio=57.0, efficiency=0.45, loss_model="proportional", backdriving_efficiency=0.0
    ),
}
torque = np.linspace(-1.5, 1.5, 601)  # at the output
speed = 10.0

fig, (left, right) = plt.subplots(1, 2, figsize=(8.8, 3.6), layout="constrained")
for name, gear in gears.items():
    point = gear.operate(output_torque=torque, output_speed=speed, motor_rated_torque=rated)
    at_motor, at_load = point.motor_torque * point.motor_speed, torque * speed
    assert np.all(at_motor - at_load >= -1e-12)  # no gear creates energy
    left.plot(at_load, at_motor, label=name)
    right.plot(at_load, point.loss)
left.plot([-15, 15], [-15, 15], color="grey", ls=":", label="no loss")
left.set(xlabel="power to the load [W]", ylabel="power from the motor [W]")
left.legend(fontsize=7)
right.set(xlabel="power to the load [W]", ylabel="loss [W]")
plt.show()

# %%
# Left of zero the load drives. Of 10 W from the load, each gear returns:

for name, gear in gears.items():
    point = gear.operate(output_torque=-1.0, output_speed=speed, motor_rated_torque=rated)
    print(f"{name:30} {0.0 - point.motor_torque * point.motor_speed:6.2f} W to the motor, {point.loss:5.2f} W lost")
