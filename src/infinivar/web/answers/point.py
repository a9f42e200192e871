"""The power balance of a drive at one place, from the supply to the load: flows, losses, limits and states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar import power
from infinivar.analysis.tightest import tight_words, tightest_of
from infinivar.drivetrain.conventional import STAGES
from infinivar.figures import style
from infinivar.limits import LEADING, Demand, Limit, words_of
from infinivar.study.study import Study
from infinivar.units import times
from infinivar.web.answers import words
from infinivar.web.answers.places import Place, place_of

_OF_SERVOS = ("amplifier", "winding", "motor friction", "motor iron", "bearing", "patch")

PASSED = (
    ("resistance of the battery", ("battery",)),
    ("steering", tuple(f"steering {name}" for name in _OF_SERVOS)),
    ("amplifier", ("amplifier",)),
    ("motor", ("winding", "motor friction", "motor iron")),
    ("gearhead", ("gearhead", "gearhead damping")),
    ("cylinder", ("cylinder bearings", "backing rollers")),
    ("wheel", ("creep", "spin", "slip", "rolling", "bearing", "wheels", "rollers")),
    ("output stage", (*STAGES, "belt damping")),
    ("guideway", ("guideway",)),
)
"""What power passes on its way from the supply to the load, and the losses in it; all other losses are of the output."""

_ROUNDING = 1e-12
"""Power over the largest one below which what is left after the losses is rounding."""

_OUTPUT = "springs and linkage"
_SUPPLY, _LOAD = "supply", "load"


def point(study: Study, request: Mapping[str, Any]) -> dict[str, Any]:
    """Power balance at a place, as a page draws it.

    Parameters
    ----------
    study : Study
    request : mapping   As in `place_of`.

    Returns
    -------
    dict
        drive, title, place: words; task; feasible; verdict; limit: None or limit, words and share of the tightest; efficiency,
        power_in, power_out, loss [W]; utilisation: rows of limit, words, share, from the largest; stages: from supply to load;
        flows: rows of from, to, watts, label, colour, kind ("power" between neighbours, "loss" out of a stage), all watts >= 0,
        in the direction in which power flows; balance_residual [-]; state: rows of label and text; parts: rows, of machines.

    Raises
    ------
    InputError
        If a name is unknown or a number is missing.
    """
    place = place_of(study, request)
    found = place.point()
    demands = _demands(place, found)
    worst, margin = tightest_of(demands)
    feasible = margin >= 1.0
    power_in, power_out = float(found.power_in), float(found.power_out)
    losses = {name: float(loss) for name, loss in found.losses.items()}
    known = bool(np.all(np.isfinite([power_in, power_out, *losses.values()])))
    stages, flows = _flows(_source(place), power_in, losses) if known else ([], [])
    efficiency = power.efficiency(found.power_in, found.power_out) if feasible else np.nan
    return {
        "drive": place.name,
        "title": place.title,
        "place": place.words,
        "task": place.task,
        "feasible": feasible,
        "verdict": _verdict(worst, margin, known),
        "limit": None
        if feasible
        else {
            "limit": worst[0].name,
            "words": words_of(worst),
            "share": words.number(1.0 / margin if margin else np.inf),
        },
        "efficiency": words.number(efficiency),
        "power_in": words.number(power_in),
        "power_out": words.number(power_out),
        "loss": words.number(sum(losses.values())),
        "utilisation": _utilisation(demands),
        "stages": stages,
        "flows": flows,
        "balance_residual": words.number(
            power.residual(found.power_in, found.power_out + _stored(found), found.losses)
        ),
        "state": list(words.states(found.states)),
        "parts": _parts(found),
    }


def _stored(found: Any) -> Any:
    """Power into what moves within a machine; of a steady point none. [W]"""
    return sum(getattr(found, "stored", {}).values())


def _source(place: Place) -> str:
    """What feeds the drive: a cart has no motor, and is pushed."""
    return getattr(place.drive, "source", _SUPPLY)


def _demands(place: Place, found: Any) -> dict[Demand, float]:
    """Demand over allowance by limit and part."""
    if place.in_task:
        return {key: float(demand) for key, demand in found.demands.items()}
    return {(limit, "load"): float(demand) for limit, demand in found.utilisation.items()}


def _verdict(worst: Demand, margin: float, known: bool) -> str:
    """Whether the place is feasible, which limit is the tightest, and by how much it is exceeded."""
    if margin >= 1.0:
        return f"feasible; {tight_words(worst, margin)}"
    if margin == 0.0:
        return f"infeasible: {tight_words(worst, margin)}"
    end = "" if known else "; no steady motion, so that powers are undefined"
    return f"infeasible: {words_of(worst)}, {times(1.0 / margin)} the allowance{end}"


def _utilisation(demands: Mapping[Demand, float]) -> list[dict[str, Any]]:
    """Rows by limit and part, the limits that lead first where they are exceeded, then from the largest demand."""

    def rank(key: Demand) -> tuple[bool, float]:
        demand = demands[key]
        return not (key[0] in LEADING and not demand <= 1.0), -demand if np.isfinite(demand) else 0.0

    return [
        {"limit": key[0].name, "words": words_of(key), "share": words.number(demands[key])}
        for key in sorted(demands, key=rank)
    ]


def _flows(source: str, power_in: float, losses: Mapping[str, float]) -> tuple[list[str], list[dict[str, Any]]]:
    """Stages from the source to the load, and the flows between neighbours and out of them.

    What passes between two stages is the power from the source less the losses before: the balance, summed stage by stage.
    """
    rest = dict(losses)
    stages = [(stage, {name: rest.pop(name) for name in names if name in rest}) for stage, names in PASSED]
    stages = [(stage, own) for stage, own in stages if own]
    if rest:
        stages.append((_OUTPUT, rest))
    names = [source, *(stage for stage, _ in stages), _LOAD]
    passing, flows = power_in, []
    rounding = _ROUNDING * (abs(power_in) + sum(losses.values()))
    for place, after in enumerate(names[1:]):
        flows.append(_passing(names[place], after, passing if abs(passing) > rounding else 0.0))
        if after == _LOAD:
            break
        for name, watts in stages[place][1].items():
            flows.append(
                {
                    "from": after,
                    "to": "loss",
                    "watts": max(watts, 0.0),
                    "label": name,
                    "colour": style.loss_colour(name),
                    "kind": "loss",
                }
            )
            passing -= watts
    return names, flows


def _passing(before: str, after: str, watts: float) -> dict[str, Any]:
    """Power between two neighbours, in the direction in which it flows."""
    ends = (before, after) if watts >= 0 else (after, before)
    return {"from": ends[0], "to": ends[1], "watts": abs(watts), "label": "", "colour": None, "kind": "power"}


def _parts(found: Any) -> list[dict[str, str]] | None:
    """Each part of a machine that shares the load; None for a drive of one axis."""
    names = getattr(found, "parts", ())
    if len(names) < 2:
        return None
    force_unit, speed_unit = found.part_units
    rows = []
    for place, name in enumerate(names):
        own = {limit: demand for (limit, part), demand in found.demands.items() if part == name}
        worst = max(own, key=lambda limit: float(np.nan_to_num(own[limit])), default=Limit.OK)
        rows.append(
            {
                "part": name,
                "force": words.quantity(found.part_forces[place], force_unit),
                "speed": words.quantity(found.part_speeds[place], speed_unit),
                "steering": words.quantity(np.degrees(found.steering[place]), "°"),
                "loss": words.quantity(found.part_losses[place], "W"),
                "demand": "" if worst is Limit.OK else f"{words.quantity(100.0 * own[worst], '%', 2)} of {worst.words}",
            }
        )
    return rows
