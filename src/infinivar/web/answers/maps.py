"""What the page begins with, and maps of the drives of a study on the force-speed plane: efficiency and limit, cell by cell.

At the start the page gets the study of the command line with its first maps, the shipped ones, and what was left behind.

Arrays of drive D, each (count, count), first index force, second index speed, from the low to the high end of the plane:
`D/efficiency` float32, nan where it is undefined; `D/limit` uint8, an index of the header's `limits`; `D/margin` float32, at most
`operating_map.CLEAR`, below 1 beyond limits; and, where the load drives and the supply gets nothing back, `D/loss` float32 in W,
nan elsewhere. `speed` and `force` float64 are the centres of the cells.
The header has what a page needs to draw them: the ends and units of the plane, the requirement and the titles.
A drive whose tag the page knows has not changed: its arrays are not computed and not sent again. Verdicts on the requirement are
in the header if they are known already; `judge` computes them.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar import __version__
from infinivar.analysis.compare import DriveResult
from infinivar.analysis.plane import of_requirement, of_study
from infinivar.analysis.region import against
from infinivar.analysis.steady_map import SteadyMap, steady_map
from infinivar.analysis.whole_mass import mass_of
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import is_machine
from infinivar.errors import InfinivarError
from infinivar.figures import operating_map
from infinivar.limits import Limit
from infinivar.study.load import read_tables
from infinivar.study.shipped import shipped_studies
from infinivar.study.study import Study
from infinivar.web.answers.answer import Answer, FaultyError
from infinivar.web.answers.document import begin_again, key_of, name_and_tables, source, stamp, study_of, with_keys
from infinivar.web.answers.payload import MOST_CELLS, texts, whole, words
from infinivar.web.answers.recent import Recent
from infinivar.web.answers.studies import plane_of, required_of

_FINEST_LABELS = 80
"""Cells along each axis, about, of the map on which the labels of regions are placed."""

_SMALLEST_SHARE = 0.004
"""Regions of a limit below this share of the map get no label."""

_KEPT = 48
"""Maps, and verdicts, kept."""

_verdicts: Recent[str, dict[str, Any]] = Recent(_KEPT)
_maps: Recent[str, tuple[dict[str, Any], dict[str, np.ndarray]]] = Recent(_KEPT)


MOST_MAPS = 2
"""Drives shown at first: the first, and the last, which a study lists to compare it with."""


def start(payload: Mapping[str, Any]) -> Answer:
    """What the page begins with; with `count`, also the maps of `most` drives, as `maps` answers them.

    With `again` the files of the study are read anew.
    """
    if payload.get("again") is True:
        begin_again()
    begun = source()
    header = {
        "version": __version__,
        "study": {"name": begun.name, "tables": begun.tables, "text": begun.text},
        "stamp": begun.stamp,
        "shipped": _shipped(),
        "recovered": _recovered(payload),
    }
    if "count" not in payload:
        return Answer(header=header)
    requested = {**header["study"], "count": whole(payload, "count", 8, MOST_CELLS)}
    names = list(begun.tables.get("drives", {}))
    shown = dict.fromkeys([*names[:1], *names[-1:]][: whole(payload, "most", 1, MOST_MAPS, MOST_MAPS)])
    try:
        made = maps({**requested, "drives": list(shown)})
    except FaultyError:  # a file may have changed since: the page asks again, and then shows the fault
        return Answer(header=header)
    return Answer(header={**header, "maps": made.header}, arrays=made.arrays)


def disk(payload: Mapping[str, Any]) -> Answer:
    """Whether the files of the study have changed: the same stamp as in `start` if they have not."""
    return Answer(header={"stamp": stamp()})


def _recovered(payload: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What pages of servers before this one edited last, as the server found it."""
    found = payload.get("recovered")
    listed = [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []
    return [
        {**{key: str(one.get(key, "")) for key in ("id", "name", "time")}, "tables": one["tables"]}
        for one in listed
        if isinstance(one.get("tables"), dict)
    ]


@functools.cache
def _shipped() -> list[dict[str, str]]:
    listed = []
    for name, file in shipped_studies().items():
        tables = read_tables(file)
        listed.append({"name": name, "title": tables.get("title", name), "description": tables.get("description", "")})
    return listed


def maps(payload: Mapping[str, Any]) -> Answer:
    """Maps of the requested drives, by default of all."""
    count, known = whole(payload, "count", 8, MOST_CELLS, 60), texts(payload, "known")
    requested = _asked(payload)
    study = requested[0][1] if requested else study_of(payload)
    if not (study.duty or study.requirement):
        return Answer(header={"drives": {}, "reason": "machines have tasks instead of maps"})
    axes = of_study(study).axes(count)
    found: dict[str, Any] = {}
    arrays: dict[str, np.ndarray] = {"speed": axes[0], "force": axes[1]}
    for name, study, key in requested:
        tag = key_of(key, *axes)
        if known.get(name) == tag:
            found[name] = {"tag": tag, "same": True}
            continue
        header, made = _kept(tag, name, study, axes)
        shown = {"title": study.titles[name], "requirement": _verdicts.get(key)}
        found[name] = {"tag": tag, "same": False, **shown, **header}
        arrays |= {f"{name}/{key}": array for key, array in made.items()}
    header = {"count": count, "plane": plane_of(study), "requirement": required_of(study), "drives": found}
    return Answer(header=header, arrays=arrays)


def _asked(payload: Mapping[str, Any]) -> list[tuple[str, Study, str]]:
    """Name, study and key of each requested drive, by default of all; machines have no maps.

    Each by itself: when a slider moves, one drive is another one, and the studies of the others are at hand.
    """
    every = name_and_tables(payload)[1].get("drives")
    found, faults = [], []
    for name in words(payload, "drives", every if isinstance(every, dict) else ()):
        try:
            study, keys = with_keys(payload, [name])
        except FaultyError as problem:
            faults += [fault for fault in problem.faults if fault not in faults]
            continue
        if not is_machine(study.drives[name]):
            found.append((name, study, keys[name]))
    if faults:
        raise FaultyError(faults)
    return found


def _kept(
    tag: str, name: str, study: Study, axes: tuple[np.ndarray, np.ndarray]
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    if tag in _maps:
        return _maps[tag]
    try:
        made = _computed(name, study, axes)
    except InfinivarError as problem:
        return {"fault": str(problem)}, {}
    _maps[tag] = made
    return made


def _computed(
    name: str, study: Study, axes: tuple[np.ndarray, np.ndarray]
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Header and arrays of the map of one drive."""
    drive, required = study.drives[name], study.requirement
    steady = steady_map(drive, *axes)
    shown = operating_map.data(steady, required)
    codes = sorted({int(Limit.OK), *np.unique(steady.limit).tolist()})
    limits = [Limit(code) for code in codes]
    arrays = {
        "efficiency": shown["efficiency"].T.astype(np.float32),
        "limit": np.searchsorted(codes, steady.limit).T.astype(np.uint8),
        "margin": np.clip(shown["margin"], 0.0, operating_map.CLEAR).T.astype(np.float32),
    }
    if np.isfinite(shown["loss"]).any():
        arrays["loss"] = shown["loss"].T.astype(np.float32)
    header = {
        "limits": [limit.words for limit in limits],
        "limit_names": [limit.name for limit in limits],
        "labels": _labels(steady, limits),
        "engine": steady.engine,
        "audit_residual": steady.audit_residual,
        "largest_loss": shown["largest_loss"],
    }
    return header, arrays


def judge(payload: Mapping[str, Any]) -> Answer:
    """Drives against the requirement: the numbers and the verdict of `compare`; empty without a requirement.

    Apart from the maps, which must follow a slider: the required region is sampled far more finely than a map.
    """
    found: dict[str, Any] = {}
    for name, study, key in _asked(payload):
        if study.requirement is None:
            break
        try:
            # Motions and envelope, of which no verdict on the requirement depends, may have changed since.
            found[name] = _verdicts[key] = {**_judged(name, study, key), **_sized(study, study.drives[name])}
        except InfinivarError as problem:
            found[name] = {"fault": str(problem)}
    return Answer(header={"drives": found})


def _judged(name: str, study: Study, key: str) -> dict[str, Any]:
    """One drive against the requirement, as `compare` judges it."""
    drive, required = study.drives[name], study.required("judge")
    if key in _verdicts:
        return _verdicts[key]
    values, _, residual = against(name, drive, required)
    few = steady_map(drive, *of_requirement(required).axes(2))
    result = DriveResult(
        name=name,
        title=study.titles[name],
        drive=drive,
        peak_efficiency=float("nan"),
        map=few,
        audit_residual=max(residual, few.audit_residual),
        **values,
    )
    tight = result.tightest
    tightest = tight and {
        "limit": tight.limit.name,
        "words": tight.limit.words,
        "margin": tight.value,
        "force": tight.force,
        "speed": tight.speed,
    }
    found = {
        "covers": result.covers,
        "coverage": result.coverage,
        "verdict": result.verdict,
        "mean_loss": result.mean_loss,
        "peak_efficiency_in_region": result.peak_efficiency_in_region,
        "tightest": tightest,
    }
    _verdicts[key] = found
    return found


def _sized(study: Study, drive: Any) -> dict[str, Any]:
    """Size in words, and whether the drive is within the envelope of the study; nothing of other packages' drives."""
    if not isinstance(drive, CoboticDrive | ConventionalDrive):
        return {}
    mass = mass_of(drive, study.service(drive), doubted=False)
    words = mass.space_words if study.envelope is None else mass.words_on(study.envelope)
    return {"size": words, "fits": mass.within(study.envelope)}


def _labels(steady: SteadyMap, limits: list[Limit]) -> list[dict[str, Any]]:
    """Where each limit is named on the map: within its region, as far from the edges as can be."""
    from scipy.ndimage import distance_transform_cdt

    step = max(1, steady.limit.shape[0] // _FINEST_LABELS)
    coarse, labels = steady.limit[::step, ::step], []
    for limit in limits:
        region = coarse == limit
        if limit == Limit.OK or region.mean() < _SMALLEST_SHARE:
            continue
        depth: Any = distance_transform_cdt(np.pad(region, 1))
        row, column = np.unravel_index(np.argmax(depth[1:-1, 1:-1]), region.shape)
        labels.append(
            {
                "limit": limit.name,
                "words": limit.words,
                "speed": float(steady.speed[row * step]),
                "force": float(steady.force[column * step]),
                "depth": float(depth.max()) / region.shape[0],
            }
        )
    return labels
