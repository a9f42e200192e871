"""The kinds of machine: a new one is added to these two lists, beside its own module in `infinivar.machines.kinds`."""

from __future__ import annotations

from infinivar.machines.kinds.arm import ArmDrive, ArmMachine, SerialArmMachine
from infinivar.machines.kinds.linked import SeparateMachine
from infinivar.machines.kinds.omniwheels import OmniwheelDrive, OmniwheelMachine
from infinivar.machines.kinds.planar import PlanarDrive, PlanarMachine
from infinivar.machines.kinds.platform import PlatformDrive, PlatformMachine
from infinivar.machines.kinds.slide import GearedSlideMachine, SlideMachine
from infinivar.machines.kinds.sphere import SphereDrive, SphereMachine

DRIVES: dict[str, type] = {
    kind.WORD: kind for kind in (PlanarDrive, SphereDrive, PlatformDrive, ArmDrive, OmniwheelDrive)
}
"""Kinds of drive of a study by their type there."""

MACHINES: tuple[type, ...] = (
    PlatformMachine,
    ArmMachine,
    OmniwheelMachine,
    SerialArmMachine,
    PlanarMachine,
    SphereMachine,
    SeparateMachine,
    SlideMachine,
    GearedSlideMachine,
)
"""Machines that move in time."""
