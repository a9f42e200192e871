"""Experiments on a virtual rig: the true motion of a drive in each run, and the readings with the errors of the sensors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.fields import given
from infinivar._core.result import Frozen, result
from infinivar.analysis.simulate import simulate
from infinivar.calibration import geared as geared_model
from infinivar.calibration.dynamometer import Dynamometer
from infinivar.calibration.options import LOADS, RATIOS
from infinivar.calibration.transmission import Errors, RigData
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import motor_side, needed
from infinivar.errors import ParameterError
from infinivar.limits import ROOT_MEAN_SQUARE
from infinivar.motion.forces import ConstantForce
from infinivar.motion.scenario import Scenario
from infinivar.parts.shaft_bearings import CylinderBearings
from infinivar.study.rig import Rig
from infinivar.transmission.rotary_linear import RotaryLinearIVT
from infinivar.units import plain

SETTLING = 2.5
"""Settling time before a run is measured; without saturation the speed loop's error falls by 1e-9 per second. [s]"""

_LEAST_SAMPLES = 20
_STICK_SPEED = 1e-5
"""Also smooths rolling; the relative error of creep is half the square of its share in the rolling speed, 1e-10. [m s^-1]"""


class Setting(NamedTuple):
    """One run as the experimenter sets it up. [rad], [kg], [N]"""

    steering_angle: float
    mass: float
    preload: float


class Truth(NamedTuple):
    """True values in the window of a run. [s], [rad], [m], [A], [V]"""

    duration: float
    cylinder_angle: float
    link_travel: float
    motor_current: float
    motor_voltage: float


@result
class Experiment(Frozen):
    """A session on the virtual rig.

    Attributes
    ----------
    data : sensor readings.
    errors : errors of settings and sensors in this session, unknown on a real rig.
    truth : true values of each run.
    left_out : infeasible runs with reasons.
    """

    data: RigData
    errors: Errors
    truth: tuple[Truth, ...]
    left_out: tuple[str, ...]


def protocol(
    drive: CoboticDrive,
    rig: Rig,
    *,
    ratios: Sequence[float] = RATIOS,
    loads: Sequence[float] = LOADS,
    preloads: Sequence[float] = (1.0,),
) -> tuple[Setting, ...]:
    """List the runs of an experiment: without preload, locked under each load, each ratio under each load in both directions.

    Parameters
    ----------
    ratios : sequence      Cylinder surface speed over link speed, > 0. [-]
    loads : sequence       Force on the link over slip force, 0 to 1. [-]
    preloads : sequence    Preloads over the drive's. [-]

    Returns
    -------
    tuple of Setting

    Raises
    ------
    ParameterError
        If a value is outside its range.

    Source: faulring2006, sections III-A (locked runs) and IV-B.
    """
    for name, values, right in (
        ("ratios", ratios, "> 0"),
        ("loads", loads, ">= 0 and < 1"),
        ("preloads", preloads, "> 0"),
    ):
        wrong = [value for value in values if not (0 <= value < 1 if name == "loads" else 0 < value < math.inf)]
        if wrong or not values:
            raise ParameterError(f"{name} must be {right}, got {wrong[0] if wrong else 'none'}")
    element = drive.transmission
    friction = element.friction_limit(drive.cylinder_speed)
    found = [Setting(0.0, 0.0, 0.0)]
    for share in preloads:
        preload = share * element.preload
        masses = [load * friction * preload / rig.gravity for load in loads]
        found += [Setting(0.0, mass, preload) for mass in masses if mass > 0]
        towards = -math.copysign(1.0, drive.cylinder_speed)
        found += [
            Setting(way * towards * math.atan(1.0 / ratio), mass, preload)
            for mass in masses
            for ratio in ratios
            for way in (1.0, -1.0)
        ]
    return tuple(found)


def experiment(
    drive: CoboticDrive,
    rig: Rig,
    settings: Sequence[Setting],
    *,
    seed: int = 0,
    exact: bool = False,
    simulated: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Experiment:
    """Run an experiment.

    Parameters
    ----------
    drive : CoboticDrive     Drive to measure, with the inertias that motion requires.
    rig : Rig                Sensors and accuracy of the settings.
    settings : sequence      Runs, from `protocol` or custom.
    seed : int               Seed of the random errors.
    exact : bool             Without errors, noise and counts.
    simulated : bool         Use the bond graph in time; else the steady solution, which is equal once settled, and fast.
    progress                 Called with the share done.

    Returns
    -------
    Experiment   Infeasible runs (wheel slip, supply voltage, travel too short) are excluded and reported.

    Raises
    ------
    ParameterError
        If the drive lacks a value that motion requires.

    Source: faulring2006, section IV-B.
    """
    random = np.random.default_rng(seed)
    masses = np.asarray([setting.mass for setting in settings])
    off: dict[str, Any] = {} if exact else _drawn(random, rig, masses)
    errors = Errors(**off)
    happen = _simulated if simulated else _steady
    kept, truths, left_out = [], [], []
    for place, setting in enumerate(settings):
        true = Setting(
            setting.steering_angle
            + errors.steering_zero
            + (0.0 if exact else _uniform(random, rig.steering_resolution)),
            setting.mass + float(np.broadcast_to(errors.mass, masses.shape)[place]),
            setting.preload * (1.0 + errors.preload),
        )
        found = happen(drive, rig, true)
        if isinstance(found, Truth):
            kept.append(place)
            truths.append(found)
        else:
            left_out.append(f"{_described(setting)}: {found}")
        if progress is not None:
            progress((place + 1) / len(settings))
    chosen = [settings[place] for place in kept]
    if not exact:
        errors = replace(errors, mass=np.broadcast_to(errors.mass, masses.shape)[kept])
    data = _read(random, rig, chosen, truths, errors, exact)
    return Experiment(data=data, errors=errors, truth=tuple(truths), left_out=tuple(left_out))


def _drawn(random: np.random.Generator, rig: Rig, masses: np.ndarray) -> dict[str, Any]:
    """Draw the errors of a session; each distinct mass has one error."""
    weighed, which = np.unique(masses, return_inverse=True)
    scales = np.where(weighed > 0, rig.mass_deviation, 0.0)
    return {
        "current_gain": rig.current_gain_deviation * random.standard_normal(),
        "preload": rig.preload_deviation * random.standard_normal(),
        "steering_zero": rig.steering_zero_deviation * random.standard_normal(),
        "mass": (scales * random.standard_normal(weighed.size))[which],
    }


def _uniform(random: np.random.Generator, width: float) -> float:
    return float(random.uniform(-0.5 * width, 0.5 * width))


def _described(setting: Setting) -> str:
    if setting.preload == 0:
        return "wheel lifted off"
    ratio = abs(1.0 / math.tan(setting.steering_angle)) if setting.steering_angle else math.inf
    way = (
        "locked"
        if ratio == math.inf
        else f"{plain(ratio, 3)}:1 at {plain(math.degrees(setting.steering_angle), 3)} deg"
    )
    return f"{way}, {plain(setting.mass, 3)} kg, {plain(setting.preload, 3)} N"


def supported(drive: CoboticDrive, preload: float) -> CylinderBearings | None:
    """The cylinder's bearings at a preload, with the wheel midway; with the wheel lifted off, those of the bare cylinder."""
    if drive.cylinder_bearings is None:
        return None
    bearings = drive.cylinder_bearings.midway()
    return bearings if preload > 0 else bearings.unloaded(drive.cylinder_speed)


def with_preload(element: RotaryLinearIVT, preload: float) -> RotaryLinearIVT:
    """The transmission with another preload; without preload, a lossless wheel represents a lifted one."""
    if preload > 0:
        return element.pressed(preload)
    free = {"rolling_torque": 0.0, "bearing_torque": 0.0, "creep_stiffness": float(element.groups(0.0).creep_stiffness)}
    return replace(element, geometry=None, steering_model="shear", **free)


def _steady(drive: CoboticDrive, rig: Rig, setting: Setting) -> Truth | str:
    """Steady solution of a run, or why it is infeasible."""
    element = with_preload(drive.transmission, setting.preload)
    weight = setting.mass * rig.gravity
    drag = drive.guideway.friction_force(setting.preload)
    speed = drive.cylinder_speed
    load = 0.0
    if setting.preload == 0:
        travelling, torque = 0.0, 0.0
    else:
        # The direction of travel sets the sign of friction; at small angles, creep under load may reverse it.
        for way in (1.0, -1.0):
            point = element.operate(
                cylinder_speed=speed, steering_angle=setting.steering_angle, link_force=weight + way * drag
            )
            load = weight + way * drag
            travelling, torque = float(point.link_speed), float(point.torque)
            if not travelling * way < 0:
                break
        else:
            return "guideway friction holds the load"
        if math.isnan(travelling):
            return "the wheel slips"
    held = supported(drive, setting.preload)
    rigged = replace(drive, transmission=element, cylinder_bearings=held, steering=None)
    torque += float(rigged.turned(speed, torque, load)[0])
    side = motor_side(drive.motor, drive.gearhead, output_torque=torque, output_speed=np.float64(speed))
    voltage, current = float(side.states["motor_voltage_V"]), float(side.states["motor_current_A"])
    if abs(voltage) > drive.motor.voltage:
        return f"the motor requires {plain(abs(voltage), 3)} V of {plain(drive.motor.voltage, 3)} V"
    duration = window(rig, travelling)
    if duration * rig.sample_rate < _LEAST_SAMPLES:
        return f"the link travels {plain(rig.travel, 3)} m in {plain(duration, 2)} s, too short to measure"
    return Truth(duration, speed * duration, travelling * duration, current, voltage)


def window(rig: Rig, link_speed: float) -> float:
    """Measuring time of a run at a link speed: whole samples within the travel. [s]"""
    longest = min(rig.longest_run, rig.travel / max(abs(link_speed), 1e-12))
    return math.floor(longest * rig.sample_rate * (1.0 + 1e-12)) / rig.sample_rate


def _simulated(drive: CoboticDrive, rig: Rig, setting: Setting) -> Truth | str:
    """Simulate a run with the bond graph and measure it once settled, or say why it is infeasible."""
    expected = _steady(drive, rig, setting)
    if isinstance(expected, str):
        return expected
    steering, contact = needed(drive.steering, "steering"), drive.transmission.contact
    if setting.preload == 0 and contact is not None:
        steering = replace(steering, patch_half_length=float(contact.patch.b))
    rigged = replace(
        drive,
        transmission=with_preload(drive.transmission, setting.preload),
        steering=steering,
        cylinder_bearings=supported(drive, setting.preload),
    )
    weight = setting.mass * rig.gravity
    samples = round(expected.duration * rig.sample_rate)
    run = simulate(
        rigged,
        Scenario(
            duration=SETTLING + expected.duration,
            output_step=expected.duration / samples,
            link="free",
            steering="held" if setting.steering_angle else "locked",
            steering_angle=setting.steering_angle or None,
            force=ConstantForce(size=-weight) if weight else None,
            load_mass=setting.mass or None,
            stick_speed=_STICK_SPEED,
        ),
    )
    if not run.complete:
        return run.verdict
    for event in run.events:
        if event.end > SETTLING and event.limit not in ROOT_MEAN_SQUARE:
            return f"{event.limit.words} exceeded"
    time, columns = run.columns["time_s"][-samples - 1 :], run.columns
    turned, current, voltage = (
        float(np.trapezoid(columns[name][-samples - 1 :], time))
        for name in ("cylinder_speed_rad_s", "motor_current_A", "motor_voltage_V")
    )
    duration = float(time[-1] - time[0])
    travel = float(columns["position_m"][-1] - columns["position_m"][-samples - 1]) if setting.preload else 0.0
    return Truth(duration, turned, travel, current / duration, voltage / duration)


def _read(
    random: np.random.Generator,
    rig: Rig,
    settings: Sequence[Setting],
    truths: Sequence[Truth],
    errors: Errors,
    exact: bool,
) -> RigData:
    """Sensor readings of the true values."""
    set_up = {name: np.asarray([getattr(s, name) for s in settings], dtype=float) for name in Setting._fields}
    true = {name: np.asarray([getattr(t, name) for t in truths], dtype=float) for name in Truth._fields}
    if not exact:
        mean = 1.0 / np.sqrt(np.maximum(rig.sample_rate * true["duration"], 1.0))
        noise = random.standard_normal((2, len(settings))) * mean
        true["motor_current"] = (1.0 + errors.current_gain) * true["motor_current"] + rig.current_noise * noise[0]
        true["motor_voltage"] = true["motor_voltage"] + rig.voltage_noise * noise[1]
        for name, count in (("cylinder_angle", rig.cylinder_resolution), ("link_travel", rig.link_resolution)):
            begin = random.uniform(0.0, 1.0, len(settings))
            true[name] = count * (np.floor(begin + true[name] / count) - np.floor(begin))
    readings: dict[str, Any] = {**set_up, **true}
    return RigData(**readings, lines=tuple(range(2, len(settings) + 2)), name="virtual rig")


def dynamometer(
    drive: ConventionalDrive,
    rig: Rig,
    *,
    speed: np.ndarray,
    torque: np.ndarray,
    noise: Mapping[str, float],
    values: Mapping[str, float] | None = None,
    geared: bool = True,
    seed: int | None = 0,
) -> Dynamometer:
    """Measure a drive at steady points.

    Parameters
    ----------
    drive : ConventionalDrive       Drive to measure.
    rig : Rig                       Deviations of the gains.
    speed, torque : (n,) float      At the gearhead's output, or at the motor if not `geared`. [rad s^-1], [N m]
    noise : mapping                 Standard deviation of each signal that is recorded. [SI]
    values : mapping                True values of parameters in place of the drive's.
    seed : int                      Seed of the random errors; None for a bench without errors.

    Returns
    -------
    Dynamometer
    """
    signals = tuple(noise)
    exact = Dynamometer(
        speed=speed,
        torque=torque,
        geared=geared,
        read=np.zeros((len(speed), len(signals))),
        signals=signals,
        lines=tuple(range(2, len(speed) + 2)),
        name="virtual bench",
    )
    true = {**geared_model.known_values(drive), **(values or {})}
    if seed is None:
        return replace(exact, read=exact.expected(drive, rig, true, {}))
    random = np.random.default_rng(seed)
    gains = {name: error.deviation * random.standard_normal() for name, error in exact.errors(rig).items()}
    # The drive moves the true torque; what stands in the file is the torque read.
    read = replace(exact, torque=torque * (1.0 + gains["torque"]))
    predicted = read.expected(drive, rig, true, gains)
    return replace(read, read=predicted + np.asarray(list(noise.values())) * random.standard_normal(predicted.shape))


def swing(
    drive: ConventionalDrive,
    rig: Rig,
    *,
    duration: float,
    rate: float,
    amplitudes: Mapping[float, float],
    noise: Mapping[str, float],
    values: Mapping[str, float] | None = None,
    seed: int = 0,
) -> dict[str, np.ndarray]:
    """Record a pendulum that a drive swings along a sum of sines.

    Parameters
    ----------
    drive : ConventionalDrive   Drive to measure.
    rig : Rig                   Pendulum, and deviations of current gain and mass.
    duration, rate : float      [s], [Hz]
    amplitudes : mapping        Amplitude by frequency. [rad], [Hz]
    noise : mapping             Standard deviations of "angle" [rad], "current" [A] and, if recorded, "voltage" [V].
    values : mapping            True values of parameters in place of the drive's.
    seed : int                  Seed of the random errors.

    Returns
    -------
    dict   Columns under headings with units.

    Source: `infinivar.drivetrain.drive.motor_side`.
    """
    random = np.random.default_rng(seed)
    mass, length = needed(rig.pendulum_mass, "pendulum_mass"), needed(rig.pendulum_length, "pendulum_length")
    inertia = given(rig.pendulum_inertia, mass * length**2)
    heavier = 1.0 + rig.mass_deviation / mass * random.standard_normal()
    time = np.arange(round(duration * rate) + 1) / rate
    angle, speed, acceleration = (np.zeros_like(time) for _ in range(3))
    for frequency, amplitude in amplitudes.items():
        turn = 2.0 * np.pi * frequency
        angle = angle + amplitude * np.sin(turn * time)
        speed = speed + amplitude * turn * np.cos(turn * time)
        acceleration = acceleration - amplitude * turn**2 * np.sin(turn * time)
    torque = heavier * (inertia * acceleration + mass * rig.gravity * length * np.sin(angle))
    torque = torque + given(drive.output_inertia, 0.0) * acceleration
    true = {**geared_model.known_values(drive), **(values or {})}
    side = motor_side(
        geared_model.motor_with(drive.motor, true),
        geared_model.gearhead_with(drive.gearhead, true),
        output_torque=torque,
        output_speed=speed,
        output_acceleration=acceleration,
    )
    gain = 1.0 + rig.current_gain_deviation * random.standard_normal()
    found = {
        "angle": ("rad", angle),
        "current": ("A", gain * np.asarray(side.states["motor_current_A"])),
        "voltage": ("V", np.asarray(side.states["motor_voltage_V"])),
    }
    read = {
        f"{name} [{unit}]": course + noise[name] * random.standard_normal(len(time))
        for name, (unit, course) in found.items()
        if name in noise
    }
    return {"time [s]": time, **read}
