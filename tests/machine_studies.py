"""Studies of machines, as texts."""

GEOMETRY = """
rod_length = "140 mm"
base_radius = "80 mm"
joint_radius = "40 mm"
base_spread = "0.15 rad"
joint_spread = "0.2 rad"
lowest = "-50 mm"
highest = "50 mm"
"""

WHEEL = """
wheel_radius = "30 mm"
preload = "200 N"
friction = 0.2
creep_stiffness = "4 kN"
rolling_torque = "9 mN m"
bearing_torque = "6 mN m"
"""

PLATFORM = f"""
title = "Six legs"
[drives.cobotic]
type = "platform"
title = "six legs, one motor"
[drives.cobotic.geometry]{GEOMETRY}
[drives.cobotic.leg]
base = "faulring2006.cobotic"
[drives.separate]
like = "cobotic"
title = "six motors"
[drives.separate.separate]
base = "faulring2006.motor2-gear4"
[tasks.lift]
twist = {{ y = "0.1 m/s", z = "0.1 m/s" }}
wrench = {{ y = "20 N", z = "20 N" }}
box = {{ x = "5 N", rz = "0.1 N m" }}
time_share = "60 %"
[tasks.hold]
wrench = {{ z = "30 N" }}
time_share = "20 %"
[paths.circle]
time_share = "20 %"
load_mass = "0.5 kg"
wrench = {{ z = "5 N" }}
x = {{ shape = "sinusoid", distance = "20 mm", frequency = "1 Hz" }}
y = {{ shape = "sinusoid", distance = "20 mm", frequency = "1 Hz", start = "250 ms" }}
"""

ARM = """
title = "Arm"
[drives.cobotic]
type = "arm"
lengths = ["0.3 m", "0.25 m"]
pulley_radius = "50 mm"
[drives.cobotic.leg]
base = "faulring2006.cobotic"
[drives.separate]
like = "cobotic"
[drives.separate.separate]
base = "faulring2006.motor2-gear4"
[tasks.push]
pose = { x = "0.35 m", y = "0.2 m" }
twist = { x = "0.05 m/s" }
wrench = { x = "3 N" }
[paths.reach]
pose = { x = "0.35 m", y = "0.2 m" }
x = { shape = "reaches", distance = "60 mm", time = "0.5 s", pause = "0.2 s" }
"""

SPHERE = f"""
title = "Joint"
[drives.ball]
type = "sphere"
input_speed = "40 rad/s"
sphere_radius = "30 mm"
layout = "cubic"
motor = {{ part = "dcx-32-l-24v" }}
gearhead = {{ part = "gpx-22-up-3-9" }}
[drives.ball.roller]{WHEEL}
[tasks.turn]
twist = {{ angle = "30 rad/s" }}
wrench = {{ angle = "50 mN m" }}
[tasks.back]
twist = {{ angle = "-10 rad/s" }}
wrench = {{ angle = "50 mN m" }}
"""

PLANAR = f"""
title = "Cart"
[drives.cart]
type = "planar"
positions = [{{ x = "0.4 m" }}, {{ x = "-0.2 m", y = "0.25 m" }}, {{ x = "-0.2 m", y = "-0.25 m" }}]
largest_push = "60 N"
[drives.cart.wheel]{WHEEL}
[drives.two]
like = "cart"
positions = [{{ x = "0.4 m" }}, {{ x = "-0.4 m" }}]
[tasks.straight]
twist = {{ x = "0.5 m/s" }}
wrench = {{ y = "30 N" }}
[tasks.turn]
twist = {{ x = "0.5 m/s", angle = "0.25 rad/s" }}
wrenches = [{{ y = "20 N" }}, {{ angle = "5 N m" }}]
"""

EVERY = {"platform": PLATFORM, "arm": ARM, "sphere": SPHERE, "planar": PLANAR}
"""By type of the machine."""
