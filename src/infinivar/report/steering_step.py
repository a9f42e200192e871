"""A step of the steering angle as text, and its figure as files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from infinivar.analysis.steering_step import SteeringStep
from infinivar.figures import steering_step, style
from infinivar.report.output import all_or_nothing
from infinivar.units import plain

_ROWS = 12
"""Distances in the table."""


def text(step: SteeringStep) -> str:
    """The step for a terminal: relaxation lengths, then forces and slip angles by distance."""
    turning = "at once" if step.rate is None else f"at {plain(step.rate, 3)} rad/s"
    setting = [
        ("step of the steering angle", f"{plain(1e3 * step.angle, 3)} mrad", f"{turning}; the link keeps its speed"),
        (
            "steady lateral force",
            f"{plain(step.steady_force, 3)} N",
            f"{step.steady_force / step.slip_force:.2f} of mu P",
        ),
        (
            "steady moment",
            f"{plain(1e3 * step.steady_moment, 3)} mN m",
            "of the contact on the wheel, against the turn",
        ),
        ("largest moment", f"{plain(1e3 * float(np.nanmax(step.moment)), 3)} mN m", "while turning"),
    ]
    lengths = [
        ("this step", step.relaxation_length, "the wheel turns, which is spin"),
        ("small steps", step.linear_relaxation_length, "linear theory, at once: the patch sticks"),
        ("lateral creep alone", step.creep_relaxation_length, "same slip angle without a turn: the link changes speed"),
        ("  small steps", step.linear_creep_relaxation_length, "linear theory"),
    ]
    blocks = [
        f"{step.title}\n{'=' * len(step.title)}",
        step.verdict,
        "\n".join(["Step", *(f"  {name:<28} {value:>10}   {how}" for name, value, how in setting)]),
        "\n".join(["Relaxation length: 63 % of the steady force", *(_length(step, *line) for line in lengths)]),
        "\n".join(_table(step)),
    ]
    return "\n\n".join(blocks) + "\n"


def _length(step: SteeringStep, name: str, length: float, how: str) -> str:
    of_patch = f"{length / step.half_length:.2f} a"
    time = f"{plain(1e3 * length / step.surface_speed, 3)} ms"
    return f"  {name:<28} {plain(1e3 * length, 3) + ' mm':>10} {of_patch:>8} {time:>10}   {how}"


def _table(step: SteeringStep) -> list[str]:
    """Force and slip angle at distances in equal steps."""
    reach = float(step.distance[-1])
    lines = [f"{'distance':>10} {'time':>9} {'slip angle':>12} {'force':>9} {'moment':>11}"]
    for distance in np.linspace(0.0, reach, _ROWS + 1):
        angle, force, moment = (
            float(np.interp(distance, step.distance, values)) for values in (step.slip_angle, step.force, step.moment)
        )
        lines.append(
            f"{1e3 * distance:7.3f} mm {1e3 * distance / step.surface_speed:6.3f} ms {1e3 * angle:7.3f} mrad "
            f"{force:7.2f} N {1e3 * moment:6.2f} mN m"
        )
    return lines


def save(steps: SteeringStep | Sequence[SteeringStep], directory: Path) -> list[Path]:
    """Write the steps as text and their figures; returns the files.

    Raises
    ------
    InputError
        If the directory cannot be written to; nothing is changed then.
    """
    with all_or_nothing(directory, "contact-transient") as scratch:
        names = []
        for step in [steps] if isinstance(steps, SteeringStep) else steps:
            name = f"contact-{step.name}-transient"
            (scratch / f"{name}.txt").write_text(text(step), "utf-8")
            names.append(f"{name}.txt")
            names += [file.name for file in style.write(steering_step.draw_all(step), scratch / name)]
    return [directory / name for name in names]
