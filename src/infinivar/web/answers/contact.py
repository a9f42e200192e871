"""The rolling contact of a drive at one place: its creep curve, and the patch with its areas of stick and slip."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from infinivar.contact import creep
from infinivar.contact.exact.patch import RollingPatch
from infinivar.drivetrain import chain
from infinivar.drivetrain.cobotic import CoboticDrive, legs_of
from infinivar.errors import ParameterError
from infinivar.figures import rolling_patch
from infinivar.limits import Limit
from infinivar.machines.rolling import RollingState, creep_ratio
from infinivar.study.study import Study
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.web.answers import payload, words
from infinivar.web.answers.answer import Answer
from infinivar.web.answers.places import Place, place_of

CELLS = 16
"""Cells along each side of the patch: 50 ms, and its force errs by about 0.003 of mu P."""

MOST_PARTS = 1000
"""Largest number of a wheel that a page may ask for."""

_POINTS = 161
_REACH = 1.25
"""Extent of the creep curve over the creepage at which the wheel slips."""

_BEYOND = 2.0
"""Creepage of a wheel that slips, over that of full slip, at which its patch is drawn."""


def contact(study: Study, request: Mapping[str, Any]) -> Answer:
    """Creep curve and patch at a place, as a page draws them; of the wheel nearest to slip if there are several.

    Parameters
    ----------
    study : Study
    request : mapping   As in `places.place_of`; part: number of the wheel, from 1, instead of the one nearest to slip.

    Returns
    -------
    Answer
        Header: reason: why there is no contact to show, else None, and then nothing else but drive, title and place; wheel:
        its name; wheels: all names; law; force_name: of its force; slip_force [N], slip_creepage [per mille]; point: None, or
        creepage [per mille] and force [N], both as magnitudes; slip_demand [-]; slips; state: rows of label and text; patch:
        None, or a, b [mm], rotation [degrees], peak_pressure [GPa], slip_share [-], force_share: what the patch carries over mu
        P [-], width of its cells [mm]; patch_reason: why there is no patch, else None.
        Arrays: creepage [per mille], force, linear [N]; patch/x, patch/y (rows, cells): middles of cells [mm], patch/length
        (rows,) [mm], patch/slides, patch/share: traction over friction bound [-], patch/pressure [GPa], patch/traction (2, rows,
        cells) [MPa], patch/outline (2, n) [mm]. x is the rolling direction.

    Raises
    ------
    InputError
        If a name is unknown or a number is missing.
    """
    place = place_of(study, request)
    head = {"drive": place.name, "title": place.title, "place": place.words, "task": place.task, "reason": None}
    states = rolling_states(place)
    if not states:
        return Answer(header={**head, "reason": _why_none(place)})
    part = payload.whole(request, "part", 0, MOST_PARTS, 0)
    state = max(states, key=lambda one: one.slip_demand if math.isfinite(one.slip_demand) else math.inf)
    if 1 <= part <= len(states):
        state = states[part - 1]
    curve, arrays = _curve(state)
    patch, reason, cells = _patch(state)
    header = {
        **head,
        "wheel": state.name,
        "wheels": [one.name for one in states],
        **curve,
        "slips": state.slips,
        "slip_demand": words.number(state.slip_demand),
        "state": list(_rows(state)),
        "patch": patch,
        "patch_reason": reason,
    }
    return Answer(header=header, arrays=words.single({**arrays, **cells}))


def _why_none(place: Place) -> str:
    if hasattr(place.drive, "rolling"):
        return f"{place.title} is at rest: its wheels are locked and do not creep"
    if legs_of(place.drive) is not None:
        return f"{place.title} does not reach this pose, so that nothing is known of its wheels"
    return f"{place.title} has no rolling contact: nothing creeps or slips in it"


def rolling_states(place: Place) -> list[RollingState]:
    """The wheels of a drive or machine at a place; empty if nothing rolls."""
    drive = place.drive
    if isinstance(drive, CoboticDrive) and not place.in_task:
        return [_of_wheel(drive, element_point(drive, place.speed, place.force), "wheel")]
    if isinstance(drive, CoboticDrive):
        return [_of_wheel(drive, element_point(drive, place.twist[0], place.wrench[0]), "wheel")]  # type: ignore[index]
    leg = legs_of(drive)
    if leg is not None:
        return list(_legs(place, leg))
    return list(drive.rolling(place.point(), place.twist, place.wrench)) if hasattr(drive, "rolling") else []


def element_point(drive: CoboticDrive, speed: float, force: float) -> OperatingPoint:
    """The wheel and cylinder of a drive at a speed and force of its load, as its `operate` has them."""
    load = chain.steady(drive.output.chain, position=0.0, speed=speed, force=force, axis=drive.axis)
    preload = drive.transmission.unbalanced_preload
    drag, _ = drive.guideway.operate(force=load.force, speed=load.speed, preload=preload)
    return drive.transmission.deliver(
        cylinder_speed=drive.cylinder_speed, link_speed=load.speed, link_force=load.force + drag
    )


def _of_wheel(drive: CoboticDrive, point: OperatingPoint, name: str) -> RollingState:
    """A wheel on a cylinder, from its operating point."""
    element = drive.transmission
    tangent = float(point.steering_tangent)
    sine_squared = tangent * tangent / (1.0 + tangent * tangent)
    groups = element.wheel.groups(element.cylinder_radius * drive.cylinder_speed)
    pressed = element.contact
    if math.isfinite(tangent):
        groups = groups.steered(sine_squared)
        if element.geometry is not None:
            pressed = element.geometry.press(
                wheel_radius=element.wheel_radius,
                cylinder_radius=element.cylinder_radius,
                preload=element.preload,
                steering_angle=math.atan(tangent),
            )
    return RollingState(
        name=name,
        law=element.creep_law,
        groups=groups,
        lateral_force=float(point.lateral_force) / element.wheels,
        creepage=creep_ratio(point.creep_speed, point.rolling_speed),
        slip_demand=float(point.utilisation[Limit.SLIP]),
        contact=pressed,
        preload=element.preload,
        notes=tuple((one["label"], one["text"]) for one in words.steering(tangent)),
    )


def _legs(place: Place, leg: CoboticDrive) -> Iterator[RollingState]:
    """Wheels of the legs of a platform or an arm: each is the leg at the force and speed of its link."""
    point = place.point()
    lever = getattr(place.drive, "pulley_radius", 1.0)
    for name, force, speed in zip(
        point.parts, np.asarray(point.part_forces) / lever, np.asarray(point.part_speeds) * lever, strict=True
    ):
        if math.isfinite(force) and math.isfinite(speed):
            yield _of_wheel(leg, element_point(leg, float(speed), float(force)), name)


def _curve(state: RollingState) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The law of the wheel as force over creepage, the line without slip, and where the wheel stands."""
    groups, formulas = state.groups, state.groups.formulas(state.law)
    slip_force, group = float(groups.slip_force), float(groups.creep_group)
    slip = float(groups.slip_creepage(state.law)) / group
    creepage = np.linspace(0.0, _REACH * slip, _POINTS)
    force = slip_force * np.where(creepage < slip, np.asarray(formulas.force(group * creepage)), 1.0)
    header = {
        "law": state.law.name,
        "force_name": state.force_name,
        "slip_force": slip_force,
        "slip_creepage": 1e3 * slip,
        "point": None
        if state.slips or not math.isfinite(state.creepage)
        else {"creepage": 1e3 * abs(state.creepage), "force": abs(state.lateral_force)},
    }
    line = np.minimum(float(groups.creep_stiffness) * creepage, slip_force)
    return header, {"creepage": 1e3 * creepage, "force": force, "linear": line}


def _rows(state: RollingState) -> Iterator[dict[str, str]]:
    """The numbers of the contact in words."""
    groups = state.groups
    yield words.row(state.force_name, words.quantity(state.lateral_force, "N"))
    yield words.row("slip limit μP", words.quantity(groups.slip_force, "N"))
    yield words.row("share of the slip limit", words.quantity(100.0 * state.slip_demand, "%"))
    yield words.row("creepage", words.quantity(1e3 * state.creepage, "‰"))
    yield words.row("creep stiffness", words.quantity(1e-3 * groups.creep_stiffness, "kN"))
    yield words.row("preload", words.quantity(state.preload, "N"))
    if state.contact is not None:
        patch = state.contact.patch
        yield words.row(
            "patch, rolling × lateral", f"{words.quantity(2e6 * patch.a, '')} × {words.quantity(2e6 * patch.b, 'µm')}"
        )
        yield words.row("peak pressure", words.quantity(1e-9 * patch.peak_pressure, "GPa"))
    for label, note in state.notes:
        yield words.row(label, note if isinstance(note, str) else words.quantity(math.degrees(note), "°"))


def _patch(state: RollingState) -> tuple[dict[str, Any] | None, str | None, dict[str, np.ndarray]]:
    """The patch under the force of the wheel, by exact rolling theory; or why there is none."""
    found = state.contact
    if found is None:
        reason = "the contact is stated by measured values, which do not give the size of its patch; state its geometry to see it"
        return None, reason, {}
    share = state.lateral_force / float(state.groups.slip_force)
    if state.slips:
        share = math.copysign(1.0, share) if math.isfinite(share) else 1.0
    if not math.isfinite(share):
        return None, "the force on the contact is undefined here", {}
    try:
        patch = RollingPatch(found.axis_ratio, found.poisson, float(found.rotation), CELLS)
        most = _BEYOND * found.full_slip
        scaled = (
            math.copysign(most, share)
            if abs(share) >= 1.0
            else float(creep.EXACT.on(found.axis_ratio, found.poisson).creepage(share))
        )
        # The exact law is in terms of C11 G a b or C22 G a b; the patch in terms of G a b.
        if state.along:
            steady = patch.steady(scaled / float(found.coefficients.c11), 0.0, 0.0)
        else:
            steady = patch.steady(0.0, scaled / float(found.lateral_coefficient), 0.0)
        numbers = rolling_patch.data(steady)
    except ParameterError as problem:  # a patch longer than exact theory is computed for
        return None, f"the patch cannot be computed: {problem}", {}
    a, b = float(found.patch.a), float(found.patch.b)
    size = 1e3 * math.sqrt(a * b)
    stress = state.groups.slip_force / (a * b)
    header = {
        "a": 1e3 * a,
        "b": 1e3 * b,
        "rotation": math.degrees(float(found.rotation)),
        "peak_pressure": 1e-9 * float(found.patch.peak_pressure),
        "slip_share": numbers["slip_share"],
        "force_share": words.number(steady.fx if state.along else steady.fy),
        "width": size * float(numbers["width"]),
    }
    arrays = {
        "patch/x": size * numbers["x"],
        "patch/y": size * numbers["y"],
        "patch/length": size * np.asarray(numbers["length"]),
        "patch/slides": np.asarray(numbers["slides"], dtype=np.uint8),
        "patch/share": numbers["share"],
        "patch/pressure": 1e-9 * state.preload / (a * b) * steady.grid.bound,
        "patch/traction": 1e-6 * stress * numbers["traction"],
        "patch/outline": size * numbers["outline"],
    }
    return header, None, arrays
