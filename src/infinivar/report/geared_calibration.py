"""The report of the calibration of a geared drive, and the calibrated study."""

from __future__ import annotations

from pathlib import Path

from infinivar import units
from infinivar.calibration.geared import model, words
from infinivar.calibration.geared.result import GearedCalibration
from infinivar.calibration.words import with_interval
from infinivar.figures import geared_calibration as figure
from infinivar.report.calibration import write
from infinivar.report.page import render


def save(calibration: GearedCalibration, directory: Path) -> list[Path]:
    """Write report, figures, results and calibrated study; `calibration.html` comes first."""
    return write(calibration, directory, figure.draw_all, html)


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
