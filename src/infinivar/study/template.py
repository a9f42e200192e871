"""The commented study file that `infinivar init` writes."""

SCHEMA_FILE = "infinivar.schema.json"
"""Name of the schema beside a study."""

SCHEMA_LINE = f"#:schema ./{SCHEMA_FILE}"
"""First line of a study; tells editors (Taplo, Even Better TOML) where to find the schema."""

TEMPLATE = """\
# An infinivar study: what is required, as a region or as motions, and the drive-trains to compare.
#
# Write a value with a unit as text: "26.3 mN m", "8040 rpm", "50 N". Write a dimensionless value as a plain number: 0.12.
# A value can state its source:
#   friction = {{ value = 0.12, kind = "stated", where = "measured on our rig, run 7" }}
# The kind is stated, catalogue, derived, fitted or assumed (the default). Set kind and where once in a table to apply
# them to all its values.
#
# Run the study:   infinivar compare {name}.toml --out out
# List the parts:  infinivar catalogue
# Edit it:         an editor extension that reads the schema line, such as Even Better TOML, checks and completes the keys

title = "{title}"
description = "Say here what you compare and why."

[requirement]          # optional if the study has a motion, [duty.NAME]; about a joint: moment, angular_speed, load_inertia
force = "50 N"         # largest force on the load
speed = "1.05 m/s"     # largest speed
power = "12 W"         # largest instantaneous power; remove it to require full force at full speed
load_mass = "0.8 kg"
quadrants = 1          # 1: driving in one direction; 2: driving and braking; 4: both in both directions

# A drive can start from a shipped one; write only the values that differ ...
[drives.cobotic]
base = "faulring2006.cobotic"
title = "Cobotic, small motor"

[drives.cobotic.gearhead]
efficiency = 0.88

# The wheel determines creep, rolling and bearing losses. See its calculation sheet: infinivar contact {name}.toml
[drives.cobotic.transmission]
preload = "650 N"
wheel_radius = "10 mm"

[drives.cobotic.transmission.geometry]
crown_radius = "8 mm"

[drives.cobotic.transmission.geometry.axle_bearing]
part = "625"
friction_model = "coefficient"  # SKF's simple rule; "skf" is the full model and needs viscosity = "100 mm^2/s" (oil)

# ... or define a drive part by part.
[drives.geared]
type = "conventional"
title = "Geared, large motor"
output_inertia = "0.02 g m^2"  # pulley and cable

[drives.geared.motor]
part = "dcx-32-l-24v"          # from the catalogue; override any of its values here

[drives.geared.gearhead]
ratio = 3.9
efficiency = {{ value = 0.96, kind = "catalogue", where = "single-stage planetary" }}
loss_model = "coulomb"         # constant friction torque, (1 - efficiency) x rated torque, as in the base above; or
                               # "proportional" to power. Use one model for all drives, as the choice can decide a comparison.

[drives.geared.pulley]
radius = "8 mm"

[drives.geared.guideway]
friction = "3 N"

[drives.geared.amplifier]
regeneration = "burn"          # negative electrical power: burn, store (with storage_efficiency) or none

# A run to simulate: infinivar simulate {name}.toml --drive cobotic --scenario reach --out out
[scenarios.reach]
title = "Reaching 100 mm in half a second"
duration = "1 s"

[scenarios.reach.motion]
shape = "reach"                # or hold, cruise, sinusoid, step, file (a recording)
distance = "100 mm"
time = "0.5 s"
start = "0.1 s"

# A repeated motion: compare reports energy, limits and heat per cycle, first of all. Remove it if you do not need it.
[duty.reaches]
title = "Reach 100 mm and back, once a second"
shape = "reaches"              # or hold, sinusoid, tremor, walking, running, file (a recording)
distance = "100 mm"
time = "0.4 s"
pause = "0.1 s"
# time_share = "60 %"          # with several motions: the share of time in each, to weigh them into one figure
"""
"""Format string with fields `name` and `title`."""
