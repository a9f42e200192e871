"""Step of the steering angle of a rolling wheel: lateral force by distance rolled, and the relaxation length."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from annotated_types import Gt, Interval

from infinivar._core.described import derived, reported
from infinivar._core.fields import check_value
from infinivar._core.result import Result, result
from infinivar.analysis.contact_sheet import HALF, cobotic_drives
from infinivar.contact.exact.patch import RollingPatch
from infinivar.contact.exact.transient import TransientRolling
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import InputError, ParameterError
from infinivar.study.check import check_study
from infinivar.study.study import Study
from infinivar.transmission.geometry import PressedContact
from infinivar.units import plain

RELAXED = 1.0 - math.exp(-1.0)
"""Share of the steady force that defines the relaxation length, as in a delay of first order."""

LARGEST = 0.2
"""Largest step; wheels slip at a tenth of it. [rad]"""

_CELLS = 16
"""Cells of the patch along each side; the relaxation length errs by about 0.5 %."""

_POINTS = 72
"""Distances after the turn."""

_REACH = 6.0
"""Distance rolled over the larger of a and sqrt(a b), after which less than 1 % of the force is missing."""

_AT_ONCE = 0.003
"""Distance over a on which a step at once takes place."""

_MOST = 1000
"""Distances while the wheel turns, at most."""

_SMALL = 1e-3
"""Scaled creepage of a small step, whose patch sticks almost everywhere."""

_ALONG = ("distance_m",)
"""Axis of the series of a step."""


@result
class SteeringStep(Result):
    """Step of the steering angle of one drive, as returned by `steering_steps`.

    The wheel rolls freely, and then turns about the contact normal while the link keeps its speed. The turn is spin, and the
    angle turned is a slip angle from then on.

    Attributes
    ----------
    name, title : str              Name of the drive, in the study and for display.
    angle : float                  Step of the steering angle. [rad]
    rate : float or None           Steering rate; None for a step at once. [rad s^-1]
    surface_speed : float          Of the cylinder. [m s^-1]
    half_length : float            Semi-axis a of the patch along the rolling direction. [m]
    slip_force : float             mu P. [N]
    steady_force, steady_moment : float   Lateral force and moment about the contact normal in the end. [N], [N m]
    distance : (n,)                Distance rolled since the wheel began to turn. [m]
    slip_angle : (n,)              [rad]
    force : (n,)                   Lateral force. [N]
    moment : (n,)                  Moment of the contact about its normal on the wheel, positive against the turn. [N m]
    relaxation_length : float      Distance at which the force is 63 % of the steady one. [m]
    linear_relaxation_length : float   The same for small steps, at which the patch sticks. [m]
    creep_distance, creep_force : (n,)   Lateral force after the same slip angle without a turn, as when the link changes
        speed. [m], [N]
    creep_relaxation_length, linear_creep_relaxation_length : float   Its distances at 63 %; for small steps. [m]
    """

    name: str = reported(key="drive")
    title: str = reported()
    angle: float = reported("rad")
    rate: float | None = reported("rad/s")
    surface_speed: float = reported("m/s")
    half_length: float = reported("m")
    slip_force: float = reported("N")
    steady_force: float = reported("N")
    steady_moment: float = reported("N m")
    distance: np.ndarray = reported("m", dims=_ALONG, variable="+", key="+")
    slip_angle: np.ndarray = reported("rad", dims=_ALONG, variable="+", key="+")
    force: np.ndarray = reported("N", dims=_ALONG, variable="+", key="+")
    moment: np.ndarray = reported("N m", dims=_ALONG, variable="+", key="+")
    relaxation_length: float = reported("m")
    linear_relaxation_length: float = reported("m")
    creep_distance: np.ndarray = reported("m")
    creep_force: np.ndarray = reported("N")
    creep_relaxation_length: float = reported("m")
    linear_creep_relaxation_length: float = reported("m")

    @derived("s")
    def relaxation_time(self) -> float:
        """Time to roll the relaxation length. [s]"""
        return self.relaxation_length / self.surface_speed

    @derived()
    def verdict(self) -> str:
        """One-sentence answer: the relaxation length and time of the step."""
        length, time = self.relaxation_length, self.relaxation_time
        if not math.isfinite(length):
            return (
                f"Relaxation length unknown after a step of {1e3 * self.angle:.3g} mrad: the solver did not converge."
            )
        return (
            f"Relaxation length {1e3 * length:.3g} mm ({length / self.half_length:.2f} a), {1e3 * time:.3g} ms at "
            f"{self.surface_speed:.3g} m/s, after a step of {1e3 * self.angle:.3g} mrad."
        )


def steering_steps(
    study: Study,
    drive: str | None = None,
    *,
    angle: float | None = None,
    rate: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[SteeringStep, ...]:
    """Step of the steering angle of every cobotic drive of a study whose contact is given by geometry, or of one.

    Parameters
    ----------
    study : Study          Drives of other types are skipped.
    drive : str, optional  Name of one cobotic drive.
    angle : float          Step, up to 0.2; by default that whose steady lateral force is half the slip limit. [rad]
    rate : float           Steering rate; by default the step is made at once. [rad s^-1]
    progress : callable    Receives a title and the share done, 0 to 1.

    Returns
    -------
    tuple of SteeringStep   In the order of the study.

    Raises
    ------
    InputError
        If no drive, or not the one named, has a contact given by geometry.
    ParameterError
        If an argument is out of range.

    Source: `contact.exact.transient.Path`; the patch is that at the steering angle 0.
    """
    check_study(study)
    for name, value, bound, unit in (
        ("angle", angle, Interval(gt=0, le=LARGEST), "rad"),
        ("rate", rate, Gt(0), "rad/s"),
    ):
        if value is not None:
            check_value(name, value, unit, bound)
    chosen = _given_by_geometry(cobotic_drives(study, drive))
    found = []
    for index, (name, one) in enumerate(chosen.items()):

        def share(done: float, index: int = index, title: str = study.titles[name]) -> None:
            if progress is not None:
                progress(title, (index + done) / len(chosen))

        found.append(_Rolling(name, one).step(study.titles[name], angle, rate, share))
    return tuple(found)


def _given_by_geometry(drives: dict[str, CoboticDrive]) -> dict[str, CoboticDrive]:
    found = {name: drive for name, drive in drives.items() if drive.transmission.contact is not None}
    if not found:
        name = next(iter(drives))
        raise InputError(
            f"drives.{name}.transmission: its contact is stated by creep_stiffness, rolling_torque and bearing_torque; "
            "the transient needs the patch: give geometry instead"
        )
    return found


class _Rolling:
    """The patch of one drive, in scaled creepages."""

    def __init__(self, name: str, drive: CoboticDrive) -> None:
        self.name = name
        element = drive.transmission
        contact = element.contact
        assert isinstance(contact, PressedContact)
        self.patch = contact.patch
        self.unit = math.sqrt(self.patch.a * self.patch.b)
        self.slip_force = float(element.groups(drive.cylinder_speed).slip_force) / element.wheels  # of one patch
        self.surface_speed = abs(element.cylinder_radius * drive.cylinder_speed)
        self.scale = contact.shear_modulus * self.unit**2 / self.slip_force
        try:
            self.rolling = RollingPatch(contact.axis_ratio, contact.poisson, contact.rotation, _CELLS)
        except ParameterError as problem:
            raise InputError(
                f"drives.{name}.transmission.geometry: patch outside the range of the solver: {problem}"
            ) from None

    def step(self, title: str, angle: float | None, rate: float | None, share: Callable[[float], None]) -> SteeringStep:
        """The step, and those it is compared with."""
        if angle is None:
            angle = math.atan(self._half_slip() / self.scale)
        creepage, at_once = self.scale * math.tan(angle), _AT_ONCE * self.patch.a / self.unit
        turn = at_once if rate is None else angle * self.surface_speed / rate / self.unit
        if turn > _MOST * self._spacing:
            least = angle * self.surface_speed / (_MOST * self._spacing * self.unit)
            rolled = f"at a lower rate the wheel rolls more than {plain(1e3 * _MOST * self._spacing * self.unit, 2)} mm"
            raise InputError(
                f"drives.{self.name}: rate must be at least {plain(least, 2)} rad/s for a step of {plain(1e3 * angle, 3)} mrad: "
                f"{rolled} while it turns, and the force is always that of steady rolling"
            )
        runs = []
        for number, (size, distance) in enumerate(
            ((creepage, turn), (_SMALL, at_once), (creepage, 0.0), (_SMALL, 0.0)),
        ):
            runs.append(self._run(size, distance, lambda done, number=number: share((number + done) / 4.0)))
        steady = self.rolling.steady(lateral=creepage)
        small = self.rolling.steady(lateral=_SMALL).fy
        step, _, alone, _ = runs
        force, moment = self.slip_force, self.slip_force * self.unit
        lengths = [
            self.unit * _reaching(run.distance, run.fy, RELAXED * end)
            for run, end in zip(runs, (steady.fy, small, steady.fy, small), strict=True)
        ]
        return SteeringStep(
            name=self.name,
            title=title,
            angle=angle,
            rate=rate,
            surface_speed=self.surface_speed,
            half_length=self.patch.a,
            slip_force=force,
            steady_force=force * steady.fy,
            steady_moment=-moment * steady.mz,
            distance=_from_start(self.unit * step.distance),
            slip_angle=_from_start(angle * np.minimum(step.distance / turn, 1.0)),
            force=_from_start(force * step.fy),
            moment=_from_start(-moment * step.mz),
            relaxation_length=lengths[0],
            linear_relaxation_length=lengths[1],
            creep_distance=_from_start(self.unit * alone.distance),
            creep_force=_from_start(force * alone.fy),
            creep_relaxation_length=lengths[2],
            linear_creep_relaxation_length=lengths[3],
        )

    @property
    def _spacing(self) -> float:
        """Distance between two forces, over the unit of length."""
        return _REACH * max(self.patch.a / self.unit, 1.0) / _POINTS

    def _half_slip(self) -> float:
        """Scaled lateral creepage at half of the slip limit."""
        from scipy.optimize import brentq

        return brentq(lambda size: self.rolling.steady(lateral=size).fy - HALF, 0.01, 1.5)  # type: ignore[return-value]

    def _run(self, creepage: float, turn: float, share: Callable[[float], None]) -> TransientRolling:
        """Forces while the wheel turns on the distance `turn`, and rolls on.

        A turn by an angle towards +y is a spin of that sense, and makes the wheel creep towards -y. Here the wheel turns
        towards -y, so that the force is positive.
        """
        spacing = self._spacing
        count = math.ceil(turn / spacing) if turn > 0.0 else 0
        turning = np.linspace(0.0, turn, count + 1)[1:]
        distance = np.concatenate([turning, turn + spacing * np.arange(1, _POINTS + 1)])
        done = (np.arange(count) + 0.5) / max(count, 1)
        lateral = creepage * np.concatenate([done, np.ones(_POINTS)])
        spin = np.concatenate([np.full(count, -creepage / turn if count else 0.0), np.zeros(_POINTS)])
        return self.rolling.transient(distance, lateral=lateral, spin=spin, progress=share)


def _from_start(values: np.ndarray) -> np.ndarray:
    """With the state of free rolling in front, where all are 0."""
    return np.concatenate([[0.0], values])


def _reaching(distance: np.ndarray, force: np.ndarray, required: float) -> float:
    """Distance at which a force first reaches a value; nan if it does not."""
    beyond = np.flatnonzero(force >= required)
    if not beyond.size:
        return math.nan
    index = int(beyond[0])
    before, at = (0.0, 0.0) if index == 0 else (force[index - 1], distance[index - 1])
    return float(at + (distance[index] - at) * (required - before) / (force[index] - before))
