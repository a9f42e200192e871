"""Mechanics of machines that are one `Mechanism`: planar cobots, spheres between rollers, serial arms."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from infinivar.limits import Limit
from infinivar.machines.linkage import ArmLoad, judged
from infinivar.machines.system import Forces, Place
from infinivar.transmission.mechanism import Mechanism
from infinivar.transmission.planar import PlanarCobot
from infinivar.transmission.spherical import SphericalIVT

_LOSSES = ("creep", "slip", "spin", "rolling", "bearing")


def _slip_demands(count: int, what: str) -> tuple[tuple[Limit, str], ...]:
    return tuple((Limit.SLIP, f"{what} {place + 1}") for place in range(count))


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanarMechanics:
    """A body on steered wheels, in its own axes; the configuration is its pose in the plane."""

    cobot: PlanarCobot
    stick_speed: float
    coordinates: tuple[str, ...] = ("v_x_m_s", "v_y_m_s", "w_rad_s")
    configuration: tuple[str, ...] = ("x_m", "y_m", "angle_rad")
    losses: tuple[str, ...] = _LOSSES
    _inertia: np.ndarray = field(init=False, repr=False, compare=False, default_factory=lambda: np.zeros((1, 3, 3)))

    def __post_init__(self) -> None:
        """Compute what does not change."""
        mass, moment = float(self.cobot.mass), float(self.cobot.inertia)  # type: ignore[arg-type]
        object.__setattr__(self, "_inertia", np.diag([mass, mass, moment])[None])

    @property
    def steered(self) -> tuple[str, ...]:
        """Headings of the wheels."""
        return tuple(f"h_{place + 1}_rad" for place in range(self.cobot.mechanism.wheels))

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Slip of each wheel."""
        return _slip_demands(self.cobot.mechanism.wheels, "wheel")

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia, and the force that turns a velocity in turning axes."""
        cosine, sine = np.cos(configuration[:, 2]), np.sin(configuration[:, 2])
        x, y, turning = rates[:, 0], rates[:, 1], rates[:, 2]
        changes, bias = np.empty_like(rates), np.zeros_like(rates)
        changes[:, 0], changes[:, 1], changes[:, 2] = cosine * x - sine * y, sine * x + cosine * y, turning
        whirled = self._inertia[0, 0, 0] * turning
        bias[:, 0], bias[:, 1] = -whirled * y, whirled * x
        return Place(changes, self._inertia, bias, None)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of the wheels."""
        heading = np.cos(angles), np.sin(angles)
        found, applied = self.cobot.mechanism.forces(rates, heading, turning, self.stick_speed)
        resisting = found.moment + 0.0 * angles
        return Forces(-applied, resisting, *judged(found.losses, found.slip_demand))


@dataclass(frozen=True, slots=True, kw_only=True)
class SphereMechanics:
    """A sphere between rollers and two shafts with their inertias; one steering angle turns all steered rollers.

    The configuration is the angles of the shafts.
    """

    ivt: SphericalIVT
    shaft_inertias: tuple[float, float]
    sphere_inertia: float
    stick_speed: float
    coordinates: tuple[str, ...] = ("w_1_rad_s", "w_2_rad_s", "sphere_x_rad_s", "sphere_y_rad_s", "sphere_z_rad_s")
    configuration: tuple[str, ...] = ("shaft_1_rad", "shaft_2_rad")
    steered: tuple[str, ...] = ("gamma_rad",)
    losses: tuple[str, ...] = _LOSSES

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Slip of each roller."""
        return _slip_demands(len(self.ivt.kinds), "roller")

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Constant inertia."""
        inertia = np.diag([*self.shaft_inertias, *[self.sphere_inertia] * 3])
        return Place(rates[:, :2], np.broadcast_to(inertia, (len(rates), 5, 5)), 0.0 * rates, None)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of the rollers, and what resists the rolling of those on fixed axles."""
        found, applied, losses, turned = self.ivt.moving(
            rates, angles[:, 0], turning[:, 0] if np.ndim(turning) else 0.0, self.stick_speed
        )
        return Forces(-applied, turned[:, None], *judged(losses, found.slip_demand))


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialArmMechanics:
    """A planar arm whose joints are coupled by wheels, one between each two."""

    load: ArmLoad
    mechanism: Mechanism
    stick_speed: float
    losses: tuple[str, ...] = _LOSSES

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Joint rates."""
        return self.load.coordinates

    @property
    def configuration(self) -> tuple[str, ...]:
        """Joint angles."""
        return self.load.configuration

    @property
    def steered(self) -> tuple[str, ...]:
        """Steering angles, as for a wheel on a cylinder: 0 locks the next joint."""
        return tuple(f"phi_{place + 1}_rad" for place in range(self.mechanism.wheels))

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Slip of each wheel."""
        return _slip_demands(self.mechanism.wheels, "wheel")

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia of the arm."""
        moved = self.load.inertia(configuration, rates)
        return Place(rates, moved.inertia, moved.bias, None)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of the wheels."""
        found, applied = self.mechanism.forces(rates, (np.sin(angles), np.cos(angles)), -turning, self.stick_speed)
        resisting: Any = -found.moment + 0.0 * angles
        return Forces(-applied, resisting, *judged(found.losses, found.slip_demand))
