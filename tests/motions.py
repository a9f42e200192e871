"""Motions written to CSV files, as a logger would record them, and random ones of moves and dwells."""

import numpy as np

from infinivar import DutyCycle
from infinivar.motion import Reaches, Recording


def written(duty, path, rate, *, column="position", count=None, noise=None):
    """A CSV file of one cycle of a duty cycle at a rate [Hz]; rounded to a `count` [m] or with `noise` if given."""
    time = np.arange(round(duty.period * rate) + 1) / rate
    position, course = duty.at(np.minimum(time, duty.period * (1 - 1e-12)))
    values = np.array(course.speed if column == "speed" else position)
    if noise is not None:
        values = values + noise
    if count is not None:
        values = count * np.round(values / count)
    force = np.broadcast_to(course.force, time.shape)
    unit = "m/s" if column == "speed" else "m"
    rows = [f"{t:.9g},{x:.9g},{f:.9g}" for t, x, f in zip(time, values, force, strict=True)]
    path.write_text("\n".join([f"time [s],{column} [{unit}],force [N]", *rows]) + "\n", "utf-8")
    return str(path)


def recorded(duty, path, rate, **options):
    """The same cycle as a recording."""
    return DutyCycle(motion=Recording.read(written(duty, path, rate, **options)), load_mass=duty.load_mass)


def moves_and_dwells(random):
    """A random cycle of reaches and stays, half of them under a constant force: times in hundredths of a second."""
    time = round(float(random.uniform(0.3, 1.2)), 2)
    pause = round(float(random.choice([0.0, random.uniform(0.15, 1.0)])), 2)
    force = float(random.choice([0.0, random.uniform(-25.0, 25.0)]))
    return DutyCycle(
        motion=Reaches(time=time, pause=pause, distance=float(random.uniform(0.1, 0.6)) * 0.5 * time),
        force=force or None,
        load_mass=0.8,
    )
