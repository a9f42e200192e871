"""The report of a simulation, with its figures and data files."""

from __future__ import annotations

from pathlib import Path

from infinivar.analysis.simulate import Simulation
from infinivar.figures import energy_flow, style, time_history
from infinivar.report.comparison import to_json
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, write_csv


def save(simulation: Simulation, directory: Path, name: str, reconstruction: tuple[str, ...] = ()) -> list[Path]:
    """Write report, figures, NetCDF, CSV and JSON; see `Simulation.save`."""
    history, energy = time_history.draw_all(simulation), energy_flow.draw_all(simulation)
    with all_or_nothing(directory, f"simulate {name}") as scratch:
        page = html(simulation, reconstruction, style.inline_svg(history), style.inline_svg(energy))
        (scratch / f"{name}.html").write_text(page, "utf-8")
        (scratch / f"{name}.json").write_text(to_json(simulation.to_dict()), "utf-8")
        simulation.dataset().to_netcdf(scratch / f"{name}.nc", engine="scipy")
        write_csv(simulation.columns, scratch / f"{name}.csv")
        figures = [
            *style.write(history, scratch / f"{name}-history"),
            *style.write(energy, scratch / f"{name}-energy"),
        ]
    names = [f"{name}.{kind}" for kind in ("html", "json", "nc", "csv")] + [figure.name for figure in figures]
    return [directory / file for file in names]


def html(simulation: Simulation, reconstruction: tuple[str, ...], history: str, energy: str) -> str:
    """The report as one page that needs no other file."""
    energies = simulation.to_dict()
    return render(
        "simulation.html",
        simulation=simulation,
        scenario=simulation.scenario,
        reconstruction=reconstruction,
        supplied=energies["supplied_J"],
        lost=energies["lost_J"],
        stored=energies["stored_J"],
        closure=energies["closure"],
        history=history,
        energy=energy,
    )
