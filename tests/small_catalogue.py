"""A small set of made-up parts to search, as a file that states what fits together, and a slide to search them for."""

from dataclasses import fields, is_dataclass

SHELF = """
manufacturer = "Made Up"
where = "data sheet 7"
date = "2024-05"

[motors.a]
name = "A"
order_number = "10"
voltage = "24 V"
resistance = "2 ohm"
torque_constant = "24 mN m/A"
no_load_current = "30 mA"
continuous_torque = "30 mN m"
max_speed = "1150 rad/s"
rotor_inertia = "10 g cm^2"
mass = "90 g"

[motors.b]
name = "B"
order_number = "11"
voltage = "24 V"
resistance = "0.8 ohm"
torque_constant = "22 mN m/A"
no_load_current = "60 mA"
continuous_torque = "55 mN m"
max_speed = "1250 rad/s"
rotor_inertia = "22 g cm^2"
mass = "130 g"

[motors.c]
voltage = "24 V"
resistance = { value = "0.35 ohm", kind = "fitted", where = "bench" }
torque_constant = "30 mN m/A"
no_load_current = "120 mA"
continuous_torque = "130 mN m"
rotor_inertia = "90 g cm^2"
mass = "310 g"

[gearheads.p5]
ratio = 5
efficiency = 0.9
continuous_torque = "1.5 N m"
inertia = "2 g cm^2"
mass = "100 g"

[gearheads.p14]
ratio = 14
efficiency = 0.83
continuous_torque = "2.4 N m"
inertia = "2 g cm^2"
mass = "130 g"

[gearheads.p35]
ratio = 35
efficiency = 0.7
continuous_torque = "4 N m"
inertia = "2 g cm^2"

[pairs]
a = ["p5", "p14"]
b = ["p5", "p14"]
c = ["p5", "p14", "p35"]
"""

SLOW = SHELF[: SHELF.index("[pairs]")] + (
    '[gearheads.p60]\nratio = 60\nefficiency = 0.75\ncontinuous_torque = "9 N m"\nmass = "140 g"\n\n'
    '[bearings.wide]\nseries = "60"\nbore = "12 mm"\noutside_diameter = "28 mm"\ndynamic_rating = "5.4 kN"\n'
    'static_rating = "2.36 kN"\ntype = "deep_groove"\norder_number = "B12"\n\n'
    '[bearings.narrow]\nseries = "60"\nbore = "8 mm"\noutside_diameter = "22 mm"\ndynamic_rating = "3.4 kN"\n'
    'static_rating = "1.3 kN"\ntype = "deep_groove"\n'
)
"""With a slow output and bearings, for cobotic drives; every motor with every gearhead."""

SLIDE = """
title = "Slide"

[drives.geared]
type = "conventional"
output_inertia = "0.02 g m^2"

[drives.geared.motor]
part = "dcx-32-l-24v"

[drives.geared.gearhead]
part = "gpx-32-up-16"
loss_model = "coulomb"

[drives.geared.pulley]
radius = "8 mm"

[duty.shake]
shape = "sinusoid"
distance = "60 mm"
frequency = "1.5 Hz"
load_mass = "3 kg"
force = "-30 N"
"""
"""Feasible with the set."""
HEAVY = SLIDE.replace("-30 N", "-900 N")
"""Infeasible."""


def slides(folder, slide=SLIDE):
    """Write the set and both studies into a folder, as shelf.toml, slide.toml and heavy.toml."""
    for name, content in (("shelf", SHELF), ("slide", slide), ("heavy", HEAVY)):
        (folder / f"{name}.toml").write_text(content, "utf-8")
    return folder


def changed(one, other, path=""):
    """Paths of the fields in which two drives differ."""
    if not is_dataclass(one) or type(one) is not type(other):
        return [] if one == other else [path.removeprefix(".")]
    names = [field.name for field in fields(one) if field.init]
    return [found for name in names for found in changed(getattr(one, name), getattr(other, name), f"{path}.{name}")]
