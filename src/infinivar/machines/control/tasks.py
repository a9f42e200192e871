"""Controllers of tasks: which one guides a machine, and how."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar._core.fields import given
from infinivar.errors import ParameterError
from infinivar.machines.control.controller import Commands, Law, Measured, Plant, Unremembering
from infinivar.machines.control.impedance import ImpedanceGuide
from infinivar.machines.control.legs import AdmittanceGuide, HoldGuide
from infinivar.machines.control.planar import CasterGuide, PathGuide, WallGuide
from infinivar.machines.control.planar_fixtures import Beside, PlanarFixtureGuide, PlanarHoldGuide
from infinivar.machines.kind import MovingMachine
from infinivar.motion.virtual.fixtures import OnCurve, OnSurface
from infinivar.motion.virtual.tasks import (
    TASKS,
    Caster,
    Coasting,
    Fixture,
    HandleTask,
    HoldingTask,
    VirtualPath,
    VirtualWall,
)

SETTLING_LENGTH = 0.05
"""Length over which the offset from a path decays, if the task does not say. [m]"""

STIFFNESS, DAMPING = 5000.0, 100.0
"""Of an impedance display, if the task does not say. [N m^-1], [N s m^-1]"""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoastGuide:
    """Leaves the wheels at the angles of the start, and the power motor without current."""

    def begin(self, plant: Plant) -> Law:
        """The law of one session."""
        kept: list[np.ndarray] = []

        def law(measured: Measured) -> Commands:
            if not kept:
                kept.append(plant.machine.coast(measured.rates, measured.steering))
            return Commands(steering=kept[0], steering_rate=0.0 * kept[0])

        return Unremembering(law)  # but of the first sample


def controller_of(task: HandleTask, machine: MovingMachine) -> Any:
    """The controller that does a task with a machine, with the settings that the task leaves open at their defaults.

    Raises
    ------
    ParameterError
        If it is no task, or the machine cannot do it.
    """
    if not isinstance(task, HandleTask):
        raise ParameterError(f"task must be one of {', '.join(kind.__name__ for kind in TASKS.values())}, got {task!r}")
    found = machine.guide(task) if isinstance(machine, MovingMachine) else None
    if found is None:
        raise ParameterError(
            f"task {type(task).__name__} has no controller for a {type(machine).__name__}; give one as controller"
        )
    return found


def guide_of_wheels(task: HandleTask) -> Any:
    """The guide of a body on steered wheels that does a task, or None."""
    if isinstance(task, VirtualPath):
        _in_plane(task.curve.dimension)
        return PathGuide(curve=task.curve, k1=given(task.settling_length, SETTLING_LENGTH) ** -2)
    if isinstance(task, VirtualWall):
        _in_plane(task.surface.dimension)
        if task.sides == "two":
            return PathGuide(curve=Beside(surface=task.surface), k1=SETTLING_LENGTH**-2)
        return WallGuide(wall=task.surface)
    if isinstance(task, Caster):
        if task.inertia is not None:
            raise ParameterError(
                "inertia does not apply: wheels render a mass across the motion, no inertia; leave it out"
            )
        return CasterGuide(mass=task.mass)
    if isinstance(task, Fixture):
        return PlanarFixtureGuide(allowed=task.allowed)
    if isinstance(task, HoldingTask):
        return PlanarHoldGuide()
    return CoastGuide() if isinstance(task, Coasting) else None


def guide_of_legs(task: HandleTask) -> Any:
    """The guide of legs on a common cylinder that does a task, or None."""
    if isinstance(task, VirtualPath):
        return AdmittanceGuide(constraint=OnCurve(curve=task.curve), ends=task.curve if task.ends == "stop" else None)
    if isinstance(task, VirtualWall):
        if task.sides == "two":
            return AdmittanceGuide(constraint=OnSurface(surface=task.surface))
        return AdmittanceGuide(wall=task.surface)
    if isinstance(task, Fixture):
        return AdmittanceGuide(constraint=task.allowed)
    if isinstance(task, Caster):
        usual = AdmittanceGuide()
        return AdmittanceGuide(mass=given(task.mass, usual.mass), inertia=given(task.inertia, usual.inertia))
    if isinstance(task, HoldingTask):
        return HoldGuide(stop_cylinder=task.stop_cylinder)
    return CoastGuide() if isinstance(task, Coasting) else None


def guide_of_motors(task: HandleTask) -> Any:
    """The guide of a motor for each link that does a task, or None."""
    if isinstance(task, VirtualWall):
        stiffness, damping = given(task.stiffness, STIFFNESS), given(task.damping, DAMPING)
        return ImpedanceGuide(wall=task.surface, stiffness=stiffness, damping=damping, two_sided=task.sides == "two")
    if isinstance(task, VirtualPath):
        return ImpedanceGuide(curve=task.curve, ends=task.ends, stiffness=STIFFNESS, damping=DAMPING)
    if isinstance(task, Fixture):
        return ImpedanceGuide(allowed=task.allowed, stiffness=STIFFNESS, damping=DAMPING)
    if isinstance(task, HoldingTask):
        return ImpedanceGuide(hold="start", stiffness=STIFFNESS, damping=DAMPING)
    # A geared drive cannot render less than its own mass: free motion and coasting are without current.
    return ImpedanceGuide() if isinstance(task, (Caster, Coasting)) else None


def _in_plane(dimension: int) -> None:
    if dimension != 2:
        raise ParameterError(
            f"task must be in the plane for a PlanarMachine, got one in {dimension} dimension{'s' * (dimension != 1)}"
        )


def surface_of(task: Any) -> Any:
    """Surface by which a session with a task is measured, or None."""
    return task.surface if isinstance(task, VirtualWall) else None


def curve_of(task: Any) -> Any:
    """Curve by which a session with a task is measured, or None."""
    return task.curve if isinstance(task, VirtualPath) else None


__all__ = ["CoastGuide", "controller_of", "curve_of", "surface_of"]
