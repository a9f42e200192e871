"""The report of a simulated run, of a drive or machine or with a user at the handle, with its figures and data files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from infinivar.analysis.machine_run import MachineRun
from infinivar.analysis.run_limits import TOLERANCE
from infinivar.analysis.sessions.measures import measures
from infinivar.analysis.sessions.session_result import Session
from infinivar.analysis.simulate import Simulation
from infinivar.errors import InputError
from infinivar.figures import energy_flow, machine_run, session, session_motion, style, time_history
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


class _Report(NamedTuple):
    """What the reports of runs differ in."""

    command: str
    template: str
    numbers: Mapping[str, Any]
    drawings: Mapping[str, Any]
    page: Mapping[str, Any]
    """For the template, beside what all runs have."""


def save(
    simulation: Simulation | MachineRun,
    directory: Path,
    name: str = "simulation",
    reconstruction: tuple[str, ...] = (),
) -> list[Path]:
    """Write report, figures, NetCDF, CSV and JSON; the report comes first."""
    _check_name(name)
    of_machine = isinstance(simulation, MachineRun)
    history = machine_run.draw_all if of_machine else time_history.draw_all
    report = _Report(
        command="simulate",
        template="machine_run.html" if of_machine else "simulation.html",
        numbers=simulation.to_dict(),
        drawings={"history": history, "energy": energy_flow.draw_all},
        page={
            "simulation": simulation,
            "scenario": simulation.scenario,
            "steered": any(column.startswith(("phi_", "gamma_")) for column in simulation.columns),
        },
    )
    return _written(simulation, report, directory, name, reconstruction)


def save_session(
    found: Session, directory: Path, name: str = "session", reconstruction: tuple[str, ...] = ()
) -> list[Path]:
    """Write report, figures, NetCDF, CSV and JSON; the report comes first."""
    _check_name(name)
    report = _Report(
        command="session",
        template="session.html",
        numbers=session_to_dict(found),
        drawings={
            "motion": session_motion.draw_all,
            "history": session.draw_all,
            "energy": energy_flow.draw_all,
        },
        page={
            "session": found,
            "task": _WORDS.get(type(found.task).__name__, "a controller of its own"),
            "user": _user(found),
            "steered": any(column.startswith("phi_") for column in found.columns),
            "measures": measures(found),
        },
    )
    return _written(found, report, directory, name, reconstruction)


def session_to_dict(found: Session) -> dict[str, Any]:
    """Plain values for JSON, with the measures."""
    return {
        **found.to_dict(),
        "task": getattr(found.task, "word", None),
        "measures": {one.key: one.value for one in measures(found)},
    }


def _check_name(name: str) -> None:
    if not re.fullmatch(r"[\w.-]+", name):
        raise InputError(f"name must be letters, digits, dots, - and _, got {name!r}")


def _written(
    found: Simulation | MachineRun | Session,
    report: _Report,
    directory: Path,
    name: str,
    reconstruction: tuple[str, ...],
) -> list[Path]:
    """Files of a run."""
    numbers, drawings = report.numbers, report.drawings
    with all_or_nothing(directory, f"{report.command} {name}") as scratch:
        (scratch / f"{name}.json").write_text(to_json(numbers), "utf-8")
        found.to_netcdf(scratch / f"{name}.nc")
        write_csv({"time_s": found.history.time, **found.columns}, scratch / f"{name}.csv")
        drawn = style.write_all(scratch, {f"{name}-{what}": (draw, found) for what, draw in drawings.items()})
        page = render(
            report.template,
            **report.page,
            run=found,
            reconstruction=reconstruction,
            supplied=numbers["supplied_J"],
            lost=numbers["lost_J"],
            stored=numbers["stored_J"],
            closure=numbers["closure"],
            tolerance=TOLERANCE,
            averaged=ROOT_MEAN_SQUARE,
            drawings={
                what: style.inline_svg(files) for what, files in zip(drawings, drawn.values(), strict=True) if files
            },
        )
        (scratch / f"{name}.html").write_text(page, "utf-8")
    names = [f"{name}.{kind}" for kind in ("html", "json", "nc", "csv")]
    return [directory / file for file in [*names, *(one.name for files in drawn.values() for one in files)]]


def _user(found: Session) -> str:
    if isinstance(found.user, ArmModel):
        arm = found.user
        return f"an arm of {arm.mass:g} kg, {arm.damping:g} N s/m and {arm.stiffness:g} N/m ({arm.name}: {arm.source})"
    return "nobody" if found.user is None else "a force over time"
