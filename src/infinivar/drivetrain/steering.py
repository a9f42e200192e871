"""The steering plant of a cobotic drive: motor, gear and bell that turn the wheel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check, component, given, quantity
from infinivar.contact import spin
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.drive import MotorSide, needed
from infinivar.errors import ParameterError, require
from infinivar.parts.bearing import Bearing
from infinivar.parts.motor import Motor
from infinivar.transmission.rotary_linear import RotaryLinearIVT


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeringPlant:
    """Steering motor, gear and bell that turn the wheel. Idle in steady operation; required for time-varying motion.

    Source: faulring2006, Fig 11.
    """

    motor: Motor = component("Steering motor")
    ratio: float = quantity("1", Gt(0), "Reduction between steering motor and bell")
    bell_inertia: float | None = quantity(
        "kg m^2",
        Gt(0),
        "Inertia of the bell that carries a wheel, about the steering axis; by default derived from the wheel's geometry",
        default=None,
    )
    sliding_friction: float = quantity("1", Gt(0), "Sliding friction mu_s of the contact patch as it turns on the spot")
    patch_half_length: float | None = quantity(
        "m",
        Gt(0),
        "Lateral half-length b of the contact patch, if the contact geometry is not given",
        default=None,
    )
    bell_bearing: Bearing | None = component("Bearing of the bell, which carries the preload", default=None)
    bell_friction: float | None = quantity(
        "m",
        Ge(0),
        "Measured friction torque of the bell bearing over preload, c_b; replaces bell_bearing",
        default=None,
    )

    derived_inertia: Array | None = field(default=None, repr=False, compare=False)
    """Of one bell, where it is not stated; set by the drive, which knows the wheel."""
    bells: int = field(default=1, repr=False, compare=False)
    """Equal bells that the motor turns; set by the drive, which knows the number of wheels."""

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if self.bell_bearing is not None:
            bearing = self.bell_bearing.type
            allowed = "deep_groove, angular_contact or thrust_ball, which carry the preload along the bell's axis"
            require(bearing not in ("cylindrical", "needle"), "bell_bearing.type", bearing, allowed)
        if self.bell_bearing is None and self.bell_friction is None:
            raise ParameterError("bell_friction is missing: give it, or bell_bearing, which determines it")
        if self.bell_bearing is not None and self.bell_friction is not None:
            raise ParameterError(
                "bell_friction and bell_bearing exclude each other: bell_bearing determines bell_friction"
            )

    @property
    def inertia_of_bell(self) -> Array:
        """Inertia of all bells with their wheels about the steering axes: as stated for one, else derived. [kg m^2]

        Raises
        ------
        ParameterError
            If it is not known.

        Source: `infinivar.drivetrain.masses.bell_inertia`.
        """
        return self.bells * needed(given(self.bell_inertia, self.derived_inertia), "steering.bell_inertia")

    def friction_torques(self, transmission: RotaryLinearIVT) -> dict[str, Array]:
        """Friction torques that resist steering on the spot: contact patch and bell bearing, of all wheels.

        Parameters
        ----------
        transmission : RotaryLinearIVT   Provides preload and patch: an ellipse from its geometry, else a uniform line.

        Returns
        -------
        dict   "patch" and "bell", magnitudes of the torques. [N m]

        Raises
        ------
        ParameterError
            If neither the half-length of the patch nor the geometry of the wheel is known.

        Source: faulring2006, section V-B; `infinivar.contact.spin`.
        """
        preload = transmission.preload
        if transmission.contact is not None:
            patch = transmission.contact.patch
            friction = transmission.friction if transmission.turns_with_spin else self.sliding_friction
            turning = spin.ellipse_moment(preload, patch.a, patch.b, friction)
        else:
            if self.patch_half_length is None:
                raise ParameterError("steering.patch_half_length is missing: give it, or the geometry of the wheel")
            turning = spin.line_moment(preload, self.patch_half_length, self.sliding_friction)
        measured = given(self.bell_friction, 0.0) * preload
        bell = measured if self.bell_bearing is None else self.bell_bearing.starting_moment(0.0, preload)
        return {"patch": self.bells * turning, "bell": self.bells * bell}

    def coulomb_torque(self, transmission: RotaryLinearIVT) -> Array:
        """Friction torque at the bell that does not depend on speed: a patch that rolls as it turns has none. [N m]"""
        torques = self.friction_torques(transmission)
        return torques["bell"] if transmission.turns_with_spin else torques["patch"] + torques["bell"]

    def follow(
        self,
        transmission: RotaryLinearIVT,
        *,
        rate: Array,
        acceleration: Array,
        patch_moment: Array | None = None,
        stick_speed: float | None = None,
    ) -> MotorSide:
        """Torque and power of the steering motor for a steering motion; its gear is lossless, as in the paper.

        Parameters
        ----------
        transmission : RotaryLinearIVT       Provides preload and patch.
        rate, acceleration : (...,) float    Of the steering angle. [rad s^-1], [rad s^-2]
        patch_moment : (...,) float          Moment of the rolling patch against steering; by default the friction of one that
            turns on the spot. [N m]
        stick_speed : float                  Of the link, below which friction falls as in a simulation; that of the motor then
            counts as that of the bell. None: not at all. [m s^-1]

        Returns
        -------
        MotorSide   Includes the power stored in the inertia of motor and bell.

        Raises
        ------
        ParameterError
            If the motor's rotor inertia is missing.

        Source: faulring2006, section V-A.1 and Fig 11.
        """
        torques, plant = self.friction_torques(transmission), self
        if stick_speed is not None:
            share = abs(coulomb(rate, 1.0, stick_speed / transmission.wheel_radius))
            bell = torques["bell"] + self.ratio * self.motor.friction_torque
            torques = {"patch": share * torques["patch"], "bell": share * bell}
            plant = replace(self, motor=self.motor.without_friction())
        return plant.turn(torques, rate=rate, acceleration=acceleration, patch_moment=patch_moment)

    def turn(
        self, resisting: Mapping[str, Array], *, rate: Array, acceleration: Array, patch_moment: Array | None = None
    ) -> MotorSide:
        """As `follow`, against known results of `friction_torques`.

        Source: faulring2006, section V-A.1 and Fig 11.
        """
        inertia = self.inertia_of_bell + self.ratio**2 * needed(
            self.motor.rotor_inertia, "steering.motor.rotor_inertia"
        )
        turning = inertia * acceleration
        patch = coulomb(rate, resisting["patch"], held=turning) if patch_moment is None else patch_moment
        bell = coulomb(rate, resisting["bell"], held=turning + patch)
        torque = (patch + bell + turning) / self.ratio
        electric = self.motor.operate(torque=torque, speed=self.ratio * rate)
        losses = {f"steering {name}": loss for name, loss in electric.losses.items()}
        return MotorSide(
            electric.power,
            {**losses, "steering patch": patch * rate, "steering bearing": bell * rate},
            dict(electric.utilisation),
            {
                "steering_current_A": electric.current,
                "steering_voltage_V": electric.voltage,
                "steering_torque_Nm": torque,
            },
            inertia * acceleration * rate,
        )
