"""Links of a platform or arm that are moved by a geared motor each: mechanics, motors, and their sampled controller.

The motors are rigid behind their links: rotor, gearhead and stage count as mass of the link. Friction is constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from infinivar._core.fields import given
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.control import LINK_BANDWIDTH, SPEED_BANDWIDTH
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.moving.bodies import rotation_between
from infinivar.drivetrain.moving.control import around, pose_twist
from infinivar.drivetrain.moving.legged import Linkage, Load, PlatformLoad
from infinivar.drivetrain.moving.motors import Powers
from infinivar.drivetrain.moving.system import Forces, Place
from infinivar.errors import ParameterError
from infinivar.limits import Limit
from infinivar.motion.histories import VectorHistory


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkMotors:
    """A motor with gearhead, amplifier and output stage on each link, all alike.

    Raises
    ------
    ParameterError
        If the rotor's inertia is missing, friction depends on the load, or a part is elastic.
    """

    drive: ConventionalDrive
    stick_speed: float
    """Of a link. [m s^-1] or [rad s^-1]"""
    moved_mass: float = field(init=False, default=0.0)
    """Of rotor, gearhead and stage, at the link. [kg] or [kg m^2]"""
    ratio: float = field(init=False, default=1.0)
    """Angle of the motor per travel of the link. [rad/m] or [-]"""
    frictions: tuple[float, float, float, float] = field(init=False, default=(0.0, 0.0, 0.0, 0.0))
    """Of motor, gearhead, stage and guideway, at the link. [N] or [N m]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        drive, gear, stage = self.drive, self.drive.gearhead, self.drive.stage
        rotor = needed(drive.motor.rotor_inertia, "motor.rotor_inertia") + given(gear.inertia, 0.0)
        if not gear.lossless and (gear.loss_model != "coulomb" or gear.friction is not None):
            raise ParameterError(
                f"gearhead.loss_model must be 'coulomb' for motors of links that move, got {gear.loss_model!r}, whose friction "
                "depends on the load"
            )
        losses = stage.efficiencies
        if losses is not None and tuple(losses) != (1.0, 1.0):
            raise ParameterError(
                f"{stage.title} must have no efficiency for motors of links that move, but a friction_torque; its friction would "
                "depend on the load"
            )
        if drive.output.chain or stage.stiffness is not None or gear.stiffness is not None:
            what = "output" if drive.output.chain else "gearhead" if gear.stiffness is not None else stage.title
            raise ParameterError(f"{what} must be rigid, without springs or linkage, for motors of links that move")
        travel = float(stage.travel_per_radian)
        ratio = gear.ratio / travel
        constant = 0.0 if gear.lossless else float(gear.coulomb_friction(drive.motor.continuous_torque))
        object.__setattr__(self, "ratio", ratio)
        object.__setattr__(self, "moved_mass", rotor * ratio**2 + drive.gear_output_inertia / travel**2)
        frictions = (
            drive.motor.friction_torque * ratio,
            constant * ratio,
            float(stage.shaft_friction) / travel,
            float(drive.guideway.friction_force()),
        )
        object.__setattr__(self, "frictions", frictions)

    @property
    def gain(self) -> float:
        """Force on a link per current. [N A^-1] or [N m A^-1]"""
        return self.ratio * self.drive.motor.torque_constant

    @property
    def current_limit(self) -> float:
        """Of the controller, or of a motor that is stalled. [A]"""
        motor = self.drive.motor
        return given(self.drive.control.current_limit, motor.voltage / motor.resistance)

    @property
    def losses(self) -> tuple[str, ...]:
        """Names of the losses; the four of friction first."""
        return ("motor friction", "gearhead", self.drive.stage.title, "guideway", "winding", "motor iron", "amplifier")

    def act(self, currents: np.ndarray, speed: np.ndarray) -> tuple[np.ndarray, Powers]:
        """Forces on the links, (m, n), and a function for the powers of all motors together, at link speeds (m, n)."""
        motor = self.drive.motor
        way = coulomb(speed, 1.0, self.stick_speed)
        iron = given(motor.viscous_friction, 0.0) * self.ratio**2 * speed
        driven = self.gain * currents
        force = driven - sum(self.frictions) * way - iron

        def powers() -> dict[str, np.ndarray]:
            winding = motor.resistance * currents * currents + 0.0 * speed
            taken, burnt, _ = self.drive.amplifier.supply(winding + driven * speed)
            lost = [*(one * way * speed for one in self.frictions), winding, iron * speed, burnt + 0.0 * speed]
            found = {name: one.sum(axis=-1) for name, one in zip(self.losses, lost, strict=True)}
            return {"supply": taken.sum(axis=-1), **found}

        return force, powers


@dataclass(frozen=True, slots=True, kw_only=True)
class SeparateMechanics:
    """A load on links, without wheels or a cylinder."""

    load: Load
    count: int
    """Of links."""
    link_mass: float
    """With what moves it. [kg] or [kg m^2]"""
    losses: tuple[str, ...] = ()
    steered: tuple[str, ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Twist."""
        return self.load.coordinates

    @property
    def configuration(self) -> tuple[str, ...]:
        """Pose."""
        return self.load.configuration

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Limits of the linkage."""
        return self.load.demands

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia with that of the links, and kinematics."""
        link = self.load.at(configuration, rates)
        across = np.swapaxes(link.jacobian, -1, -2)
        inertia = link.moved.inertia + self.link_mass * np.matmul(across, link.jacobian)
        bias = link.moved.bias + self.link_mass * np.matmul(across, link.bias[..., None])[..., 0]
        return Place(link.changes, inertia, bias, link)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """None: the motors act on the links, see `LinkMotors`."""
        return Forces(0.0 * rates, 0.0 * angles, dict, lambda: place.kinematics.demand)


@dataclass(slots=True)
class LinkController:
    """Pose loop with an inner speed loop, of all links together; inertia, centrifugal forces and friction are fed forward.

    The inertia of the machine decouples the links, so that every motion has the poles of the bandwidths. The integral, which
    begins with the force of the user at the start, converges to that force.
    """

    motors: LinkMotors
    mechanics: SeparateMechanics
    motion: VectorHistory
    integral: np.ndarray
    """Forces on the coordinates. (d,)"""
    limit: float = field(init=False, default=0.0)
    """Of the current of each motor. [A]"""

    def __post_init__(self) -> None:
        """Compute what does not change."""
        self.limit = self.motors.current_limit

    def act(self, time: float, pose: np.ndarray, rates: np.ndarray, period: float) -> np.ndarray:
        """Currents of the motors from the measurements of a time; they act for a period from the next sample on. (n,) [A]"""
        control = self.motors.drive.control
        pole = 2.0 * math.pi * given(control.speed_bandwidth, SPEED_BANDWIDTH)
        gain = 2.0 * math.pi * given(control.link_bandwidth, LINK_BANDWIDTH)
        load = self.mechanics.load
        goal, twist = pose_twist(load, self.motion, time)
        # In the middle of the sample in which the currents act.
        before, after = around(self.motion, min(time + 1.5 * period, float(self.motion.time[-1])))
        change = (pose_twist(load, self.motion, after)[1] - pose_twist(load, self.motion, before)[1]) / (after - before)
        off = goal - pose
        if isinstance(load, PlatformLoad):
            off = np.concatenate([off[:3], rotation_between(pose[3:], goal[3:])])
        wanted = twist + gain * off
        place = self.mechanics.at(pose[None], rates[None])
        link: Linkage = place.kinematics
        inertia, jacobian = place.inertia[0], link.jacobian[0]
        grown = self.integral + pole * pole * period * (inertia @ (wanted - rates))
        forces = inertia @ (change + 2.0 * pole * (wanted - rates)) + place.bias[0] + grown
        share = np.clip(jacobian @ wanted / self.motors.stick_speed, -1.0, 1.0)
        on_links = np.linalg.lstsq(jacobian.T, forces, rcond=None)[0] + sum(self.motors.frictions) * share
        currents = on_links / self.motors.gain
        if np.all(np.abs(currents) <= self.limit):
            self.integral = grown
        return np.clip(currents, -self.limit, self.limit)
