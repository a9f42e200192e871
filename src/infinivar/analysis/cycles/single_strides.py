"""Energy of the strides that a recording averages: of their mean cycle, and of each stride as it was recorded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infinivar._core.described import at, derived, reported
from infinivar._core.result import Result, result
from infinivar.drivetrain.drive import Drive, followed, orders_of
from infinivar.motion.duty_cycles import DutyCycle, check_duty_cycle
from infinivar.motion.recordings import Recording
from infinivar.units import percent, plain


@result
class StrideEnergies(Result):
    """Energy from the supply in the mean cycle and in single strides, windings at 25 °C.

    Attributes
    ----------
    mean_cycle : float      Energy of the mean cycle. [J]
    singles : (k,) float    Energy of each stride, as part of the run of all strides; as a cycle of its own if the
                            recording states the end of each stride. [J]
    """

    mean_cycle: float = reported("J")
    singles: np.ndarray = reported("J", key="strides_J")

    _also = (at("singles.size", key="strides"),)

    @derived("J", key="mean_of_strides_J")
    def mean(self) -> float:
        """Mean of the energies of single strides. [J]"""
        return float(np.mean(self.singles))

    @derived("J", key="deviation_of_strides_J")
    def deviation(self) -> float:
        """Standard deviation of the energies of single strides. [J]"""
        return float(np.std(self.singles, ddof=1)) if self.singles.size > 1 else 0.0

    @property
    def verdict(self) -> str:
        """Both energies in one clause."""
        off = self.mean / self.mean_cycle - 1.0 if self.mean_cycle else float("nan")
        share = "" if np.isnan(off) else f" ({percent(off, 1, '+')})"
        return (
            f"{self.singles.size} single strides {plain(self.mean, 3)} J ± {plain(self.deviation, 2)} J on average, their mean "
            f"cycle {plain(self.mean_cycle, 3)} J with cold windings{share}"
        )


def stride_energies(drive: Drive, duty: DutyCycle) -> StrideEnergies | None:
    """Energy of the mean cycle of a recording beside the energies of its single strides.

    The mean cycle lacks the differences between strides. A loss that grows with the square of a quantity, as copper loss with
    that of the current, is lower in the mean cycle than in the strides on average, by the variance of that quantity. A power
    proportional to the quantity, and all of the energy if the strides are equal, is the same in both.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive
    duty : DutyCycle

    Returns
    -------
    StrideEnergies   None if the motion is not the average of strides.

    Raises
    ------
    ParameterError
        If the drive lacks a value that motion requires.
    """
    check_duty_cycle(duty)
    motion = duty.motion
    run = motion.as_run if isinstance(motion, Recording) else None
    if not isinstance(motion, Recording) or motion.averaged is None or run is None:
        return None
    mean = float(np.sum(_drawn(drive, duty)))
    if motion.averaged.separate:
        singles = np.array([np.sum(_drawn(drive, replace(duty, motion=one))) for one in motion.as_cycles])
        return StrideEnergies(mean_cycle=mean, singles=singles)
    whole = replace(duty, motion=run)
    drawn = _drawn(drive, whole)
    spent = np.concatenate([[0.0], np.cumsum(drawn)])
    edges = motion.averaged.edges - motion.averaged.edges[0]
    passed = np.interp(edges, np.arange(drawn.size + 1) * (whole.period / drawn.size), spent)
    return StrideEnergies(mean_cycle=mean, singles=np.diff(passed))


def _drawn(drive: Drive, duty: DutyCycle) -> np.ndarray:
    """Energy from the supply in each of the equal steps of a motion. [J]"""
    over = duty.instants(orders=orders_of(drive))
    power = np.broadcast_to(followed(drive, over.course, load_mass=duty.moved_mass).power_in, over.time.shape)
    return power * (duty.period / over.time.size)
