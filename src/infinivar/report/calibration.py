"""The report of a calibration, the calibrated study, and the data of a virtual rig as files."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from infinivar import units
from infinivar.calibration.dynamometer import Dynamometer
from infinivar.calibration.fitted import Fitted
from infinivar.calibration.laws import DECIDED
from infinivar.calibration.result import Calibration, GearedCalibration
from infinivar.calibration.transmission import RigData
from infinivar.calibration.virtual_rig import Setting
from infinivar.calibration.words import described, determined, estimate, with_interval
from infinivar.figures import style
from infinivar.report.output import all_or_nothing, check_file
from infinivar.report.page import render, to_json, write_csv
from infinivar.study.spreads import NORMAL_95


def save(calibration: Calibration | GearedCalibration, directory: Path) -> list[Path]:
    """Write report, figures, results and calibrated study; `calibration.html` comes first."""
    with all_or_nothing(directory, "calibrate") as scratch:
        figures = style.write(calibration.plot(), scratch / "calibration-figure")
        (scratch / "calibration.html").write_text(html(calibration, style.inline_svg(figures)), "utf-8")
        (scratch / "calibration.json").write_text(to_json(calibration.to_dict()), "utf-8")
        (scratch / "calibrated.toml").write_text(toml(calibration, directory), "utf-8")
    names = ["calibration.html", "calibrated.toml", "calibration.json", *(file.name for file in figures)]
    return [directory / name for name in names]


def save_data(data: RigData | Dynamometer, file: Path) -> None:
    """Write the runs of a rig as CSV.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    check_file(file)
    write_csv(data.columns, file)


def html(calibration: Calibration | GearedCalibration, image: str) -> str:
    """The report as one self-contained page."""
    fit, known = calibration.fit, calibration.known
    common = {
        "calibration": calibration,
        "parameters": fit.parameters,
        "estimate": estimate,
        "known": lambda name: units.show_in(known[name], *fit.parameters[name][:2], digits=5),
        "sums": [determined(one, fit) for one in fit.combinations],
        "image": image,
    }
    if isinstance(calibration, GearedCalibration):
        return render("calibration.html", of_rig=False, **common)
    return render(
        "calibration.html",
        of_rig=True,
        **common,
        decided=DECIDED,
        expected=lambda name: _expected(calibration, name),
        runs=list(_runs(calibration)),
        next_runs=_counted([described(setting) for setting in calibration.plan.settings]),
    )


def _expected(calibration: Calibration, name: str) -> str:
    deviation = calibration.plan.deviations[name]
    if math.isinf(deviation):
        return "not identifiable"
    return with_interval(None, deviation, calibration.fit.parameters[name])


def _runs(calibration: Calibration) -> Iterator[dict[str, Any]]:
    data, found = calibration.data, calibration.efficiencies
    reasons = {one.row: one.reason for one in calibration.left_out}
    for row, line in enumerate(data.lines):
        setting = Setting(*(float(getattr(data, name)[row]) for name in Setting._fields))
        stiffness, spread = (float(part[row]) for part in calibration.eq9)
        yield {
            "line": line,
            "setting": described(setting),
            "efficiency": math.nan if row in reasons else float(found.value[row]),
            "half": NORMAL_95 * float(found.deviation[row]),
            "stiffness": ""
            if math.isnan(stiffness)
            else with_interval(stiffness, spread, data.parameters["creep_stiffness"]),
            "reason": reasons.get(row, ""),
        }


def _counted(runs: list[str]) -> list[str]:
    """Each run once, with its number of repetitions."""
    return [run if runs.count(run) == 1 else f"{run} ({runs.count(run)} times)" for run in dict.fromkeys(runs)]


def toml(calibration: Calibration | GearedCalibration, directory: Path) -> str:
    """A study that extends the calibrated one and replaces the fitted values."""
    study, rows, name = calibration.study, calibration.rows, calibration.name
    source = Path(calibration.data.name).name
    lines = [
        f"# {calibration.summary} of {_plain(source)}.",
        "# Every infinivar command accepts this file as a study.",
    ]
    if study.path is not None:
        lines.append(f"extends = {json.dumps(_relative(study.path, directory))}")
    title = f"{study.title.removesuffix(', calibrated')}, calibrated"
    lines.append(f"title = {json.dumps(title, ensure_ascii=False)}")
    for row, opens in _by_table(rows, f"drives.{name}"):
        lines += [*opens, f"{_field(row)} = {{ {_value(row.value, row.unit)}, {_origin(row)} }}"]
    spread = [row for row in rows if row.deviation is not None]
    for row, opens in _by_table(spread, f"uncertainty.{name}"):
        size = f"{row.deviation:.6g}" if row.unit == "1" else f'"{row.deviation:.6g} {row.unit}"'
        lines += [*opens, f"{_field(row)} = {{ deviation = {size}, {_origin(row)} }}"]
    lines += _correlations(calibration, spread)
    return "\n".join(lines) + "\n"


def _by_table(rows: Sequence[Fitted], where: str) -> Iterator[tuple[Fitted, list[str]]]:
    """TOML lines of each row, with the table header before the first row of a table."""
    table = ""
    for row in rows:
        head = row.path.rpartition(".")[0]
        yield row, [] if head == table else ["", f"[{where}.{head}]"]
        table = head


def _field(row: Fitted) -> str:
    return row.path.rpartition(".")[2]


def _correlations(calibration: Calibration | GearedCalibration, spread: list[Fitted]) -> Iterator[str]:
    names, matrix = calibration.fit.names, calibration.fit.correlations
    for place, one in enumerate(spread):
        for other in spread[place + 1 :]:
            if one.parameter == other.parameter:
                continue
            value = float(matrix[names.index(one.parameter), names.index(other.parameter)])
            value *= math.copysign(1.0, one.slope * other.slope)
            if abs(value) >= 0.005:
                yield from (
                    "",
                    "[[correlations]]",
                    f"drive = {json.dumps(calibration.name)}",
                    f"between = [{json.dumps(one.path)}, {json.dumps(other.path)}]",
                    f"value = {value:.4f}",
                )


def _origin(row: Fitted) -> str:
    return f"kind = {json.dumps(row.kind)}, where = {json.dumps(row.where, ensure_ascii=False)}"


def _value(value: float | str, unit: str) -> str:
    if isinstance(value, str):
        return f"value = {json.dumps(value)}"
    return f"value = {value:.9g}" + ("" if unit == "1" else f', unit = "{unit}"')


def _relative(path: Path, directory: Path) -> str:
    try:
        return Path(os.path.relpath(path.resolve(), directory.resolve())).as_posix()
    except ValueError:  # on another drive of the machine
        return path.resolve().as_posix()


def _plain(text: str) -> str:
    return "".join(letter for letter in text if letter.isprintable())
