"""Reports on measured sets as files: figures, results, and one table of all."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from infinivar.calibration.measured.outcome import Residual
from infinivar.calibration.measured.report import MeasuredReport
from infinivar.calibration.measured.words import judged, shown
from infinivar.figures import style
from infinivar.report.output import all_or_nothing
from infinivar.report.page import to_json

HEAD = ("set", "reading", "licence", "rows", "rms", "worst", "left out: rms", "within interval", "goal")


def rows(report: MeasuredReport) -> Iterator[tuple[str, ...]]:
    """Cells of a table under `HEAD`: all parts together, then each part."""
    for residual in report.totals:
        yield _cells(report, report.set.name, residual)
    if len(report.parts) > 1:
        for part in report.parts:
            for residual in part.residuals:
                yield _cells(report, f"- {part.name}", residual)


def _cells(report: MeasuredReport, name: str, one: Residual) -> tuple[str, ...]:
    whole = not name.startswith("- ")
    left = math.isfinite(one.left_out_rms)
    return (
        name,
        one.signal,
        report.set.licence.split(",")[0] if whole else "",
        str(one.rows),
        shown(one.rms, one.unit),
        shown(one.worst, one.unit),
        shown(one.left_out_rms, one.unit) if left else "",
        f"{one.coverage:.0%}" if left and math.isfinite(one.coverage) else "",
        judged(one).removeprefix("goal "),
    )


def table(reports: Sequence[MeasuredReport]) -> str:
    """A Markdown table of all reports."""
    lines = [HEAD, ("---",) * len(HEAD), *(cells for report in reports for cells in rows(report))]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def save(report: MeasuredReport, directory: Path) -> list[Path]:
    """Write a report's table, text, results and figure; the table comes first."""
    return save_all([report], directory)


def save_all(reports: Sequence[MeasuredReport], directory: Path) -> list[Path]:
    """Write a table of all reports, `measurements.md`, and of each its text, results and figure."""
    names = ["measurements.md"]
    with all_or_nothing(directory, "measured") as scratch:
        (scratch / "measurements.md").write_text(table(reports), "utf-8")
        for report in reports:
            name = report.set.name
            (scratch / f"{name}.txt").write_text("\n".join(report.lines) + "\n", "utf-8")
            (scratch / f"{name}.json").write_text(to_json(report.to_dict()), "utf-8")
            figures = style.write(report.plot(), scratch / name)
            names += [f"{name}.txt", f"{name}.json", *(file.name for file in figures)]
    return [directory / name for name in names]
