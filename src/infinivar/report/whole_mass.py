"""Tables of masses in reports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from infinivar.analysis.whole_mass import DOUBT, LEFT_OUT, WholeMass, exceeded_words
from infinivar.drivetrain.body import Body
from infinivar.units import show_in


def words() -> dict[str, Any]:
    """What the macro of the tables needs, by name."""
    return {
        "mass_rows": rows,
        "mass_cell": cell,
        "mass_left_out": LEFT_OUT,
        "mass_doubt": f"{DOUBT:g}",
        "exceeded_envelope": exceeded_words,
    }


def rows(found: Mapping[str, WholeMass]) -> list[tuple[str, list[str]]]:
    """Masses by body, with a column for each drive; bodies in the order of the drives."""
    columns = [{body.name: body for body in mass.bodies} for mass in found.values()]
    names = dict.fromkeys(name for column in columns for name in column)
    return [(name, [cell(column.get(name)) for column in columns]) for name in names]


def cell(body: Body | None) -> str:
    """Mass of a body in grams; "" for a body that a drive has not, "not known" for one without mass."""
    if body is None:
        return ""
    return "not known" if body.mass is None else show_in(float(body.mass), "kg", "g", 3)
