"""The kinds of machine: a new one is added to these two lists, beside its own module in `infinivar.machines.kinds`."""

from __future__ import annotations

DRIVES = {
    "planar": "infinivar.machines.kinds.planar:PlanarDrive",
    "sphere": "infinivar.machines.kinds.sphere:SphereDrive",
    "platform": "infinivar.machines.kinds.platform:PlatformDrive",
    "arm": "infinivar.machines.kinds.arm:ArmDrive",
    "robot": "infinivar.machines.kinds.robot:RobotDrive",
    "omniwheels": "infinivar.machines.kinds.omniwheels:OmniwheelDrive",
}
"""Kinds of drive of a study by their type there, their `WORD`; a study of drives of one axis imports none of them."""

MACHINES = (
    "PlatformMachine",
    "ArmMachine",
    "RobotMachine",
    "OmniwheelMachine",
    "SerialArmMachine",
    "PlanarMachine",
    "DrivenMachine",
    "SphereMachine",
    "SeparateMachine",
    "SlideMachine",
    "GearedSlideMachine",
)
"""Machines that move in time."""
