"""The report of a simulation of a drive or machine, with its figures and data files."""

from __future__ import annotations

import re
from pathlib import Path

from infinivar.analysis.machine_run import MachineRun
from infinivar.analysis.run_limits import TOLERANCE
from infinivar.analysis.simulate import Simulation
from infinivar.errors import InputError
from infinivar.figures import energy_flow, machine_run, style, time_history
from infinivar.limits import ROOT_MEAN_SQUARE
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json, write_csv


def save(
    simulation: Simulation | MachineRun,
    directory: Path,
    name: str = "simulation",
    reconstruction: tuple[str, ...] = (),
) -> list[Path]:
    """Write report, figures, NetCDF, CSV and JSON; the report comes first."""
    if not re.fullmatch(r"[\w.-]+", name):
        raise InputError(f"name must be letters, digits, dots, - and _, got {name!r}")
    if isinstance(simulation, MachineRun):
        history, columns = machine_run.draw_all(simulation), {"time_s": simulation.time, **simulation.columns}
    else:
        history, columns = time_history.draw_all(simulation), simulation.columns
    energy = energy_flow.draw_all(simulation)
    with all_or_nothing(directory, f"simulate {name}") as scratch:
        (scratch / f"{name}.json").write_text(to_json(simulation.to_dict()), "utf-8")
        simulation.to_netcdf(scratch / f"{name}.nc")
        write_csv(columns, scratch / f"{name}.csv")
        drawn = [
            style.write(made, scratch / f"{name}-{what}") for what, made in (("history", history), ("energy", energy))
        ]
        page = html(simulation, reconstruction, *map(style.inline_svg, drawn))
        (scratch / f"{name}.html").write_text(page, "utf-8")
    names = [f"{name}.{kind}" for kind in ("html", "json", "nc", "csv")] + [
        file.name for files in drawn for file in files
    ]
    return [directory / file for file in names]


def html(simulation: Simulation | MachineRun, reconstruction: tuple[str, ...], history: str, energy: str) -> str:
    """The report as one self-contained page."""
    energies = simulation.to_dict()
    return render(
        "machine_run.html" if isinstance(simulation, MachineRun) else "simulation.html",
        simulation=simulation,
        scenario=simulation.scenario,
        steered=any(name.startswith(("phi_", "gamma_")) for name in simulation.columns),
        reconstruction=reconstruction,
        supplied=energies["supplied_J"],
        lost=energies["lost_J"],
        stored=energies["stored_J"],
        closure=energies["closure"],
        tolerance=TOLERANCE,
        averaged=ROOT_MEAN_SQUARE,
        history=history,
        energy=energy,
    )
