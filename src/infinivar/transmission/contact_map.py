"""Kinematic map over rolling contacts, and the forces and losses of all contacts at given rates; see `mechanism`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from annotated_types import Gt

from infinivar._core.array_namespace import Array, as_floats, check_broadcast, named_floats, namespace
from infinivar._core.arrays import shown
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check_value
from infinivar._core.frozen import frozen
from infinivar._core.result import Result, equal, result
from infinivar.errors import ParameterError, nearest, require
from infinivar.limits import Limit
from infinivar.power import PowerPoint
from infinivar.transmission.kinematics import Heading, applied_to, directions
from infinivar.transmission.rolling_contact import ContactForces, RollingContact


@result
class MechanismPoint(PowerPoint, Result):
    """Where a machine stands: arrays over (..., n) coordinates or (..., k) wheels, SI.

    Where no steady motion exists under prescribed forces, rates, forces and losses are nan and the limit is SLIP. Wheels that
    slide at prescribed rates have the forces of gross sliding, and the limit is SLIP.
    """

    contact: ClassVar[str] = "wheel"
    """What touches."""
    coordinates: tuple[str, ...]
    rates: Array
    """qdot. (..., n)"""
    applied: Array
    """Forces Q that the machine applies on its coordinates. (..., n)"""
    cosine: Array
    """Of the headings, as `sine`. (..., k)"""
    sine: Array
    creep_speed: Array
    """u. (..., k) [m s^-1]"""
    rolling_speed: Array
    """v. (..., k) [m s^-1]"""
    lateral_force: Array
    """f_u. (..., k) [N]"""
    moment: Array
    """M, against spin. (..., k) [N m]"""
    steering_rate: Array
    """(..., k) [rad s^-1]"""
    wheel_losses: Mapping[str, Array]
    """By name. (..., k) [W]"""
    slip_demand: Array
    """1 is the slip limit. (..., k) [-]"""
    pressed: Mapping[Limit, Array]
    """Demand over allowance for the limits that preload alone can exceed, of the worst wheel. [-]"""

    @property
    def heading(self) -> Array:
        """Angle from x to the rolling direction of each wheel. (..., k) [rad]"""
        return namespace(self.sine).atan2(self.sine, self.cosine)

    @property
    def power(self) -> Array:
        """Power out of the machine by coordinate, Q qdot. (..., n) [W]"""
        return self.applied * self.rates

    @property
    def steering_power(self) -> Array:
        """Power into the machine by the steering of each wheel, M times the steering rate. (..., k) [W]"""
        return self.moment * self.steering_rate

    @property
    def contact_losses(self) -> Mapping[str, Array]:
        """As `wheel_losses`."""
        return self.wheel_losses

    @property
    def losses(self) -> Mapping[str, Array]:
        """Losses of all wheels by name. [W]"""
        return {name: namespace(loss).sum(loss, axis=-1) for name, loss in self.wheel_losses.items()}

    @property
    def power_in(self) -> Array:
        """Power into the machine, by the coordinates and steerings through which it enters. [W]"""
        return self._directed(1.0)

    @property
    def power_out(self) -> Array:
        """Power out of the machine, by the coordinates and steerings through which it leaves. [W]"""
        return self._directed(-1.0)

    def _directed(self, sign: float) -> Array:
        xp = namespace(self.power)
        powers = [-sign * self.power, sign * self.steering_power]
        # Not clipped, which would hide a nan.
        return sum(xp.sum(xp.where(power < 0, 0.0 * power, power), axis=-1) for power in powers) + 0.0

    @property
    def utilisation(self) -> Mapping[Limit, Array]:  # type: ignore[override]
        """Demand over allowance by limit, of the worst wheel. [-]"""
        return {Limit.SLIP: namespace(self.slip_demand).max(self.slip_demand, axis=-1), **self.pressed}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ContactMap:
    """A machine at one configuration, or at many, without what looks for its motion; fields and errors as of `Mechanism`."""

    contacts: Sequence[RollingContact] | RollingContact
    jacobian: Array
    coordinates: Sequence[str] | None = None
    spin: Array | None = None
    surface: Array | None = None
    kinds: tuple[tuple[RollingContact, tuple[int, ...]], ...] = field(init=False, repr=False, default=())
    """Contacts that differ, with their wheels."""
    rows: Array = field(init=False, repr=False, default=None)
    """Rows of all x, of all y and of all spins: (..., 2 k or 3 k, n)."""
    columns: Array = field(init=False, repr=False, default=None)
    """The same transposed: (..., n, 2 k or 3 k)."""

    def __post_init__(self) -> None:
        """Validate the fields."""
        xp = namespace(self.jacobian, self.spin, self.surface)
        found = {}
        for name in ("jacobian", "spin", "surface"):
            value = getattr(self, name)
            optional = value is None and name != "jacobian"
            found[name] = None if optional else named_floats(xp, **{name: value})[0]
        shape = tuple(found["jacobian"].shape)
        *_, wheels, both, count = (0, 0, 0, *shape)
        require(
            both == 2 and wheels * count > 0, "jacobian", f"shape {shape}", "of shape (..., wheels, 2, coordinates)"
        )
        for name in ("spin", "surface"):
            if found[name] is not None:
                said: tuple[int, ...] = tuple(found[name].shape)
                require(said[-2:] == (wheels, count), name, f"shape {said}", f"of shape (..., {wheels}, {count})")
        check_broadcast(
            **{name: value.shape[: -2 - (name == "jacobian")] for name, value in found.items() if value is not None}
        )
        names = tuple(f"q{place + 1}" for place in range(count)) if self.coordinates is None else self.coordinates
        known = isinstance(names, Sequence) and all(isinstance(one, str) for one in names)
        require(known and len(names) == count == len(set(names)), "coordinates", names, f"{count} different names")
        names = tuple(names)
        for name, value in found.items():
            object.__setattr__(self, name, frozen(value))
        object.__setattr__(self, "coordinates", names)
        object.__setattr__(self, "contacts", contacts_of(self.contacts, wheels, "wheel of the jacobian"))
        object.__setattr__(self, "kinds", kinds_of(self.contacts))  # type: ignore[arg-type]
        a = found["jacobian"]
        parts = [a[..., 0, :], a[..., 1, :]]
        if found["spin"] is not None:
            parts.append(found["spin"])
        if any(part.shape != parts[0].shape for part in parts):
            parts = list(xp.broadcast_arrays(*parts))
        object.__setattr__(self, "rows", xp.concat(parts, axis=-2))
        object.__setattr__(self, "columns", xp.matrix_transpose(self.rows))

    @property
    def wheels(self) -> int:
        """Number of wheels, k."""
        return self.jacobian.shape[-3]

    @property
    def reference_force(self) -> float:
        """Mean slip force of the wheels at rest. [N]"""
        return sum(contact.slip_force for contact in self.contacts) / self.wheels  # type: ignore[union-attr]

    def velocities(self, rates: Array) -> Array:
        """x and y velocities, and spins where known: (..., 2 k or 3 k)."""
        return applied_to(self.rows, rates)

    def operate(
        self, *, rates: Array, heading: Heading, steering_rate: Array = 0.0, stick_speed: float | None = None
    ) -> MechanismPoint:
        """Forces and losses at given rates.

        Parameters
        ----------
        rates : (..., n) float or mapping of coordinate to (...,) float   qdot.
        heading : (..., k) float or tuple    Angles of the wheels, or their cosines and sines; see `Heading`.
        steering_rate : (..., k) float       Rate of the headings; counts where a contact `turns_with_spin`. [rad s^-1]
        stick_speed : float                  As in `RollingContact.act`, for motion in time.

        Returns
        -------
        MechanismPoint   Without a stick speed the forces of a wheel at rest are nan: any force below slip holds it.
        """
        if isinstance(rates, Mapping):
            rates = self.vector(rates, "rates")
        if stick_speed is not None:
            check_value("stick_speed", stick_speed, "m/s", Gt(0))
        xp = namespace(self.rows, rates, steering_rate, *(heading if isinstance(heading, tuple) else (heading,)))
        rates = self.checked_rates(xp, rates)
        heading = directions(xp, heading, self.wheels)
        steering_rate = self.checked_points(xp, steering_rate, rates=rates.shape[:-1], heading=heading[0].shape[:-1])
        forces, applied = self.forces(rates, heading, steering_rate, stick_speed)
        return self.point(rates, applied, heading, steering_rate, forces)

    def forces(
        self, rates: Array, heading: tuple[Array, Array], steering_rate: Array = 0.0, stick_speed: float | None = None
    ) -> tuple[ContactForces, Array]:
        """Forces of every contact, (..., k) each, and the forces Q that they exert on the coordinates, (..., n); arguments as in
        `operate`."""
        xp = namespace(self.rows, rates, *heading, steering_rate)
        k = self.wheels
        motion = self.velocities(rates)
        speed = None if self.surface is None else applied_to(self.surface, rates)
        spin = self.spins(motion, steering_rate)
        found = self.by_contact(xp, _act(stick_speed), motion[..., :k], motion[..., k : 2 * k], *heading, spin, speed)
        parts = [found.x, found.y] + ([-found.moment] if self.spin is not None else [])
        if any(part.shape != parts[0].shape for part in parts):
            parts = list(xp.broadcast_arrays(*parts))
        return found, applied_to(self.columns, xp.concat(parts, axis=-1))

    def spins(self, motion: Array, steering_rate: Array) -> Array | None:
        """psi of every wheel, (..., k), from `velocities`; None where nothing turns."""
        if self.spin is not None:
            return motion[..., 2 * self.wheels :] + steering_rate
        if isinstance(steering_rate, (int, float)) and steering_rate == 0:
            return None
        return 0.0 * motion[..., : self.wheels] + steering_rate

    def by_contact(self, xp: Any, function: Any, *columns: Array | None) -> Any:
        """``function(contact, *columns)`` for each kind of contact on the columns (..., k) of its wheels, joined again."""
        if len(self.kinds) == 1:
            return function(self.kinds[0][0], *columns)
        known = iter(xp.broadcast_arrays(*(column for column in columns if column is not None)))
        columns = tuple(column if column is None else next(known) for column in columns)
        parts, order = [], []
        for contact, wheels in self.kinds:
            places = xp.asarray(wheels, dtype=xp.int64)
            own = (column if column is None else xp.take(column, places, axis=-1) for column in columns)
            parts.append(function(contact, *own))
            order += wheels
        back = xp.asarray([order.index(place) for place in range(self.wheels)], dtype=xp.int64)
        return joined(xp, parts, back)

    def point(
        self,
        rates: Array,
        applied: Array,
        heading: tuple[Array, Array],
        steering_rate: Array,
        forces: ContactForces,
    ) -> MechanismPoint:
        """The point of known forces."""
        xp = namespace(rates, applied, forces.x)
        # What does not move as prescribed, because a heading or the configuration is beyond a limit, has no demand of its own.
        lost = xp.isnan(forces.creep_speed)
        cosine, sine, steering_rate, u = xp.broadcast_arrays(
            *heading, *as_floats(xp, steering_rate), forces.creep_speed
        )
        rates, applied = xp.broadcast_arrays(rates, applied)
        pressed: dict[Limit, Array] = {}
        for contact, _ in self.kinds:
            for limit, demand in contact.utilisation.items():
                known = pressed.get(limit)
                pressed[limit] = demand if known is None else xp.maximum(xp.asarray(known), xp.asarray(demand))
        return MechanismPoint(
            coordinates=tuple(self.coordinates),  # type: ignore[arg-type]
            rates=rates,
            applied=applied,
            cosine=cosine,
            sine=sine,
            creep_speed=u,
            rolling_speed=forces.rolling_speed,
            lateral_force=forces.lateral_force,
            moment=forces.moment + 0.0 * u,
            steering_rate=steering_rate,
            wheel_losses=forces.losses,
            slip_demand=xp.where(lost, xp.inf, forces.slip_demand),
            pressed=pressed,
        )

    def vector(self, values: Mapping[str, Array], what: str) -> Array:
        """Values of all coordinates as one array (..., n).

        Raises
        ------
        ParameterError
            If a coordinate is missing or unknown.
        """
        self.known(values, what)
        for name in self.coordinates:  # type: ignore[union-attr]
            if name not in values:
                raise ParameterError(f"{what} of {name} is missing")
        xp = namespace(*values.values())
        found = self.checked_values(xp, values, what)
        return xp.stack(xp.broadcast_arrays(*(found[name] for name in self.coordinates)), axis=-1)  # type: ignore[union-attr]

    def checked_rates(self, xp: Any, rates: Array) -> Array:
        """Rates (..., n) as floats; nan, of a point that is lost elsewhere, makes the point nan here.

        Raises
        ------
        ParameterError
            If one is infinite or no number, or there is not one for each coordinate. Traced values are not checked.
        """
        (rates,) = named_floats(xp, rates=rates)
        shape, count = tuple(rates.shape), self.jacobian.shape[-1]
        require(shape[-1:] == (count,), "rates", f"shape {shape}", f"of shape (..., {count}), one for each coordinate")
        _check_bounded(xp, rates=rates)
        return rates

    @staticmethod
    def checked_values(xp: Any, values: Mapping[str, Array], what: str) -> dict[str, Array]:
        """Values by coordinate, as floats that broadcast; nan and ParameterError as for `checked_rates`."""
        titles = [f"{what} of {name}" for name in values]
        found = named_floats(xp, **dict(zip(titles, values.values(), strict=True)))
        check_broadcast(**{name: tuple(value.shape) for name, value in zip(titles, found, strict=True)})
        _check_bounded(xp, **dict(zip(titles, found, strict=True)))
        return dict(zip(values, found, strict=True))

    def checked_points(self, xp: Any, steering_rate: Array, **points: tuple[int, ...]) -> Array:
        """The steering rate, if it fits the wheels, and all arrays fit the shapes of many points.

        Raises
        ------
        ParameterError
            If a shape does not fit, or the rate is infinite.
        """
        if isinstance(steering_rate, (int, float)):
            check_value("steering_rate", steering_rate, "rad/s", FINITE)
        else:
            (steering_rate,) = named_floats(xp, steering_rate=steering_rate)
            _check_bounded(xp, steering_rate=steering_rate)
            shape = tuple(steering_rate.shape)
            fits = shape[-1:] in ((), (1,), (self.wheels,))
            require(fits, "steering_rate", f"shape {shape}", f"one number, or of shape (..., {self.wheels})")
            points["steering_rate"] = shape[:-1]
        check_broadcast(configuration=tuple(self.rows.shape[:-2]), **points)
        return steering_rate

    def known(self, values: Mapping[str, Array], what: str) -> None:
        """Raise ParameterError unless values are a mapping whose names are those of coordinates."""
        names = tuple(self.coordinates)  # type: ignore[arg-type]
        require(isinstance(values, Mapping), what, shown(values), "a mapping of coordinate to value")
        for name in values:
            if name not in names:
                raise ParameterError(
                    f"{what} has an unknown coordinate {name!r}{nearest(str(name), names)}; coordinates: {', '.join(names)}"
                )


def _check_bounded(xp: Any, **named: Array) -> None:
    """Raise ParameterError if a value is infinite; values that are being traced are not checked."""
    if xp.__name__ == "numpy":
        for name, value in named.items():
            infinite = xp.isinf(value)
            require(not xp.any(infinite), name, value[infinite][:1], "finite")


def _act(stick_speed: float | None) -> Any:
    def act(
        contact: RollingContact, vx: Array, vy: Array, cosine: Array, sine: Array, spin: Array, speed: Array | None
    ) -> ContactForces:
        return contact.act((vx, vy), (cosine, sine), spin=spin, surface_speed=speed, stick_speed=stick_speed)

    return act


def contacts_of(given: Any, count: int, each: str) -> tuple[RollingContact, ...]:
    """One contact for each of `count` wheels, from a row of contacts or one for all.

    Raises
    ------
    ParameterError
        If their number does not fit, one is no `RollingContact`, or its creep law has a flow loss.
    """
    if not isinstance(given, (RollingContact, Sequence)) or isinstance(given, (str, bytes)):
        raise ParameterError(f"contacts must be RollingContact, one for all or one for each {each}, got {shown(given)}")
    contacts = (given,) * count if isinstance(given, RollingContact) else tuple(given)
    require(len(contacts) == count, "contacts", len(contacts), f"{count}, one for each {each}")
    for contact in contacts:
        if not isinstance(contact, RollingContact):
            raise ParameterError(f"contacts must be RollingContact, got {contact!r}")
        if contact.creep_law.flow_factor is not None:
            raise ParameterError(
                f"creep_law must be one without a flow loss, got {contact.creep_law.name!r}: Eq 17 is a loss of the link "
                "speed of a wheel on a cylinder (RotaryLinearIVT)"
            )
    return contacts


def kinds_of(contacts: Sequence[RollingContact]) -> tuple[tuple[RollingContact, tuple[int, ...]], ...]:
    """Contacts that differ, with the wheels that have them."""
    found: list[tuple[RollingContact, list[int]]] = []
    for place, contact in enumerate(contacts):
        for known, wheels in found:
            if known is contact or equal(known, contact):
                wheels.append(place)
                break
        else:
            found.append((contact, [place]))
    return tuple((contact, tuple(wheels)) for contact, wheels in found)


def joined(xp: Any, parts: Sequence[Any], back: Array) -> Any:
    """Tuples of arrays and of dictionaries of arrays, joined along the wheels; what a kind lacks is zero."""
    joined = []
    for place, first in enumerate(parts[0]):
        pieces = [part[place] for part in parts]
        if isinstance(first, dict):
            like = [part[0] for part in parts]
            names = dict.fromkeys(name for piece in pieces for name in piece)
            joined.append(
                {
                    name: _wheels(xp, [p.get(name, 0.0 * one) for p, one in zip(pieces, like, strict=True)], back)
                    for name in names
                }
            )
        else:
            joined.append(_wheels(xp, pieces, back))
    return type(parts[0])(*joined)


def _wheels(xp: Any, pieces: Sequence[Array], back: Array) -> Array:
    return xp.take(xp.concat(pieces, axis=-1), back, axis=-1)
