"""Sessions on the virtual rig for the tests of calibration: under any creep law, and with readings gone wrong."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from infinivar.contact import creep, exact_tables
from infinivar.study import Rig
from internals import virtual_rig

RIG = Rig()
RATIOS = (100.0, 20.0, 8.0, 3.0, 1.0)

READINGS = {"motor_current": (0.1, 0.6), "link_travel": (0.01, 0.1), "motor_voltage": (1.0, 8.0)}
"""Readings that may be misread, and by how much where that is not a factor. [A], [m], [V]"""


def under(drive, law):
    """The drive with another creep law."""
    return replace(drive, transmission=replace(drive.transmission, creep_law=law))


def session(drive, seed=0, rig=RIG, **options):
    """A session by the steady solution, which the bond graph settles to (`test_bond_graph_settles...`)."""
    protocol = virtual_rig.protocol(drive, rig, **{"ratios": RATIOS, **options})
    return virtual_rig.experiment(drive, rig, protocol, seed=seed, simulated=False).data


def misread(data, seed, *, share=0.05, readings=("motor_current",)):
    """The data with a share of the runs misread, by a factor from 0.3 to 3 or by an offset, and which."""
    random = np.random.default_rng(10_000 + seed)
    columns = {name: getattr(data, name).copy() for name in READINGS}
    wrong = random.random(len(data)) < share
    for row in np.flatnonzero(wrong):
        name = readings[random.integers(len(readings))]
        if random.random() < 0.5:
            columns[name][row] *= random.uniform(0.3, 3.0)
        else:
            columns[name][row] += random.choice([-1.0, 1.0]) * random.uniform(*READINGS[name])
    return replace(data, **columns), wrong


def law_of(ratio, creepage, name):
    """A creep law through points of force ratio and scaled creepage, from 0 to slip."""
    inverse, forward = PchipInterpolator(ratio, creepage), PchipInterpolator(creepage, ratio)
    slope = inverse.derivative()

    def odd(function, most):
        return lambda value: np.sign(value) * function(np.clip(np.abs(value), 0.0, most))

    return creep.CreepLaw(
        name=name,
        creepage=odd(inverse, 1.0),
        slope=lambda value: slope(np.clip(np.abs(value), 0.0, 1.0)),
        force=odd(forward, creepage[-1]),
        slip_creepage=float(creepage[-1]),
    )


def exact_law(a_over_b):
    """Exact rolling theory's law for a shape of the patch; what little force it adds near slip is left away."""
    curve = next(one for one in exact_tables.lateral_creep() if one["a_over_b"] == a_over_b)
    ratio, creepage = curve["force_ratio"], 3.0 * curve["scaled_creepage"]
    count = int(np.argmax(ratio > 0.999)) + 1
    return law_of(ratio[:count] / ratio[count - 1], creepage[:count], "theory")
