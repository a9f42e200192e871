"""A cart on steered wheels, some with a motor on their axle, that moves in time along a motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from infinivar._core.fields import given
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.control import LINK_BANDWIDTH, SPEED_BANDWIDTH, CoboticControl
from infinivar.drivetrain.control.loops import largest_current
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import ParameterError
from infinivar.limits import Limit
from infinivar.machines.control.traction import TractionController, planned_headings, wrapped
from infinivar.machines.kind import MovingMachine
from infinivar.machines.kinds.planar_motion import PlanarMachine, PlanarMechanics
from infinivar.machines.motors import PowerMotor, SteeringServo
from infinivar.machines.pictures.wheeled import Wheeled
from infinivar.machines.rolling import judged
from infinivar.machines.system import Defaults, Forces, Place, SteeringLaw
from infinivar.motion.histories import VectorHistory
from infinivar.motion.machine_scenario import MachineScenario
from infinivar.transmission.driven_contact import DrivenContact
from infinivar.transmission.kinematics import applied_to


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivenMechanics(Defaults):
    """A body on steered wheels, in its own axes; the speeds of driven axles are further coordinates."""

    body: PlanarMechanics
    driven: tuple[int, ...]
    """Places of the driven wheels."""
    contact: DrivenContact = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]
    coordinates: tuple[str, ...] = field(init=False, default=())
    _inertia: np.ndarray = field(init=False, repr=False, compare=False, default_factory=lambda: np.zeros((1, 3, 3)))

    def __post_init__(self) -> None:
        """Compute what does not change; all wheels are alike."""
        count = 3 + len(self.driven)
        inertia = np.zeros((1, count, count))
        inertia[0, :3, :3] = self.body.inertia
        names = (*self.body.coordinates, *(f"axle_{place + 1}_rad_s" for place in self.driven))
        contact = DrivenContact.of(self.body.cobot.contacts[0])  # type: ignore[index]
        for name, value in {"contact": contact, "coordinates": names, "_inertia": inertia}.items():
            object.__setattr__(self, name, value)

    @property
    def configuration(self) -> tuple[str, ...]:
        """Pose of the body."""
        return self.body.configuration

    @property
    def steered(self) -> tuple[str, ...]:
        """Headings of the wheels."""
        return self.body.steered

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Slip of each wheel."""
        return self.body.demands

    @property
    def losses(self) -> tuple[str, ...]:
        """Of the wheels."""
        return self.body.losses

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia of the body; that of axles is the motors'."""
        place = self.body.at(configuration, rates[:, :3])
        bias = np.zeros_like(rates)
        bias[:, :3] = place.bias
        return Place(place.changes, self._inertia, bias, None)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of wheels that roll freely, and of those on driven axles."""
        own, stick = self.body.cobot.mechanism, self.body.stick_speed
        k, driven, free = own.wheels, list(self.driven), [one for one in range(own.wheels) if one not in self.driven]
        motion = own.velocities(rates[:, :3])
        vx, vy, cosine, sine = motion[..., :k], motion[..., k : 2 * k], np.cos(angles), np.sin(angles)
        spin = own.spins(motion, turning)
        assert spin is not None
        rolled = self.contact.wheel_radius * rates[:, 3:]
        creep = (vx * cosine + vy * sine)[:, driven] - rolled, (vy * cosine - vx * sine)[:, driven]
        turned = self.contact.act(creep, spin=spin[:, driven], surface_speed=rolled, stick_speed=stick)
        groups, way = self.contact.groups(rolled), coulomb(rolled, 1.0, stick)
        turned.losses["rolling"] = groups.rolling_torque / groups.wheel_radius * way * rolled
        turned.losses["bearing"] = groups.bearing_torque / groups.wheel_radius * way * rolled
        e, s = cosine[:, driven], sine[:, driven]
        found = turned._replace(x=turned.x * e - turned.y * s, y=turned.x * s + turned.y * e)
        every = {name: getattr(found, name) for name in ("x", "y", "moment", "slip_demand")} | dict(found.losses)
        if free:
            contact: Any = self.body.cobot.contacts[free[0]]  # type: ignore[index]
            others = contact.act(
                (vx[:, free], vy[:, free]), (cosine[:, free], sine[:, free]), spin=spin[:, free], stick_speed=stick
            )
            rest = {name: getattr(others, name) for name in ("x", "y", "moment", "slip_demand")} | dict(others.losses)
            every = {
                name: self._joined(angles, {**dict.fromkeys(every, 0.0), **rest}[name], one)
                for name, one in every.items()
            }
        generalised = np.zeros_like(rates)
        parts = [every["x"], every["y"], -every["moment"]]
        generalised[:, :3] = applied_to(own.columns, np.concatenate(parts, axis=-1))
        generalised[:, 3:] = -self.contact.wheel_radius * (turned.x + groups.rolling_force * way)
        losses = {name: every[name] for name in found.losses}
        return Forces(generalised, every["moment"] + 0.0 * angles, *judged(losses, every["slip_demand"]))

    def _joined(self, angles: np.ndarray, free: Any, driven: np.ndarray) -> np.ndarray:
        """Values of free and of driven wheels in their order."""
        made = np.zeros_like(angles)
        made[:, [one for one in range(angles.shape[-1]) if one not in self.driven]] = free
        made[:, list(self.driven)] = driven
        return made

    def rates_of(self, configuration: np.ndarray, change: np.ndarray) -> np.ndarray:
        """In axes of the body."""
        return self.body.rates_of(configuration, change)

    def start(self, motion: VectorHistory) -> tuple[np.ndarray, np.ndarray]:
        """Along the motion, with wheels that roll."""
        pose = motion(0.0)
        twist = np.asarray(self.body.rates_of(pose, motion.rate(0.0)), dtype=float)
        return pose, np.append(twist, self.rolling(twist, planned_headings(self.body, motion)(0.0)))

    def rolling(self, twist: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Speeds at which driven axles roll without creep. (n,) [rad s^-1]"""
        velocity = np.asarray(self.body.cobot.mechanism.jacobian) @ twist
        ahead = velocity[:, 0] * np.cos(angles) + velocity[:, 1] * np.sin(angles)
        return ahead[list(self.driven)] / self.contact.wheel_radius

    def outline(self) -> Wheeled:
        """Body and wheels."""
        return self.body.outline()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrivenMachine(MovingMachine):
    """A cart with servos on its wheels and motors on some axles, which follows a motion; `PlanarDrive.moving` makes it."""

    cart: PlanarMachine
    drive: ConventionalDrive
    axles: tuple[int, ...]
    """Places of the driven wheels."""
    lever: float
    """Radius over which a linear drive turns an axle. [m]"""
    tracks: ClassVar[bool] = True
    ungraphed: ClassVar[str] = "machine must have a bond graph: there is none of a cart with motors on its axles"

    def __post_init__(self) -> None:
        """Check that the drive can move in time."""
        stage = self.drive.stage
        rubs = (
            stage.efficiencies is not None or float(stage.shaft_friction) or float(self.drive.guideway.friction_force())
        )
        if rubs or self.drive.chain or stage.stiffness is not None or self.drive.gearhead.stiffness is not None:
            raise ParameterError(
                "drive must be motor and rigid gearhead alone to move in time, without friction or stiffness of its output "
                "stage, guideway or springs; state the friction as that of the motor, or as bearing_torque of the wheel"
            )

    @property
    def control(self) -> CoboticControl:
        """Settings of the servos; those of traction are the drive's."""
        return self.cart.control

    @property
    def home(self) -> np.ndarray:
        """Pose in the plane at the start."""
        return self.cart.home

    @property
    def contacts(self) -> Any:
        """The wheels."""
        return self.cart.contacts

    def mechanics(self, stick_speed: float) -> DrivenMechanics:
        """Contacts and inertia."""
        return DrivenMechanics(body=self.cart.mechanics(stick_speed), driven=self.axles)

    def servo(self, stick_speed: float) -> SteeringServo:
        """Servo of each wheel."""
        return self.cart.servo(stick_speed)

    def power_motor(self, stick_speed: float) -> PowerMotor:
        """Motors of the driven axles."""
        drive, radius = self.drive, float(self.contacts[0].wheel_radius)
        travel = float(drive.stage.travel_per_radian) / (1.0 if drive.own_axis.rotary else self.lever)
        return PowerMotor(
            motor=drive.motor,
            gearhead=drive.gearhead,
            amplifier=drive.amplifier,
            coordinates=tuple(range(3, 3 + len(self.axles))),
            stick_speed=stick_speed / radius * drive.gearhead.ratio / travel,
            travel=travel,
            output_inertia=drive.gear_output_inertia,
        )

    def follow(self, mechanics: Any, motion: VectorHistory | None, pose: np.ndarray, duration: float) -> SteeringLaw:
        """Headings along a motion."""
        if motion is None:
            raise ParameterError("motion is missing: steering = 'controlled' follows it")
        planned, gain, body = planned_headings(mechanics.body, motion), self._gain, mechanics.body

        def law(time: float, c: np.ndarray, nu: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            wanted = body.rates_of(c, motion.rate(time))
            towards = wanted + body.rates_of(c, gain * (motion(time) - c))
            return wrapped(planned(time) + turned_by(body, wanted, towards, planned(time)), angles), planned.rate(time)

        return law

    @property
    def _gain(self) -> float:
        return 2.0 * math.pi * given(self.drive.control.link_bandwidth, LINK_BANDWIDTH)

    def traction(self, mechanics: DrivenMechanics, motion: VectorHistory, user: np.ndarray) -> TractionController:
        """Controller of the currents of the motors along a motion, which begins with the wrench of a user. (3,)"""
        control, motor = self.drive.control, self.power_motor(mechanics.body.stick_speed)
        return TractionController(
            body=mechanics.body,
            driven=self.axles,
            motor=motor,
            motion=motion,
            pole=2.0 * math.pi * given(control.speed_bandwidth, SPEED_BANDWIDTH),
            gain=self._gain,
            limit=largest_current(control.current_limit, self.drive.motor),
            integral=-user[:3],
        )


_SLOW = 0.05
"""Speed of a wheel below which an error of the pose turns it less. [m s^-1]"""


def turned_by(body: PlanarMechanics, wanted: np.ndarray, towards: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Angles from the velocities of the wheels in a motion to those that also correct its pose, (k,), small while they creep."""
    jacobian = np.asarray(body.cobot.mechanism.jacobian)
    first, other = jacobian @ wanted, jacobian @ towards
    ahead = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    way = np.where(np.sum(first * ahead, axis=-1) < 0.0, -1.0, 1.0)
    first, other = first + _SLOW * way[:, None] * ahead, other + _SLOW * way[:, None] * ahead
    return np.arctan2(first[:, 0] * other[:, 1] - first[:, 1] * other[:, 0], np.sum(first * other, axis=-1))


def scenario_along(
    machine: Any, time: np.ndarray, pose: np.ndarray, wrench: np.ndarray, closed: bool
) -> MachineScenario:
    """Motion in closed loops along poses (t, 3), whose rates are twists in axes of the cart, under wrenches on the load (t, 3);
    closed: whether half of it settles."""
    angle, steps = pose[:, 2], np.diff(pose[:, :2], axis=0) @ np.array([1.0, 1.0j])
    turned = np.cumsum(steps * np.exp(0.5j * (angle[1:] + angle[:-1])))
    place = pose[0, :2] @ np.array([1.0, 1.0j]) + np.append(0.0, turned)
    duration, fixed = float(time[-1]), np.stack([np.real(place), np.imag(place), angle], axis=-1)
    return MachineScenario(
        duration=duration,
        motion=VectorHistory(time=time, values=fixed),
        wrench=VectorHistory(time=time, values=wrench, smooth=False) if np.any(wrench) else None,
        settling_time=0.5 * duration if closed else None,
    )
