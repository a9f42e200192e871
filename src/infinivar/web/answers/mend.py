"""What then: which values of an infeasible drive, changed, bring it within all limits; each change can be applied."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import Any

import numpy as np

from infinivar._core.fields import quantities_of
from infinivar.drivetrain.drive import operated
from infinivar.errors import InfinivarError
from infinivar.sizing.geared.candidates import STRUCTURE
from infinivar.sizing.machine_changes import TOGETHER as MACHINES_TOGETHER
from infinivar.sizing.machine_changes import machine_demands, sought
from infinivar.sizing.mending import TOGETHER, Demands, mending
from infinivar.sizing.what_if import Change, Judge
from infinivar.study.study import Study
from infinivar.web.answers.answer import Answer, FaultyError, RefusedError
from infinivar.web.answers.document import name_and_tables, study_of, with_values
from infinivar.web.answers.fields import fields_of
from infinivar.web.answers.payload import number, word

_MOST = 8
"""Changes offered."""

_DIGITS = 4
"""Of a value offered."""


def mend(payload: Mapping[str, Any]) -> Answer:
    """Changes of one value, or where none is enough of two, the smallest first: `at` and `value` for the tables, and words.

    Parameters
    ----------
    payload : mapping   Study and `drive`; with `speed` and `force` for that point, else for all that is required.
    """
    study = study_of(payload)
    name = word(payload, "drive", study.drives)
    drive = study.drives[name]
    machines = bool(study.tasks or study.paths)
    fields = {
        one["path"]: one
        for one in fields_of(study)
        if one["owner"] == name and one["type"] == "quantity" and one["slider"] and one["value"] and one["shown"]
        if not machines or sought(one["path"])
    }
    known = quantities_of(drive)
    ends = {path: (one["slider"]["low"], one["slider"]["high"]) for path, one in fields.items() if path in known}
    place = {key: number(payload, key) for key in ("speed", "force")} if "speed" in payload else None
    demands = _demands(study, place)
    if np.all(demands(drive) <= 1.0):
        return Answer(header={"rows": [], "reason": "Nothing: it is within all limits."})
    rows: list[list[dict[str, Any]]] = []
    together = MACHINES_TOGETHER if machines else TOGETHER
    for changes in mending(drive, ends, demands, together):
        row = [_row(fields[path], change) for path, change in changes.items()]
        if len(rows) < _MOST and _holds(payload, row, name, place):
            rows.append(row)
    none = (
        f"No change of up to {together} of its {len(ends)} values together, each from a fifth to five times, is enough."
    )
    return Answer(header={"rows": rows, "reason": "" if rows else none})


def _demands(study: Study, place: Mapping[str, float] | None) -> Demands:
    """Demands over allowances of a drive at a point, or in all that the study requires."""
    if study.tasks or study.paths:
        return machine_demands(study)
    judge = Judge(study, 1.0) if place is None else None

    def demanded(drive: Any) -> np.ndarray:
        if judge is None:
            found = [float(np.max(one)) for one in operated(drive, **(place or {})).utilisation.values()]
        else:
            found = [float(one) for key, one in judge(drive).demands.items() if key[0] != STRUCTURE]
        return np.nan_to_num(found, nan=np.inf, posinf=np.inf)

    return demanded


def _row(field: Mapping[str, Any], change: Change) -> dict[str, Any]:
    """A change as the page shows and applies it, in the unit of the file, rounded to what is still enough."""
    shown = field["shown"]
    number = (change.stated - shown["offset"]) / shown["factor"]
    rounding = ROUND_CEILING if change.stated > change.start else ROUND_FLOOR
    rounded = Context(prec=_DIGITS, rounding=rounding).create_decimal(repr(number)).normalize()
    text = f"{rounded:f} {shown['unit']}".strip()
    label = " › ".join(filter(None, [field["group"], field["label"]]))
    return {
        "at": field["at"],
        "value": text if shown["unit"] else float(rounded),
        "label": label,
        "text": text,
        "was": field["written"],
    }


def _holds(payload: Mapping[str, Any], row: list[dict[str, Any]], name: str, place: Mapping[str, float] | None) -> bool:
    """Whether the drive of the changed tables keeps all limits, as values that follow from others may change as well."""
    try:
        tables = with_values(name_and_tables(payload)[1], [(change["at"], change["value"]) for change in row])
        study = study_of({**payload, "tables": tables})
        return bool(np.all(_demands(study, place)(study.drives[name]) <= 1.0))
    except (FaultyError, InfinivarError, RefusedError):
        return False
