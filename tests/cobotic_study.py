"""A cobotic drive described part by part, for tests of several folders."""

from dataclasses import replace

GOOD = """
[requirement]
force = "30 N"
speed = "0.5 m/s"
power = "8 W"

[drives.arm]
type = "cobotic"
cylinder_speed = "20 rad/s"

[drives.arm.motor]
part = "dcx-26-l-24v"

[drives.arm.gearhead]
ratio = 30
efficiency = 0.9

[drives.arm.transmission]
cylinder_radius = "25 mm"
wheel_radius = "12 mm"
preload = "400 N"
friction = 0.15
creep_law = "fastsim"

[drives.arm.transmission.geometry]
crown_radius = "12 mm"
bearing_span = "14 mm"
wheel_material = { part = "440c" }
cylinder_material = { part = "bearing-steel" }

[drives.arm.transmission.geometry.axle_bearing]
part = "608"
friction_model = "skf"
viscosity = "50 mm^2/s"

[drives.arm.steering]
ratio = 12
bell_inertia = "10 g cm^2"
sliding_friction = 0.15

[drives.arm.steering.motor]
part = "dcx-16-l-24v"

[drives.arm.steering.bell_bearing]
part = "61804"
"""


def unweighed(drive):
    """A cobotic drive whose link mass is neither stated nor known, as its steering motor's data sheet states no mass."""
    steering = replace(drive.steering, motor=replace(drive.steering.motor, mass=None))
    return replace(drive, link_mass=None, steering=steering)
