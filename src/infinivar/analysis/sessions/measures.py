"""What a user got for a session: offset, penetration, stiffness and leak of constraints, mass felt, and joules."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from infinivar.analysis.sessions.session_result import Session
from infinivar.errors import InputError
from infinivar.motion.vectors import ROTATIONS
from infinivar.motion.virtual.tasks import Caster, Fixture, HoldingTask
from infinivar.units import plain

_PUSH = 1e-3
"""Mean force across a constraint below which no leak is stated. [N]"""

_ALONG = 1e-9
"""Difference of unit vectors that counts as rounding."""

_SPEED = 1e-4
"""Change of speed below which no mass is stated. [m s^-1]"""


class Measure(NamedTuple):
    """One measure of a session."""

    key: str
    """With its unit, for data."""
    words: str
    value: float
    """In the unit; nan if the words say that it is not determined."""
    unit: str

    def __str__(self) -> str:
        """One line."""
        return self.words if np.isnan(self.value) else f"{self.words}: {plain(self.value, 3)} {self.unit}"


def measures(found: Session) -> list[Measure]:
    """What a session shows of its task: measures of guidance, then of what the user felt, then of energy.

    Parameters
    ----------
    found : Session

    Returns
    -------
    list of Measure   Those that the session determines; of a session that ended early, up to its end.

    Source: offsets, penetration and energies as of `Session`. A leak is the mean speed across a constraint over the mean force
    across it; the mass felt is the impulse of the user over the change of speed up to the largest speed.
    """
    return [*_path(found), *_wall(found), *_leaks(found), *_mass(found), *_forces(found), *_energies(found)]


def _path(found: Session) -> Iterator[Measure]:
    if found.path is None:
        return
    offset = np.abs(found.path_offset)
    yield Measure("offset_largest_mm", "largest offset from the path", 1e3 * float(np.max(offset)), "mm")
    square = _mean(found.time, offset**2)
    yield Measure("offset_rms_mm", "RMS offset from the path", 1e3 * float(np.sqrt(square)), "mm")
    farthest = max([one.distance for one in found.overruns], default=0.0)
    if farthest:
        yield Measure("past_end_mm", "farthest past the end of the path", 1e3 * farthest, "mm")


def _wall(found: Session) -> Iterator[Measure]:
    if found.wall is None:
        return
    deepest = max([touch.depth for touch in found.touches], default=0.0)
    yield Measure("penetration_mm", "deepest penetration of the wall", 1e3 * deepest, "mm")
    if not found.touches:
        return
    beyond = sum(touch.end - touch.start for touch in found.touches)
    yield Measure("time_beyond_s", "time beyond the wall", beyond, "s")
    inside = found.penetration > 0.0
    if np.any(inside):
        pressed = max(0.0, float(np.max(found.wall_force[inside])))
        yield Measure("wall_force_N", "largest force into the wall", pressed, "N")
    stiffness = found.rendered_stiffness
    if np.isfinite(stiffness):
        yield Measure("wall_stiffness_N_mm", "stiffness rendered, without inertia", 1e-3 * stiffness, "N/mm")
    elif found.machine.own_motors:
        words = "stiffness rendered: not determined, as the motion does not separate it from damping"
        yield Measure("wall_stiffness_N_mm", words, stiffness, "N/mm")


def _leaks(found: Session) -> Iterator[Measure]:
    moved, pushed = found.position[-1] - found.position[0], np.trapezoid(found.force, found.time, axis=0)
    last = float(found.time[-1])
    for name, across in _across(found):
        drift, push = float(moved @ across), float(pushed @ across) / last
        yield Measure(f"drift_{_key(name)}_mm", f"drift {_said(name)}", 1e3 * drift, "mm")
        if abs(push) > _PUSH and _creeps(found):
            leak = 1e3 * drift / last / push
            yield Measure(f"leak_{_key(name)}_mm_s_N", f"leak {_said(name)}", leak, "mm/s per N")


def _creeps(found: Session) -> bool:
    """Whether a drift goes on by the laws of the machine.

    What a spring holds yields, and then stays. What rests drifts only by the slope that stands for sticking in the model.
    """
    if not isinstance(found.task, HoldingTask):
        return True
    return hasattr(found.machine, "leg") and found.electrical_energy > 0.0


def _key(name: str) -> str:
    return name.replace(" ", "_")


def _said(name: str) -> str:
    return "along the push" if name == "push" else f"through the constraint {_where(name)}"


def _where(name: str) -> str:
    return "at an angle to the axes" + name.removeprefix("oblique") if name.startswith("oblique") else f"along {name}"


def _across(found: Session) -> Iterator[tuple[str, np.ndarray]]:
    """Directions, (d,), in which the handle should not move."""
    if isinstance(found.task, HoldingTask):
        pushed = np.trapezoid(found.force, found.time, axis=0)
        size = float(np.linalg.norm(pushed))
        if size > _PUSH * float(found.time[-1]):
            yield "push", pushed / size
        return
    if not isinstance(found.task, Fixture):
        return
    turning = ROTATIONS if len(found.axes) == 3 and hasattr(found.machine, "platform") else ()
    place = np.concatenate([found.position[0], np.zeros(3)])[:3]
    try:
        rows = found.task.allowed.rows((*found.axes, *turning), place).rows
    except InputError:
        return
    count = len(found.axes)
    # Rows on the velocity alone; their span does not depend on how they are written.
    plain_rows = rows[~np.any(np.abs(rows[:, count:]) > 1e-12, axis=1)][:, :count]
    if not len(plain_rows):
        return
    kept = np.linalg.pinv(plain_rows) @ plain_rows  # projects on what the rows keep
    for name, axis in zip(found.axes, np.eye(count), strict=True):
        if np.linalg.norm(kept @ axis - axis) < _ALONG:
            yield name, axis
            kept = kept - np.outer(axis, axis)
    values, vectors = np.linalg.eigh(kept)
    oblique = vectors[:, values > 0.5].T
    yield from ((f"oblique {place}" if len(oblique) > 1 else "oblique", one) for place, one in enumerate(oblique, 1))


def _mass(found: Session) -> Iterator[Measure]:
    if found.task is not None and not isinstance(found.task, Caster):
        return
    for place, axis in enumerate(found.axes):
        speed = found.velocity[:, place] - found.velocity[0, place]
        peak = int(np.argmax(np.abs(speed)))
        if peak < 2 or abs(speed[peak]) < _SPEED:
            continue
        mass = float(found.felt_mass(0.0, float(found.time[peak]))[place])
        if np.any(found.force[:, place]) and np.isfinite(mass):
            yield Measure(f"felt_mass_{axis}_kg", f"mass felt along {axis}", mass, "kg")


def _forces(found: Session) -> Iterator[Measure]:
    largest = float(np.max(np.linalg.norm(found.force, axis=1)))
    if largest > 0.0:
        yield Measure("user_force_N", "largest force of the user", largest, "N")
    if found.turns:
        moment = float(np.max(np.linalg.norm(found.moment, axis=1)))
        yield Measure("user_moment_Nm", "largest moment of the user", moment, "N m")
    speed = float(np.max(np.linalg.norm(found.velocity, axis=1)))
    yield Measure("speed_m_s", "largest speed of the handle", speed, "m/s")


def _energies(found: Session) -> Iterator[Measure]:
    if found.user is not None and hasattr(found.user, "stiffness"):
        yield Measure("handle_work_J", "work of the arm at the handle", found.handle_work, "J")
    electrical = [name for name in found.supplied if "supply" in name]
    if electrical:
        energy = found.electrical_energy
        yield Measure("electrical_energy_J", "electrical energy", energy, "J")
        yield Measure("electrical_power_W", "mean electrical power", energy / float(found.time[-1]), "W")


def _mean(time: np.ndarray, values: Any) -> float:
    return float(np.trapezoid(values, time) / (time[-1] - time[0])) if len(time) > 1 else float(values[0])
