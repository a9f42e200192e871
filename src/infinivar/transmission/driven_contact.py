r"""A rolling contact whose wheel is driven: it transmits traction along its rolling direction, and creeps in both directions.

With the creep velocity :math:`\delta` of the wheel's surface over the other one, the rolling speed v and the stiffnesses
:math:`C_{11} G a b` and :math:`C_{22} G a b`, the linear force is :math:`L = C \delta/|v|`. A creep law reduces its size.

With spin, exact theory is known for lateral creep: :math:`f(\xi, \varphi)` and :math:`m(\xi, \varphi)` of
`infinivar.contact.exact.spin_map`. Here :math:`\xi = |L|/\mu P` and d is the direction of L. The parts of f and m that are
even in the spin (f+, m+) and odd in it (f-, m-) then give

.. math:: F/\mu P = f^+ d + f^- \hat y, \qquad M/\mu P c = m^- + (d \cdot \hat y)\, m^+ .

This equals exact theory under lateral creep, the linear theory for small creepages and that of a rigid circle in full sliding.
In between, C11/C22 falls to 1 with the spin. It is passive: for equal stiffnesses the power is the mean, with weights
:math:`(1 \pm d_y)/2`, of the powers of lateral creep to either side. For a wheel that rolls backwards,
f- and m+ change their sign.

Source: kalker1990, steady rolling, for lateral creep with spin; shen1983 for the reduction of the linear force.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from infinivar._core.array_namespace import Array, namespace
from infinivar.transmission import spin_law
from infinivar.transmission.geometry import LossGroups
from infinivar.transmission.rolling_contact import ContactForces, RollingContact

_TURNED = 20.0
"""Scaled spin at which the elastic difference of both directions has fallen by half: chosen by comparison with the solver of
exact rolling contact. [-]"""

_SPOT = 1e-12
"""Rolling speed over the speed at which the patch slides or turns, below which it turns on the spot. [-]"""

_STILL = 1e-40
"""Square of a creep speed that is none: with it, forces have slopes at rest. [m^2 s^-2]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivenContact(RollingContact):
    """A preloaded wheel that drives a surface, or is driven by it; fields as for `RollingContact`."""

    @classmethod
    def of(cls, contact: RollingContact) -> DrivenContact:
        """The same wheel, driven or on a fixed axle."""
        return cls(**{one.name: getattr(contact, one.name) for one in fields(RollingContact) if one.init})

    @property
    def stiffness_ratio(self) -> float:
        """Longitudinal over lateral creep stiffness, C11/C22; 1 if only measured values are known. [-]"""
        if self.contact is None:
            return 1.0
        return self.contact.coefficients.c11 / self.contact.coefficients.c22

    def act(
        self,
        velocity: tuple[Array, Array],
        heading: tuple[Array, Array] = (1.0, 0.0),
        *,
        spin: Array | None = None,
        surface_speed: Array | None = None,
        stick_speed: float | None = None,
    ) -> ContactForces:
        """Forces of the contact at a creep velocity.

        Parameters
        ----------
        velocity : two of (...,) float   Creep velocity of the wheel's surface over the other, along its rolling direction x and
            across it. [m s^-1]
        heading : two of (...,) float    Not used: x is the rolling direction.
        spin : (...,) float              psi, from x to y; ignored unless `turns_with_spin`. [rad s^-1]
        surface_speed : (...,) float     v, rolling speed of the wheel's circumference. [m s^-1]
        stick_speed : float              Least rolling speed at which the wheel creeps; None:
            exact, and nan where nothing moves. [m s^-1]

        Returns
        -------
        ContactForces
            Force on the wheel; `creep_speed` is that along x, `lateral_force` the size of the tangential force. Rolling
            resistance and bearings, which act on the wheel's shaft, are not included.
        """
        dx, dy = velocity
        xp = namespace(self, dx, dy, surface_speed, spin)
        v = xp.asarray(0.0 if surface_speed is None else surface_speed, dtype=xp.float64)
        psi = 0.0 * dx if spin is None or not self.turns_with_spin else spin
        groups = self.groups(v)
        rolling = self._rolling(xp, dx, dy, v, psi if spin is None else spin, stick_speed)
        turns = self.turns_with_spin and spin is not None
        linear_x, linear_y = self._ratio(xp, groups, psi, rolling, turns) * dx, dy
        size = xp.sqrt(linear_x * linear_x + linear_y * linear_y + _STILL)
        way_x, way_y = linear_x / size, linear_y / size
        if turns:
            along, across, moment, demand = self._with_spin_law(xp, groups, size, way_y, rolling, v, psi)
        else:
            law = groups.formulas(self.creep_law)
            scaled = groups.creep_group * size / rolling
            along, across, moment = law.force(scaled), 0.0 * size, 0.0 * size
            demand = scaled / (groups.slip_creepage(self.creep_law) * (1.0 + 1e-9))
        fx, fy = groups.slip_force * along * way_x, groups.slip_force * (along * way_y + across)
        creep = fx * dx + fy * dy
        by_creep, by_spin = spin_law.shares(creep, moment * psi)
        total = xp.sqrt(fx * fx + fy * fy)
        ratio = total / groups.slip_force
        return ContactForces(
            x=-fx,
            y=-fy,
            moment=moment,
            creep_speed=dx + 0.0 * total,
            rolling_speed=v + 0.0 * total,
            lateral_force=total,
            losses={"creep": by_creep, "spin": by_spin, "rolling": 0.0 * total, "bearing": 0.0 * total},
            slip_demand=xp.where(demand > ratio, demand, ratio),
        )

    def _ratio(self, xp: Any, groups: LossGroups, psi: Array, rolling: Array, turns: bool) -> Array:
        """Stiffness ratio that the direction of the force follows: elastic without spin, 1 where the patch slides by it."""
        if not turns:
            return self.stiffness_ratio
        lever = spin_law.TurningPatch.of(self, groups).lever
        scaled = groups.creep_group * lever * xp.abs(psi) / rolling
        return 1.0 + (self.stiffness_ratio - 1.0) / (1.0 + scaled / _TURNED)

    def _rolling(self, xp: Any, dx: Array, dy: Array, v: Array, spin: Array, stick_speed: float | None) -> Array:
        """Rolling speed at which the wheel creeps, > 0 unless nothing moves; nan there."""
        if stick_speed is not None:
            return xp.sqrt(v * v + stick_speed * stick_speed)
        lever = self.wheel_radius if self.contact is None else (self.contact.patch.a * self.contact.patch.b) ** 0.5
        least = _SPOT * (xp.abs(dx) + xp.abs(dy) + lever * xp.abs(spin))
        found = xp.sqrt(v * v + least * least)
        return xp.where(found > 0, found, xp.nan)

    def _with_spin_law(
        self, xp: Any, groups: LossGroups, size: Array, way_y: Array, rolling: Array, v: Array, psi: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Force ratios along the creep and across the wheel, moment, and slip demand; see the module."""
        patch = spin_law.TurningPatch.of(self, groups)
        size, psi, rolling, v, way_y = xp.broadcast_arrays(size, psi, rolling, v, way_y)
        one = spin_law.law(size, psi, rolling, **patch._asdict())
        other = spin_law.law(size, -psi, rolling, **patch._asdict())
        # A wheel that rolls backwards has leading and trailing edge exchanged.
        way = v / rolling
        along = 0.5 * (one[0] + other[0]) / groups.slip_force
        across = 0.5 * way * (one[0] - other[0]) / groups.slip_force
        moment = 0.5 * (one[1] - other[1]) + 0.5 * way * way_y * (one[1] + other[1])
        demand = spin_law.slip_demand(
            size,
            psi,
            rolling,
            slip_force=groups.slip_force,
            creep_stiffness=groups.creep_stiffness,
            lever=patch.lever,
            slip_creepage=groups.full_slip,
        )
        return along, across, moment, demand
