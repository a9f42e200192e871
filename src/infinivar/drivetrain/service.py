"""What the structure of a drive has to carry, and over which travel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from infinivar._core.array_namespace import Array
from infinivar._core.fields import given
from infinivar.drivetrain import chain
from infinivar.motion.duty_cycles import DutyCycle


class Service(NamedTuple):
    """What the output of a drive, on its own side of springs and linkage, has to do; arrays that broadcast."""

    travel: Array | None
    """From end to end; None: not known. [m]"""
    force: Array | None
    """Largest. [N]; of a drive that turns a shaft [N m]"""
    energies: Mapping[str, float] = {}
    """Largest energy in each spring, by the name of its place in the output; what is missing is not known. [J]"""
    reach: tuple[float, float] | None = None
    """Least and largest position in the motions; None without one. [m]"""


NO_SERVICE = Service(None, None)
"""Nothing is known."""


def service_of(
    drive: Any, duty: Mapping[str, DutyCycle], requirement: Any = None, travel: float | None = None
) -> Service:
    """What the motions and the required region of a study ask of a drive's own output.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive
    duty : mapping of DutyCycle
    requirement : Requirement   Required region.
    travel : float              Of the load; behind a linkage it counts about position 0. [m]

    Returns
    -------
    Service   The largest of all; out of reach of a linkage, what can be reached.
    """
    import numpy as np

    own, axis = drive.output.chain, drive.axis
    travels: list[float] = []
    reached: list[float] = []
    forces: list[float] = []
    energies: dict[str, float] = {}
    for cycle in duty.values():
        _, _, course = cycle.instants(orders=6 if drive.output.has_series_spring else 4)
        load = chain.inward(own, course, given(cycle.moved_mass, 0.0), axis, (2, 0))
        position = np.asarray(load.course.position, dtype=float)
        step = cycle.period / position.size
        force = np.abs(load.course.driving_force(load.mass).value)
        some = position[np.isfinite(position)]
        travels += [float(np.ptp(some))] if some.size else []
        reached += [float(some.min()), float(some.max())] if some.size else []
        forces += [float(np.max(some))] if (some := force[np.isfinite(force)]).size else []
        for place in own:
            if place.name in load.stored:
                energy = np.append(0.0, np.cumsum(load.stored[place.name]) * step)
                energies[place.name] = max(energies.get(place.name, 0.0), float(np.ptp(energy)))
    if requirement is not None:
        for speed, force in requirement.corners().values():
            at = chain.steady(own, position=0.0, speed=speed, force=force, axis=axis)
            forces.append(abs(float(at.force)))
        if travel is not None and drive.output.linkage is not None:
            ends = [
                chain.steady(own, position=end, speed=0.0, force=0.0, axis=axis).position
                for end in (-0.5 * travel, 0.5 * travel)
            ]
            travels.append(abs(float(ends[1]) - float(ends[0])))
    if travel is not None and drive.output.linkage is None:
        travels.append(travel)
    reach = (min(reached), max(reached)) if reached else None
    return Service(max(travels, default=drive.structure.travel), max(forces, default=None), energies, reach)
