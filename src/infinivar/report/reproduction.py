"""The report of a reproduction: the paper's figures and its claims."""

from __future__ import annotations

from pathlib import Path

from infinivar.analysis.claims.shaking import FARTHEST
from infinivar.analysis.reproduce import Reproduction
from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.figures.paper import FIGURES
from infinivar.report.comparison import to_json
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render


def check_figure(figure: int | None) -> None:
    """Refuse a figure that cannot be drawn.

    Raises
    ------
    InputError
        With the numbers of those that can.
    """
    if figure is not None and figure not in FIGURES:
        raise InputError(f"--figure {figure}: must be one of {', '.join(map(str, FIGURES))}")


def save(reproduction: Reproduction, directory: Path, figure: int | None = None) -> list[Path]:
    """Write report, claims and figures; see `Reproduction.save`."""
    check_figure(figure)
    wanted = [figure] if figure is not None else list(FIGURES)
    names = ["reproduction.html", "claims.json"]
    with all_or_nothing(directory, names[0]) as scratch:
        figures = []
        for number in wanted:
            made = FIGURES[number].draw_all(reproduction.machine)
            names += [path.name for path in style.write(made, scratch / f"fig{number}")]
            figures.append({"number": number, "image": style.inline_svg(made), "caption": FIGURES[number].CAPTION})
        (scratch / names[0]).write_text(html(reproduction, figures), "utf-8")
        (scratch / names[1]).write_text(to_json(reproduction.to_list()), "utf-8")
    return [directory / name for name in names]


def html(reproduction: Reproduction, figures: list[dict]) -> str:
    """The report as one page that needs no other file."""
    verdicts = [claim.verdict for claim in reproduction.claims]
    return render(
        "reproduction.html",
        claims=reproduction.claims,
        counts={verdict: verdicts.count(verdict) for verdict in dict.fromkeys(verdicts)},
        figures=figures,
        farthest=FARTHEST,
        reconstruction=reproduction.machine.comparison.study.reconstruction,
    )
