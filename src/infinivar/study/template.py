"""The commented study file that `infinivar init` writes."""

SCHEMA_FILE = "infinivar.schema.json"
"""Name of the schema beside a study."""

SCHEMA_LINE = f"#:schema ./{SCHEMA_FILE}"
"""First line of a study, by which editors (Taplo, Even Better TOML) find its schema."""

TEMPLATE = """\
# A study for infinivar: what is required, and the drive-trains that compete for it.
#
# Every value with a dimension is text with a unit: "26.3 mN m", "8040 rpm", "50 N"; pure numbers stand bare: 0.12.
# A value can say where it comes from:
#   friction = {{ value = 0.12, kind = "stated", where = "measured on our rig, run 7" }}
# with kind one of stated, catalogue, derived, fitted, assumed (which a bare value is). Written once in a table, kind
# and where hold for all its values.
#
# Run it:                  infinivar compare {name}.toml --out out
# Help from your editor:   an extension for TOML that knows the first line, such as Even Better TOML
# Parts:                   infinivar catalogue

title = "{title}"
description = "Replace this by what is compared and why."

[requirement]
force = "50 N"         # largest force on the load
speed = "1.05 m/s"     # largest speed
power = "12 W"         # largest power at any one time; leave it out to require force and speed together
load_mass = "0.8 kg"
quadrants = 1          # 1: driving one way; 2: driving and braking; 4: both directions of each

# A drive can start from a shipped one and change what differs ...
[drives.cobotic]
base = "faulring2006.cobotic"
title = "Cobotic, small motor"

[drives.cobotic.gearhead]
efficiency = 0.88

# The wheel: creep, rolling and bearing losses follow from this. See what it gives: infinivar contact {name}.toml
[drives.cobotic.transmission]
preload = "650 N"
wheel_radius = "10 mm"

[drives.cobotic.transmission.geometry]
crown_radius = "8 mm"

[drives.cobotic.transmission.geometry.axle_bearing]
part = "625"
friction_model = "coefficient"  # SKF's simple rule; "skf" is the full model, with viscosity = "100 mm^2/s" of the oil

# ... or be given part by part.
[drives.geared]
type = "conventional"
title = "Geared, large motor"
output_inertia = "0.02 g m^2"  # of pulley and cable; only motion needs it

[drives.geared.motor]
part = "dcx-32-l-24v"          # from the catalogue; any of its values can be overridden here

[drives.geared.gearhead]
ratio = 3.9
efficiency = {{ value = 0.96, kind = "catalogue", where = "single-stage planetary" }}
loss_model = "coulomb"         # a constant friction torque (1 - efficiency) x rated torque, as in the base above;
                               # or "proportional" to power. Compare drives by one law: it can decide between them.

[drives.geared.pulley]
radius = "8 mm"

[drives.geared.guideway]
friction = "3 N"

[drives.geared.amplifier]
regeneration = "burn"          # negative electrical power: burn, store (with storage_efficiency) or none

# A run in time: infinivar simulate {name}.toml --drive cobotic --scenario reach --out out
[scenarios.reach]
title = "Reaching 100 mm in half a second"
duration = "1 s"

[scenarios.reach.motion]
shape = "reach"                # or hold, cruise, sinusoid, step, file (a CSV file with time and position)
distance = "100 mm"
time = "0.5 s"
start = "0.1 s"

# A motion that repeats: compare gives joules, limits and heat over it. Remove it if you need none.
[duty.reaches]
title = "Reach 100 mm and back, once a second"
shape = "reaches"              # or hold, sinusoid, tremor, walking, file (a CSV file, units in its header)
distance = "100 mm"
time = "0.4 s"
pause = "0.1 s"
"""
"""Filled by `str.format` with name and title."""
