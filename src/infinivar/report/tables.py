"""Results as tables: one row per drive, parameter, line or claim."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from infinivar._core import extras
from infinivar.analysis.compare import Comparison
from infinivar.analysis.cycles.duty_comparison import DutyComparison
from infinivar.analysis.cycles.mixed_use import MixedUse
from infinivar.analysis.cycles.tracking import TwoWays
from infinivar.analysis.hanging import Hanging
from infinivar.analysis.machines import MachineComparison
from infinivar.analysis.robustness.verdicts import Builds, DutyBuilds
from infinivar.analysis.simulate import Simulation
from infinivar.bondgraph.audit import Trajectory
from infinivar.calibration.result import Calibration, GearedCalibration
from infinivar.contact.exact.transient import TransientRolling
from infinivar.displays.comparison import DisplayComparison
from infinivar.sizing.builds.result import Doubt
from infinivar.sizing.design import limit_words
from infinivar.sizing.result import Sizing

if TYPE_CHECKING:
    import pandas as pd


def frame(content: Any, **options: Any) -> pd.DataFrame:
    """A table; where pandas is missing, an error with the command that installs it."""
    return extras.load("pandas", "xarray", "a table").DataFrame(content, **options)


def _rows(rows: Iterable[Mapping[str, Any]], index: str) -> pd.DataFrame:
    made = frame(list(rows))
    return made.set_index(index) if len(made) else made


def comparison(found: Comparison) -> pd.DataFrame:
    """One row per drive: verdict, coverage, efficiencies, mean loss and tightest limit."""
    return _rows(
        (
            {
                "drive": name,
                "title": result.title,
                "able": found.able(name),
                "coverage": result.coverage,
                "peak_efficiency": result.peak_efficiency,
                "peak_efficiency_in_region": result.peak_efficiency_in_region,
                "mean_loss_W": result.mean_loss,
                "tightest_limit": None if result.tightest is None else result.tightest.limit.name,
                "margin": None if result.tightest is None else result.tightest.value,
                "mass_kg": None if (mass := found.masses.get(name)) is None else mass.total,
                "verdict": result.verdict,
            }
            for name, result in found.results.items()
        ),
        "drive",
    )


def machine_comparison(found: MachineComparison) -> pd.DataFrame:
    """One row per machine, and task or path: power, losses and tightest limit."""
    made = frame(
        [
            {
                "drive": name,
                "task": key,
                "title": one.title,
                "feasible": done.feasible,
                "power_in_W": done.mean_power,
                "steady_power_W": done.steady_power,
                "steering_power_W": done.steering_power,
                "loss_W": sum(done.losses.values()),
                "tightest_limit": done.demand[0].name,
                "part": done.demand[1],
                "margin": done.margin,
            }
            for name, one in found.results.items()
            for key, done in one.found.items()
        ]
    )
    return made.set_index(["drive", "task"])


def hanging(found: Hanging) -> pd.DataFrame:
    """One row per answer to an open choice, that used first: figures by drive, winner, whether it is another one."""
    return frame(
        [
            {
                "choice": row.choice,
                "used": row.used,
                "instead": row.instead,
                **{f"{name} [{found.unit}]": value for name, value in row.figures.items()},
                "winner": row.winner,
                "flips": row.flips,
            }
            for row in (found.used, *found.rows)
        ]
    )


def duty_comparison(found: DutyComparison) -> pd.DataFrame:
    """One row per drive: verdict, energy and work per cycle."""
    return _rows(
        (
            {
                "drive": name,
                "title": result.title,
                "feasible": result.feasible,
                "energy_J": result.energy,
                "power_W": result.power_in,
                "peak_power_W": result.powers["power_from_supply_peak_W"],
                "energy_per_mass_J_kg": result.energy_per_kilogram,
                "energy_per_distance_J_m": result.energy_per_metre,
                "work_on_load_J": result.delivered,
                "work_of_load_J": result.absorbed,
                "verdict": result.verdict,
            }
            for name, result in found.results.items()
        ),
        "drive",
    )


def mixed_use(found: MixedUse) -> pd.DataFrame:
    """One row per drive: feasibility, mean power and verdict in mixed use."""
    return _rows(
        (
            {
                "drive": name,
                "title": title,
                "feasible": found.feasible[name],
                "power_W": found.power[name],
                "verdict": found.verdict_on(name),
            }
            for name, title in found.titles.items()
        ),
        "drive",
    )


def display_comparison(found: DisplayComparison) -> pd.DataFrame:
    """One row per number of axes and display: energy of a round as shown, and its range, parts and heat."""
    rows = []
    for place, count in enumerate(found.axes.tolist()):
        for row, display in enumerate(found.displays):
            shown, low, high = found.range_of(found.total[:, row, place], found.feasible[:, row, place])
            parts = dict(zip(found.parts, found.energy[0, row, place].tolist(), strict=True))
            rows.append(
                {
                    "axes": count,
                    "display": display,
                    "feasible": bool(found.feasible[0, row, place]),
                    "energy_J": shown,
                    "least_energy_J": low,
                    "largest_energy_J": high,
                    **{f"{part.replace('-', '_')}_J": energy for part, energy in parts.items()},
                    "user_J": float(found.user[0, row, place]),
                    "winding_W": float(found.winding[0, row, place]),
                }
            )
    return frame(rows).set_index(["axes", "display"])


def transient_rolling(found: TransientRolling) -> pd.DataFrame:
    """One row per distance rolled: forces and energies."""
    names = ("fx", "fy", "mz", "energy", "work", "dissipated")
    columns = {name: getattr(found, name) for name in names}
    return frame({"distance": found.distance, **columns, "outcome": found.outcome}).set_index("distance")


def two_ways(found: TwoWays) -> pd.DataFrame:
    """One row per loss: its energy per cycle, prescribed and simulated. [J]"""
    names = dict.fromkeys([*found.lost_prescribed, *found.lost_followed])
    return _rows(
        (
            {
                "loss": name,
                "prescribed_J": found.lost_prescribed.get(name, 0.0),
                "followed_J": found.lost_followed.get(name, 0.0),
            }
            for name in names
        ),
        "loss",
    )


def builds(found: Builds) -> pd.DataFrame:
    """One row per sample: its values, coverage, margin and loss."""
    values = dict(zip((spread.path for spread in found.spreads), found.values.T, strict=True))
    made = frame({**values, "coverage": found.coverage, "margin": found.margin, "loss_W": found.loss})
    return made.rename_axis("build")


def duty_builds(found: DutyBuilds) -> pd.DataFrame:
    """One row per sample: energy per cycle, highest temperature if known, and whether it is within limits."""
    heated = {"temperature_K": found.temperature} if found.temperature.size else {}
    return frame({"energy_J": found.energy, **heated, "able": found.able}).rename_axis("build")


def calibration(found: Calibration | GearedCalibration) -> pd.DataFrame:
    """One row per parameter: estimate, standard deviation, 95 % interval and the study's value. [SI]"""
    rows = found.to_dict()["parameters"]
    return _rows(
        (
            {
                "parameter": name,
                "unit": row["unit"],
                "value": row["value"],
                "standard_deviation": row["standard_deviation"],
                "low_95": row["interval_95"][0],
                "high_95": row["interval_95"][1],
                "identifiable": row["identifiable"],
                "study": row["study"],
            }
            for name, row in rows.items()
        ),
        "parameter",
    )


def simulation(found: Simulation) -> pd.DataFrame:
    """One row per instant: the columns of the run, and the energies supplied, lost and stored."""
    return frame(dict(found.columns)).set_index("time_s").join(trajectory(found.trajectory))


def trajectory(run: Trajectory) -> pd.DataFrame:
    """One row per instant: the energies supplied, lost and stored, by name."""
    energies = {
        f"{kind} {name} [J]": values
        for kind, group in (("supplied", run.supplied), ("lost", run.lost), ("stored", run.stored))
        for name, values in group.items()
    }
    return frame({"time_s": run.time, **energies}).set_index("time_s")


def doubt(found: Doubt) -> pd.DataFrame:
    """One row per design: shares of its builds, the limit most often exceeded, and power."""
    return _rows(
        (
            {
                "design": one.name,
                "parts": one.title,
                "feasible": one.share,
                "feasible_low": one.interval[0],
                "feasible_high": one.interval[1],
                "best": one.best_share,
                "most_often_exceeded": None if one.weakest is None else limit_words(one.weakest),
                "nominal_power_W": one.nominal,
                **{f"power_{name}_W": value for name, value in one.band.items()},
            }
            for one in (*found.designs, *found.front)
        ),
        "design",
    )


def sizing(found: Sizing) -> pd.DataFrame:
    """One row per design: parts, searched values, mass, power and tightest limit."""
    return _rows(
        (
            {
                "rank": place,
                "template": design.template,
                **{role: part.part for role, part in design.parts.items()},
                **{path: value.value for path, value in design.free.items()},
                "mass_kg": design.mass,
                "power_W": design.power,
                "margin": design.margin,
                "tightest_limit": None if design.tightest is None else limit_words(design.tightest),
            }
            for place, design in enumerate(found.designs, 1)
        ),
        "rank",
    )
