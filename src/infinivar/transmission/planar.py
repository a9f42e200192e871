r"""Two translational velocities: steered wheels on a plane.

A carriage that slides along x and y on one steered wheel is the cylinder of `RotaryLinearIVT` unrolled. A planar cobot is a body
with wheels at points p_i, each with its own steering. With the twist :math:`\xi = (v_x, v_y, \omega)` of the body,

.. math:: V_i = v + \omega\, J p_i, \qquad A_i = [I \mid J p_i], \qquad J = \begin{pmatrix} 0 & -1 \\ 1 & 0 \end{pmatrix},
    \qquad W \cdot \xi = -\sum \mathrm{loss}

in steady motion with the wrench W that the body applies to its load, here to the user who pushes it. All in axes of
the body, or of the carriage.

A wheel driven along its heading e with the speed w of its axle slides over the ground along its heading and across it at

.. math:: \delta_x = V \cdot e - r w, \qquad \delta_y = V \cdot l, \qquad v = r w

and transmits the traction f_x and the side force f_y of `infinivar.transmission.driven_contact`. In steady motion

.. math:: \tau = r f_x + \tau_0\,\mathrm{sgn}(w), \qquad \sum_k \tau_k w_k - W \cdot \xi = \sum \mathrm{loss}

with the rolling and bearing torque :math:`\tau_0`.

Source: peshkin2001 for the machines; contact as in `infinivar.transmission.rolling_contact`; kalker1990 for driven wheels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import (
    Array,
    as_floats,
    bisect,
    check_broadcast,
    common_floats,
    finite_floats,
    named_floats,
    namespace,
    signed_infinity,
)
from infinivar._core.arrays import real_array
from infinivar._core.fields import check, check_number, component, quantity
from infinivar.errors import require
from infinivar.transmission.contact_map import contacts_of
from infinivar.transmission.driven_contact import DrivenContact
from infinivar.transmission.kinematics import Heading, directions
from infinivar.transmission.mechanism import Mechanism, MechanismPoint
from infinivar.transmission.rolling_contact import RollingContact

COORDINATES = ("x", "y", "angle")
"""Of a body in the plane: its twist is their rates, its wrench the forces along x and y and the moment, on its load."""

_LARGEST = 0.9
"""Longitudinal creepage beyond which a wheel counts as sliding. [-]"""

_CLOSE = 1e-9
"""Torque that is missing, over that of the slip force, in a solution. [-]"""


def drift(contact: RollingContact, side_load: Array) -> Array:
    """Angle from the heading of a rolling wheel to its path under a side load, whatever the speed.

    Parameters
    ----------
    contact : RollingContact       On a plane, without spin.
    side_load : (...,) float       Applied to the carrier at a right angle to the heading, positive to the left. [N]

    Returns
    -------
    (...,) float   Slip angle atan(u/v), with the sign of the load; nan beyond the slip limit. [rad]

    Source: creep law, inverted.
    """
    creepage = contact.creepage(*as_floats(namespace(side_load), side_load))
    return namespace(creepage).atan(creepage)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanarCarriage:
    """A carriage that slides along x and y over a plane, on one steered wheel.

    Raises
    ------
    ParameterError
        If the contact is not one on a plane.
    """

    contact: RollingContact = component("The wheel on the plane")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _check_planar(self.contact)

    @property
    def mechanism(self) -> Mechanism:
        """Kinematic map with coordinates "x" and "y": V is the velocity of the carriage."""
        return Mechanism(contacts=self.contact, jacobian=[[[1.0, 0.0], [0.0, 1.0]]], coordinates=COORDINATES[:2])


class PlanarFreedom(NamedTuple):
    """How a body on steered wheels can move; see `PlanarCobot.freedom`."""

    misalignment: Array
    """Least rms creep velocity of the wheels over the rms velocity of their carriers; 0 if all can roll. (...,) [-]"""
    twist: Array
    """The motion with that creep, forwards on average, with 1 m/s of rms carrier velocity. (..., 3)"""
    singular_values: Array
    """Of the map from motions to creep velocities, over the root of the number of wheels, from the largest. (..., <= 3) [-]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanarCobot:
    """A body on steered wheels, which a user pushes or a source drives.

    The wheels roll freely on their axles, except in `drive`. Twist and wrench are those at the body's reference point; for
    motion in time this is its centre of mass.

    Raises
    ------
    ParameterError
        If a field is outside its range, positions and contacts differ in number, or a contact is not one on a plane.
    """

    contacts: Sequence[RollingContact] | RollingContact = component(
        "The wheels on the plane: one for all, or one for each"
    )
    positions: Sequence[Sequence[float]] = component("Points of the wheels, x and y in axes of the body, in m")
    mass: float | None = quantity("kg", Gt(0), "Mass of the body, needed for motion in time", default=None)
    inertia: float | None = quantity(
        "kg m^2", Gt(0), "Moment of inertia about the centre of mass, needed for motion in time", default=None
    )
    mechanism: Mechanism = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]
    """Kinematic map with the coordinates "x", "y" and "angle"; the wheels have the spin of the body."""

    def __post_init__(self) -> None:
        """Validate the fields and make the kinematic map."""
        check(self)
        for name, unit in (("mass", "kg"), ("inertia", "kg m^2")):
            if getattr(self, name) is not None:
                check_number(name, getattr(self, name), unit, Gt(0))
        points = real_array("positions", self.positions)
        fits = points.ndim == 2 and points.shape[1:] == (2,) and points.shape[0] > 0
        require(fits, "positions", f"shape {points.shape}", "one row of x and y for each wheel")
        require(bool(np.all(np.isfinite(points))), "positions", "nan or infinity", "finite", "m")
        k = len(points)
        contacts = contacts_of(self.contacts, k, "position")
        for contact in contacts:
            _check_planar(contact)
        ones, nothing = np.ones(k), np.zeros(k)
        x, y = points[:, 0], points[:, 1]
        jacobian = np.stack([np.stack([ones, nothing, -y], -1), np.stack([nothing, ones, x], -1)], axis=-2)
        spin = np.stack([nothing, nothing, ones], axis=-1)
        made = Mechanism(contacts=contacts, jacobian=jacobian, spin=spin, coordinates=COORDINATES)
        object.__setattr__(self, "contacts", contacts)
        object.__setattr__(self, "positions", tuple((float(a), float(b)) for a, b in points))
        object.__setattr__(self, "mechanism", made)

    def headings(self, twist: Array, wrench: Mapping[str, Array] | None = None) -> Array:
        """Angles of the wheels for a motion: across the lines from the instant centre, less slip angles under a load.

        Parameters
        ----------
        twist : (..., 3) float    v_x, v_y and omega of the body; only its direction matters. [m s^-1], [rad s^-1]
        wrench : mapping          Forces "x", "y" [N] and moment "angle" [N m] that the body must apply to its load, see
            `Mechanism.steer`. In steady motion not all three are free, as the user must supply the losses.

        Returns
        -------
        (..., k) float   From x of the body to the heading of each wheel. nan where a wheel stands at the instant centre or
            would slip. [rad]
        """
        twist = _twist(twist)
        if wrench is not None:
            self.mechanism.known(wrench, "wrench")
        cosine, sine = self.mechanism.steer(rates=twist, applied=wrench)
        return namespace(cosine).atan2(sine, cosine)

    def drive(self, *, twist: Array, heading: Heading, torque: Array) -> MechanismPoint:
        """Steady motion with wheels that are driven along their headings by torques on their axles.

        Parameters
        ----------
        twist : (..., 3) float              v_x, v_y and omega of the body. [m s^-1], [rad s^-1]
        heading : (..., k) float or tuple   Angles of the wheels, or their cosines and sines. [rad]
        torque : (..., k) float             Of a motor on each axle, positive where it drives the wheel along its heading; 0: the
            wheel rolls freely. One number: the same for all. [N m]

        Returns
        -------
        MechanismPoint
            With the speeds of the axles as further coordinates "wheel1" to "wheel<k>", on whose motors the wheels apply the
            opposite of the torques. The forces on "x", "y" and "angle" are the wrench on the load: along the motion where the
            wheels drive it.
            `creep_speed` is that along the heading, `lateral_force` the whole tangential force of a wheel. Where a wheel cannot
            transmit its torque, or does not roll, all is nan and the limit is SLIP. NumPy arrays only.

        Source: as in the module; the contact by `DrivenContact`.
        """
        return _drive(self.mechanism, twist, heading, torque)

    def freedom(self, heading: Heading) -> PlanarFreedom:
        """The motion that the wheels permit with the least creep.

        With three wheels or more, all can roll exactly if the normals of their headings meet in one point, or are parallel.
        Otherwise every motion creeps, and costs what the internal forces between the wheels lose: see `Mechanism.operate` at
        the twist found. One wheel or two can always roll.

        Parameters
        ----------
        heading : (..., k) float or tuple    Angles of the wheels, or their cosines and sines. [rad]

        Returns
        -------
        PlanarFreedom   Where several motions roll without creep, one of them.

        Source: singular values of the lateral velocities at the wheels.
        """
        xp = namespace(self.mechanism.rows, *(heading if isinstance(heading, tuple) else (heading,)))
        k = self.mechanism.wheels
        cosine, sine = xp.broadcast_arrays(*directions(xp, heading, k))
        finite_floats(xp, heading=cosine + sine)
        x, y = (xp.asarray([point[axis] for point in self.positions], dtype=xp.float64) for axis in (0, 1))
        centre_x, centre_y = xp.mean(x), xp.mean(y)
        x, y = x - centre_x, y - centre_y
        # About the centre of the wheels, with turning as the rms velocity that it gives them.
        radius = xp.sqrt(xp.mean(x * x + y * y))
        radius = xp.where(radius > 0, radius, 1.0)
        lateral = xp.stack([-sine, cosine, (cosine * x + sine * y) / radius], axis=-1) / k**0.5
        values, vectors = xp.linalg.svd(lateral, full_matrices=True)[1:]
        vx, vy, turning = (vectors[..., 2, place] for place in range(3))
        turning = turning / radius
        rolling = cosine * (vx[..., None] - turning[..., None] * y) + sine * (vy[..., None] + turning[..., None] * x)
        way = xp.where(xp.sum(rolling, axis=-1) < 0, -1.0, 1.0)
        vx, vy, turning = way * vx, way * vy, way * turning
        misalignment = xp.abs(values[..., 2]) if k > 2 else 0.0 * values[..., 0]
        return PlanarFreedom(
            misalignment,
            xp.stack([vx + turning * centre_y, vy - turning * centre_x, turning], axis=-1),
            values,
        )


def instant_centre(twist: Array) -> tuple[Array, Array]:
    """Point of the body that stands still: x and y, infinite to the side of a pure translation, and nan at rest. [m]

    Parameters
    ----------
    twist : (..., 3) float   v_x, v_y, omega. [m s^-1], [rad s^-1]

    Source: V = v + omega J p = 0.
    """
    twist = _twist(twist)
    xp = namespace(twist)
    vx, vy, turning = twist[..., 0], twist[..., 1], twist[..., 2]
    turns, rests = turning != 0, (vx == 0) & (vy == 0)
    found = []
    for across in (-vy, vx):
        far = xp.where(rests, xp.nan, xp.where(across == 0, 0.0, signed_infinity(xp, across)))
        found.append(xp.where(turns, across / xp.where(turns, turning, 1.0), far) + 0.0)  # no negative zero
    return found[0], found[1]


def _twist(given: Array) -> Array:
    """A twist (..., 3) as floats."""
    (twist,) = named_floats(namespace(given), twist=given)
    require(tuple(twist.shape)[-1:] == (3,), "twist", f"shape {tuple(twist.shape)}", "of shape (..., 3)")
    return twist


def _check_planar(contact: RollingContact) -> None:
    require(contact.surface == "plane", "surface", repr(contact.surface), "'plane' for a machine on a plane")


def driving_creepage(contact: RollingContact, traction: Array, side_load: Array = 0.0) -> tuple[Array, Array]:
    """Creepages of a driven wheel under a traction and a side load, without spin.

    Parameters
    ----------
    contact : RollingContact     The wheel.
    traction : (...,) float      f_x, of the ground on the wheel along its heading: positive where the wheel drives. [N]
    side_load : (...,) float     Applied to the carrier at a right angle to the heading, positive to the left. [N]

    Returns
    -------
    along, across : (...,) float   delta_x/|v|, negative where the wheel drives, and delta_y/|v|; nan beyond slip. [-]

    Source: creep law, inverted for the size of the force; each part over its stiffness.
    """
    traction, side_load = np.broadcast_arrays(*common_floats(np, traction=traction, side_load=side_load))
    driven = DrivenContact.of(contact)
    size = np.hypot(traction, side_load)
    safe = np.where(size > 0, size, 1.0)
    linear = driven.creepage(size)
    return -linear * traction / safe / driven.stiffness_ratio, linear * side_load / safe


def _drive(body: Mechanism, twist: Array, heading: Heading, torque: Array) -> MechanismPoint:
    """See `PlanarCobot.drive`; `body` is its mechanism."""
    k = body.wheels
    given, torques = real_array("twist", twist), real_array("torque", torque)
    require(given.shape[-1:] == (3,), "twist", f"shape {given.shape}", "of shape (..., 3)")
    require(torques.shape[-1:] in ((), (1,), (k,)), "torque", f"shape {torques.shape}", f"one number, or {k} of them")
    for name, values in (("twist", given), ("torque", torques)):
        require(bool(np.all(np.isfinite(values))), name, "nan or inf", "finite")
    cosine, sine = directions(np, heading, k)
    shape = check_broadcast(twist=given.shape[:-1], heading=cosine.shape[:-1], torque=torques.shape[:-1])
    cosine, sine, torques = (np.broadcast_to(one, (*shape, k)) for one in (cosine, sine, torques))
    given = np.broadcast_to(given, (*shape, 3))
    contacts = [DrivenContact.of(one) for one in body.contacts]  # type: ignore[union-attr]
    motion = body.velocities(given)
    along = cosine * motion[..., :k] + sine * motion[..., k : 2 * k]
    across = cosine * motion[..., k : 2 * k] - sine * motion[..., :k]
    speeds = np.stack(
        [
            _speed(one, along[..., place], across[..., place], motion[..., 2 * k + place], torques[..., place])
            for place, one in enumerate(contacts)
        ],
        axis=-1,
    )
    machine = _machine(body, contacts, cosine, sine)
    point = machine.operate(rates=np.concatenate([given, speeds], axis=-1), heading=np.zeros(k))
    return _with_resistance(point, contacts, speeds, cosine, sine)


def _speed(contact: DrivenContact, along: Array, across: Array, spin: Array, torque: Array) -> np.ndarray:
    """Speed of the axle of one wheel; nan where no rolling wheel transmits the torque. [rad s^-1]"""
    way = np.sign(along)

    def missing(creepage: np.ndarray) -> np.ndarray:
        """Torque that remains at a creepage, which it rises with."""
        rolling = along / (1.0 + creepage * way)
        groups = contact.groups(rolling)
        found = contact.act((along - rolling, across), spin=spin, surface_speed=rolling)
        resisted = (groups.rolling_torque + groups.bearing_torque) * way
        return torque - contact.wheel_radius * found.x - resisted

    moves = way != 0
    along, way = np.where(moves, along, 1.0), np.where(moves, way, 1.0)
    ends = np.full(along.shape, _LARGEST)
    creepage = bisect(np, missing, -ends, ends)
    found = moves & (np.abs(missing(creepage)) <= _CLOSE * contact.slip_force * contact.wheel_radius)
    return np.where(found, along / (1.0 + creepage * way) / contact.wheel_radius, np.nan)


def _machine(body: Mechanism, contacts: list[DrivenContact], cosine: np.ndarray, sine: np.ndarray) -> Mechanism:
    """The kinematic map of body and axles, along and across each heading."""
    rows, k = np.asarray(body.jacobian), len(contacts)
    radii = np.array([one.wheel_radius for one in contacts])
    jacobian = np.zeros((*cosine.shape, 2, 3 + k))
    jacobian[..., 0, :3] = cosine[..., None] * rows[:, 0] + sine[..., None] * rows[:, 1]
    jacobian[..., 1, :3] = cosine[..., None] * rows[:, 1] - sine[..., None] * rows[:, 0]
    places = np.arange(k)
    jacobian[..., places, 0, 3 + places] = -radii
    surface, spin = np.zeros((k, 3 + k)), np.zeros((k, 3 + k))
    surface[places, 3 + places] = radii
    spin[:, 2] = 1.0
    names = (*body.coordinates, *(f"wheel{place + 1}" for place in places))  # type: ignore[misc]
    return Mechanism(contacts=contacts, jacobian=jacobian, spin=spin, surface=surface, coordinates=names)


def _with_resistance(
    point: MechanismPoint, contacts: list[DrivenContact], speeds: np.ndarray, cosine: np.ndarray, sine: np.ndarray
) -> MechanismPoint:
    """With the rolling and bearing torques, which the contact of a driven wheel leaves to its axle."""
    losses: dict[str, Any] = {name: np.array(loss) for name, loss in point.wheel_losses.items()}
    applied = np.array(point.applied)
    for place, contact in enumerate(contacts):
        speed = speeds[..., place]
        groups = contact.groups(contact.wheel_radius * speed)
        for name, torque in (("rolling", groups.rolling_torque), ("bearing", groups.bearing_torque)):
            losses[name][..., place] += torque * np.abs(speed)
            applied[..., 3 + place] -= torque * np.sign(speed)
    return replace(point, applied=applied, wheel_losses=losses, cosine=cosine, sine=sine)
