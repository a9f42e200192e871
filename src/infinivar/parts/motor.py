"""Brushed or electronically commutated DC motor from its data sheet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import check, component, quantity
from infinivar.contact.friction import coulomb
from infinivar.errors import require
from infinivar.limits import Limit
from infinivar.units import plain

SCALED = {
    "resistance": -1,
    "no_load_current": 1,
    "viscous_friction": 1,
    "continuous_torque": 1,
    "peak_torque": 1,
    "demagnetisation_current": 1,
    "inductance": -1,
    "rotor_inertia": 1,
    "mass": 1,
    "price": 1,
    "length": 1,
    "winding_to_housing": -1,
    "housing_to_ambient": -1,
}
"""Values of a motor that change with the number of them on one shaft, and whether they multiply by it or divide."""


def multiple(values: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """Values of `factor` motors on one shaft from those of one, which are numbers, arrays or None, by name; others stay."""
    found = dict(values)
    for name, power in SCALED.items():
        if found.get(name) is not None:
            found[name] = found[name] * factor if power > 0 else found[name] / factor
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorPoint:
    """Electrical state of a motor at a torque and speed; arrays that broadcast to one shape, SI."""

    current: Array
    voltage: Array
    power: Array
    losses: Mapping[str, Array]
    utilisation: Mapping[Limit, Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class Motor:
    """DC motor: ``V = I R + K w``, with a friction torque equal to K times the no-load current at no-load speed.

    With `viscous_friction`, part of that torque grows with speed: ``K I0 = T + c w0`` at the no-load speed w0. It stands for
    iron loss, mainly eddy currents, in an electronically commutated motor. Without it the friction torque is constant.

    Optional fields may be None: a steady map needs no thermal or inertial data.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    ALLOWANCES: ClassVar[Mapping[Limit, str]] = {
        Limit.THERMAL: "continuous_torque",
        Limit.VOLTAGE: "voltage",
        Limit.PEAK: "peak_torque",
        Limit.DEMAGNETISATION: "demagnetisation_current",
        Limit.SPEED: "max_speed",
    }
    """Field that states what each limit of `utilisation` allows."""

    name: str = component("Name for reports", default="motor")
    voltage: float = quantity("V", Gt(0), "Supply voltage available to the motor")
    resistance: float = quantity("ohm", Gt(0), "Terminal resistance with the winding at data-sheet temperature")
    torque_constant: float = quantity("N m/A", Gt(0), "Torque constant K, also the back-emf constant in V s/rad")
    no_load_current: float = quantity("A", Ge(0), "No-load current; the friction torque is K times this current")
    viscous_friction: float | None = quantity(
        "N m s", Ge(0), "Part of the no-load torque that grows with speed, per speed: iron loss", default=None
    )
    continuous_torque: float = quantity("N m", Gt(0), "Continuous torque at the shaft")
    peak_torque: float | None = quantity(
        "N m",
        Gt(0),
        "Peak torque at the shaft; without it only the voltage limits the torque",
        default=None,
    )
    demagnetisation_current: float | None = quantity(
        "A", Gt(0), "Current above which the magnets lose magnetisation for good", default=None
    )
    inductance: float | None = quantity("H", Gt(0), "Terminal inductance", default=None)
    rotor_inertia: float | None = quantity("kg m^2", Gt(0), "Rotor inertia", default=None)
    max_speed: float | None = quantity("rad/s", Gt(0), "Permissible speed", default=None)
    mass: float | None = quantity("kg", Gt(0), "Mass", default=None)
    diameter: float | None = quantity("m", Gt(0), "Outer diameter", default=None)
    length: float | None = quantity("m", Gt(0), "Length without the shaft", default=None)
    price: float | None = quantity("1", Ge(0), "Price, in one currency for all parts", default=None)
    winding_to_housing: float | None = quantity("K/W", Gt(0), "Thermal resistance winding to housing", default=None)
    housing_to_ambient: float | None = quantity("K/W", Gt(0), "Thermal resistance housing to ambient", default=None)
    winding_time_constant: float | None = quantity("s", Gt(0), "Thermal time constant of the winding", default=None)
    housing_time_constant: float | None = quantity("s", Gt(0), "Thermal time constant of the motor", default=None)
    max_winding_temperature: float | None = quantity("K", Gt(0), "Permissible winding temperature", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        known = all(isinstance(value, (int, float)) for value in (self.no_load_current, self.voltage, self.resistance))
        if known:
            stall = self.voltage / self.resistance
            require(
                self.no_load_current < stall,
                "no_load_current",
                self.no_load_current,
                f"< {plain(stall, 3)} (stall)",
                "A",
            )
        if known and isinstance(self.viscous_friction, (int, float)):
            most = self.torque_constant * self.no_load_current / self.no_load_speed
            require(
                self.viscous_friction <= most * (1.0 + 1e-12),
                "viscous_friction",
                self.viscous_friction,
                f"<= {plain(most, 3)} N m s, which is all of the no-load torque at no-load speed",
            )

    @property
    def no_load_torque(self) -> float:
        """Friction torque at the no-load speed, from the no-load current. [N m]"""
        return self.torque_constant * self.no_load_current

    @property
    def friction_torque(self) -> float:
        """Friction torque independent of speed: of the no-load torque, what does not grow with speed. [N m]

        Source: data sheets, maxon2020; with a part that grows with speed, faulhaber2020.
        """
        if self.viscous_friction is None:
            return self.no_load_torque
        rest = self.no_load_torque - self.viscous_friction * self.no_load_speed
        # Where all of it grows with speed, rounding must not leave a negative rest.
        return max(rest, 0.0) if isinstance(rest, float) else rest

    @property
    def continuous_current(self) -> float:
        """Current at the continuous torque; it heats the winding to its temperature limit. [A]"""
        return self.continuous_torque / self.torque_constant + self.no_load_current

    @property
    def no_load_speed(self) -> float:
        """Speed at the supply voltage without load. [rad s^-1]"""
        return (self.voltage - self.resistance * self.no_load_current) / self.torque_constant

    @property
    def peak_efficiency(self) -> float:
        """Peak efficiency at the supply voltage, ``(1 + c R/K^2) (1 - sqrt(I0/Istall))^2``. [-]"""
        peak = (1.0 - (self.no_load_current * self.resistance / self.voltage) ** 0.5) ** 2
        if self.viscous_friction is None:
            return peak
        return peak * (1.0 + self.viscous_friction * self.resistance / self.torque_constant**2)

    def scaled(self, factor: float) -> Motor:
        """`factor` such motors on one shaft: torque, currents, inertia and mass scale; speed and voltage do not; see `multiple`.

        They share torque and current equally, each with an amplifier of its own, or all in parallel on one: to the supply and to
        the shaft both are the same. They lie in line: one behind the other, with the diameter of one. No other scaling preserves
        efficiency, speed and voltage. A fraction of a motor has no diameter and no length.
        """
        values = multiple({name: getattr(self, name) for name in SCALED}, factor)
        sizes = {} if float(factor).is_integer() else {"diameter": None, "length": None}
        return replace(self, name=f"{factor:g} x {self.name}", **{**values, **sizes})

    def with_resistance(self, resistance: float) -> Motor:
        """The motor with another winding resistance [ohm] and the same friction: the no-load current follows the speed."""
        if self.viscous_friction is None:
            return replace(self, resistance=resistance)
        constant, drag = self.torque_constant, self.viscous_friction
        idle = (self.friction_torque + drag * self.voltage / constant) / (constant + drag * resistance / constant)
        return replace(self, resistance=resistance, no_load_current=idle)

    def specimen(self, *, torque_constant: Array, resistance: Array) -> Motor:
        """A motor of this type whose constants differ from the data sheet's, as those of every single motor do.

        - Its friction torque is that of the type; the no-load current follows from it.
        - Its winding may be heated as much as the type's, so the continuous current goes with ``1/sqrt(R)``; the continuous
          torque follows from that current. A weak motor thus has less continuous torque, not more current.
        - Its peak current is that of the type, as magnets and brushes limit it.

        Parameters
        ----------
        torque_constant : (...,) float   > 0. [N m/A]
        resistance : (...,) float        > 0. [ohm]

        Returns
        -------
        Motor   Values that follow broadcast; equal to the type itself at its own constants.

        Source: winding loss I^2 R and the definitions of data sheets, maxon2020; iron loss as in faulhaber2020.
        """
        drag = 0.0 if self.viscous_friction is None else self.viscous_friction
        idle = (self.friction_torque + drag * self.voltage / torque_constant) / (
            torque_constant + drag * resistance / torque_constant
        )
        lasting = self.continuous_current * (self.resistance / resistance) ** 0.5
        peak = self.peak_torque
        if peak is not None:
            peak = torque_constant * (peak / self.torque_constant + self.no_load_current - idle)
        return replace(
            self,
            torque_constant=torque_constant,
            resistance=resistance,
            no_load_current=idle,
            continuous_torque=torque_constant * (lasting - idle),
            peak_torque=peak,
        )

    def without_friction(self) -> Motor:
        """The motor without friction, with the same current limits."""

        def more(torque: float | None) -> float | None:
            return None if torque is None else torque + self.no_load_torque

        return replace(
            self,
            no_load_current=0.0,
            viscous_friction=None,
            continuous_torque=self.continuous_torque + self.no_load_torque,
            peak_torque=more(self.peak_torque),
        )

    def operate(self, *, torque: Array, speed: Array) -> MotorPoint:
        """Steady electrical state at the shaft torque and speed, in all four quadrants.

        Parameters
        ----------
        torque : (...,) float   Shaft torque that the motor applies to its load. [N m]
        speed : (...,) float    Shaft speed; at exactly 0 friction helps to hold. [rad s^-1]

        Returns
        -------
        MotorPoint
            current [A], voltage [V], electrical power [W] (negative where the motor generates), losses "winding",
            "motor friction" and, with `viscous_friction`, "motor iron" [W], utilisation of the thermal and voltage limits,
            and of peak torque, demagnetisation and speed if known.

        Source: faulring2006, Fig 12 and Fig 14 (gyrator and resistance); friction and continuous torque: data sheets,
        maxon2020.
        """
        xp = namespace(self, torque, speed)
        constant = self.torque_constant
        braked, iron = torque + coulomb(speed, self.friction_torque, held=torque), {}
        if self.viscous_friction is not None:
            drag = self.viscous_friction * speed
            braked, iron = braked + drag, {"motor iron": drag * speed}
        current = braked / constant
        voltage = current * self.resistance + constant * speed
        return MotorPoint(
            current=current,
            voltage=voltage,
            power=voltage * current,
            losses={
                "winding": current * current * self.resistance,
                "motor friction": self.friction_torque * xp.abs(speed),
                **iron,
            },
            utilisation=self.utilisation(current=current, voltage=voltage, speed=speed),
        )

    def utilisation(self, *, current: Array, voltage: Array, speed: Array) -> dict[Limit, Array]:
        """Demand over allowance for continuous torque, supply voltage and, if known, peak torque, demagnetisation and speed.

        Parameters
        ----------
        current, voltage, speed : (...,) float   Terminal current and voltage, shaft speed. [A], [V], [rad s^-1]

        Returns
        -------
        dict of Limit to (...,) float   1 is at the limit. [-]

        Source: data sheets, maxon2020.
        """
        xp = namespace(self, current, voltage, speed)
        demand = {
            Limit.THERMAL: xp.abs(current) / self.continuous_current,
            Limit.VOLTAGE: xp.abs(voltage) / self.voltage,
        }
        if self.peak_torque is not None:
            demand[Limit.PEAK] = xp.abs(current) / (self.peak_torque / self.torque_constant + self.no_load_current)
        if self.demagnetisation_current is not None:
            demand[Limit.DEMAGNETISATION] = xp.abs(current) / self.demagnetisation_current
        if self.max_speed is not None:
            demand[Limit.SPEED] = xp.abs(speed) / self.max_speed
        return demand

    def extreme_utilisation(
        self, *, current: Array, lasting: Array, voltage: Array, speed: Array
    ) -> dict[Limit, Array]:
        """Largest demands over a motion, as `utilisation`: that for speed first, that for voltage last.

        Parameters
        ----------
        current, voltage, speed : (...,) float   Largest sizes. [A], [V], [rad s^-1]
        lasting : (...,) float                   Current whose limit applies to its root mean square. [A]
        """
        found = self.utilisation(current=current, voltage=voltage, speed=speed)
        found |= {Limit.THERMAL: self.utilisation(current=lasting, voltage=0.0, speed=0.0)[Limit.THERMAL]}
        order = (Limit.SPEED, Limit.THERMAL, Limit.PEAK, Limit.DEMAGNETISATION, Limit.VOLTAGE)
        return {limit: found[limit] for limit in order if limit in found}
