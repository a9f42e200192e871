"""The report of a sensitivity analysis, with its figure and numbers."""

from __future__ import annotations

from pathlib import Path

from infinivar.analysis.robustness.sensitivity import ASSUMED, Sensitivity
from infinivar.figures import sensitivity as figure
from infinivar.figures import style
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json


def save(sensitivity: Sensitivity, directory: Path) -> list[Path]:
    """Write report, figures and JSON; the report comes first."""
    name = f"sensitivity-{sensitivity.outcome.name}"
    with all_or_nothing(directory, f"sensitivity {name}") as scratch:
        figures: list[Path] = []
        image = None
        if sensitivity.influences:
            figures = style.write(figure.draw_all(sensitivity), scratch / name)
            image = style.inline_svg(figures)
        page = render("sensitivity.html", sensitivity=sensitivity, image=image, assumed=ASSUMED)
        (scratch / f"{name}.html").write_text(page, "utf-8")
        (scratch / f"{name}.json").write_text(to_json(sensitivity.to_dict()), "utf-8")
    return [directory / file for file in (f"{name}.html", f"{name}.json", *(made.name for made in figures))]
