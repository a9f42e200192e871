"""The report of the calibration of a geared drive, and the calibrated study."""

from __future__ import annotations

from pathlib import Path

from infinivar import units
from infinivar.calibration.geared import model, words
from infinivar.calibration.geared.result import GearedCalibration
from infinivar.calibration.words import with_interval
from infinivar.figures import geared_calibration as figure
from infinivar.figures import style
from infinivar.report.calibration import toml
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json


def save(calibration: GearedCalibration, directory: Path) -> list[Path]:
    """Write report, figures, results and calibrated study; `calibration.html` comes first."""
    with all_or_nothing(directory, "calibrate") as scratch:
        figures = style.write(figure.draw_all(calibration), scratch / "calibration-figure")
        (scratch / "calibration.html").write_text(html(calibration, style.inline_svg(figures)), "utf-8")
        (scratch / "calibration.json").write_text(to_json(calibration.to_dict()), "utf-8")
        (scratch / "calibrated.toml").write_text(toml(calibration, directory), "utf-8")
    names = ["calibration.html", "calibrated.toml", "calibration.json", *(file.name for file in figures)]
    return [directory / name for name in names]


def html(calibration: GearedCalibration, image: str) -> str:
    """The report as one self-contained page."""
    fit, known = calibration.fit, calibration.known
    return render(
        "geared_calibration.html",
        calibration=calibration,
        parameters=model.PARAMETERS,
        estimate=lambda name: with_interval(fit.values[name], fit.deviations[name], model.PARAMETERS[name]),
        known=lambda name: units.show_in(known[name], *model.PARAMETERS[name][:2], digits=5),
        sums=[words.sum_in_words(one, fit) for one in fit.combinations],
        image=image,
    )
