"""Options of analyses that have a command; nothing heavy is imported here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from infinivar.errors import InputError
from infinivar.options import Options, amount, choice, flag, headings, option, quantities, words

if TYPE_CHECKING:
    from infinivar._core.engine import Engine


@dataclass(frozen=True, slots=True, kw_only=True)
class CompareOptions(Options):
    """What `compare` can be given beside the study."""

    command: ClassVar[str] = "compare"

    quick: bool = flag(
        "Print the verdicts only; skip report and files, sampled builds, cylinder speeds and the simulation check."
    )
    engine: Engine = choice(
        "What computes maps and samples: numpy, jax (compiled), or auto: jax for large ones if it is installed.",
        ("auto", "numpy", "jax"),
        default="auto",
    )
    default_spreads: bool = flag(
        "Where the study states no spreads, sample builds within default ones: measured model errors and assumed tolerances."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class SensitivityOptions(Options):
    """What `sensitivity` can be given beside the study, its drive, the outcome and the operating point."""

    command: ClassVar[str] = "sensitivity"

    duty: str | None = option("Of energy and temperature: name of the duty cycle, if the study has several.")
    method: str = choice(
        "How to compute derivatives: complex, jax or difference.", ("complex", "jax", "difference"), default="complex"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class StepOptions(Options):
    """What `steering_steps` can be given beside the study and its drive."""

    command: ClassVar[str] = "contact"

    angle: float | None = amount(
        'Step of the steering angle with --transient, such as "1 mrad".',
        "rad",
        usual="half the slip limit",
        metavar="ANGLE",
    )
    rate: float | None = amount(
        'Steering rate with --transient, such as "6 rad/s".', "rad/s", usual="at once", metavar="RATE"
    )


def _window(name: str, said: str) -> tuple[float, ...]:
    parts = quantities(name, said, "s")
    if len(parts) != 2:
        raise InputError(f'{name} {said!r} must be a start and an end, such as "2 s, 12 s"')
    return parts


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionOptions(Options):
    """What `inspect_motion` can be given beside the file and the mass of the load."""

    command: ClassVar[str] = "motion"

    columns: Mapping[str, str] | None = headings(
        'Headings of the columns by role, such as "time=t, angle=Knee angle [deg]"; by default, the headings decide.'
    )
    flip: tuple[str, ...] = words('Columns whose sign is reversed, such as "moment".', default=())
    cycle_time: float | None = amount('Time of a cycle, for a file without times, such as "1.1 s".', "s")
    body_mass: float | None = amount('Body mass, for moments per kilogram, such as "75 kg".', "kg")
    window: tuple[float, ...] | None = option(
        'Start and end in the time of the file, such as "2 s, 12 s".', read=_window, unit="s"
    )
    cutoff: float | None = amount('Cutoff of the smoothing, such as "8 Hz"; defaults to 10 Hz.', "Hz")
    stride_time: float | None = amount('Approximate time of a stride, such as "1.1 s".', "s")
    force_file: Path | None = option(
        "Second file, with the force or moment, where FILE has only the motion.",
        Path,
        of_files=True,
    )
    force_columns: Mapping[str, str] | None = headings(
        'As --columns, of the second file, such as "time=t, moment=M [N m]".'
    )
