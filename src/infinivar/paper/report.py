"""The report of a reproduction: the paper's figures and its claims."""

from __future__ import annotations

from pathlib import Path

from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.paper.claims.shaking import FARTHEST
from infinivar.paper.claims.verdict import FACTOR, KINDS, Range, turned
from infinivar.paper.figures import FIGURES
from infinivar.paper.reproduce import Reproduction
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json


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
            files = style.write(FIGURES[number].draw_all(reproduction.machine), scratch / f"fig{number}")
            names += [path.name for path in files]
            figures.append({"number": number, "image": style.inline_svg(files), "caption": FIGURES[number].CAPTION})
        (scratch / names[0]).write_text(html(reproduction, figures), "utf-8")
        (scratch / names[1]).write_text(to_json(reproduction.to_list()), "utf-8")
    return [directory / name for name in names]


def html(reproduction: Reproduction, figures: list[dict]) -> str:
    """The report as one page that needs no other file."""
    claims = reproduction.claims
    verdicts = [claim.verdict for claim in claims]
    parameters: dict[tuple[str, str, float], dict[str, Range]] = {}
    for claim in claims:
        for reach in claim.ranges:
            parameters.setdefault((reach.parameter, reach.unit, reach.shipped), {})[claim.id] = reach
    return render(
        "reproduction.html",
        claims=claims,
        counts={verdict: verdicts.count(verdict) for verdict in dict.fromkeys(verdicts)},
        fitted=sum(claim.by_construction for claim in claims),
        kinds=KINDS,
        turned=lambda claim: turned(claim.shown, claim.variants),
        reached={claim.id: claim for claim in claims if claim.ranges},
        parameters=parameters,
        factor=FACTOR,
        figures=figures,
        farthest=FARTHEST,
        reconstruction=reproduction.machine.study.reconstruction,
    )
