"""Report of a reproduction: the paper's figures in order, each with its claims."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from infinivar._core.processes import apart
from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.paper.claims.claim import FACTOR, KINDS, Claim, PaperMachine, Range, turned
from infinivar.paper.claims.shaking import FARTHEST
from infinivar.paper.figures import FIGURES, missing_for
from infinivar.paper.reproduce import Reproduction
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json
from infinivar.report.tables import frame

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


def check_figure(figure: int | None) -> None:
    """Raise an error if a figure cannot be drawn.

    Raises
    ------
    InputError
        If the paper has no such figure, or a library that it needs is missing; the message says which.
    """
    if figure is None:
        return
    if figure not in FIGURES:
        raise InputError(f"--figure {figure}: must be from {min(FIGURES)} to {max(FIGURES)}")
    if missing := missing_for(figure):
        raise InputError(f"--figure {figure}: {missing}")


def left_out() -> str:
    """A sentence that lists the figures that cannot be drawn and what to install; empty if all can be drawn."""
    numbers = [number for number in FIGURES if missing_for(number)]
    if not numbers:
        return ""
    *first, last = map(str, numbers)
    return f"Figures {', '.join(first)} and {last} are left out. {missing_for(numbers[0])}"


def draw(reproduction: Reproduction, figure: int = 7) -> Figure:
    """Draw one of the paper's figures."""
    check_figure(figure)
    return FIGURES[figure].draw_all(reproduction.machine)


def table(reproduction: Reproduction) -> pd.DataFrame:
    """One row per claim: the paper's statement, the computed value and the verdict."""
    columns = [field.name for field in dataclasses.fields(Claim) if field.name not in ("figure", "ranges", "variants")]
    rows = frame(reproduction.to_list(), columns=columns)
    return rows.astype({"paper": object, "computed": object}).set_index("id")


def save(reproduction: Reproduction, directory: Path, figure: int | None = None) -> list[Path]:
    """Write report, claims and figures; see `infinivar.report.save`. Figures that need a missing library are left out."""
    check_figure(figure)
    required = [figure] if figure is not None else list(FIGURES)
    names = ["reproduction.html", "claims.json"]
    with all_or_nothing(directory, names[0]) as scratch:
        figures = []
        draw = functools.partial(_written, reproduction.machine, scratch, style.formats())
        for number, files in zip(required, apart(draw, required), strict=True):
            drawn, missing = FIGURES[number], missing_for(number)
            names += [path.name for path in files]
            figures.append(
                {
                    "number": number,
                    "title": drawn.title,
                    "caption": drawn.caption,
                    "image": style.inline_svg(files) if files else "",
                    "missing": missing,
                }
            )
        (scratch / names[0]).write_text(html(reproduction, figures), "utf-8")
        (scratch / names[1]).write_text(to_json(reproduction.to_list()), "utf-8")
    return [directory / name for name in names]


def _written(machine: PaperMachine, folder: Path, formats: Sequence[str], number: int) -> list[Path]:
    """Files of a figure; none if a library is missing."""
    return (
        [] if missing_for(number) else style.write(FIGURES[number].draw_all(machine), folder / f"fig{number}", formats)
    )


def html(reproduction: Reproduction, figures: list[dict[str, Any]]) -> str:
    """The report as a single self-contained page.

    Parameters
    ----------
    figures : list of dict   In order: number, title, caption, image (its address, or "" if not drawn) and missing (what to
        install if it is not drawn).
    """
    claims = reproduction.claims
    parameters: dict[tuple[str, str, float], dict[str, Range]] = {}
    for claim in claims:
        for reach in claim.ranges:
            parameters.setdefault((reach.parameter, reach.unit, reach.shipped), {})[claim.id] = reach
    shown = {figure["number"] for figure in figures}
    return render(
        "reproduction.html",
        package="infinivar.paper",
        claims=claims,
        counts=reproduction.verdict,
        kinds=KINDS,
        turned=lambda claim: turned(claim.shown, claim.variants),
        reached={claim.id: claim for claim in claims if claim.ranges},
        parameters=parameters,
        factor=FACTOR,
        figures=figures,
        by_figure={number: [claim for claim in claims if claim.figure == number] for number in shown},
        without_figure=[claim for claim in claims if claim.figure not in shown],
        farthest=FARTHEST,
        exact=reproduction.with_exact_law,
        spin=reproduction.with_spin,
        bearings=reproduction.with_bearings,
        reconstruction=reproduction.machine.study.reconstruction,
    )
