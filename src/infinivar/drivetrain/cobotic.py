"""The cobotic drive-train: a cylinder at constant speed, a steered wheel, a link on its guideway."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from infinivar._xp import Array, finite_floats, namespace
from infinivar.contact import spin
from infinivar.drivetrain.control import CoboticControl
from infinivar.drivetrain.drive import DrivePoint, electrical_side
from infinivar.errors import require
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.bearing import Bearing
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.linear import Guideway
from infinivar.parts.motor import Motor
from infinivar.quantities import check, component, quantity
from infinivar.transmission.rotary_linear import RotaryLinearIVT


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeringPlant:
    """What turns the wheel. In steady operation it stands still and takes no power; simulation in time needs it.

    Source: faulring2006, Fig 11.
    """

    motor: Motor = component("Steering motor")
    ratio: float = quantity("1", "> 0", "Reduction between steering motor and bell")
    bell_inertia: float = quantity("kg m^2", "> 0", "Inertia of the bell that holds the wheel, about its steering axis")
    sliding_friction: float = quantity("1", "> 0", "Sliding friction mu_s of the patch that turns on the spot")
    patch_half_length: float | None = quantity(
        "m",
        "> 0",
        "Lateral half-length b of the contact patch, where no geometry of the contact gives it",
        default=None,
    )
    bell_bearing: Bearing | None = component("Bearing of the bell, which carries the preload", default=None)
    bell_friction: float | None = quantity(
        "m",
        ">= 0",
        "Measured friction torque of the bell bearing over preload, c_b, instead of bell_bearing",
        default=None,
    )

    def __post_init__(self) -> None:
        """Refuse what is not physical."""
        check(self)
        if self.bell_bearing is not None:
            bearing = self.bell_bearing.type
            wanted = "deep_groove, angular_contact or thrust_ball, which carry the preload along the bell's axis"
            require(bearing not in ("cylindrical", "needle"), "bell_bearing.type", bearing, wanted)
        if self.bell_bearing is None and self.bell_friction is None:
            raise ValueError("bell_friction is missing: give it, or bell_bearing, from which it follows")
        if self.bell_bearing is not None and self.bell_friction is not None:
            raise ValueError("bell_friction and bell_bearing exclude each other: it would follow from bell_bearing")

    def friction_torques(self, transmission: RotaryLinearIVT) -> dict[str, Array]:
        """What holds the bell against slow steering: the patch that turns on the spot, and the bell bearing.

        Parameters
        ----------
        transmission : RotaryLinearIVT   Gives preload and patch: an ellipse from its geometry, else a uniform line.

        Returns
        -------
        dict   "patch" and "bell", sizes of torques that oppose steering. [N m]

        Source: faulring2006, section V-B; `infinivar.contact.spin`.
        """
        preload = transmission.preload
        if transmission.contact is not None:
            patch = transmission.contact.patch
            turning = spin.ellipse_moment(preload, patch.a, patch.b, self.sliding_friction)
        else:
            turning = spin.line_moment(preload, self.patch_half_length, self.sliding_friction)
        given = (self.bell_friction or 0.0) * preload
        bell = given if self.bell_bearing is None else self.bell_bearing.starting_moment(0.0, preload)
        return {"patch": turning, "bell": bell}


@dataclass(frozen=True, slots=True, kw_only=True)
class CoboticDrive:
    """Motor and gearhead turn a cylinder at constant speed; a steered wheel takes off what the link needs.

    Source: faulring2006, Figs 10-13.
    """

    motor: Motor = component("Cylinder motor")
    gearhead: Gearhead = component("Gearhead between motor and cylinder")
    transmission: RotaryLinearIVT = component("The rotational-to-linear element")
    cylinder_speed: float = quantity("rad/s", "!= 0", "Speed at which the cylinder is kept")
    guideway: Guideway = component("Guideway of the link", default_factory=Guideway)
    amplifier: Amplifier = component("Amplifier of the cylinder motor", default_factory=Amplifier)
    cylinder_inertia: float | None = quantity(
        "kg m^2", "> 0", "Inertia of the cylinder about its axis; simulation in time needs it", default=None
    )
    link_mass: float | None = quantity("kg", "> 0", "Mass of the moving link without load", default=None)
    steering: SteeringPlant | None = component("Steering plant", default=None)
    control: CoboticControl = component("Controllers, for simulation in time", default_factory=CoboticControl)

    def __post_init__(self) -> None:
        """Refuse what is not physical."""
        check(self)
        if self.steering is None:
            return
        given, derived = self.steering.patch_half_length is not None, self.transmission.geometry is not None
        if given and derived:
            raise ValueError("steering.patch_half_length and transmission.geometry exclude each other")
        if not given and not derived:
            raise ValueError("steering.patch_half_length is missing: give it, or transmission.geometry")

    @property
    def motors(self) -> Mapping[str, Motor]:
        """Cylinder motor and, where described, steering motor."""
        steering = {} if self.steering is None else {"steering": self.steering.motor}
        return {"cylinder": self.motor, **steering}

    @property
    def steering_amplifier(self) -> Amplifier:
        """Of the kind of the cylinder motor's; what a drive draws on standby is counted there."""
        return replace(self.amplifier, standby_power=0.0)

    def operate(self, *, speed: Array, force: Array) -> DrivePoint:
        """Steady point at a link speed and force, in all four quadrants, with the wheel steered accordingly.

        Parameters
        ----------
        speed : (...,) float   Link speed. Standing still under load needs a small steering angle. [m s^-1]
        force : (...,) float   Force applied by the drive to the load. [N]

        Returns
        -------
        DrivePoint   Inputs broadcast. Where the wheel would slip there is no steady motion and all powers are nan.

        Source: faulring2006, section VI-B and Figs 10, 12, 13.
        """
        xp = namespace(self, speed, force)
        speed, force = finite_floats(xp, speed=speed, force=force)
        drag, guide_loss = self.guideway.operate(speed=speed, preload=self.transmission.preload)
        element = self.transmission.deliver(
            cylinder_speed=self.cylinder_speed, link_speed=speed, link_force=force + drag
        )
        power_in, losses, utilisation, states = electrical_side(
            self.amplifier,
            self.motor,
            self.gearhead,
            output_torque=element.torque,
            output_speed=xp.asarray(self.cylinder_speed, dtype=xp.float64),
        )
        return DrivePoint(
            power_in=power_in,
            power_out=force * speed,
            losses={**losses, **element.losses, "guideway": guide_loss},
            utilisation={**element.utilisation, **utilisation},
            states={**states, "steering_tangent": element.steering_tangent, "cylinder_torque_Nm": element.torque},
        )
