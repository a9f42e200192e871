"""The bench of a transmission: runs of a rig, and the readings that a cobotic drive would give in them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.result import result
from infinivar.calibration.bench import Bench, Error, Parameter, refuse
from infinivar.contact import creep
from infinivar.contact.creep import CreepLaw
from infinivar.contact.friction import coulomb
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import require
from infinivar.parts.shaft_bearings import CylinderBearings, WheelLoad
from infinivar.study.rig import Rig
from infinivar.tables.named import read_named
from infinivar.transmission.geometry import PRELOAD_POWERS
from infinivar.transmission.rotary_linear import RotaryLinearIVT, turning_as
from infinivar.units import plain

COLUMNS = {
    "steering_angle": "rad",
    "mass": "kg",
    "preload": "N",
    "duration": "s",
    "cylinder_angle": "rad",
    "link_travel": "m",
    "motor_current": "A",
    "motor_voltage": "V",
}
"""Columns of rig data with their SI units; the voltage is optional."""

_REQUIRED = tuple(name for name in COLUMNS if name != "motor_voltage")

PARAMETERS = {
    "creep_stiffness": Parameter("N", "N", "creep stiffness C = C22 G a b", divides=True),
    "rolling_torque": Parameter("N m", "mN m", "hysteresis torque of the rolling contact"),
    "bearing_torque": Parameter("N m", "mN m", "friction torque of the axle bearings"),
    "guideway_friction": Parameter("N", "N", "friction of the guideway"),
    "nominal_torque": Parameter("N m", "mN m", "no-load torque of motor, gearing and cylinder, at the motor"),
    "torque_constant": Parameter("N m/A", "mN m/A", "torque constant of the motor", divides=True),
    "resistance": Parameter("ohm", "ohm", "terminal resistance of the motor"),
}
"""Parameters by name; those that depend on the preload refer to the study's preload."""

USUAL = tuple(PARAMETERS)[:5]
"""Parameters fitted by default."""

OF_MASS = "mass of "
"""What the names of errors of masses begin with; the mass follows. [kg]"""

_COUNTED = 1.0 / math.sqrt(6.0)
"""Standard deviation of the difference of two encoder counts."""


class Readings(NamedTuple):
    """Sensor readings, one value per run; the voltage is given even if not recorded. [m], [A], [V]"""

    link_travel: np.ndarray
    motor_current: np.ndarray
    motor_voltage: np.ndarray


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """Errors of settings and sensors common to all runs of a session; zero for an exact rig.

    `mass` has one error per run.
    """

    current_gain: Array = 0.0
    """Current read over true current, less 1. [-]"""
    preload: Array = 0.0
    """True preload over its setting, less 1. [-]"""
    steering_zero: Array = 0.0
    """True steering angle less what the encoder says. [rad]"""
    mass: Array = 0.0
    """True mass less what the balance says. [kg]"""


@result
class RigData(Bench):
    """Runs of a rig: arrays of equal length, SI.

    Sign convention of the transmission: on a cylinder that turns forwards, a positive steering angle moves the link
    backwards; a mass pulls the link backwards; lifting is a positive travel. A run without preload (wheel lifted off)
    gives the torque of motor and gearing alone.

    Attributes
    ----------
    steering_angle : reading of the steering encoder. [rad]
    mass : mass hanging on the link. [kg]
    preload : set preload; 0 with the wheel lifted off. [N]
    duration : length of the measuring window. [s]
    cylinder_angle, link_travel : change over the window. [rad], [m]
    motor_current, motor_voltage : means over the window; the voltage may be None. [A], [V]
    lines, name, empty : see `Bench`.
    """

    steering_angle: np.ndarray
    mass: np.ndarray
    preload: np.ndarray
    duration: np.ndarray
    cylinder_angle: np.ndarray
    link_travel: np.ndarray
    motor_current: np.ndarray
    motor_voltage: np.ndarray | None
    lines: tuple[int, ...]
    name: str = "rig data"
    empty: Mapping[int, str] = dataclasses.field(default_factory=dict)

    kind = "rig"
    row = "run"
    many = "{count} of {whole} runs are implausible, too many to exclude as single misreadings"
    parameters: ClassVar[Mapping[str, Parameter]] = PARAMETERS
    units: ClassVar[Mapping[str, str]] = COLUMNS
    uncertain: ClassVar[tuple[str, ...]] = ("link_travel",)

    @property
    def signals(self) -> tuple[str, ...]:  # type: ignore[override]
        """Names of the readings."""
        return Readings._fields[: 2 if self.motor_voltage is None else 3]

    @property
    def read(self) -> np.ndarray:  # type: ignore[override]
        """Readings, (n, m)."""
        return np.stack([getattr(self, name) for name in self.signals], axis=-1)

    @property
    def usual(self) -> tuple[str, ...]:
        """Parameters fitted by default."""
        return USUAL

    @property
    def pressed(self) -> np.ndarray:
        """Mask of the runs with the wheel pressed on the cylinder."""
        return self.preload > 0

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Columns under headings with units, in the format that `read` accepts."""
        found = {name: getattr(self, name) for name in COLUMNS}
        return {f"{name} [{COLUMNS[name]}]": values for name, values in found.items() if values is not None}

    def refusal(self, name: str) -> str | None:
        """Why a parameter cannot be fitted to these columns, or None."""
        if name == "resistance" and self.motor_voltage is None:
            return "fitting the resistance requires a column motor_voltage"
        return None

    def known(self, drive: CoboticDrive) -> dict[str, float]:
        """The parameters as the study has them. [SI]"""
        return known_values(drive)

    def scales(self, drive: CoboticDrive) -> dict[str, float]:
        """Values of the study, or a size that matters where they are zero. [SI]"""
        element = drive.transmission
        natural = {
            "guideway_friction": 1e-3 * element.preload,
            "nominal_torque": 0.1 * drive.motor.continuous_torque,
        }
        other = 1e-3 * element.wheel_radius * element.slip_force
        return {name: abs(value) or natural.get(name, other) for name, value in known_values(drive).items()}

    def errors(self, rig: Rig) -> dict[str, Error]:
        """Errors of the settings and of the current sensor; each mass that hangs on the link has one."""
        room = 0.5 * math.pi - float(np.abs(self.steering_angle).max(initial=0.0))
        return {
            "current_gain": Error(rig.current_gain_deviation),
            "preload": Error(rig.preload_deviation, 1.0),
            "steering_zero": Error(rig.steering_zero_deviation, room),
            **{_of_mass(mass): Error(rig.mass_deviation) for mass in np.unique(self.mass).tolist() if mass > 0},
        }

    def expected(
        self, drive: CoboticDrive, rig: Rig, values: Mapping[str, Any], errors: Mapping[str, Array]
    ) -> np.ndarray:
        """Expected readings; see `predict`. (..., n, m)"""
        weighed, which = np.unique(self.mass, return_inverse=True)
        exact = np.zeros(1)
        off = [np.asarray(errors.get(_of_mass(mass), exact)) for mass in weighed.tolist()]
        masses = np.concatenate(np.broadcast_arrays(exact, *off), axis=-1)[..., 1 + which]
        others = {name: value for name, value in errors.items() if not name.startswith(OF_MASS)}
        found = predict(drive, rig, self, values, Errors(**others, mass=masses))
        return np.stack(np.broadcast_arrays(*found[: len(self.signals)]), axis=-1)

    def whitening(self, drive: CoboticDrive, rig: Rig) -> np.ndarray:
        """Whitening matrices from encoder counts, noise, and the resolution of the steering angle, which affects travel, current
        and voltage together. (n, m, m)"""
        known, width = known_values(drive), len(self.signals)
        turned = 1e-7
        more, less = (self.expected(drive, rig, known, {"steering_zero": way * turned}) for way in (1.0, -1.0))
        by_angle = np.nan_to_num((more - less) / (2.0 * turned))
        mean = 1.0 / np.sqrt(np.maximum(rig.sample_rate * self.duration, 1.0))
        by_cylinder = np.nan_to_num(predict(drive, rig, self, known).link_travel / self.cylinder_angle)
        travel = _COUNTED * np.hypot(rig.link_resolution, by_cylinder * rig.cylinder_resolution)
        own = np.stack([travel, rig.current_noise * mean, rig.voltage_noise * mean][:width], axis=-1)
        own = np.maximum(own, 1e-12)  # keeps weights finite for a rig without noise
        angle = rig.steering_resolution / math.sqrt(12.0) * by_angle
        covariance = own[:, :, None] ** 2 * np.eye(width) + angle[:, :, None] * angle[:, None, :]
        found = np.linalg.inv(np.linalg.cholesky(covariance))
        found[~self.pressed, 0, :] = 0.0  # a lifted wheel moves no link
        return found

    def check(self) -> None:
        """Refuse impossible settings, such as a negative mass.

        Raises
        ------
        InputError
            Lists the faults, one line each, with line number, value found and permitted range.
        """
        faults = {row: said for row in range(len(self)) if (said := _setting_fault(self, row)) is not None}
        if faults:
            refuse(self, faults)


def _of_mass(mass: float) -> str:
    """Name of the error of a mass."""
    return f"{OF_MASS}{mass!r}"


def read(file: str | Path, columns: Mapping[str, str] | None = None) -> RigData:
    """Read runs from a file of columns: CSV with commas or semicolons, or any other that recordings may have.

    Parameters
    ----------
    file : str or Path   Header with column names and units, such as ``mass [kg]``, then one line per run; one with an empty
        cell is left out.
    columns : mapping    Headings by name of a column, where they differ: ``{"mass": "m [kg]"}``.

    Returns
    -------
    RigData

    Raises
    ------
    InputError
        If the file cannot be read, a column or unit is missing or wrong, or a cell is not a number.
    """
    found = read_named(file, COLUMNS, _REQUIRED, columns)
    arrays: dict[str, Any] = {"motor_voltage": None, **found.columns}
    return RigData(**arrays, lines=tuple(found.lines.tolist()), name=str(file), empty=found.empty)


def _setting_fault(data: RigData, row: int) -> str | None:
    duration, mass, preload = (float(getattr(data, name)[row]) for name in ("duration", "mass", "preload"))
    angle = float(data.steering_angle[row])
    if duration <= 0:
        return f"duration must be > 0 s, got {plain(duration)}"
    if mass < 0 or preload < 0:
        name, value = ("mass", mass) if mass < 0 else ("preload", preload)
        return f"{name} must be >= 0, got {plain(value)}"
    if abs(angle) >= 0.5 * math.pi:
        return f"steering_angle must be within -90 and 90 deg, got {plain(math.degrees(angle))} deg"
    return None


def known_values(drive: CoboticDrive) -> dict[str, float]:
    """The parameters as the study has them."""
    motor, gear = drive.motor, drive.gearhead
    require(drive.transmission.wheels == 1, "transmission.wheels", drive.transmission.wheels, "1 on a bench")
    groups = drive.transmission.groups(drive.cylinder_speed)
    nominal = motor.friction_torque + gear.coulomb_friction(motor.continuous_torque) + unloaded_bearings(drive)
    return {
        "creep_stiffness": float(groups.creep_stiffness),
        "rolling_torque": float(groups.rolling_torque),
        "bearing_torque": float(groups.bearing_torque),
        "guideway_friction": float(drive.guideway.friction_force(drive.transmission.preload)),
        "nominal_torque": float(nominal),
        "torque_constant": motor.torque_constant,
        "resistance": motor.resistance,
    }


def unloaded_bearings(drive: CoboticDrive) -> float:
    """Friction torque of the cylinder's bearings with the wheel lifted off, at the motor; 0 where none are stated. [N m]"""
    bearings = drive.cylinder_bearings
    return 0.0 if bearings is None else _alone(drive, bearings) / drive.gearhead.ratio


def _alone(drive: CoboticDrive, bearings: CylinderBearings) -> float:
    """The same at the cylinder. [N m]"""
    found = bearings.midway().unloaded(drive.cylinder_speed).torque
    assert found is not None
    return found


def _loaded_bearings(
    drive: CoboticDrive, preload: Array, torque: Array, force: Array, speed: Array, rolling: Array
) -> Array:
    """Torque on the cylinder that a pressed wheel adds to the friction of its bearings, which the study knows. [N m]"""
    bearings = drive.cylinder_bearings
    if bearings is None:
        return 0.0
    bearings = bearings.midway()
    wheel = WheelLoad(preload=preload, torque=torque, force=force, radius=drive.transmission.cylinder_radius)
    drag, _ = bearings.operate([wheel], speed, torque=torque, rolling=rolling)
    return drag - coulomb(speed, _alone(drive, bearings))


def load_on_wheel(
    drive: CoboticDrive, rig: Rig, data: RigData, guideway_friction: float, errors: Errors | None = None
) -> np.ndarray:
    """Force of the transmission on the link that lifts or lowers a mass against guideway friction.

    Parameters
    ----------
    guideway_friction : float   Friction at the study's preload; its preload-dependent part scales with that of the run. [N]

    Returns
    -------
    (n,) float   [N]

    Source: faulring2006, Eq 18.
    """
    errors = errors or Errors()
    guide = drive.guideway
    share = data.preload * (1.0 + errors.preload) / drive.transmission.preload
    follows = guide.follows(drive.transmission.preload)
    size = guideway_friction * (1.0 - follows + follows * share)
    return (data.mass + errors.mass) * rig.gravity + coulomb(data.link_travel, size)


def _law_on_patch(known: RotaryLinearIVT) -> CreepLaw:
    """The creep law of the patch, as the element that is fitted has measured values and no geometry."""
    contact = known.contact
    return known.creep_law if contact is None else creep.pinned(known.creep_law, contact.axis_ratio, contact.poisson)


def _growth(element: RotaryLinearIVT, preload: Array, speed: float) -> dict[str, Array]:
    """Loss factors relative to the study's preload; for bearings by their model, if given."""
    share = preload / element.preload
    found = {name: share**power for name, power in PRELOAD_POWERS.items()}
    known = element.groups(speed)
    if element.geometry is not None and known.bearing_torque > 0:
        torque = element.geometry.axle_friction(
            wheel_radius=element.wheel_radius,
            preload=preload,
            slip_force=share * known.slip_force,
            surface_speed=element.cylinder_radius * abs(speed),
        )
        found["bearing_torque"] = torque / known.bearing_torque
    return found


def predict(
    drive: CoboticDrive, rig: Rig, data: RigData, values: Mapping[str, float], errors: Errors | None = None
) -> Readings:
    """Predict the readings of every run from its settings and the cylinder angle.

    Parameters
    ----------
    drive : CoboticDrive   Drive of the study: dimensions, gearing, creep law.
    rig : Rig
    data : RigData         Settings; of the measured values only the cylinder angle and the direction of travel.
    values : mapping       Values of all `PARAMETERS`, in SI.
    errors : Errors        Session errors; None for zero.

    Returns
    -------
    Readings   Zero travel with the wheel lifted off; nan where the wheel would slip.

    Source: `RotaryLinearIVT.operate` and `load_on_wheel`.
    """
    errors = errors or Errors()
    known, pressed = drive.transmission, data.pressed
    preload: Any = np.where(pressed, data.preload, known.preload) * (1.0 + errors.preload)
    growth = _growth(known, preload, drive.cylinder_speed)
    groups: dict[str, Any] = {name: values[name] * factor for name, factor in growth.items()}
    element = turning_as(
        RotaryLinearIVT(
            cylinder_radius=known.cylinder_radius,
            wheel_radius=known.wheel_radius,
            preload=preload,
            friction=known.friction_limit(drive.cylinder_speed),
            creep_law=_law_on_patch(known),
            **groups,
        ),
        known,
    )
    speed = data.cylinder_angle / data.duration
    force = load_on_wheel(drive, rig, data, values["guideway_friction"], errors)
    point = element.operate(
        cylinder_speed=speed,
        steering_angle=np.where(pressed, data.steering_angle + errors.steering_zero, 0.0),
        link_force=np.where(pressed, force, 0.0),
    )
    ratio = drive.gearhead.ratio
    rubbing = _loaded_bearings(drive, preload, point.torque, force, speed, element.groups(speed).rolling_force)
    passed = np.where(pressed, point.torque + rubbing, 0.0) / ratio
    torque = passed + coulomb(speed, values["nominal_torque"]) + drive.gearhead.load_friction(speed * ratio, passed)
    current = torque / values["torque_constant"]
    return Readings(
        link_travel=np.where(pressed, point.link_speed * data.duration, 0.0),
        motor_current=(1.0 + errors.current_gain) * current,
        motor_voltage=values["resistance"] * current + values["torque_constant"] * speed * ratio,
    )
