"""A design as a column of a table: a drive or machine of a study in one state, with its mass, powers, temperatures and margin.

The page keeps designs and asks for each by itself; the numbers are those of `compare`, and of the drive at a point. So are those
of a drive with other parts, which it is tried with before one is picked.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from statistics import fmean
from typing import Any

from infinivar.analysis.at_a_glance import tightest
from infinivar.analysis.compare import Comparison
from infinivar.analysis.cycles.duty_cycle import duty_cycle
from infinivar.analysis.cycles.performance import motors_of, windings_after
from infinivar.analysis.machines import MachineResult, evaluate_machine
from infinivar.analysis.region import against
from infinivar.drivetrain.drive import is_machine
from infinivar.errors import InfinivarError
from infinivar.limits import words_of
from infinivar.parts.heat import REFERENCE, missing
from infinivar.sizing.tables import equal_shares
from infinivar.study.study import Study
from infinivar.units import ZERO_CELSIUS, margin_words, plain, show
from infinivar.web.answers import words
from infinivar.web.answers.answer import Answer, FaultyError, RefusedError
from infinivar.web.answers.document import name_and_tables, with_keys, with_values
from infinivar.web.answers.glance import compared
from infinivar.web.answers.payload import names, number, word
from infinivar.web.answers.places import place_of

_LONGEST = 1e7
"""Longest time for which motors are warmed. [s]"""

_MOST_TRIED = 16
"""Most parts tried in one answer, and most keys to a part."""


def design(study: Study, request: Mapping[str, Any]) -> dict[str, Any]:
    """What one drive or machine of a study weighs, spends, warms to, and what limits it.

    Parameters
    ----------
    study : Study
    request : mapping   drive: name; time: since the cold start of its motors, at 25 °C unless a motion states another [s]; with
        speed and force, also the drive at that point [m s^-1], [N] or about a joint.

    Returns
    -------
    dict
        title; able: whether it meets all that is required; rows: of key, label, `of`: in which motion or place, text and value
        (None where not known), `better` ("less", "more", or "" of words), `lacks`: what the value leaves out, and `beyond`:
        whether it exceeds what is permitted.

    Raises
    ------
    RefusedError
        If a value is of another kind than a page sends.
    """
    name, time = word(request, "drive", study.drives), number(request, "time")
    if not 0.0 < time <= _LONGEST:
        raise RefusedError(f"time must be above 0 and at most {_LONGEST:g} s")
    if not (study.requirement or study.duty or study.tasks or study.paths):
        return {"title": study.titles[name], "able": False, "rows": []}
    found = compared(request)
    if isinstance(found, Comparison):
        able, rows = found.able(name), list(_of_drive(found, name, time, request))
    else:
        able, rows = found.results[name].feasible, list(_of_machine(found.results[name]))
    margin, limit = tightest(found, name)
    rows += [
        _row("limit", "Tightest limit", None, limit or "none is loaded"),
        _row("margin", "Margin", margin, margin_words(margin), better="more", beyond=margin < 1.0),
    ]
    return {"title": study.titles[name], "able": able, "rows": rows}


def _row(key: str, label: str, value: float | None, text: str, **more: Any) -> dict[str, Any]:
    return {
        "key": key,
        "label": label,
        "value": None if value is None else words.number(value),
        "text": text,
        "of": "",
        "better": "",
        "lacks": "",
        "beyond": False,
        **more,
    }


def _watts(key: str, label: str, value: float, of: str = "") -> dict[str, Any]:
    return _row(key, label, value, show(value, "W", 3) if math.isfinite(value) else "–", of=of, better="less")


def _of_drive(found: Comparison, name: str, time: float, request: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield mass, powers and temperatures of a drive of one axis."""
    mass = found.masses.get(name)
    if mass is not None:
        yield _row("mass", "Mass", mass.known, mass.known_words, better="less", lacks=", ".join(mass.open))
    if found.mixed is not None:
        yield _watts("mixed", "Mean power", found.mixed.power[name], "mixed use")
    for key, cycle in found.duty.items():
        own = cycle.results[name]
        yield _watts(f"duty.{key}", "Mean power", own.power_in, own.duty.title or key)
        permissible = {what: hot.permissible for what, hot in own.heat.items() if hot is not None}
        yield _hottest(
            f"heat.{key}",
            own.duty.title or key,
            own.windings_after(time),
            permissible,
            own.lacking,
        )
    if found.study.requirement is not None:
        yield _watts("region", "Mean loss", found.results[name].mean_loss, "over the required region")
    drive = found.study.drives[name]
    if "speed" not in request or is_machine(drive):
        return
    place = place_of(found.study, request)
    point = place.point()
    yield _watts("point", "Power from the supply", float(point.power_in), place.words)
    motors = motors_of(drive)
    yield _hottest(
        "point.heat",
        f"holding {place.words}",
        windings_after(drive, point, time, time, ambient=REFERENCE),
        {what: motor.max_winding_temperature for what, motor in motors.items()},
        {what: missing(motor) for what, motor in motors.items()},
    )


def _hottest(
    key: str,
    of: str,
    found: Mapping[str, float],
    permissible: Mapping[str, float | None],
    lacking: Mapping[str, Sequence[str]],
) -> dict[str, Any]:
    """The warmest of the motors whose temperature is known; the others count as what the value leaves out."""
    unknown = [f"{what} without {', '.join(names)}" for what, names in lacking.items() if names]
    known = {what: kelvin for what, kelvin in found.items() if not math.isnan(kelvin)}
    lacks = "; ".join([*unknown, *(f"{what} without steady motion" for what in found if what not in known)])
    hottest = max(known.values(), default=math.nan)
    text = (
        "–"
        if math.isnan(hottest)
        else "without bound"
        if math.isinf(hottest)
        else f"{plain(hottest - ZERO_CELSIUS, 3)} °C"
    )
    beyond = any(kelvin > (permissible[what] or math.inf) for what, kelvin in known.items())
    return _row(key, "Hottest winding", hottest, text, of=of, better="less", lacks=lacks, beyond=beyond)


def _of_machine(found: MachineResult) -> Iterator[dict[str, Any]]:
    """Yield the mass of the motors, and the powers of a machine."""
    if math.isfinite(found.motor_mass):
        yield _row("motors", "Mass of the motors", found.motor_mass, show(found.motor_mass, "kg", 3), better="less")
    if found.shares:
        yield _watts("mixed", "Mean power", found.mean_power, "mixed use")
    for key, one in found.found.items():
        yield _watts(key, "Mean power", one.mean_power, one.title)


def tried(payload: Mapping[str, Any]) -> Answer:
    """A drive or machine with each of some parts in place of the present one: what it would spend, and its margin.

    Parameters
    ----------
    payload : mapping   Study; `drive`; `at`: keys of the part in the tables; `parts`: names in the catalogue, "" the present one.

    Header: rows, one a part: part; power: mean over the motions, else mean loss over the required region, else mean over tasks
    and paths [W], None where there is none; margin of the tightest limit; `able`; and words, or what is wrong with it.
    """
    name, tables = name_and_tables(payload)
    drive = word(payload, "drive", tables.get("drives", {}))
    at, parts = (names(payload, key, _MOST_TRIED) for key in ("at", "parts"))
    return Answer(header={"rows": [_tried({"name": name, "tables": tables}, drive, at, one) for one in parts]})


def _tried(document: dict[str, Any], drive: str, at: list[str], part: str) -> dict[str, Any]:
    try:
        study = with_keys(
            {**document, "tables": with_values(document["tables"], [(at, part)] if part else [])}, [drive]
        )[0]
        power, margin, limit = _needed(study, drive)
        spent = "on average" if study.duty or study.tasks or study.paths else "lost on average"
    except FaultyError as found:
        return {"part": part, "able": False, "words": found.faults[0]["message"]}
    except InfinivarError as problem:
        return {"part": part, "able": False, "words": str(problem)}
    watts = [f"{show(power, 'W', 3)} {spent}"] if math.isfinite(power) else []
    text = ", ".join([*watts, f"margin {margin_words(margin)} ({limit})"])
    return {
        "part": part,
        "able": margin >= 1.0,
        "power": words.number(power),
        "margin": words.number(margin),
        "words": text,
    }


def _needed(study: Study, name: str) -> tuple[float, float, str]:
    """Mean power, least margin and tightest limit of one drive or machine, as `compare` finds them."""
    drive = study.drives[name]
    if study.tasks or study.paths:
        machine = evaluate_machine(study, name)
        tight = min(machine.found.values(), key=lambda one: one.margin)
        power = machine.mean_power if machine.shares else fmean(one.mean_power for one in machine.found.values())
        return power, tight.margin, words_of(tight.demand)
    powers, margins = [], []
    for key, duty in study.duty.items():
        cycle = duty_cycle(drive, duty, travel=study.travel)
        powers.append(equal_shares(study.duty)[key] * cycle.power_in)
        margins.append((cycle.tightest[1], words_of(cycle.tightest[0])))
    loss = math.nan
    if study.requirement is not None:
        judged, _, _ = against(name, drive, study.requirement)
        loss = judged["mean_loss"]
        margins.append((judged["tightest"].value, judged["tightest"].limit.words))
    return sum(powers) if powers else loss, *min(margins)
