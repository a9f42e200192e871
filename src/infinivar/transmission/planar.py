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
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import (
    Array,
    as_floats,
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
from infinivar.transmission.driven_body import driven
from infinivar.transmission.driven_contact import DrivenContact
from infinivar.transmission.kinematics import Heading, directions
from infinivar.transmission.mechanism import Mechanism, MechanismPoint
from infinivar.transmission.rolling_contact import RollingContact

COORDINATES = ("x", "y", "angle")
"""Of a body in the plane: its twist is their rates, its wrench the forces along x and y and the moment, on its load."""


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
        return driven(self.mechanism, twist, heading, torque)

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


def pushed(mechanism: Mechanism, scale: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> MechanismPoint:
    """A body on wheels that are steered so that its source pushes along the motion only.

    Parameters
    ----------
    mechanism : Mechanism              Of a body in the plane or a carriage.
    scale : (d,) float                 Lengths by which rates are multiplied to compare them. [m]
    twist, wrench : (..., d) float     Of one shape; the wrench is that on the load.

    Returns
    -------
    MechanismPoint   nan where the body rests, a wheel would slip, or wheels do not hold what acts across the motion.

    Source: `infinivar.machines.kinds.planar`.
    """
    d = twist.shape[-1]
    scaled = twist * scale
    size = np.sqrt(np.sum(scaled * scaled, axis=-1, keepdims=True))
    moves = size > 0
    along = np.where(moves, scaled / np.where(moves, size, 1.0), np.eye(d)[0])
    # The reflection of the first axis onto the motion is orthogonal; its other columns are the motions across.
    mirror = along - np.eye(d)[0]
    square = np.sum(mirror * mirror, axis=-1)[..., None, None]
    turns = square > 1e-30
    basis = np.eye(d) - np.where(
        turns, 2.0 * mirror[..., :, None] * mirror[..., None, :] / np.where(turns, square, 1.0), 0.0
    )
    basis = basis / scale[:, None]
    jacobian = np.matmul(np.asarray(mechanism.jacobian), basis[..., None, :, :])
    names = tuple(f"across {place}" for place in range(1, d))
    shared: dict[str, Any] = {"contacts": mechanism.contacts, "coordinates": ("along", *names)}
    if mechanism.spin is not None:
        shared["spin"] = np.matmul(np.asarray(mechanism.spin), basis)
    turned = Mechanism(jacobian=jacobian, **shared)
    held = np.matmul(np.swapaxes(basis, -1, -2), wrench[..., None])[..., 0]
    rates = np.concatenate([np.where(moves, size, np.nan), np.zeros((*twist.shape[:-1], d - 1))], axis=-1)
    safe = np.where(moves, np.nan_to_num(rates), np.eye(d)[0])

    def steered(across: np.ndarray) -> MechanismPoint:
        heading = turned.steer(rates=safe, applied={name: across[..., place] for place, name in enumerate(names, 1)})
        lost = np.where(moves, 1.0, np.nan)
        return mechanism.operate(rates=twist, heading=(heading[0] * lost, heading[1] * lost))

    point = steered(held)
    fails = ~np.all(np.isfinite(np.asarray(point.slip_demand)), axis=-1, keepdims=True) & moves
    if not np.any(fails):
        return point
    # The push against the rolling resistance of each wheel, which has components across the motion.
    velocity = np.matmul(np.asarray(mechanism.jacobian), np.where(moves, twist, 1.0)[..., None, :, None])[..., 0]
    ahead = velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)
    free = np.asarray(mechanism.operate(rates=twist, heading=(ahead[..., 0], ahead[..., 1])).applied)
    across = held + np.matmul(np.swapaxes(basis, -1, -2), free[..., None])[..., 0]
    return steered(np.where(fails, across, held))
