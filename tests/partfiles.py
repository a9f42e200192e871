"""Small files of made-up parts in every format that can be imported, with every peculiarity of the MGDB format."""

MOTOR_HEADINGS = (
    "key,manufacturer,ID,type,V,k_t,R,L,mass,inertia,omega_nl,I_nl,I_nom,max_int_torque,max_int_speed,"
    "max_cont_speed,max_cont_power,coulomb_friction,viscous_friction,Rth1,Rth2"
)
GEARBOX_HEADINGS = (
    "key,manufacturer,ID,type,stages,ratio,mass,inertia,efficiency,direction,max_int_torque,max_cont_torque"
)

# Two good motors (the second with friction that grows with speed and no thermal resistances), one without a no-load current
# and with a lumped thermal resistance, and three bad ones: no number, a cell too few, a negative resistance.
MGDB_MOTORS = f"""{MOTOR_HEADINGS}
XX_A1,Made_Up,A1,DC,24,0.03,0.5,0.0001,0.3,1e-05,786,0.1,3,Inf,1200,Inf,Inf,NaN,NaN,2,6
XX_B2,Made_Up,B2,BLDC,24.0,0.02,0.8,,0.2,4e-06,1180,0.2,2.5,inf,1500,1100,inf,0.002,1.5e-06,,
XX_C3,Made_Up,C3,BLDC,48,0.1,0.9,0.0003,0.2,5.1e-05,445,,5.1,4,inf,inf,inf,,,2.8,
XX_D4,Made_Up,D4,DC,24,0.03,0.5-3,0.0001,0.3,1e-05,786,0.1,3,Inf,1200,Inf,Inf,NaN,NaN,2,6
XX_E5,Made_Up,E5,DC,24,0.03,0.5
XX_F6,Made_Up,F6,DC,24,0.03,-0.5,0.0001,0.3,1e-05,786,0.1,3,Inf,1200,Inf,Inf,NaN,NaN,2,6
"""
MGDB_GEARBOXES = f"""{GEARBOX_HEADINGS}
XX_G16_R4:1,Made_Up,G16_R4:1,planetary,1,4,0.02,0,0.9,1,0.3,0.2
XX_G16_R16:1,Made_Up,G16_R16:1,planetary,2,16,0.03,1e-08,0.8,1.0,0.5,0.4
XX_G22_R5:1,Made_Up,G22_R5:1,spur,NaN,5,0.05,1e-07,,-1,Inf,Inf
XX_G22_R5:1,Made_Up,G22_R5:1,spur,1,5.5,0.05,1e-07,0.8,-1,2,1
"""
# A motor with a pattern, one with keys, one without any gearhead, one that was refused, and an unknown gearhead.
MGDB_COMPATIBILITY = """XX_A1,XX_G16_R*,XX_G22_R5:1
XX_B2,XX_G16_R4:1,XX_H99
XX_C3,
XX_F6,XX_G16_R4:1
XX_B2,XX_H*
"""

CSV_MOTORS = """key,name,order_number,voltage [V],resistance [ohm],torque_constant [mN m/A],no_load_current [mA],\
continuous torque (mN m),mass [g],max_speed [rpm],colour
m1,First,100-1,24,0.5,30,100,90,300,12000,red
m2,Second,,24,0.8,20,200,45,200,inf,
m3,Third,,24,0.8,20,200,-,,,blue
m4,Fourth,,24,nought,20,200,45,200,9000,blue
m5,Fifth,,24,0,20,200,45,200,9000,blue
"""
CSV_GEARHEADS = """key;ratio;efficiency [%];continuous_torque [N m]
g1;4;90;0.2
g2;16;80;0.4
g3;16;180;0.4
"""
CSV_PAIRS = """motor,gearhead
m1,g*
m2,g1
m2,g9
"""

TOML = """
manufacturer = "Made Up"
where = "data sheet 7"
date = "2024-05"

[motors.t1]
name = "T 1"
order_number = "4711"
voltage = "24 V"
resistance = "0.5 ohm"
torque_constant = "30 mN m/A"
no_load_current = "0.1 A"
continuous_torque = "90 mN m"
mass = { value = 300, unit = "g" }

[motors.t2]
voltage = "24 V"
resistance = "0.5 ohm m"

[gearheads.h1]
ratio = 4
efficiency = 0.9
continuous_torque = "0.2 N m"

[gearheads.h2]
ratio = 100
[gearheads.h2.friction]
friction = "5 N m"

[pairs]
t1 = ["h1"]
"""


def write_mgdb(folder):
    """The three files of the MGDB format."""
    files = {
        "made_motors.csv": MGDB_MOTORS,
        "made_gearboxes.csv": MGDB_GEARBOXES,
        "made_compatibility.csv": MGDB_COMPATIBILITY,
    }
    return [write(folder, name, text) for name, text in files.items()]


def write_csv(folder):
    """Plain CSV files of motors, gearheads and pairs."""
    files = {"motors.csv": CSV_MOTORS, "gearheads.csv": CSV_GEARHEADS, "pairs.csv": CSV_PAIRS}
    return [write(folder, name, text) for name, text in files.items()]


def write(folder, name, text):
    path = folder / name
    path.write_text(text, "utf-8")
    return path
