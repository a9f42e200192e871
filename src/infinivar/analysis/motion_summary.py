"""What a recording holds, before any drive: columns, sampling, closure, cutoff, spectrum, power and strides."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.described import at, derived, reported
from infinivar._core.result import Frozen, Result, result
from infinivar.axis import Axis
from infinivar.errors import InputError, require
from infinivar.motion.files.agreement import one_course
from infinivar.motion.files.table import RecordedTable
from infinivar.motion.recordings import CUTOFF, Recording
from infinivar.motion.smoothing import DRIFT, GAP, lowest_cutoff, open_end
from infinivar.motion.spectrum import Density, density
from infinivar.motion.strides import Strides, strides_of
from infinivar.motion.two_files import read_recording
from infinivar.units import plain, rounded_up

_PASSED = 0.999
"""Share of the speed's power that an advised cutoff passes unchanged."""
_FIRST = 3
"""First values shown of each column."""
_TIME = ("time",)
_PER_STRIDE = ("work_on_load_per_stride_J", "work_of_load_per_stride_J")
_SAMPLES = 4000
"""Fewest instants at which the smoothed motion is evaluated."""
_PER_WAVE = 40


@result
class Sampling(Frozen):
    """Sampling of a recording.

    Attributes
    ----------
    rows : int                  Number of rows.
    duration : float            From the first row to the last. [s]
    rate : float                Rows per second, from the median step. [Hz]
    jitter : float              Standard deviation of the steps without gaps, over the median step. [-]
    gaps : tuple                Start and length of each gap: a step more than 5 times the median. [s], [s]
    """

    rows: int = reported()
    duration: float = reported("s")
    rate: float = reported("Hz")
    jitter: float = reported("1")
    gaps: tuple[tuple[float, float], ...] = reported("s")

    @classmethod
    def of(cls, time: np.ndarray) -> Sampling:
        """Sampling of given times, which increase. [s]"""
        steps = np.diff(time)
        median = float(np.median(steps))
        wide = steps > GAP * median
        return cls(
            rows=len(time),
            duration=float(time[-1] - time[0]),
            rate=1.0 / median,
            jitter=float(np.std(steps[~wide])) / median,
            gaps=tuple((float(time[place]), float(steps[place])) for place in np.flatnonzero(wide)),
        )


@result
class Spectrum(Frozen):
    """Spectrum of a recorded position, or of the position that a recorded speed gives.

    Attributes
    ----------
    frequency, power : (n,) float   Power spectral density without the straight line through the ends. [Hz], [m^2/Hz, rad^2/Hz]
    floor : float                   Noise floor: median of the upper half of the frequencies. [m^2/Hz, rad^2/Hz]
    above : float                   Share of the motion's power above the cutoff. [-]
    above_speed : float             Share of the speed's power above the cutoff. [-]
    removed_speed : float           Share of the speed's power above the noise floor that the smoothing removes. [-]
    passed : float                  Frequency up to which 99.9 % of the speed's power above the noise floor lies. [Hz]
    """

    frequency: np.ndarray
    power: np.ndarray
    floor: float
    above: float = reported("1", key="power_above_cutoff")
    above_speed: float = reported("1", key="speed_power_above_cutoff")
    removed_speed: float = reported("1", key="speed_power_removed")
    passed: float = reported("Hz", key="motion_below_Hz")


@result
class MotionSummary(Result):
    """What was understood of a recording, and what it demands of any drive.

    Attributes
    ----------
    table           The recording as read: format, columns by role, remarks.
    motion          The recording, smoothed: one cycle if it closes, else a run.
    closed          Whether it ends where it starts, to 5 % of its range, and counts as one cycle.
    drift           Position of the end relative to the start. [m, rad]
    sampling        Rows, duration, rate, jitter and gaps.
    cutoff_from     How the cutoff was chosen.
    spectrum        Spectrum of the motion.
    strides         Strides found; None if there are none.
    no_strides      Why no strides were found; "" if there are some.
    time, position, speed, acceleration : (n,) float   The smoothed motion. [s], [m, rad] ...
    force : (n,) float   The smoothed force on the load; None if none is recorded. [N, N m]
    load_mass       Mass of the load, for the force that a drive must apply. [kg, kg m^2]
    """

    table: RecordedTable
    motion: Recording
    closed: bool = reported()
    drift: float = reported()
    sampling: Sampling = reported(key="*")
    cutoff_from: str = reported()
    spectrum: Spectrum = reported(key="*")
    strides: Strides | None
    no_strides: str
    time: np.ndarray = reported("s", dims=_TIME)
    position: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray = reported("m/s^2 or rad/s^2", dims=_TIME, variable="+")
    force: np.ndarray | None
    load_mass: float = reported()

    _also = (
        at("table.file", attribute="title"),
        at("table.format"),
        at("table.ignored"),
        at("table.remarks"),
        at("axis.rotary", key="about_a_joint"),
        at("motion.cutoff", "Hz"),
    )

    @property
    def axis(self) -> Axis:
        """Whether the motion is along a line or about a joint."""
        return self.table.axis

    @property
    def driving_force(self) -> np.ndarray:
        """Force of a drive on the load: inertia less the recorded force. [N, N m]"""
        return self.load_mass * self.acceleration - (0.0 if self.force is None else self.force)

    @derived("W", dims=_TIME, variable="+")
    def power(self) -> np.ndarray | None:
        """Power of a drive to the load; None if neither a force nor a mass is known. [W]"""
        return None if self.force is None and not self.load_mass else self.driving_force * self.speed

    @property
    def extremes(self) -> dict[str, tuple[float, float, float]]:
        """Lowest, highest and RMS of position (about its mean), speed, acceleration and force, by field."""
        found = {"position": self.position, "speed": self.speed, "acceleration": self.acceleration}
        if self.force is not None:
            found["force"] = self.force
        return {
            name: (
                float(np.min(values)),
                float(np.max(values)),
                float(np.sqrt(np.mean((values - (np.mean(values) if name == "position" else 0.0)) ** 2))),
            )
            for name, values in found.items()
        }

    @property
    def work(self) -> tuple[float, float]:
        """Work of a drive on the load while driving, and of the load on a drive while braking; nan if unknown. [J]"""
        power = self.power
        if power is None:
            return float("nan"), float("nan")
        lasts = self.sampling.duration
        return float(np.mean(np.clip(power, 0.0, None))) * lasts, float(np.mean(np.clip(-power, 0.0, None))) * lasts

    @property
    def one_cycle(self) -> bool:
        """Whether the recording is one cycle, rather than several strides or a run."""
        return self.closed and self.strides is None

    @property
    def work_per_stride(self) -> tuple[float, float] | None:
        """Work as `work`, of a stride on average over the recording; None without strides or power. [J]"""
        if self.strides is None or self.power is None:
            return None
        share = self.strides.period / self.sampling.duration
        given, taken = self.work
        return share * given, share * taken

    @derived("1")
    def resting(self) -> float:
        """Share of the time at rest. [-]"""
        return float(np.mean(self.speed == 0.0))

    @derived()
    def warnings(self) -> tuple[str, ...]:
        """Gaps, drift and slow intervals."""
        return self.motion.warnings

    @derived(attribute="verdict")
    def verdict(self) -> str:
        """What the recording is, in one sentence."""
        names = ", ".join(role.replace("_", " ") for role in self.table.columns)
        if self.strides is not None:
            kind = f"{len(self.strides)} strides of {plain(self.strides.period, 3)} s"
            kind += ", closes" if self.closed else ", does not close"
        else:
            kind = "one cycle that closes" if self.closed else "a run that does not close"
        return f"{names} in {self.sampling.rows} rows, {plain(self.sampling.duration, 4)} s: {kind}"

    @derived(dims=_TIME)
    def _histories(self) -> dict[str, np.ndarray]:
        """Position, speed and force, if one is recorded, by the names of their columns."""
        columns = zip(self.axis.columns, (self.position, self.speed, self.force), strict=True)
        return {name: values for name, values in columns if values is not None}

    @derived()
    def _columns(self) -> list[dict[str, Any]]:
        return [
            {
                "role": role,
                "heading": column.heading,
                "unit": column.unit,
                "first_values_SI": column.values[:_FIRST],
            }
            for role, column in self.table.columns.items()
        ]

    @derived(key="*")
    def _ranges(self) -> dict[str, dict[str, float]]:
        return {name: dict(zip(("lowest", "highest", "rms"), row, strict=True)) for name, row in self.extremes.items()}

    @derived(key="power")
    def _powers(self) -> dict[str, float] | None:
        if (power := self.power) is None:
            return None
        work = dict(zip(("work_on_load_J", "work_of_load_J"), self.work, strict=True))
        each = {} if self.work_per_stride is None else dict(zip(_PER_STRIDE, self.work_per_stride, strict=True))
        extremes = {"highest_W": float(np.max(power)), "lowest_W": float(np.min(power))}
        return {**extremes, "mean_W": float(np.mean(power)), **work, **each}

    @derived(key="strides")
    def _found(self) -> Strides | str:
        return self.no_strides if self.strides is None else self.strides


def inspect_motion(
    file: str | Path,
    *,
    columns: Mapping[str, str] | None = None,
    flip: Sequence[str] = (),
    cycle_time: float | None = None,
    body_mass: float | None = None,
    window: Sequence[float] | None = None,
    sample_rate: float | None = None,
    cutoff: float | None = None,
    resolution: float | None = None,
    stride_time: float | None = None,
    load_mass: float = 0.0,
    closed: bool | None = None,
    force_file: str | Path | None = None,
    force_columns: Mapping[str, str] | None = None,
) -> MotionSummary:
    """Read a recording and show what was understood of it.

    Parameters
    ----------
    file : str or Path
    columns : mapping       Heading of each column to read, by role; by default the headings of the file decide.
    flip : sequence         Roles of columns whose sign is reversed.
    cycle_time : float      Time of a cycle, for a file without times. [s]
    body_mass : float       For forces or moments per kilogram. [kg]
    window : (2,) float     Start and end in the time of the file; all of it by default. [s]
    sample_rate : float     Rate to resample to, by linear interpolation; the file's own by default. [Hz]
    cutoff : float          Frequency above which the motion is smoothed; 10 Hz by default, as in a study. [Hz]
    resolution : float      Deviation within which the load counts as at rest; estimated by default. [m, rad]
    stride_time : float     Approximate time of a stride; by default the period of the motion. [s]
    load_mass : float       Mass or moment of inertia of the load; 0 by default. [kg, kg m^2]
    closed : bool           Whether it is one cycle; by default, if it ends where it starts to 5 % of its range.
    force_file : str or Path   Second file, with the force or moment, where the first has only the motion.
    force_columns : mapping    As columns, of the second file.

    Returns
    -------
    MotionSummary

    Raises
    ------
    InputError
        If the file is invalid; the message names file, line and column.
    ParameterError
        If an argument is outside its range.
    """
    table = read_recording(
        file,
        force_file=force_file,
        force_columns=force_columns,
        columns=columns,
        flip=flip,
        body_mass=body_mass,
        cycle_time=cycle_time,
        window=window,
        sample_rate=sample_rate,
    )
    return summary(
        table,
        cutoff=cutoff,
        resolution=resolution,
        stride_time=stride_time,
        load_mass=load_mass,
        closed=closed,
    )


def summary(
    table: RecordedTable,
    *,
    cutoff: float | None = None,
    resolution: float | None = None,
    stride_time: float | None = None,
    load_mass: float = 0.0,
    closed: bool | None = None,
) -> MotionSummary:
    """Summarise a recording that is already read; arguments as of `inspect_motion`."""
    table = one_course(table)
    values = table.values
    _check_request(Sampling.of(values["time"]), cutoff, stride_time, load_mass)
    field = "position" if "position" in values else "speed"
    time = values["time"]
    drift, span = _drift(time, values[field], field)
    closes = abs(drift) <= DRIFT * span if closed is None else closed
    lowest = lowest_cutoff(float(time[-1] - time[0]), closed=closes)
    used, chosen = (CUTOFF, "default of recordings in a study") if cutoff is None else (cutoff, "as given")
    if cutoff is None and lowest > CUTOFF:
        used, chosen = lowest, "the lowest that so short a recording allows"
    within = {"angle_resolution" if table.axis.rotary else "resolution": resolution}
    # All strides are shown, so that a phase that starts again does not matter here.
    whole = {role: column for role, column in table.columns.items() if role != "phase"}
    strides, reason = _strides(table, stride_time)
    doubts = table.warnings
    if closed is None and not closes and strides is None:
        said = open_end("position", drift, span, table.axis)
        doubts = (*doubts, f"{table.file}: shown as a run; a study reads one cycle by default, but {said}")
    read = dataclasses.replace(table, columns=whole, warnings=doubts)
    motion = Recording.of(read, cutoff=used, closed=closes, **within)
    count = max(_SAMPLES, int(_PER_WAVE * used * motion.period))
    at = (np.arange(count) + 0.5) * (motion.period / count)
    position, speed, acceleration = motion.derivatives(at, 2)
    if closes and strides is None and stride_time is None and "no repeated stride" in reason:
        reason = "no stride repeats within the one cycle"
    return MotionSummary(
        table=table,
        motion=motion,
        closed=closes,
        drift=drift,
        sampling=Sampling.of(time),
        cutoff_from=chosen,
        # Where strides repeat, a cycle is not the whole recording, and its ends need not fit together.
        spectrum=_spectrum(density(time, values[field], field, closed=closes and strides is None), used),
        strides=strides,
        no_strides=reason,
        time=at,
        position=position,
        speed=speed,
        acceleration=acceleration,
        force=motion.push(at, 0)[0] if "force" in values else None,
        load_mass=load_mass,
    )


def _check_request(sampling: Sampling, cutoff: float | None, stride_time: float | None, load_mass: float) -> None:
    """Refuse options outside their ranges, among them a cutoff of which the recording holds nothing."""
    if cutoff is not None:
        most = 0.5 * sampling.rate
        require(cutoff <= most * (1.0 + 1e-9), "cutoff", plain(cutoff), f"<= {plain(most, 4)} Hz, half the sample rate")
    if stride_time is not None:
        require(stride_time > 0.0, "stride_time", plain(stride_time), "> 0", "s")
    require(load_mass >= 0.0, "load_mass", plain(load_mass), ">= 0")


def _drift(time: np.ndarray, values: np.ndarray, field: str) -> tuple[float, float]:
    """Position of the end relative to the start, and the range of the position."""
    if field == "speed":
        steps = 0.5 * (values[1:] + values[:-1]) * np.diff(time)
        values = np.concatenate([[0.0], np.cumsum(steps)])
    return float(values[-1] - values[0]), float(np.ptp(values)) or 1.0


def _strides(table: RecordedTable, stride_time: float | None) -> tuple[Strides | None, str]:
    """Strides, or why there are none."""
    try:
        found = strides_of(table, stride_time)
    except InputError as problem:
        return None, str(problem).removeprefix(f"{table.file}: ")
    return found, ""


def _spectrum(found: Density, cutoff: float) -> Spectrum:
    """Spectrum with the shares above a cutoff [Hz]."""
    over = found.frequency > cutoff * (1.0 + 1e-9)
    speed = found.power * found.turn**2
    return Spectrum(
        frequency=found.frequency,
        power=found.power,
        floor=found.floor,
        above=float(np.sum(found.power[over]) / (np.sum(found.power) or 1.0)),
        above_speed=float(np.sum(speed[over]) / (np.sum(speed) or 1.0)),
        removed_speed=found.removed(cutoff),
        passed=found.below(_PASSED),
    )


def advice(found: MotionSummary) -> tuple[str, ...]:
    """What to set in a study, as far as the recording decides it."""
    said = []
    spectrum, used = found.spectrum, found.motion.cutoff
    if found.sampling.rate > 4.0 * spectrum.passed and not 1.99 * spectrum.passed <= used <= 8.0 * spectrum.passed:
        said.append(
            f"99.9 % of the speed's power above the noise lies at or below {plain(spectrum.passed, 2)} Hz; a cutoff passes what "
            f'is up to half of it unchanged: cutoff = "{rounded_up(2.0 * spectrum.passed)} Hz" suffices'
        )
    if found.strides is not None:
        said.append('strides = "average" gives their mean cycle')
    if not found.closed:
        said.append("closed = false gives the energy over the run")
    if found.power is None:
        said.append("no force is recorded: set load_mass for the power")
    return tuple(said)
