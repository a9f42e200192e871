r"""The rotational-to-rotational cobotic transmission: a sphere between drive rollers on two shafts and steered rollers.

The sphere turns at :math:`\omega` about an axis in the plane of the drive rollers, at the angle gamma from roller 1, which the
steered rollers select. The carriers of all rollers stand still, so that a contact with the normal n (outwards) moves over the
sphere at :math:`V = -R_s\,\omega \times n` and turns at :math:`\psi = -\omega \cdot n`. A drive roller with the axis a rolls
without creep at

.. math:: r w_i = -R_s\, \omega \cdot a_i, \qquad w_1/w_2 = \tan\gamma

for drive rollers a quarter turn apart. At gamma = 0 shaft 1 is locked and shaft 2 turns freely with the sphere, at a quarter
turn the reverse; in between the ratio has both signs. In steady motion the forces on the sphere balance, and

.. math:: \tau_1 w_1 - T_2 w_2 = \sum \mathrm{loss} \ge 0

for every law of the contact, with the torque :math:`\tau_1` applied to shaft 1 and the torque :math:`T_2` that shaft 2 applies to
its load.

Source: faulring2006, section I, for the family; contacts as in `infinivar.transmission.rolling_contact`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array, finite_floats, namespace
from infinivar._core.arrays import real_array, shown
from infinivar._core.fields import check, check_single, check_value, component, quantity
from infinivar.errors import ParameterError, require
from infinivar.transmission import spherical_solve
from infinivar.transmission.driven_contact import DrivenContact
from infinivar.transmission.mechanism import Mechanism
from infinivar.transmission.rolling_contact import ContactForces, RollingContact
from infinivar.transmission.sphere_layout import LAYOUTS, LayoutName, Roller, basis, check_rollers
from infinivar.transmission.spherical_solve import SphericalPoint

COORDINATES = ("shaft1", "shaft2", "sphere_x", "sphere_y", "sphere_z")

_PAIRS = (("input_speed", "output_torque"), ("sphere_speed", "load"))
"""What may be prescribed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SphericalIVT:
    """Sphere between rollers: the infinitely variable transmission between two shafts.

    Raises
    ------
    ParameterError
        If a field is outside its range, a contact is not one on this sphere, or the rollers cannot hold the sphere, do not
        balance, or do not roll together.
    """

    sphere_radius: float = quantity("m", Gt(0), "Radius R_s of the sphere")
    drive: RollingContact = component("Drive rollers, one or more on each shaft")
    steering: RollingContact | None = component("Steered rollers; like the drive rollers if not given", default=None)
    idler: RollingContact | None = component("Idlers; like the drive rollers if not given", default=None)
    layout: LayoutName = component("Positions of the rollers, unless `rollers` gives them", default="tetrahedral")
    rollers: Sequence[Roller] | None = component(
        "Positions and axes of the rollers; None: those of `layout`", default=None
    )
    _frames: Any = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        """Validate the fields, and compute the kinematic map."""
        check(self)
        check_single(self)
        if self.rollers is None:
            object.__setattr__(self, "rollers", LAYOUTS[self.layout])
        if not isinstance(self.rollers, Sequence):
            raise ParameterError(f"rollers must be a row of Roller, got {shown(self.rollers)}")
        object.__setattr__(self, "rollers", tuple(self.rollers))  # type: ignore[arg-type]
        for kind in ("drive", "steering", "idler"):
            if getattr(self, kind) is None:
                object.__setattr__(self, kind, self.drive)
            self._check_contact(kind, getattr(self, kind))
        for one in self.rollers:  # type: ignore[union-attr]
            if not isinstance(one, Roller):
                raise ParameterError(f"rollers must be Roller, got {one!r}")
        check_rollers(self.rollers, [getattr(self, one.kind).preload for one in self.rollers])  # type: ignore
        object.__setattr__(self, "_frames", _Frames(self))

    def _check_contact(self, kind: str, contact: Any) -> None:
        if not isinstance(contact, RollingContact):
            raise ParameterError(f"{kind} must be a RollingContact, got {contact!r}")
        require(contact.surface == "sphere", f"{kind}.surface", repr(contact.surface), "'sphere'")
        radius = contact.surface_radius
        if radius is not None and radius != self.sphere_radius:
            raise ParameterError(
                f"{kind}.surface_radius must be sphere_radius, {self.sphere_radius:g} m, got {radius:g}"
            )
        if contact.creep_law.flow_factor is not None:
            raise ParameterError(f"{kind}.creep_law must be one without a flow loss, got {contact.creep_law.name!r}")

    @property
    def kinds(self) -> tuple[str, ...]:
        """ "drive", "steering" or "idler", by roller."""
        return tuple(one.kind for one in self.rollers)  # type: ignore[union-attr]

    def pressed(self, factor: float) -> SphericalIVT:
        """The same transmission with all preloads multiplied by a factor; measured values scale by `PRELOAD_POWERS`."""
        check_value("factor", factor, "1", Gt(0))
        changed = {kind: one.pressed(factor * one.preload) for kind, one in self._contacts.items()}
        return replace(self, **changed)

    def with_roller_radius(self, wheel_radius: float) -> SphericalIVT:
        """The same transmission with another rolling radius of all rollers [m]; measured values are kept."""
        return replace(self, **{kind: replace(one, wheel_radius=wheel_radius) for kind, one in self._contacts.items()})

    @property
    def _contacts(self) -> dict[str, RollingContact]:
        return {kind: getattr(self, kind) for kind in ("drive", "steering", "idler")}

    def ideal_speeds(self, steering_angle: Array) -> tuple[Array, Array]:
        """Shaft speeds over the speed of the sphere without creep: R_s sin(gamma)/r and R_s cos(gamma)/r in both layouts.

        Parameters
        ----------
        steering_angle : (...,) float   gamma, any angle. [rad]

        Returns
        -------
        w_1, w_2 : (...,) float   Over Omega. [-]
        """
        found = self._frames.ideal(self._frames.axis(real_array("steering_angle", steering_angle)))
        return found[..., 0], found[..., 1]

    def rolling_rates(self, steering_angle: float, input_speed: float) -> np.ndarray:
        """w_1, w_2 and the angular velocity of the sphere without creep; the sphere rests where shaft 1 is locked. (5,)"""
        frames = self._frames
        axis = frames.axis(np.asarray(float(steering_angle)))
        first, second = frames.ideal(axis)
        turning = input_speed / first if abs(first) > 1e-6 * abs(second) else 0.0
        return np.array([input_speed, second * turning, *(axis * turning)])

    def headings(self, steering_angle: Array) -> Array:
        """Angles of all rollers in their tangent frames at a steering angle; 0 for drive rollers. (..., k) [rad]"""
        cosine, sine = self._frames.headings(real_array("steering_angle", steering_angle))
        return np.arctan2(sine, cosine)

    def mechanism(self, steering_angle: Array = 0.0) -> Mechanism:
        """The kinematic map, with the shaft speeds and the angular velocity of the sphere as coordinates.

        Parameters
        ----------
        steering_angle : (...,) float   Only rolling speeds depend on it, which bearings and friction limits follow. [rad]

        Returns
        -------
        Mechanism
            Operate it with `headings`. Rolling resistance and bearings of drive rollers and idlers are not part of it.
        """
        return self._frames.mechanism(*self._frames.headings(real_array("steering_angle", steering_angle)))

    def operate(
        self,
        *,
        steering_angle: Array,
        input_speed: Array | None = None,
        output_torque: Array | None = None,
        sphere_speed: Array | None = None,
        load: Array | None = None,
    ) -> SphericalPoint:
        """Steady operation, in all four quadrants.

        Parameters
        ----------
        steering_angle : (...,) float   gamma; 0 locks shaft 1, a quarter turn shaft 2. [rad]
        input_speed : (...,) float      w_1, with `output_torque`. [rad s^-1]
        output_torque : (...,) float    T_2, applied by shaft 2 to its load. [N m]
        sphere_speed : (...,) float     Omega without creep, instead, with `load`: this also passes through the steering angles
            at which a shaft is locked. The shaft speeds are prescribed along their direction without creep. [rad s^-1]
        load : (...,) float             kappa: drive rollers a quarter turn apart transmit the forces kappa cos(gamma) and
            kappa sin(gamma), up to losses. [N]

        Returns
        -------
        SphericalPoint
            Inputs broadcast. Beyond slip all is nan with the limit SLIP; so it is with an input speed where shaft 1 is
            locked, as it determines nothing there. At zero speed the forces are those of slow motion, without losses.

        Raises
        ------
        ParameterError
            If both or neither pair of inputs is given, one is no finite number, or shapes do not broadcast.
        """
        given = {
            "input_speed": input_speed,
            "output_torque": output_torque,
            "sphere_speed": sphere_speed,
            "load": load,
        }
        names = tuple(name for name, value in given.items() if value is not None)
        if names not in _PAIRS:
            raise ParameterError(
                f"give either input_speed and output_torque, or sphere_speed and load, got {' and '.join(names) or 'none'}"
            )
        known = {"steering_angle": steering_angle} | {name: given[name] for name in names}
        angle, speed, force = np.broadcast_arrays(*finite_floats(np, **known))
        return spherical_solve.point(self.kinds, self._frames, angle, speed, force, along_shaft=names == _PAIRS[0])

    def patches(self) -> tuple[RollingContact, ...]:
        """Contact of each roller: drive rollers and idlers as `DrivenContact`."""
        return tuple(self._frames.patches)

    def rolling_map(self) -> tuple[np.ndarray, np.ndarray]:
        """Jacobian of the contacts (k, 2, 5), and the rolling speed of rollers on fixed axles by each rate (k, 5)."""
        return self._frames.jacobian, self._frames.rolling_rows

    def heading_of(self, roller: int, steering_angle: Array) -> tuple[Array, Array]:
        """Cosine and sine of the heading of one roller, over any array library; see `headings`."""
        frames = self._frames
        if not frames.steered[roller]:
            return 1.0 + 0.0 * steering_angle, 0.0 * steering_angle
        xp = namespace(steering_angle)
        cosine, sine = xp.cos(steering_angle), xp.sin(steering_angle)
        normal, tangents = frames.normals[roller], (frames.tangents[0][roller], frames.tangents[1][roller])
        along, across = (
            cosine * float(-np.cross(frames.p, normal) @ t) + sine * float(-np.cross(frames.q, normal) @ t)
            for t in tangents
        )
        size = xp.sqrt(along * along + across * across)
        return along / size, across / size

    def moving(
        self, rates: np.ndarray, steering_angle: np.ndarray, steering_rate: Array, stick_speed: float
    ) -> tuple[ContactForces, np.ndarray, dict[str, np.ndarray], np.ndarray]:
        """Forces in motion, when those on the sphere need not balance; finite arguments are not checked.

        Parameters
        ----------
        rates : (m, 5) float              w_1, w_2 and the angular velocity of the sphere. [rad s^-1]
        steering_angle : (m,) float       gamma. [rad]
        steering_rate : (m,) or float     Its rate, with which the steered rollers turn. [rad s^-1]
        stick_speed : float               See `RollingContact.act`. [m s^-1]

        Returns
        -------
        forces : ContactForces (m, k)     Of the contacts.
        exerted : (m, 5) float            Forces on the shafts and the sphere. [N m]
        losses : name to (m, k) float     creep, spin, rolling, bearing. [W]
        moment : (m,) float               That the contacts exert against gamma. [N m]
        """
        frames = self._frames
        heading, slope = frames.headings(steering_angle), frames.heading_slopes(steering_angle)
        turning = slope * np.asanyarray(steering_rate)[..., None]
        forces, exerted, shaft, _ = spherical_solve.forces_at(frames, heading, rates, stick_speed, turning)
        losses = {
            name: forces.losses.get(name, 0.0 * forces.x) + shaft.get(name, 0.0)
            for name in ("creep", "spin", "rolling", "bearing")
        }
        return forces, exerted, losses, np.sum(forces.moment * slope, axis=-1)


class _Frames:
    """Tangent frames of the rollers, and all that follows from them."""

    def __init__(self, ivt: SphericalIVT) -> None:
        rollers: Sequence[Roller] = ivt.rollers  # type: ignore[assignment]
        self.sphere_radius = radius = ivt.sphere_radius
        self.normals = np.array([one.position for one in rollers])
        self.p, self.q = basis(rollers)
        self.steered = np.array([one.axis is None for one in rollers])
        self.shaft = np.array([one.shaft or 0 for one in rollers])
        self.contacts = [getattr(ivt, one.kind) for one in rollers]
        self.radii = np.array([one.wheel_radius for one in self.contacts])
        self.patches = [
            contact if steered else DrivenContact.of(contact)
            for contact, steered in zip(self.contacts, self.steered, strict=True)
        ]
        k = len(rollers)
        first = np.array([_tangent(n) if one.axis is None else np.cross(one.axis, n)
                          for n, one in zip(self.normals, rollers, strict=True)])  # fmt: skip
        self.tangents = first, np.cross(self.normals, first)
        self.axes = np.array([(0.0, 0.0, 0.0) if one.axis is None else one.axis for one in rollers])
        # V t = -R_s (omega x n) t = -R_s omega (n x t)
        self.jacobian = np.zeros((k, 2, 5))
        for row, t in enumerate(self.tangents):
            self.jacobian[:, row, 2:] = -radius * np.cross(self.normals, t)
        self.rolling_rows = np.zeros((k, 5))
        for place in np.flatnonzero(~self.steered & (self.shaft == 0)):
            self.rolling_rows[place], self.jacobian[place, 0] = self.jacobian[place, 0], 0.0
        for place in np.flatnonzero(self.shaft):
            column = self.shaft[place] - 1
            self.jacobian[place, 0, column] = -self.radii[place]
            self.rolling_rows[place, column] = self.radii[place]
        self.spin = np.concatenate([np.zeros((k, 2)), -self.normals], axis=1)

    def axis(self, angle: np.ndarray) -> np.ndarray:
        """Axis of the sphere, (..., 3)."""
        return np.cos(angle)[..., None] * self.p + np.sin(angle)[..., None] * self.q

    def ideal(self, axis: np.ndarray) -> np.ndarray:
        """Shaft speeds over the speed of the sphere, (..., 2), those of the first roller on each shaft."""
        places = [int(np.flatnonzero(self.shaft == shaft)[0]) for shaft in (1, 2)]
        return np.stack([-self.sphere_radius / self.radii[one] * (axis @ self.axes[one]) for one in places], axis=-1)

    def headings(self, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Cosines and sines, (..., k): steered rollers along the motion of the sphere, all others along their frames."""
        axis = self.axis(angle)
        moving = -np.cross(axis[..., None, :], self.normals)
        along, across = (np.sum(moving * t, axis=-1) for t in self.tangents)
        size = np.sqrt(along * along + across * across)
        steers = self.steered & (size > 1e-12)
        safe = np.where(steers, size, 1.0)
        return np.where(steers, along / safe, 1.0), np.where(steers, across / safe, 0.0)

    def heading_slopes(self, angle: np.ndarray) -> np.ndarray:
        """Derivatives of the headings by the steering angle, (..., k); 0 for rollers that are not steered."""
        here, there = (-np.cross(self.axis(one)[..., None, :], self.normals) for one in (angle, angle + 0.5 * np.pi))
        (along, across), (d_along, d_across) = (
            [np.sum(moving * t, axis=-1) for t in self.tangents] for moving in (here, there)
        )
        square = along * along + across * across
        steers = self.steered & (square > 1e-24)
        return np.where(steers, (along * d_across - across * d_along) / np.where(steers, square, 1.0), 0.0)

    def mechanism(self, cosine: np.ndarray, sine: np.ndarray) -> Mechanism:
        """The kinematic map with the rolling speeds at these headings."""
        free = self.steered[:, None]
        rows = cosine[..., None] * self.jacobian[:, 0] + sine[..., None] * self.jacobian[:, 1]
        return Mechanism(
            contacts=self.patches,
            jacobian=self.jacobian,
            spin=self.spin,
            surface=np.where(free, rows, self.rolling_rows),
            coordinates=COORDINATES,
        )


def _tangent(normal: np.ndarray) -> np.ndarray:
    """A tangent as near to z as there is one; x at the poles."""
    up = np.array([0.0, 0.0, 1.0]) if abs(normal[2]) < 1.0 - 1e-9 else np.array([1.0, 0.0, 0.0])
    found = up - (up @ normal) * normal
    return found / np.linalg.norm(found)
