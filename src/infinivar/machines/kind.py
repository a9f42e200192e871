"""What a kind of machine is: all that the rest of the program asks of it, in one place.

A kind is a module in `infinivar.machines.kinds`, with up to three classes, which `infinivar.machines.registry` lists:

- A *drive* of a study, with the fields of its table. It must have what `infinivar.machines.machine.Machine` asks: ``WORD``, its
  type in a study, ``coordinates``, ``home`` and ``perform``; and may have ``follow``, ``counts`` and ``lacking``, see there. What
  else it may have is in `MachineDrive`.
- A *machine* that moves in time, a subclass of `MovingMachine` here: control, motors, servos, controllers of tasks, bond graph.
- Its *mechanics*, see `infinivar.machines.system.Mechanics`: the equations of motion, handle and outline. Machines whose links
  are moved side by side share theirs, and have a `infinivar.machines.linkage.Load` instead.

Nothing outside this package asks which kind a machine is. A drive at a steady point is drawn from its ``picture``, made of the
strokes of `infinivar.machines.pictures`; a machine in motion from its ``outline``. Figures of one kind only are in
`infinivar.figures.kinds`, by the drive's ``WORD``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import ParameterError
from infinivar.machines.bonds import Bonds
from infinivar.machines.motors import LinkMotors, PowerMotor, SteeringServo
from infinivar.machines.pictures.strokes import Picture
from infinivar.machines.system import Mechanics, SteeringLaw
from infinivar.motion.histories import VectorHistory
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.transmission.rolling_contact import RollingContact


class MovingMachine:
    """A machine of many contacts that can move in time, or its rival with a motor for each link.

    A kind must define ``control``, the settings of its controllers, ``home`` and `mechanics`; all else has a default.
    """

    __slots__ = ()
    control: Any
    home: Any
    """Configuration at the start. (c,)"""
    pushed: ClassVar[bool] = False
    """Whether a user is its only source."""
    own_motors: ClassVar[bool] = False
    """Whether each link has a motor of its own."""
    ungraphed: ClassVar[str] = ""
    """Why it has no bond graph of its own."""
    tracks: ClassVar[bool] = False
    """Whether its power motors follow the motion, by a controller of its own, instead of holding a speed."""
    driven: ClassVar[str] = "cylinder"
    """The 1-junction of its bond graph that the power motor turns."""

    @property
    def contacts(self) -> Sequence[RollingContact]:
        """All kinds of its contacts."""
        raise NotImplementedError

    def bonds(self, stick_speed: float) -> Bonds:
        """Its bond graph without motors: coordinates with inertias, contacts, user."""
        raise NotImplementedError

    @property
    def twisted(self) -> tuple[str, ...]:
        """Names of the velocities at which a session may start; none of a machine that starts at rest."""
        return ()

    @property
    def set_speed(self) -> float:
        """Speed of the motor's coordinate; 0 without one. [rad s^-1]"""
        return 0.0

    def mechanics(self, stick_speed: float) -> Mechanics:
        """Equations of motion, with friction that sticks below a speed. [m s^-1]"""
        raise NotImplementedError

    def servo(self, stick_speed: float) -> SteeringServo | None:
        """Servo of each steered axis; None if nothing is steered."""
        return None

    def power_motor(self, stick_speed: float) -> PowerMotor | None:
        """Motor that drives coordinates of the machine, or None."""
        return None

    def link_motors(self, stick_speed: float) -> LinkMotors | None:
        """Motors of the links, or None."""
        return None

    def roll(self, rates: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Rates at which all contacts roll at steering angles, where the motor's coordinate determines all others. (N,)"""
        return rates

    def coast(self, rates: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Steering angles at which the wheels coast from a motion; those of now if nothing else is known. (s,)"""
        return angles

    def follow(self, mechanics: Any, motion: VectorHistory | None, pose: np.ndarray, duration: float) -> SteeringLaw:
        """Steering angles that follow a motion, or without one hold a pose for a duration.

        Raises
        ------
        ParameterError
            If the machine cannot.
        """
        raise ParameterError(
            "steering must be 'locked' or angles over time for a sphere or a serial arm; only a platform, an arm on a common "
            "cylinder and a planar cobot follow a motion"
        )

    def guide(self, task: Any) -> Any:
        """The controller of a `infinivar.motion.virtual.tasks.HandleTask`, its open settings at their defaults; None if there
        is none."""
        return None


class MachineDrive:
    """What a drive of a study may have beside its steady operation."""

    __slots__ = ()
    session: ClassVar[tuple[str, ...]] = ()
    """Keys of a session that apply to it beside those of all; none if it has no handle."""
    source: ClassVar[str] = "supply"
    """What feeds it."""
    unmoved: ClassVar[str] = "simulate works with drives of one axis, platforms, arms, spheres and carts with motors"
    """Why it has no ``scenario``: how it does not move in `infinivar simulate`."""

    held_time: ClassVar[float] = 0.2
    """Time for which a task is simulated, of which the first half settles. [s]"""
    shown: ClassVar[str] = ""
    """What its picture shows, for a caption: starts with a comma or a colon."""

    def picture(self, point: Any, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> Picture | None:
        """What is drawn of it at an operating point, a `TaskPoint`, at a pose, twist and wrench (d,); None if nothing is.

        Raises
        ------
        InputError
            If it cannot be drawn there, as it does not reach the pose or a wheel slips.
        """
        return None

    @property
    def commands(self) -> tuple[str, ...]:
        """Commands that work with it besides those of all machines."""
        return ()

    def followed(self, pose: Array, wrench: Array) -> tuple[np.ndarray, np.ndarray]:
        """Configuration of the machine in motion, and forces on the load there, of poses and wrenches (..., d)."""
        return np.asarray(pose, dtype=float), np.asarray(wrench, dtype=float)


def servo_of(plant: SteeringPlant | None, wheel: Any, amplifier: Amplifier, stick_speed: float) -> SteeringServo:
    """Servo of a wheel with a steering plant.

    Raises
    ------
    ParameterError
        If there is no plant.
    """
    plant = needed(plant, "steering")
    friction = plant.friction_torques(wheel)
    return SteeringServo(
        plant=plant,
        amplifier=Amplifier(
            regeneration=amplifier.regeneration,
            storage_efficiency=amplifier.storage_efficiency,
            efficiency=amplifier.efficiency,
        ),
        # A patch that rolls as it turns belongs to the contact.
        patch_friction=0.0 if wheel.turns_with_spin else float(friction["patch"]),
        bell_friction=float(friction["bell"]),
        stick_speed=stick_speed / wheel.wheel_radius,
    )


def motor_of(
    motor: Motor | None, gearhead: Gearhead | None, amplifier: Amplifier, coordinate: int, stick_speed: float
) -> PowerMotor | None:
    """Power motor behind a gearhead, of 1:1 without one; None without a motor."""
    if motor is None:
        return None
    gearhead = Gearhead(ratio=1.0, efficiency=1.0) if gearhead is None else gearhead
    return PowerMotor(
        motor=motor,
        gearhead=gearhead,
        amplifier=amplifier,
        coordinates=(coordinate,),
        stick_speed=stick_speed * gearhead.ratio,
    )
