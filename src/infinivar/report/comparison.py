"""The report of a comparison, with its data files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from infinivar.analysis.compare import Comparison
from infinivar.analysis.cycles import cylinder_policy
from infinivar.analysis.robustness.verdicts import band, percent
from infinivar.figures import duty_cycle, least_loss, losses, operating_map, style
from infinivar.limits import words_of
from infinivar.power import AUDIT_TOLERANCE
from infinivar.report import whole_mass
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json, write_csv
from infinivar.report.provenance import provenance_tables

LEAST_LOSS = "report-least-loss.nc"
"""File of the map of the least loss, beside its figure."""


def save(comparison: Comparison, directory: Path) -> list[Path]:
    """Write report, figures, results, one NetCDF map per drive, one CSV per drive and duty cycle; the report comes first."""
    least = comparison.least_loss
    with all_or_nothing(directory, "compare") as scratch:
        drawings = {
            "report-maps": (operating_map.draw_all, comparison),
            **({} if least is None else {"report-least-loss": (least_loss.draw_all, least)}),
            **({} if comparison.study.requirement is None else {"report-losses": (losses.draw_all, comparison)}),
            **{f"report-duty-{task}": (duty_cycle.draw_all, found) for task, found in comparison.duty.items()},
        }
        figures = style.write_all(scratch, drawings)
        images = {name.removeprefix("report-"): style.inline_svg(files) for name, files in figures.items()}
        (scratch / "report.html").write_text(html(comparison, images), "utf-8")
        (scratch / "results.json").write_text(to_json(results(comparison)), "utf-8")
        for name, result in comparison.results.items():
            result.map.to_netcdf(scratch / f"{name}.nc")
        if least is not None:
            least.to_netcdf(scratch / LEAST_LOSS)
        for task, found in comparison.duty.items():
            for name, result in found.results.items():
                write_csv(result.columns, scratch / f"{name}-{task}.csv")
    cycles = [f"{name}-{task}.csv" for task, found in comparison.duty.items() for name in found.results]
    maps = [f"{name}.nc" for name in comparison.results] + ([] if least is None else [LEAST_LOSS])
    drawn = [file.name for files in figures.values() for file in files]
    return [directory / name for name in ("report.html", "results.json", *maps, *cycles, *drawn)]


ENGINE_WORDS = {"numpy": "NumPy", "jax": "JAX, compiled", "jax and numpy": "JAX, compiled, and NumPy"}
"""What computed a result, by the word in it."""


def results(comparison: Comparison) -> dict[str, Any]:
    """All results of the report as plain numbers."""
    content = comparison.to_dict()
    for name, result in comparison.results.items():
        content["drives"][name]["corners"] = {
            label: {**asdict(corner), "limit": corner.limit.name} for label, corner in result.corners.items()
        }
    required = comparison.study.requirement
    content["requirement"] = None if required is None else required.to_dict()
    content["provenance"] = [asdict(row) for row in comparison.study.provenance]
    return content


def html(comparison: Comparison, images: Mapping[str, str]) -> str:
    """The report as one self-contained page with its figures by name: maps, least-loss, losses and duty-NAME."""
    study = comparison.study
    first = next(iter(comparison.results.values())).map
    return render(
        "comparison.html",
        study=study,
        comparison=comparison,
        corners={} if study.requirement is None else study.requirement.corners(),
        corner_words=losses.corner_words,
        braking=bool(first.speed[0] < 0 or first.force[0] < 0),
        placed=any(output.chain for drive in study.drives.values() if (output := getattr(drive, "output", None))),
        map_figure=images["maps"],
        least_figure=images.get("least-loss"),
        loss_figure=images.get("losses"),
        duty=[(found, images[f"duty-{task}"]) for task, found in comparison.duty.items()],
        provenance=provenance_tables(study.provenance),
        words_of=words_of,
        **whole_mass.words(),
        cylinder_range=cylinder_policy.RANGE,
        audit_tolerance=AUDIT_TOLERANCE,
        engines=ENGINE_WORDS,
        band=band,
        percent=percent,
    )
