"""Options of the virtual rig and of a calibration; nothing heavy is imported here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from infinivar.options import Options, headings, numbers, option, words

RATIOS = (100.0, 50.0, 20.0, 8.0, 4.0, 2.0, 1.0)
LOADS = (0.15, 0.5)
"""Loads of the paper's experiment: forces on the link over the slip force. `RATIOS` are its reduction ratios."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RigOptions(Options):
    """What a session on the rig measures."""

    command: ClassVar[str] = "rig"

    ratios: tuple[float, ...] = numbers("Reduction ratios to measure.", default=RATIOS)
    loads: tuple[float, ...] = numbers("Loads to measure, as fractions of the slip force.", default=LOADS)
    preloads: tuple[float, ...] = numbers("Preloads to measure, as multiples of the study's preload.", default=(1.0,))


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrateOptions(Options):
    """What `calibrate` can be given beside the study, its drive and the data."""

    command: ClassVar[str] = "calibrate"

    parameters: tuple[str, ...] | None = words(
        "Parameters to fit; defaults to those that such data usually determine.", name="fit"
    )
    leave_out: Sequence[int] = option(
        "Line of the data file to exclude; repeat for more lines.",
        list[int],
        default=(),
    )
    creep_laws: tuple[str, ...] | None = words(
        "Creep laws to compare with the data, such as linear,polach; defaults to all."
    )
    columns: Mapping[str, str] | None = headings(
        'Headings by name of a column, where they differ, such as "mass=m [kg]".'
    )
