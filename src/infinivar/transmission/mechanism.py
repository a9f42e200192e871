r"""Machines of rolling contacts: a kinematic map over one contact law.

The carrier of wheel k moves relative to its surface at ``V_k = A_k qdot`` in the tangent plane and turns about the normal at
``psi_k = S_k qdot`` plus the rate at which the wheel is steered. By virtual power the contacts exert the generalised forces

.. math:: Q = \sum_k \left(A_k^T f_k - S_k^T M_k\right), \qquad
    Q_a \cdot \dot q + \sum_k M_k \dot h_k = \sum_k \mathrm{loss}_k \ge 0, \qquad Q_a = -Q,

for every machine and every law of the contact. ``Q_a`` are the forces that motors, users and loads apply to the machine in
steady motion; a positive power ``Q_a qdot`` goes into the machine.

The forces do not depend on the size of the velocities, only on their direction, with one exception: bearings and friction
limits that depend on speed. So at rest they are indeterminate, and a motion is determined by forces alone except for its speed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from infinivar._core.array_namespace import Array
from infinivar.transmission import mechanism_forward, mechanism_inverse
from infinivar.transmission.contact_map import ContactMap, MechanismPoint
from infinivar.transmission.kinematics import Heading


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mechanism(ContactMap):
    """A machine at one configuration, or at many.

    Attributes
    ----------
    contacts : RollingContact, or one for each of the k wheels
    jacobian : (..., k, 2, n) float   A: velocity of each carrier along x and y by each coordinate's rate.
    coordinates : n names             "q1", "q2", ... by default.
    spin : (..., k, n) float          S: turning of each carrier about the normal, relative to the surface; None: none.
    surface : (..., k, n) float       Speed of the surface at each wheel, by each coordinate's rate: bearing friction and a
        friction limit that falls with speed follow it. None: they follow |V|.

    Raises
    ------
    ParameterError
        If shapes do not fit, or a creep law has a flow loss (law "faulring"), which is defined for the wheel on a cylinder only.
    """

    def solve(
        self,
        *,
        heading: Heading,
        rates: Mapping[str, Array],
        applied: Mapping[str, Array],
        steering_rate: Array = 0.0,
    ) -> MechanismPoint:
        """Steady motion with some rates prescribed, and the applied forces on all other coordinates.

        Parameters
        ----------
        heading, steering_rate : as in `operate`.
        rates : mapping of coordinate to (...,) float     Prescribed rates.
        applied : mapping of coordinate to (...,) float   Prescribed applied forces, on each coordinate whose rate is not.

        Returns
        -------
        MechanismPoint
            Forces agree with those prescribed to 1e-9 of the slip force; the balance of powers is exact. Where no steady motion
            is found, all is nan and the limit is SLIP. Where all prescribed rates are zero the machine rests: the forces of
            each wheel are indeterminate and nan, the applied forces are those prescribed (nan on the others), and the limit is
            OK if static friction can hold them: see `mechanism_forward.static_demand`.

        Raises
        ------
        ParameterError
            If a coordinate is in neither mapping, in both or unknown, or no rate is prescribed.

        Notes
        -----
        Newton's method with a falling residual, from the motion without creep. Given as nan are also motions in which a wheel
        is held by static friction while others move, and some that the prescribed rates hardly determine, because the machine
        moves across them: of random motions one in a thousand. At rest with arrays of other libraries than NumPy all is nan.
        """
        return mechanism_forward.solve(self, heading, rates, applied, steering_rate)

    def steer(
        self, *, rates: Array, applied: Mapping[str, Array] | None = None, steering_rate: Array = 0.0
    ) -> tuple[Array, Array]:
        """Headings for a motion: along the velocity of each carrier, less the slip angle that its load needs.

        Parameters
        ----------
        rates : (..., n) float or mapping of coordinate to (...,) float   qdot.
        applied : mapping of coordinate to (...,) float   Prescribed applied forces, on at most k coordinates; the others follow.
            With fewer than k, the wheels share them with the smallest lateral forces (to first order in the slip angles).
            None: headings of pure rolling without lateral force.
        steering_rate : as in `operate`.

        Returns
        -------
        cosine, sine : (..., k) float   Of headings along the motion; a wheel that points the other way is the same wheel. nan
            where a wheel would slip, and where a carrier stands still, as any heading serves.

        Raises
        ------
        ParameterError
            If a coordinate is unknown, or more forces are prescribed than there are wheels.
        """
        return mechanism_inverse.steer(self, rates, applied or {}, steering_rate)
