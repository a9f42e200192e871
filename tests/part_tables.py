"""Tables of motors and gearheads as data sheets have them, drawn at random, with gaps."""

import numpy as np


def part_tables(seed, motors=12, gearheads=10, gaps=0.3, thermal=0.6):
    """Columns of motors and gearheads, and all pairs of both."""
    random = np.random.default_rng(seed)

    def some(values, share=gaps):
        return np.where(random.random(len(values)) < share, np.nan, values)

    constant = random.uniform(0.012, 0.05, motors)
    volts = random.choice([24.0, 36.0, 48.0], motors)
    ohms = 0.6 * (constant / 0.03) ** 2 * random.uniform(0.3, 2.0, motors)
    idle = random.uniform(0.02, 0.2, motors)
    lasting = random.uniform(0.03, 0.2, motors)
    known = random.random(motors) < thermal
    most_viscous = constant * idle / ((volts - ohms * idle) / constant)
    of_motors = {
        "voltage": volts,
        "resistance": ohms,
        "torque_constant": constant,
        "no_load_current": idle,
        "continuous_torque": lasting,
        "viscous_friction": some(0.6 * most_viscous, 0.5),
        "peak_torque": some(3.0 * lasting),
        "max_speed": some(random.uniform(600.0, 1500.0, motors)),
        "rotor_inertia": random.uniform(1e-6, 8e-6, motors),
        "mass": random.uniform(0.05, 0.4, motors),
        "winding_to_housing": np.where(known, random.uniform(1.0, 4.0, motors), np.nan),
        "housing_to_ambient": np.where(known, random.uniform(4.0, 12.0, motors), np.nan),
        "winding_time_constant": np.where(known, random.uniform(1.0, 30.0, motors), np.nan),
        "housing_time_constant": np.where(known, random.uniform(200.0, 900.0, motors), np.nan),
        "max_winding_temperature": np.where(known, random.uniform(360.0, 430.0, motors), np.nan),
    }
    of_gearheads = {
        "ratio": random.uniform(3.0, 40.0, gearheads),
        "efficiency": random.uniform(0.6, 0.95, gearheads),
        "backdriving_efficiency": some(random.uniform(0.3, 0.9, gearheads)),
        "continuous_torque": some(random.uniform(1.0, 6.0, gearheads)),
        "intermittent_torque": some(random.uniform(2.0, 9.0, gearheads)),
        "max_input_speed": some(random.uniform(600.0, 1500.0, gearheads)),
        "inertia": some(random.uniform(1e-7, 1e-6, gearheads)),
        "mass": random.uniform(0.05, 0.3, gearheads),
    }
    pairs = np.stack(np.meshgrid(np.arange(motors), np.arange(gearheads), indexing="ij"), axis=-1).reshape(-1, 2)
    return of_motors, of_gearheads, pairs
