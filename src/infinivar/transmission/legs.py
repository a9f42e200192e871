r"""Legs on a common cylinder: n wheels, each with a link of its own, coupled by the cylinder alone.

A machine's kinematics give the link speeds ``ldot = J xi``, and the forces f of the links exert the wrench W that the machine
applies to its load: ``J^T f = W``. Each wheel is a `RotaryLinearIVT` with a steering angle of its own, and the torques on the
cylinder add up, so that

.. math:: \omega \sum_i \tau_i - W \cdot \xi = \sum_i \mathrm{loss}_i \ge 0.

A positive torque goes from the cylinder plant into the legs; ``W xi`` is the power to the load.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from infinivar._core.array_namespace import Array, check_broadcast
from infinivar._core.arrays import real_array
from infinivar._core.fields import check, check_instance, component, quantities_of, value_at
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.parts.linear import Guideway
from infinivar.power import PowerPoint
from infinivar.transmission.configuration import Configuration, over_links, solved
from infinivar.transmission.mechanism import Mechanism
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rotary_linear import RotaryLinearIVT


@result
class LegsPoint(PowerPoint, Result):
    """Where the legs stand: arrays over (..., n) legs or (..., d) components of the twist, SI.

    Where a wheel would slip, twist, torque and powers are nan and the limit is SLIP.
    """

    contact: ClassVar[str] = "leg"
    """What touches."""
    cylinder_speed: Array
    """omega. [rad s^-1]"""
    torque: Array
    """Of the cylinder plant on all legs. [N m]"""
    twist: Array
    """xi. (..., d)"""
    wrench: Array
    """W, which the machine applies to its load. (..., d)"""
    link_speed: Array
    """(..., n) [m s^-1]"""
    link_force: Array
    """Of each link on the machine. (..., n) [N]"""
    steering_tangent: Array
    """(..., n) [-]"""
    leg_torque: Array
    """(..., n) [N m]"""
    leg_losses: Mapping[str, Array]
    """By name. (..., n) [W]"""
    slip_demand: Array
    """1 is the slip limit. (..., n) [-]"""
    utilisation: Mapping[Limit, Array]
    """Of the worst leg, and of the kinematics. [-]"""

    @property
    def contact_losses(self) -> Mapping[str, Array]:
        """As `leg_losses`."""
        return self.leg_losses

    @property
    def losses(self) -> Mapping[str, Array]:
        """Losses of all legs by name. [W]"""
        return {name: over_links(np.add, loss) for name, loss in self.leg_losses.items()}

    @property
    def loss_of_legs(self) -> Array:
        """Loss of each leg. (..., n) [W]"""
        return sum(self.leg_losses.values())

    @property
    def power_in(self) -> Array:
        """Power from the cylinder. [W]"""
        return self.torque * self.cylinder_speed

    @property
    def power_out(self) -> Array:
        """Power to the load, ``W xi``. [W]"""
        return over_links(np.add, self.wrench * self.twist) + 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Legs:
    """Wheels of one kind on a common cylinder, with a link each.

    Raises
    ------
    ParameterError
        If the number of legs is not 1 or more.
    """

    transmission: RotaryLinearIVT = component("Wheel of each leg; any value may be an array over the legs")
    count: int = component("Number of legs n")
    guideway: Guideway = component("Guideway of each link", default_factory=Guideway)
    pressed: Mapping[Limit, Array] = field(init=False, repr=False, compare=False, default_factory=dict)
    """Demand over allowance for the limits that the preload alone can exceed, of the worst wheel. [-]"""

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        whole = isinstance(self.count, int) and not isinstance(self.count, bool) and self.count >= 1
        require(whole, "count", repr(self.count), "a whole number of legs, 1 or more")
        require(
            self.transmission.wheels == 1, "transmission.wheels", self.transmission.wheels, "1 in a machine of legs"
        )
        require(
            np.ndim(self.transmission.cylinder_radius) == 0,
            "transmission.cylinder_radius",
            "an array",
            "one number: the legs share the cylinder",
        )
        for name in quantities_of(self.transmission):
            shape = np.shape(value_at(self.transmission, name))
            fits = shape in ((), (1,), (self.count,))
            require(fits, f"transmission.{name}", f"shape {shape}", f"one number, or one for each of {self.count} legs")
        pressed = {limit: float(np.max(demand)) for limit, demand in self.transmission.utilisation.items()}
        object.__setattr__(self, "pressed", FrozenDict(pressed))

    def operate(
        self, configuration: Configuration, *, cylinder_speed: Array, wrench: Array, twist: Array | None = None
    ) -> LegsPoint:
        """Steady operation at poses, in all quadrants of every leg.

        Parameters
        ----------
        configuration : Configuration    Of as many links as there are legs.
        cylinder_speed : (...,) float    omega. [rad s^-1]
        wrench : (..., d) float          W, which the machine applies to its load.
        twist : (..., d) float           xi; the steering angles follow. None: all wheels locked at steering angle 0, where
            the machine yields to its load; this requires as many links as components of the twist.

        Returns
        -------
        LegsPoint   Inputs broadcast.

        Raises
        ------
        ParameterError
            If the numbers of links or components do not fit.

        Source: faulring2006, section VI; principle of virtual power.
        """
        self.check_links(configuration)
        wrench = configuration.vector(wrench, "wrench")
        with np.errstate(invalid="ignore", over="ignore"):
            force = configuration.link_forces(wrench)
            locked = twist is None
            omega = real_array("cylinder_speed", cylinder_speed)[..., None]
            require(bool(np.all(np.isfinite(omega))), "cylinder_speed", "nan or inf", "finite", "rad/s")
            points = {"configuration": configuration.jacobian.shape[:-2], "cylinder_speed": omega.shape[:-1]}
            points["wrench"] = wrench.shape[:-1]
            if not locked:
                points["twist"] = configuration.vector(twist, "twist").shape[:-1]
            check_broadcast(**points)
            if locked:
                wheels, drag_loss, force = self._locked(configuration, omega, force)
                xi = configuration.twist_of(wheels.link_speed)
            else:
                xi = configuration.vector(twist, "twist")
                wheels, drag_loss = self._moving(omega, configuration.link_speeds(xi), force)
            return self._point(configuration, wheels, drag_loss, wrench, xi, force)

    def check_links(self, configuration: Configuration) -> None:
        """Raise ParameterError unless it is a `Configuration` with as many links as there are legs."""
        check_instance("configuration", configuration, Configuration)
        n = configuration.links
        require(n == self.count, "configuration", f"{n} links", f"of {self.count}, as many as there are legs")

    def _moving(self, omega: np.ndarray, speed: np.ndarray, force: np.ndarray) -> tuple[OperatingPoint, np.ndarray]:
        drag, loss = self.guideway.operate(force=force, speed=speed, preload=self.transmission.preload)
        return self.transmission.deliver(cylinder_speed=omega, link_speed=speed, link_force=force + drag), loss

    def _locked(
        self, configuration: Configuration, omega: np.ndarray, force: np.ndarray
    ) -> tuple[OperatingPoint, np.ndarray, np.ndarray]:
        """Wheels at steering angle 0: each link yields to its load, held by what its guideway can hold."""
        if configuration.links != configuration.freedoms:
            configuration.twist_of(force)
        # The link moves against the force that it exerts, unless its guideway holds that.
        drag, _ = self.guideway.operate(force=force, speed=0.0 * force, preload=self.transmission.preload)
        wheels = self.transmission.operate(cylinder_speed=omega, steering_angle=0.0, link_force=force + drag)
        return wheels, drag * wheels.link_speed, force

    def _point(
        self,
        configuration: Configuration,
        wheels: OperatingPoint,
        drag_loss: np.ndarray,
        wrench: np.ndarray,
        twist: np.ndarray,
        force: np.ndarray,
    ) -> LegsPoint:
        slip = wheels.utilisation[Limit.SLIP]
        shape = np.broadcast_shapes(np.shape(slip), force.shape)
        utilisation = {limit: _worst(demand, shape) for limit, demand in wheels.utilisation.items()}
        for limit, demand in self.pressed.items():
            utilisation[limit] = np.broadcast_to(demand, shape[:-1])
        for limit, demand in configuration.utilisation.items():
            utilisation[limit] = np.broadcast_to(demand, shape[:-1])
        torque = over_links(np.add, np.broadcast_to(wheels.torque, shape))
        losses = {**wheels.losses, "guideway": drag_loss}
        return LegsPoint(
            cylinder_speed=np.broadcast_to(wheels.cylinder_speed[..., 0], shape[:-1]),
            torque=torque,
            twist=twist + 0.0 * torque[..., None],
            wrench=np.broadcast_to(wrench, (*shape[:-1], configuration.freedoms)),
            link_speed=np.broadcast_to(wheels.link_speed, shape),
            link_force=np.broadcast_to(force, shape),
            steering_tangent=np.broadcast_to(wheels.steering_tangent, shape),
            leg_torque=np.broadcast_to(wheels.torque, shape),
            leg_losses={name: np.broadcast_to(loss, shape) for name, loss in losses.items()},
            slip_demand=np.broadcast_to(slip, shape),
            utilisation=utilisation,
        )

    def mechanism(self, configuration: Configuration) -> Mechanism:
        """The same machine, without guideways, as a kinematic map over its contacts.

        Returns
        -------
        Mechanism   With coordinates "xi1" to "xi<d>" and "cylinder". The forces that it applies along the first are the wrench W;
            about the last it takes up the torque of the cylinder plant, so that it applies the opposite there.

        Raises
        ------
        ParameterError
            If the creep law has a flow loss, or values of the wheel are arrays over the legs.
        """
        self.check_links(configuration)
        if np.ndim(self.transmission.slip_force) or np.ndim(self.transmission.wheel_radius):
            raise ParameterError(
                "transmission must be one wheel for all legs, got values that are arrays over the legs"
            )
        jacobian, radius = configuration.jacobian, self.transmission.cylinder_radius
        n, d = configuration.links, configuration.freedoms
        carriers = np.zeros((*jacobian.shape[:-2], n, 2, d + 1))
        carriers[..., 0, :d] = jacobian
        carriers[..., 1, d] = -radius
        surface = np.zeros((n, d + 1))
        surface[:, d] = radius
        names = (*(f"xi{place + 1}" for place in range(d)), "cylinder")
        return Mechanism(contacts=self.transmission.wheel, jacobian=carriers, surface=surface, coordinates=names)

    def force_limits(self, link_speed: Array, cylinder_speed: Array) -> np.ndarray:
        r"""Largest force of each link before its wheel slips, without rolling resistance and creep.

        .. math:: |f| \le \mu P \cos\phi, \qquad |\tan\phi| = |\dot l|/(R |\omega|)

        Parameters
        ----------
        link_speed : (..., n) float      [m s^-1]
        cylinder_speed : (...,) float    Not 0 where a link moves. [rad s^-1]

        Returns
        -------
        (..., n) float   [N]; the inverse of `least_surface_speed`.
        """
        speed, omega = real_array("link_speed", link_speed), real_array("cylinder_speed", cylinder_speed)[..., None]
        surface = self.transmission.cylinder_radius * np.abs(omega)
        at = self.transmission.groups(omega)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.where(speed == 0, 0.0, speed / surface)
        return at.slip_force / np.sqrt(1.0 + slope * slope)


def _worst(demand: Array, shape: tuple[int, ...]) -> np.ndarray:
    """Of all legs; a nan, where a wheel slips, stays one."""
    return over_links(np.maximum, np.broadcast_to(demand, shape))


def creep_drift(jacobian: Array, wrench: Array, surface_speed: Array, creep_stiffness: Array) -> np.ndarray:
    r"""Twist at which a locked machine yields to its load while its cylinder turns, for small creep.

    .. math:: \xi = -\frac{R|\omega|}{C} (J^T J)^{-1} W

    Parameters
    ----------
    jacobian : (..., n, d) float       J.
    wrench : (..., d) float            W, which the machine applies to its load.
    surface_speed : (...,) float       R omega. [m s^-1]
    creep_stiffness : (...,) float     C, one for all legs. [N]

    Returns
    -------
    (..., d) float   Against the wrench, in the sense of ``W xi <= 0``.

    Source: linear creep law with ``J^T f = W``; exact for the linear law with as many legs as components.
    """
    found = Configuration(jacobian=jacobian)
    ease = np.abs(np.asarray(surface_speed, dtype=float)) / creep_stiffness
    return -ease[..., None] * solved(found.squared(), found.vector(wrench, "wrench"))


def least_creep_speed(link_speed: Array) -> np.ndarray:
    """Surface speed of the smallest creep loss of a leg at a link speed, ``sqrt(2) |ldot|``: a steering angle of 35.26 degrees.

    There the loss is the share ``(3 sqrt(3)/2) f/C`` of the power that the leg delivers.

    Parameters
    ----------
    link_speed : (...,) float   [m s^-1]

    Returns
    -------
    (...,) float   [m s^-1]

    Source: the minimum of `creep_loss` over the surface speed.
    """
    return math.sqrt(2.0) * np.abs(link_speed)


def least_surface_speed(link_speed: Array, link_force: Array, slip_force: Array) -> np.ndarray:
    r"""Surface speed below which the wheel of a leg slips, without rolling resistance and creep.

    .. math:: S \ge |\dot l| / \sqrt{(\mu P/f)^2 - 1}

    Parameters
    ----------
    link_speed : (...,) float              [m s^-1]
    link_force, slip_force : (...,) float  f, mu P. [N]

    Returns
    -------
    (...,) float   inf where the force exceeds the slip force. [m s^-1]

    Source: ``|f| <= mu P cos(phi)``.
    """
    ratio = np.abs(link_force) / slip_force
    room = 1.0 - ratio * ratio
    slope = ratio / np.sqrt(np.where(room > 0, room, 1.0))
    return np.where(room > 0, np.abs(link_speed) * slope, np.inf)


def reflected_mass(mass: Array, inertia: Array, cylinder_radius: Array, steering_tangent: Array) -> np.ndarray:
    """Mass that a user feels at the link of one ideal leg whose cylinder turns freely: ``m + J/(R t)^2``.

    Parameters
    ----------
    mass : (...,) float               m, of link and load. [kg]
    inertia : (...,) float            J, of the cylinder. [kg m^2]
    cylinder_radius : (...,) float    R. [m]
    steering_tangent : (...,) float   t = tan(phi), constant. [-]

    Returns
    -------
    (...,) float   inf where the link is locked. [kg]

    Source: energy ``(J + m R^2 t^2) omega^2/2`` with ``ldot = -R omega t``.
    """
    lever = np.square(np.asarray(cylinder_radius, dtype=float) * steering_tangent)
    return mass + np.where(lever > 0, inertia / np.where(lever > 0, lever, 1.0), np.inf)
