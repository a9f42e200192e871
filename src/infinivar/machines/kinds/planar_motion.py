"""A cart on steered wheels that moves in time, pushed by a user: its mechanics, and the machine with its servos."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from infinivar._core.arrays import real_array
from infinivar._core.fields import check, component, given
from infinivar.bondgraph.graph import Parameter, Signal
from infinivar.bondgraph.recorded import vector
from infinivar.drivetrain.control import CoboticControl
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.machines import bonds
from infinivar.machines.control.loops import following_path
from infinivar.machines.control.tasks import guide_of_wheels
from infinivar.machines.hand import BodyGrip, Grip
from infinivar.machines.kind import MovingMachine, servo_of
from infinivar.machines.motors import SteeringServo
from infinivar.machines.pictures.wheeled import Wheeled
from infinivar.machines.rolling import ROLLING_LOSSES, judged, slip_demands
from infinivar.machines.system import Defaults, Forces, Place, SteeringLaw
from infinivar.motion.histories import VectorHistory
from infinivar.parts.amplifier import Amplifier
from infinivar.transmission.planar import PlanarCobot
from infinivar.transmission.rolling_contact import RollingContact


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanarMechanics(Defaults):
    """A body on steered wheels, in its own axes; the configuration is its pose in the plane."""

    cobot: PlanarCobot
    stick_speed: float
    coordinates: tuple[str, ...] = ("v_x_m_s", "v_y_m_s", "w_rad_s")
    configuration: tuple[str, ...] = ("x_m", "y_m", "angle_rad")
    losses: tuple[str, ...] = ROLLING_LOSSES
    _inertia: np.ndarray = field(init=False, repr=False, compare=False, default_factory=lambda: np.zeros((1, 3, 3)))

    def __post_init__(self) -> None:
        """Compute what does not change."""
        mass, moment = float(self.cobot.mass), float(self.cobot.inertia)  # type: ignore[arg-type]
        object.__setattr__(self, "_inertia", np.diag([mass, mass, moment])[None])

    @property
    def inertia(self) -> np.ndarray:
        """Mass matrix in axes of the body. (3, 3)"""
        return self._inertia[0]

    @property
    def steered(self) -> tuple[str, ...]:
        """Headings of the wheels."""
        return tuple(f"h_{place + 1}_rad" for place in range(self.cobot.mechanism.wheels))

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Slip of each wheel."""
        return slip_demands(self.cobot.mechanism.wheels, "wheel")

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia, and the force that turns a velocity in turning axes."""
        cosine, sine = np.cos(configuration[:, 2]), np.sin(configuration[:, 2])
        x, y, turning = rates[:, 0], rates[:, 1], rates[:, 2]
        changes, bias = np.empty_like(rates), np.zeros_like(rates)
        changes[:, 0], changes[:, 1], changes[:, 2] = cosine * x - sine * y, sine * x + cosine * y, turning
        whirled = self._inertia[0, 0, 0] * turning
        bias[:, 0], bias[:, 1] = -whirled * y, whirled * x
        return Place(changes, self._inertia, bias, None)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of the wheels."""
        heading = np.cos(angles), np.sin(angles)
        found, exerted = self.cobot.mechanism.forces(rates, heading, turning, self.stick_speed)
        resisting = found.moment + 0.0 * angles
        return Forces(exerted, resisting, *judged(found.losses, found.slip_demand))

    def rates_of(self, configuration: np.ndarray, change: np.ndarray) -> np.ndarray:
        """In axes of the body."""
        (c,), (s,) = np.cos(configuration[2:]), np.sin(configuration[2:])
        x, y, turning = change
        return vector(c * x + s * y, c * y - s * x, turning)

    def grip(self, handle: Sequence[float] = (0.0, 0.0)) -> Grip:
        """A point of the body."""
        point = real_array("handle", handle)
        fits = point.shape == (2,) and bool(np.all(np.isfinite(point)))
        require(fits, "handle", f"{handle}", "x and y, two finite numbers", "m")
        return BodyGrip(point=(float(point[0]), float(point[1])))

    def held_at(self, configuration: np.ndarray, position: np.ndarray) -> np.ndarray:
        """In axes of the body."""
        away, angle = position - configuration[:2], configuration[2]
        cosine, sine = np.cos(angle), np.sin(angle)
        return np.array([cosine * away[0] + sine * away[1], cosine * away[1] - sine * away[0]])

    def outline(self) -> Wheeled:
        """Body and wheels."""
        return Wheeled(
            spots=np.array(self.cobot.positions),
            radii=np.array([float(one.wheel_radius) for one in self.cobot.contacts]),  # type: ignore[union-attr]
            mass=float(given(self.cobot.mass, 0.0)),
            inertia=float(given(self.cobot.inertia, 0.0)),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanarMachine(MovingMachine):
    """A planar cobot with servos on its wheels, moved by a user.

    Raises
    ------
    ParameterError
        If the cobot has no mass or inertia.
    """

    cobot: PlanarCobot = component("Body and wheels")
    steering: SteeringPlant | None = component("Servo of each wheel", default=None)
    amplifier: Amplifier = component("Amplifier of the servos", default_factory=Amplifier)
    control: CoboticControl = component("Controllers", default_factory=CoboticControl)

    pushed: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        for name in ("mass", "inertia"):
            needed(getattr(self.cobot, name), f"cobot.{name}")

    @property
    def home(self) -> np.ndarray:
        """Pose in the plane at the start."""
        return np.zeros(3)

    def mechanics(self, stick_speed: float) -> PlanarMechanics:
        """Contacts and inertia."""
        return PlanarMechanics(cobot=self.cobot, stick_speed=stick_speed)

    def servo(self, stick_speed: float) -> SteeringServo:
        """Servo of each wheel."""
        wheel = self.cobot.contacts[0]  # type: ignore[index]
        return servo_of(self.steering, wheel, self.amplifier, stick_speed)

    @property
    def twisted(self) -> tuple[str, ...]:
        """All."""
        return "x", "y", "angle"

    @property
    def contacts(self) -> Sequence[RollingContact]:
        """The wheels."""
        return self.cobot.contacts  # type: ignore[return-value]

    def bonds(self, stick_speed: float) -> bonds.Bonds:
        """Body in its own axes, and wheels."""
        ports = ("v_x", "v_y", "w")
        inertia = self.mechanics(stick_speed).inertia
        body = bonds.inertias(
            [
                bonds.Coordinate("v_x", "v_x", "m_x", "m", "kg", "body"),
                bonds.Coordinate("v_y", "v_y", "m_y", "m", "kg", "body"),
                bonds.Coordinate("w", r"\omega", "I", "I", "kg m^2", "body"),
            ],
            inertia,
        )
        body.signals.append(Signal(name="turn", symbol=r"\omega", of="w"))
        mass = Parameter("m", float(inertia[0, 0]), "kg")
        turning = bonds.axes_that_turn("turning", r"-m\omega", ("v_x", "v_y"), "turn", mass, -1.0)
        wheels = bonds.wheels(self.cobot.mechanism, ports, stick_speed)
        return bonds.Bonds.of(body, turning, wheels, bonds.user(ports))

    def coast(self, rates: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Headings of a body that moves."""
        if not np.any(rates):
            return angles
        found = np.asarray(self.cobot.headings(rates))
        return np.where(np.isfinite(found), found, angles)

    def follow(self, mechanics: Any, motion: VectorHistory | None, pose: np.ndarray, duration: float) -> SteeringLaw:
        """Headings along a motion."""
        if motion is None:
            raise ParameterError("motion is missing: steering = 'controlled' follows it")
        return following_path(self.cobot, motion, gain=2.0 * math.pi * self.control.link_bandwidth)

    def guide(self, task: Any) -> Any:
        """Guides of wheels that steer."""
        return guide_of_wheels(task)
