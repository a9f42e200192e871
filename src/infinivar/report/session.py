"""The report of a session of a user at the handle of a machine, with its figures and data files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from infinivar.analysis.run_limits import TOLERANCE
from infinivar.analysis.sessions.measures import measures
from infinivar.analysis.sessions.session_result import Session
from infinivar.errors import InputError
from infinivar.figures import energy_flow, session, session_motion, style
from infinivar.limits import ROOT_MEAN_SQUARE
from infinivar.motion.users import ArmModel
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json, write_csv

_WORDS = {
    "VirtualPath": "a virtual path",
    "VirtualWall": "a virtual wall",
    "Fixture": "a fixture",
    "Caster": "free motion",
    "Coasting": "coasting",
    "HoldingTask": "holding",
}


def save(found: Session, directory: Path, name: str = "session", reconstruction: tuple[str, ...] = ()) -> list[Path]:
    """Write report, figures, NetCDF, CSV and JSON; the report comes first."""
    if not re.fullmatch(r"[\w.-]+", name):
        raise InputError(f"name must be letters, digits, dots, - and _, got {name!r}")
    drawings = {
        "motion": session_motion.draw_all(found),
        "history": session.draw_all(found),
        "energy": energy_flow.draw_all(found),
    }
    with all_or_nothing(directory, f"session {name}") as scratch:
        (scratch / f"{name}.json").write_text(to_json(to_dict(found)), "utf-8")
        found.to_netcdf(scratch / f"{name}.nc")
        write_csv({"time_s": found.time, **found.columns}, scratch / f"{name}.csv")
        drawn = {
            what: style.write(made, scratch / f"{name}-{what}") for what, made in drawings.items() if made is not None
        }
        page = html(found, reconstruction, {what: style.inline_svg(files) for what, files in drawn.items()})
        (scratch / f"{name}.html").write_text(page, "utf-8")
    names = [f"{name}.{kind}" for kind in ("html", "json", "nc", "csv")]
    return [directory / file for file in [*names, *(one.name for files in drawn.values() for one in files)]]


def to_dict(found: Session) -> dict[str, Any]:
    """Plain values for JSON, with the measures."""
    return {
        **found.to_dict(),
        "task": getattr(found.task, "word", None),
        "measures": {one.key: one.value for one in measures(found)},
    }


def html(found: Session, reconstruction: tuple[str, ...], drawings: dict[str, str]) -> str:
    """The report as one self-contained page."""
    energies = found.to_dict()
    return render(
        "session.html",
        session=found,
        task=_WORDS.get(type(found.task).__name__, "a controller of its own"),
        user=_user(found),
        steered=any(name.startswith("phi_") for name in found.columns),
        measures=measures(found),
        reconstruction=reconstruction,
        supplied=energies["supplied_J"],
        lost=energies["lost_J"],
        stored=energies["stored_J"],
        closure=energies["closure"],
        tolerance=TOLERANCE,
        averaged=ROOT_MEAN_SQUARE,
        drawings=drawings,
    )


def _user(found: Session) -> str:
    if isinstance(found.user, ArmModel):
        arm = found.user
        return f"an arm of {arm.mass:g} kg, {arm.damping:g} N s/m and {arm.stiffness:g} N/m ({arm.name}: {arm.source})"
    return "nobody" if found.user is None else "a force over time"
