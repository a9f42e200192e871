"""How long and how far a battery lasts in a task or on a path of a machine."""

from __future__ import annotations

import math

import numpy as np

from infinivar._core.described import reported
from infinivar._core.result import Result, result
from infinivar.motion.vectors import TRANSLATIONS
from infinivar.parts.battery import Battery
from infinivar.units import plain, show_in


@result
class Endurance(Result):
    """What the usable energy of a battery is enough for, at one mean power; infinite where nothing is drawn.

    Attributes
    ----------
    share : float      Of it that one path draws; nan of a task, which has no end. [-]
    time : float       [s]
    distance : float   Way of the end point. [m]
    """

    share: float = reported("1")
    time: float = reported("s")
    distance: float = reported("m")

    @property
    def words(self) -> str:
        """In words, without names."""
        if not math.isfinite(self.time):
            return "battery not discharged" if self.time > 0.0 else ""
        far = f", {show_in(self.distance, 'm', 'km', 3)}" if self.distance > 0.0 else ""
        lasts = f"lasts {show_in(self.time, 's', 'h', 3)}{far}"
        if math.isnan(self.share):
            return f"battery {lasts}"
        return f"{plain(100.0 * self.share, 3)} % of the battery, which {lasts}"


def endurance(
    battery: Battery | None, power: float, coordinates: tuple[str, ...], twist: np.ndarray, period: float = math.nan
) -> Endurance | None:
    """Endurance at a mean power of the cells; None without a battery.

    Parameters
    ----------
    battery : Battery or None
    power : float               [W]
    coordinates : d names       Of the twist.
    twist : (..., d) float      Of the end point at equal steps of time.
    period : float              Time of the path; nan of a task. [s]
    """
    if battery is None:
        return None
    places = [place for place, name in enumerate(coordinates) if name in TRANSLATIONS]
    speed = float(np.mean(np.linalg.norm(np.atleast_2d(twist)[:, places], axis=-1)))
    energy = battery.usable_energy
    time = energy / power if power > 0.0 else math.nan if math.isnan(power) else math.inf
    return Endurance(share=power * period / energy, time=time, distance=speed * time if speed else 0.0)
