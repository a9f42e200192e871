"""Where the parts of a machine are while it moves: what its drawings and scenes show.

Sessions at a handle and simulated runs have the same parts. A run has no user: its handle is where one would hold it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from infinivar.analysis.machine_run import MachineRun
from infinivar.analysis.sessions.session_result import Session
from infinivar.errors import InputError
from infinivar.machines.pictures.jointed import Chain
from infinivar.machines.pictures.robots import TurningMembers
from infinivar.machines.pictures.rods import OnRods
from infinivar.machines.pictures.slides import Slides
from infinivar.machines.pictures.wheeled import Wheeled

Outline = Wheeled | OnRods | Chain | TurningMembers | Slides

STICK_SPEED = 1e-4
"""With which mechanics are made where only their geometry and inertia count. [m s^-1]"""


class Parts(NamedTuple):
    """A machine at t instants; d directions of its handle, k wheels."""

    outline: Outline
    time: np.ndarray
    """(t,) [s]"""
    configuration: np.ndarray
    """(t, c)"""
    steering: np.ndarray
    """Angles of the wheels; none of a machine without wheels. (t, k) [rad]"""
    sliding: np.ndarray
    """Whether a wheel is beyond its slip limit. (t, k)"""
    cylinder_angle: np.ndarray | None
    """Since the start; None without a cylinder. (t,) [rad]"""
    axes: tuple[str, ...]
    """Directions of the handle."""
    handle: np.ndarray
    """(t, d) [m]"""
    force: np.ndarray | None
    """Of the user on the handle; None without a user. (t, d) [N]"""
    held_at: np.ndarray
    """The handle on a body in the plane, in its axes; otherwise zero. (2,) [m]"""

    @property
    def link_positions(self) -> np.ndarray:
        """Of the links on the cylinder since their position 0. (t, n) [m]"""
        return self.outline.link_positions(self.configuration)


def parts_of(run: Session | MachineRun, time: np.ndarray | None = None) -> Parts:
    """The parts of a machine during a session or run.

    Parameters
    ----------
    run : Session or MachineRun
    time : (t,) float   Instants, between which results are interpolated; by default those of the results. [s]

    Raises
    ------
    InputError
        If the machine has no handle: a sphere between rollers.
    """
    mechanics = run.machine.mechanics(STICK_SPEED)
    outline = mechanics.outline()
    if outline is None:
        raise InputError(
            f"a {type(run.machine).__name__} is not drawn in motion: only planar cobots, slides, platforms and arms"
        )
    known, columns = run.time, run.columns
    time = known if time is None else np.asarray(time, dtype=float)

    def at(name: str) -> np.ndarray:
        return np.interp(time, known, columns[name])

    configuration = np.stack([at(name) for name in mechanics.configuration], axis=-1)
    steering = (
        np.stack([at(name) for name in mechanics.steered], axis=-1) if mechanics.steered else np.zeros((len(time), 0))
    )
    wheels = [f"slip_demand_wheel_{place + 1}" for place in range(steering.shape[1])]
    sliding = np.stack([at(name) > 1.0 for name in wheels], axis=-1) if wheels else np.zeros((len(time), 0), dtype=bool)
    turned = None
    if "cylinder_speed_rad_s" in columns:
        speed = columns["cylinder_speed_rad_s"]
        steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(known)
        turned = np.interp(time, known, np.concatenate([[0.0], np.cumsum(steps)]))
    held_at = np.zeros(2)
    if isinstance(run, Session):
        began = np.array([columns[name][0] for name in mechanics.configuration])
        held_at = mechanics.held_at(began, run.position[0])
    grip = mechanics.grip(held_at.tolist())
    handle = grip.at(configuration, np.zeros((len(time), len(mechanics.coordinates)))).position
    force = np.stack([at(f"force_{axis}_N") for axis in run.axes], axis=-1) if isinstance(run, Session) else None
    return Parts(
        outline=outline,
        time=time,
        configuration=configuration,
        steering=steering,
        sliding=sliding,
        cylinder_angle=turned,
        axes=grip.axes,
        handle=handle,
        force=force,
        held_at=held_at,
    )
