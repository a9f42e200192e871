"""
Choosing a material for the wheel
=================================

The material determines the size of the contact patch, its creep stiffness, the hysteresis loss and the allowable pressure.
Each candidate replaces the wheel material of the shipped drive, with everything else equal.
"""

from dataclasses import replace

import matplotlib.pyplot as plt

import infinivar as iv

study = iv.load_study("hand_controller")
ivt = study.drives["cobotic"].transmission

materials = {
    "bearing steel": iv.contact.Material(name="bearing steel", youngs_modulus=210e9, poisson=0.3, yield_strength=2.0e9),
    "titanium Ti-6Al-4V": iv.contact.Material(
        name="Ti-6Al-4V", youngs_modulus=114e9, poisson=0.34, yield_strength=0.88e9
    ),
    "silicon nitride": iv.contact.Material(name="silicon nitride", youngs_modulus=310e9, poisson=0.27),
    "aluminium 7075-T6": iv.contact.Material(name="7075-T6", youngs_modulus=71e9, poisson=0.33, yield_strength=0.5e9),
}
wheels = {
    name: replace(ivt, geometry=replace(ivt.geometry, wheel_material=material)) for name, material in materials.items()
}

print(f"{'wheel of':20} {'p0 [GPa]':>9} {'C [kN]':>8} {'loss at 8:1':>12}")
losses = {}
for name, wheel in wheels.items():
    point = wheel.deliver(cylinder_speed=14.0, link_speed=wheel.cylinder_radius * 14.0 / 8, link_force=39.0)
    losses[name] = point.losses
    pressure, stiffness = wheel.contact.patch.peak_pressure, wheel.contact.creep_stiffness
    print(f"{name:20} {1e-9 * pressure:9.2f} {1e-3 * stiffness:8.1f} {sum(point.losses.values()):10.3f} W")

# %%
# A softer wheel lowers the pressure but creeps more. Demand over allowable value, where the strength is known:

for name, wheel in wheels.items():
    demands = ", ".join(f"{limit.words} {demand:.2f}" for limit, demand in wheel.utilisation.items())
    print(f"{name}: {demands}")

fig, ax = plt.subplots(figsize=(6.5, 3.0), layout="constrained")
left = [0.0] * len(losses)
for cause in ("creep", "rolling", "bearing"):
    width = [float(found[cause]) for found in losses.values()]
    ax.barh(list(losses), width, left=left, label=cause)
    left = [start + more for start, more in zip(left, width, strict=True)]
ax.invert_yaxis()
ax.set_xlabel("loss at 39 N and 8:1 [W]")
fig.legend(loc="outside upper right", ncols=3)
plt.show()
