"""Bandwidths of the loops of a geared drive whose load hangs on its motor by compliant parts.

The loops measure the motor there, and their gains belong to the inertia of motor and load together. Above the resonance of the
load on the compliance the motor moves alone, and the sampled loop is faster there than its bandwidth by the ratio of the
inertias. Beyond some bandwidth it therefore drives the resonance instead of damping it. Where a bandwidth is not stated, it is
at most the share `MARGIN` of that.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from infinivar._core.fields import given
from infinivar.drivetrain.control import LINK_BANDWIDTH, SPEED_BANDWIDTH
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.graphs import output_start
from infinivar.drivetrain.graphs.compliances import damping_of_gear, damping_of_stage, rotor_inertia
from infinivar.units import plain

MARGIN = 0.5
"""Default bandwidth over the largest with which the loops are stable."""

_LEAST = 1e-3
"""Smallest bandwidth tried, relative to the default one."""

_TRIED = np.geomspace(_LEAST, 1.0 / MARGIN, 80) * SPEED_BANDWIDTH
"""Bandwidths tried, each 1.1 times the one before. [Hz]"""

_ROUNDING = 1e-12


class Line(NamedTuple):
    """Masses in a row with springs and dampers between them, from the motor to the load; all as of the load."""

    masses: tuple[float, ...]
    names: tuple[str, ...] = ()
    stiffness: tuple[float, ...] = ()
    damping: tuple[float, ...] = ()

    def between(self, values: Sequence[float]) -> np.ndarray:
        """Forces on the masses per displacement, or speed, of each, for values of the springs or dampers."""
        found = np.zeros((len(self.masses), len(self.masses)))
        for i, value in enumerate(values):
            found[i : i + 2, i : i + 2] += value * np.array([[-1.0, 1.0], [1.0, -1.0]])
        return found

    def frequencies(self) -> tuple[float, float]:
        """Lowest frequency with the motor locked, and with a free motor. [Hz]"""
        turning = -self.between(self.stiffness) / np.array(self.masses)[:, None]
        held = np.min(np.real(np.linalg.eigvals(turning[1:, 1:])))
        free = np.sort(np.real(np.linalg.eigvals(turning)))[1]
        return _hertz(float(held)), _hertz(float(free))


def _hertz(square: float) -> float:
    return math.sqrt(max(square, 0.0)) / (2.0 * math.pi)


class Loops(NamedTuple):
    """Bandwidths of the speed loop and of the position loop, and the largest of the speed loop that is stable. [Hz]"""

    speed: float
    link: float
    stable: float
    line: Line

    @property
    def unstable(self) -> bool:
        """Whether the loops drive a resonance."""
        return self.speed > self.stable

    @property
    def slowed(self) -> bool:
        """Whether a resonance is why the speed loop is slower than that of a rigid drive."""
        return self.speed < SPEED_BANDWIDTH and self.speed <= 1.01 * MARGIN * self.stable < SPEED_BANDWIDTH

    def __str__(self) -> str:
        """What the resonance means for the loops; "" if nothing."""
        if not (self.unstable or self.slowed):
            return ""
        locked, free = self.line.frequencies()
        parts = " and ".join(self.line.names)
        what = f"resonance of the {parts} at {plain(free, 3)} Hz ({plain(locked, 3)} Hz with the motor locked)"
        most = plain(self.stable, 2)
        if self.slowed:
            return f"the speed loop is slowed to {plain(self.speed, 2)} Hz: above {most} Hz it would excite the {what}"
        way = f"set control.speed_bandwidth below {most} Hz, or raise" if self.stable else "raise"
        return (
            f"caution: the speed loop of {plain(self.speed, 3)} Hz is unstable, as it excites the {what}; {way} "
            "control.sample_rate"
        )


def of(drive: ConventionalDrive, position: float, mass: float, *, imposed: bool = False) -> Loops:
    """Bandwidths of the loops of a drive, as stated or by default.

    Parameters
    ----------
    drive : ConventionalDrive
    position, mass : float   Of the load at the start, which a linkage depends on. [m] or [rad], [kg] or [kg m^2]
    imposed : bool           Whether another agent moves the load.
    """
    control = drive.control
    carried = output_start.carried(drive.output, position, mass)
    line = _line(drive, math.inf if imposed else carried)
    if len(line.masses) == 1:
        usual = given(control.speed_bandwidth, SPEED_BANDWIDTH), given(control.link_bandwidth, LINK_BANDWIDTH)
        return Loops(*usual, math.inf, line)
    period = 1.0 / control.sample_rate
    total = carried + (rotor_inertia(drive) + drive.gear_output_inertia) / float(drive.stage.travel_per_radian) ** 2
    ahead, felt = _sampled(line, period)

    def stable(speed: float) -> bool:
        return _growth(ahead, felt, total, period, speed, _link(drive, speed)) <= 1.0 + _ROUNDING

    most = max(itertools.takewhile(stable, _TRIED.tolist()), default=0.0)
    largest = most if most < _TRIED[-1] else math.inf
    speed = given(control.speed_bandwidth, min(SPEED_BANDWIDTH, max(MARGIN * largest, float(_TRIED[0]))))
    return Loops(speed, _link(drive, speed), largest, line)


def _link(drive: ConventionalDrive, speed: float) -> float:
    """Bandwidth of the position loop: as stated, or slower than the speed loop by the ratio of the defaults. [Hz]"""
    return given(drive.control.link_bandwidth, LINK_BANDWIDTH * min(1.0, speed / SPEED_BANDWIDTH))


def _line(drive: ConventionalDrive, carried: float) -> Line:
    """Rotor, gear output and load, as far as they are not rigid with each other."""
    squared = float(drive.stage.travel_per_radian) ** 2
    gear, stage = given(drive.gearhead.stiffness, 0.0) / squared, float(given(drive.stage.stiffness, 0.0))
    output, rotor = drive.gear_output_inertia / squared, rotor_inertia(drive) / squared
    twisted = [("gearhead", gear, damping_of_gear(drive) / squared, output)] if gear else []
    rotor += 0.0 if gear else output
    if stage:
        twisted.append((drive.stage.title, stage, damping_of_stage(drive), carried))
    elif gear:
        twisted[0] = (*twisted[0][:-1], output + carried)
    moving = [each for each in twisted if each[-1]]
    if not moving:
        return Line((rotor + (0.0 if stage or gear else carried),))
    names, stiffness, damping, masses = zip(*moving, strict=True)
    return Line((rotor, *masses), names, stiffness, damping)


def _sampled(line: Line, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Change of positions and speeds over a sample, by themselves and by a force on the motor that is held.

    Source: franklin1998, zero-order hold.
    """
    from scipy.linalg import expm

    count = len(line.masses)
    yields = np.array([1.0 / mass for mass in line.masses])
    system = np.zeros((2 * count + 1, 2 * count + 1))
    system[:count, count:-1] = np.eye(count)
    system[count:-1, :count] = line.between(line.stiffness) * yields[:, None]
    system[count:-1, count:-1] = line.between(line.damping) * yields[:, None]
    system[count, -1] = yields[0]
    found = expm(system * period)
    return found[:-1, :-1], found[:-1, -1]


def _growth(ahead: np.ndarray, felt: np.ndarray, total: float, period: float, speed: float, link: float) -> float:
    """Largest growth over a sample of the linear loops, which measure the motor; at most 1 if they are stable.

    Source: `infinivar.drivetrain.control.one_axis.ConventionalController`, without feedforward.
    """
    count = len(ahead) // 2
    pole = 2.0 * math.pi * speed
    proportional, integral = 2.0 * pole * total, pole * pole * total * period
    error = np.zeros(2 * count + 1)
    error[0], error[count] = -2.0 * math.pi * link, -1.0
    kept = np.zeros(2 * count + 1)
    kept[-1] = 1.0
    grown = kept + integral * error
    closed = np.zeros((2 * count + 1, 2 * count + 1))
    closed[:-1, :-1] = ahead
    closed[:-1] += np.outer(felt, proportional * error + grown)
    closed[-1] = grown
    return float(np.max(np.abs(np.linalg.eigvals(closed))))
