r"""Z-width: the softest and the stiffest impedance that a display can show to a named arm, over frequency.

Softest is free motion, of an admittance display with the least stable virtual mass. Stiffest is the stiffest stable wall.
Both keep a margin to the limit of stability. The impedance is that at the fundamental, see
`infinivar.displays.sampled_loop`; one point of it can be measured in a simulated sweep.

The envelopes compare magnitudes. What the user feels as mass is where the softest one rises with frequency, as stiffness
where the stiffest one falls.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.described import at, derived, finite, reported
from infinivar._core.fields import check_number
from infinivar._core.result import Result, result
from infinivar.displays.kinds import AdmittanceDisplay, Display
from infinivar.displays.plants import Held
from infinivar.displays.sampled_loop import (
    arm_impedance,
    check_moving,
    checked_frequency,
    impedance,
    run_in_time,
    sampled_loop,
)
from infinivar.displays.stability import WALLS, check_display, least_stable_mass, stiffest_wall
from infinivar.errors import ParameterError
from infinivar.motion.users import ArmModel
from infinivar.units import plain

_POINTS = 120
"""Frequencies by default, from `_LOWEST` to two fifths of the sample rate."""

_LOWEST = 0.1
"""[Hz]"""

_RINGING = 12.0
"""Time constants of the slowest decay before a sweep is measured: what is left is 6e-6."""

_MEASURED = 400
"""Samples measured in a sweep, at least."""

_WITHIN = 8
"""Steps in a sample of a sweep."""

_MOST = 200_000
"""Samples of a sweep, at most."""


_ALONG = ("frequency",)


@result
class ZWidth(Result):
    """Range of impedances that a display can show to an arm, as returned by `z_width`.

    Attributes
    ----------
    display, held : str           Kind of display; the arm.
    frequency : (n,)              [Hz]
    softest, stiffest : (n,) complex   Force over speed at the handle, at the fundamental. [N s m^-1]
    least_mass : float            Virtual mass of the softest one, the least stable one times the margin; nan for an impedance
        display, which feels as its reflected mass. [kg]
    wall : float                  Stiffness of the stiffest one, the stiffest stable one over the margin; at the handle, in series
        with structure and sensor. [N m^-1]
    least_force : float           Below which nothing is felt: noise of the force sensor, or friction without one. [N]
    counted : float               Wall damping beyond which encoder counts chatter at that wall; inf with an exact encoder, or if
        no friction is stated. [N s m^-1]
    limited : bool                Whether stability limits the wall; else it is the stiffest one searched.
    margin : float                [-]
    """

    display: str = reported(attribute="display")
    held: str = reported(attribute="held")
    frequency: np.ndarray = reported("Hz", dims=_ALONG, key="+")
    softest: np.ndarray
    stiffest: np.ndarray
    least_mass: float = reported("kg", convert=finite)
    wall: float = reported("N/m", attribute="wall_N_m")
    least_force: float = reported("N")
    counted: float = reported("N s/m", convert=finite, key="largest_wall_damping_by_counts_Ns_m")
    limited: bool = reported()
    margin: float = reported("1", attribute="margin")

    _also = tuple(
        at(
            f"{name}.{part}",
            "N s m-1",
            f"{part} part of the {name} impedance",
            _ALONG,
            variable=f"{name}_{part}",
            key=f"{name}_{part}_Ns_m",
        )
        for name in ("softest", "stiffest")
        for part in ("real", "imag")
    )

    @property
    def mass_felt(self) -> np.ndarray:
        """Mass whose impedance is the imaginary part of the softest one. (n,) [kg]"""
        return np.imag(self.softest) / (2.0 * np.pi * self.frequency)

    @property
    def stiffness_felt(self) -> np.ndarray:
        """Stiffness whose impedance is the imaginary part of the stiffest one. (n,) [N m^-1]"""
        return -np.imag(self.stiffest) * (2.0 * np.pi * self.frequency)

    def floor(self, speed: float) -> np.ndarray:
        """Softest impedance felt at an amplitude of the speed [m s^-1]: not below the least force over it. (n,) [N s m^-1]

        A constant friction f has the fundamental 4 f/pi; noise counts as it is.
        """
        check_number("speed", speed, "m/s", Gt(0))
        scale = 4.0 / math.pi if self.display == "ImpedanceDisplay" else 1.0
        return np.maximum(np.abs(self.softest), scale * self.least_force / speed)

    @property
    def decades(self) -> np.ndarray:
        """Width: decades between both magnitudes, negative where they have changed places. (n,) [-]"""
        return np.log10(np.abs(self.stiffest) / np.abs(self.softest))

    @derived("Hz", convert=finite)
    def crossing(self) -> float:
        """Lowest frequency at which the stiffest impedance is not above the softest one; inf if there is none. [Hz]"""
        below = np.flatnonzero(self.decades <= 0.0)
        return float(self.frequency[below[0]]) if below.size else math.inf

    @derived()
    def verdict(self) -> str:
        """One-sentence answer: mass and stiffness felt at the lowest frequency, and up to where there is a width."""
        lowest = plain(float(self.frequency[0]), 2)
        wall = f"{plain(float(self.stiffness_felt[0]) / 1e3, 3)} N/mm"
        end = plain(self.crossing, 3) if math.isfinite(self.crossing) else ""
        up_to = f"the width ends at {end} Hz" if end else f"no end up to {plain(float(self.frequency[-1]), 3)} Hz"
        limit = "" if self.limited else ", which stability does not limit"
        floor = f"; nothing is felt below {plain(self.least_force, 2)} N" if self.least_force else ""
        return (
            f"With {self.held}: {plain(float(self.mass_felt[0]), 3)} kg to {wall} at {lowest} Hz "
            f"({self.decades[0]:.1f} decades{limit}); {up_to}{floor}."
        )


def z_width(
    display: Display, held: Held, frequency: Sequence[float] | np.ndarray | None = None, *, margin: float = 1.1
) -> ZWidth:
    """Softest and stiffest impedance of a display that are stable with an arm.

    Parameters
    ----------
    display : AdmittanceDisplay or ImpedanceDisplay
        The wall is that of its virtual mass and damping; its wall stiffness does not matter.
    held : ArmModel or "free"   What is at the handle.
    frequency : (n,) float      Rising, below half of the sample rate; by default 0.1 Hz to 0.4 of the sample rate. [Hz]
    margin : float              Virtual mass over the least stable one, and stiffest stable wall over that shown, >= 1. [-]

    Returns
    -------
    ZWidth

    Raises
    ------
    ParameterError
        If an argument is out of range, no virtual mass is stable in free motion, or no wall with that of the display.
    """
    check_display(display)
    check_moving(held)
    check_number("margin", margin, "1", Ge(1))
    if frequency is None:
        frequency = np.geomspace(_LOWEST, 0.4 / display.period, _POINTS)
    frequency = checked_frequency(display, frequency)
    softest: Display = display.softest()
    least = math.nan
    if isinstance(softest, AdmittanceDisplay):
        least = margin * least_stable_mass(softest, held)
        if math.isnan(least):
            raise ParameterError(
                f"no virtual mass is stable in free motion with {_name(held)}: lower steering_bandwidth"
            )
        softest = replace(softest, virtual_mass=least)
    most = stiffest_wall(display, held)
    if math.isnan(most):
        what = (
            "a larger virtual_mass or virtual_damping"
            if isinstance(display, AdmittanceDisplay)
            else "less wall_damping"
        )
        raise ParameterError(f"no wall is stable with {_name(held)}: the display needs {what}")
    stiffest = replace(display, wall_stiffness=most / margin)
    return ZWidth(
        display=type(display).__name__,
        held=_name(held),
        frequency=frequency,
        softest=impedance(softest, frequency, held),
        stiffest=impedance(stiffest, frequency, held),
        least_mass=least,
        wall=display.at_handle(most / margin),
        least_force=display.least_force,
        counted=_counted(display, most / margin),
        limited=most < WALLS[1],
        margin=float(margin),
    )


def _counted(display: Display, wall: float) -> float:
    """Largest wall damping that encoder counts permit. [N s m^-1]

    Source: `required_friction`, solved for B.
    """
    count, friction = display.encoder_resolution, display.coulomb_friction
    return max(0.0, display.period * (friction / count - 0.5 * wall)) if count and friction else math.inf


def swept_impedance(display: Display, held: Held, frequency: float, *, force: float = 1.0) -> complex:
    """Impedance at one frequency, from the motion under a sinusoidal force in time.

    Parameters
    ----------
    display : AdmittanceDisplay or ImpedanceDisplay   Stable with what is at the handle.
    held : ArmModel or "free"
    frequency : float   [Hz]
    force : float       Amplitude, which does not matter to a linear loop. [N]

    Returns
    -------
    complex   Force over speed at the fundamental, without the arm. [N s m^-1]

    Raises
    ------
    ParameterError
        If an argument is out of range, or the loop is not stable or decays too slowly to be measured.

    Source: `run_in_time`; the fundamental by a Hann window.
    """
    check_display(display)
    check_moving(held)
    check_number("force", force, "N", Gt(0))
    (frequency,) = checked_frequency(display, [frequency])
    loop = sampled_loop(display, held)
    growth = loop.growth
    settling = _RINGING / -math.log(growth) if 0.0 < growth < 1.0 else (0.0 if growth == 0.0 else math.inf)
    window = max(_MEASURED, math.ceil(8.0 / (frequency * loop.period)))
    if settling + window > _MOST:
        raise ParameterError(
            f"display must settle within {_MOST - window} samples to be measured at {frequency:g} Hz; its largest growth per "
            f"sample is {growth:.9g}"
        )
    before = math.ceil(settling)
    samples, step, omega = before + window, loop.period / _WITHIN, 2.0 * math.pi * frequency
    starts = np.arange(samples * _WITHIN) * step
    pushes = force * np.sin(omega * np.stack([starts + step / 3.0, starts + step], axis=-1)).ravel()
    run = run_in_time(display, held, np.zeros(len(loop.plant.states)), samples, pushes, _WITHIN)
    kept = run.time >= run.time[before * _WITHIN] - 0.5 * step
    time, position = run.time[kept], run.state[kept, loop.plant.states.index("x_m")]
    share = (time - time[0]) / (time[-1] - time[0])
    basis = np.stack([np.sin(omega * time), np.cos(omega * time), np.ones_like(time)], axis=-1)
    weight = np.sin(np.pi * share)[:, None] ** 2
    sine, cosine, _ = np.linalg.lstsq(basis * weight, position * weight[:, 0], rcond=None)[0]
    # A sin + B cos is the imaginary part of (A + jB) exp(j omega t), as the force is that of the amplitude.
    speed = 1j * omega * (sine + 1j * cosine)
    return complex(force / speed - arm_impedance(held, np.array(omega)))


def _name(held: Held) -> str:
    return held.name if isinstance(held, ArmModel) else str(held)
