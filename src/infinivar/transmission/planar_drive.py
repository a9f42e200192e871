r"""A body on steered wheels that are driven along their headings, each by a torque on its axle.

The wheel with the speed w of its axle slides over the ground along its heading and across it at

.. math:: \delta_x = V \cdot e - r w, \qquad \delta_y = V \cdot l, \qquad v = r w

and transmits the traction f_x and the side force f_y of `infinivar.transmission.driven_contact`. In steady motion

.. math:: \tau = r f_x + \tau_0\,\mathrm{sgn}(w), \qquad W \cdot \xi + \sum_k \tau_k w_k = \sum \mathrm{loss}

with the rolling and bearing torque :math:`\tau_0`, the wrench W of user and load, and the twist :math:`\xi`.

Source: kalker1990 for the contact; balance of powers as in `infinivar.transmission.mechanism`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array, bisect, check_broadcast, common_floats
from infinivar._core.arrays import real_array
from infinivar.errors import require
from infinivar.transmission.driven_contact import DrivenContact
from infinivar.transmission.kinematics import Heading, directions
from infinivar.transmission.mechanism import Mechanism, MechanismPoint
from infinivar.transmission.rolling_contact import RollingContact

_LARGEST = 0.9
"""Longitudinal creepage beyond which a wheel counts as sliding. [-]"""

_CLOSE = 1e-9
"""Torque that is missing, over that of the slip force, in a solution. [-]"""


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


def drive(body: Mechanism, twist: Array, heading: Heading, torque: Array) -> MechanismPoint:
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
            applied[..., 3 + place] += torque * np.sign(speed)
    return replace(point, applied=applied, wheel_losses=losses, cosine=cosine, sine=sine)
