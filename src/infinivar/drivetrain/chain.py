"""Motion and force on the drive's side of its springs and linkage, from those of the load.

Each element of `Output.chain` maps two rows of time derivatives inward, exactly, by the chain rule: x, the position, and F, the
force or moment that the drive's side exerts towards the load.

- A parallel spring adds its force at x.
- A linkage maps x to g(x) and F to F/g'(x); beyond a dead centre there is no motion, and all but the position is nan.
- A guideway adds its friction to F; its jump where the motion reverses has no rate.
- A series spring adds its deflection under F to x; where a one-sided one would have to pull, there is no motion either. The
  drive's speed thus contains the rate of the force: with a load m and a spring k, ``x_drive' = x' + (m x''' - f')/k``, and
  the drive's acceleration contains the fourth derivative of x.

The load's inertia is in F from the start: ``F = m x'' - f``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeVar

from infinivar._core import chain_rule
from infinivar._core.array_namespace import Array, namespace
from infinivar.axis import ROTARY, Axis
from infinivar.drivetrain.output import Place
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.motion.course import Course, heading
from infinivar.parts import history
from infinivar.parts.elastic import Elastic
from infinivar.parts.linear import Guideway
from infinivar.parts.linkage import Linkage

T = TypeVar("T")


class Inward(NamedTuple):
    """What a drive sees of its load through its springs and linkage."""

    course: Course
    """Motion of the drive's output; its external force is that of the chain, so that the mass to move is `mass`."""
    mass: Array
    """Mass of a load that the drive moves directly; 0 behind springs or a linkage, which transmit its force. [kg]"""
    losses: Mapping[str, Array]
    stored: Mapping[str, Array]
    utilisation: Mapping[Demand, Array]
    states: Mapping[str, Array]


class _Rows:
    """Rows of derivatives on the way from the load to the drive, and what the elements passed so far add to the results."""

    def __init__(self, position: list[Array], force: list[Array], rotary: bool, closes: bool) -> None:
        self.position, self.force = position, force
        self.rotary, self.closes = rotary, closes
        self.losses: dict[str, Array] = {}
        self.stored: dict[str, Array] = {}
        self.utilisation: dict[Demand, Array] = {}
        self.states: dict[str, Array] = {}

    def pass_through(self, place: Place) -> None:
        """Map position and force from the load's side of an element to the drive's side."""
        if isinstance(place.part, Linkage):
            self._linkage(place.part, place.name)
        elif place.kind == "guideway":
            self.guideway(place.part, place.name)
        elif place.kind == "series":
            self._series(place.part, place.name)
        else:
            self._parallel(place.part, place.name)

    def _linkage(self, linkage: Linkage, name: str) -> None:
        angle = self.position
        slopes = linkage.derivatives(angle[0], max(len(angle) - 1, len(self.force)))
        self.utilisation[Limit.LINKAGE, name] = linkage.demand(angle[0])
        if linkage.dead_centres:
            xp, lost = namespace(linkage, angle[0]), linkage.beyond_reach(angle[0])
            slopes = [slopes[0], *(xp.where(lost, xp.nan, slope) for slope in slopes[1:])]
        self.states["lever_arm_m" if not linkage.rotary_drive else "linkage_ratio"] = slopes[1] + 0.0 * angle[0]
        self.position = chain_rule.composed(slopes, angle)
        self.force = chain_rule.quotient(self.force, chain_rule.composed(slopes[1:], angle))
        self.rotary = linkage.rotary_drive

    def guideway(self, guide: Guideway, name: str) -> None:
        """Add the friction of a guideway, at a steady speed or along a motion."""
        speed = self.position[1] if len(self.position) == 2 else heading(*self.position[1:3])
        drag, self.losses[name] = guide.operate(force=self.force[0], speed=speed)
        self.force = [self.force[0] + drag, *self.force[1:]]

    def _parallel(self, spring: Elastic, name: str) -> None:
        x = self.position
        force = chain_rule.composed(spring.derivatives(x[0], len(self.force) - 1), x)
        self.stored[name] = force[0] * x[1]
        self.utilisation[Limit.SPRING, name] = spring.demand(x[0])
        self.force = chain_rule.total(self.force, force)
        if spring.hysteretic:
            state = history.along_positions(spring, x[0], self.closes)
            friction = chain_rule.composed(spring.hysteresis_derivatives(state, x[1], len(self.force) - 1), x)
            self.force = chain_rule.total(self.force, friction)
            self._hysteresis(spring, name, state, x[1])
        self._state(name, "force", force[0], force=True)

    def _series(self, spring: Elastic, name: str) -> None:
        force, orders = self.force, min(len(self.force), len(self.position)) - 1
        if not spring.hysteretic:
            row = spring.deflection_derivatives(force[0], orders)
            deflection = chain_rule.composed(row, force)
            self.stored[name] = force[0] * deflection[1]
        else:
            at, state = history.under_forces(spring, force[0], self.closes)
            friction = spring.hysteresis_derivatives(state, force[1], orders)
            total = chain_rule.total(spring.derivatives(at, orders), friction)
            deflection = chain_rule.composed(chain_rule.inverse(total, at), force)
            self.stored[name] = (force[0] - state) * deflection[1]
            self._hysteresis(spring, name, state, deflection[1])
        xp = namespace(deflection[0], force[0])
        demand, pull = spring.demand(deflection[0]), spring.pull_demand(force[0])
        self.utilisation[Limit.SPRING, name] = xp.where(pull > demand, pull, demand)
        if spring.shape == "one-sided":
            deflection = [deflection[0], *(xp.where(pull > 1.0, xp.nan, rate) for rate in deflection[1:])]
        self.position = chain_rule.total(self.position, deflection)
        self._state(name, "deflection", deflection[0], force=False)

    def _hysteresis(self, spring: Elastic, name: str, state: Array, speed: Array) -> None:
        self.losses[f"{name} hysteresis"] = spring.hysteresis_loss(state, speed)
        self.stored[f"{name} hysteresis"] = spring.hysteresis_stored(state, speed)

    def _state(self, name: str, what: str, value: Array, *, force: bool) -> None:
        unit = ("Nm" if self.rotary else "N") if force else ("rad" if self.rotary else "m")
        self.states[f"{name.replace(' ', '_')}_{what}_{unit}"] = value


def inward(chain: Sequence[Place], course: Course, load_mass: Array, axis: Axis, orders: tuple[int, int]) -> Inward:
    """Motion and force on the drive's side of its output.

    Parameters
    ----------
    chain : sequence of Place  Springs and linkage, from the load to the drive.
    course : Course            Of the load, with its position, and the derivatives that the springs require.
    load_mass : (...,) float   [kg], or about a joint [kg m^2]
    axis : Axis                Of the load.
    orders : (int, int)        Derivatives that the drive requires: of its position, and of the force on it.

    Returns
    -------
    Inward   Without springs and linkage the course and mass as given.

    Raises
    ------
    ParameterError
        If the course lacks the position, or a derivative that a series spring requires.
    """
    if not chain:
        return Inward(course, load_mass, {}, {}, {}, {})
    far, push = orders
    if any(place.kind == "series" for place in chain):
        push = max(push, far)
    known = max(far, push)
    massless = isinstance(load_mass, (int, float)) and load_mass == 0
    moved = [course.position, course.speed, course.acceleration, course.jerk, course.snap, course.fifth, course.sixth]
    pushed = [course.force, course.force_rate, course.force_curvature, course.force_third, course.force_fourth]
    names = ("position", "speed", "acceleration", "jerk", "snap", "fifth", "sixth")
    for row, fields, most in (
        (moved, names, known if massless else max(known, push + 2)),
        (pushed, ("force", "force_rate", "force_curvature", "force_third", "force_fourth"), push),
    ):
        missing = [field for field, value in zip(fields[: most + 1], row, strict=False) if value is None]
        if missing:
            raise ParameterError(f"course.{missing[0]} is missing: the drive's springs or linkage need it")
    load = [-part for part in pushed[: push + 1]]
    if not massless:
        load = [load_mass * one + part for one, part in zip(moved[2:], load, strict=False)]
    rows = _Rows(moved[: known + 1], load, axis is ROTARY, course.closes)
    for element in chain:
        rows.pass_through(element)
    unit = "rad" if rows.rotary else "m"
    states = {f"drive_position_{unit}": rows.position[0], f"drive_speed_{unit}_s": rows.position[1]}
    return Inward(
        _course(rows, far, orders[1]), 0.0, rows.losses, rows.stored, rows.utilisation, {**rows.states, **states}
    )


def _course(rows: _Rows, place: int, push: int) -> Course:
    """The course of the drive's output, with no more derivatives than requested."""
    position = [*rows.position[: place + 1], *[0.0] * 5][:5]
    force = [*(-part for part in rows.force[: push + 1]), 0.0, 0.0][:3]
    return Course(
        position=position[0],
        speed=position[1],
        acceleration=position[2],
        jerk=position[3],
        snap=position[4],
        force=force[0],
        force_rate=force[1],
        force_curvature=force[2],
        closes=rows.closes,
    )


class Standing(NamedTuple):
    """What a drive sees of a load at a steady speed and force, at a stated position of the load."""

    position: Array
    speed: Array
    force: Array
    power: Array
    """Power that leaves the drive's springs and linkage: to the load, and into parallel springs. [W]"""
    losses: Mapping[str, Array]
    utilisation: Mapping[Limit, Array]
    states: Mapping[str, Array]


def steady(chain: Sequence[Place], *, position: Array, speed: Array, force: Array, axis: Axis) -> Standing:
    """Speed and force on the drive's side of its output, with the load at a position.

    Parameters
    ----------
    chain : sequence of Place             Springs and linkage, from the load to the drive.
    position, speed, force : (...,) float Of the load; see `Drive.operate`.
    axis : Axis                           Of the load.

    Returns
    -------
    Standing   Parallel springs add their force at this position; series springs transmit the force and keep their
        deflection. Hysteresis of parallel springs is fully built up in motion, and zero at rest.
    """
    if not chain:
        return Standing(position, speed, force, force * speed, {}, {}, {})
    xp = namespace(position, speed, force, *(place.part for place in chain))
    rotary = axis is ROTARY
    rows = _Rows([position, speed], [force], rotary, True)
    power, losses, utilisation = force * speed, {}, {}
    for place in chain:
        part = place.part
        if place.kind == "guideway":
            rows.pass_through(place)
            continue
        if place.kind == "parallel" and not isinstance(part, Linkage):
            x, v = rows.position
            elastic = part.force(x)
            power = power + elastic * v
            rows.force = [rows.force[0] + elastic]
            rows._state(place.name, "force", elastic, force=True)
            if part.hysteretic:
                friction = part.hysteresis * xp.sign(v)
                rows.force = [rows.force[0] + friction]
                losses[f"{place.name} hysteresis"] = friction * v
            demand = part.demand(x)
        elif isinstance(part, Linkage):
            power = xp.where(part.beyond_reach(rows.position[0]), xp.nan, power)
            rows.pass_through(place)
            demand = rows.utilisation[Limit.LINKAGE, place.name]
        else:
            deflection = part.deflection(rows.force[0])
            demand, pull = part.demand(deflection), part.pull_demand(rows.force[0])
            demand = xp.where(pull > demand, pull, demand)
            speed = rows.position[1]
            if part.shape == "one-sided":
                speed, power = xp.where(pull > 1.0, xp.nan, speed), xp.where(pull > 1.0, xp.nan, power)
            rows.position = [rows.position[0] + deflection, speed]
            rows._state(place.name, "deflection", deflection, force=False)
        limit = Limit.LINKAGE if place.kind == "linkage" else Limit.SPRING
        before = utilisation.get(limit, 0.0 * demand)
        utilisation[limit] = xp.where(demand > before, demand, before)
    unit = "rad" if rows.rotary else "m"
    states = {f"drive_position_{unit}": rows.position[0], f"drive_speed_{unit}_s": rows.position[1]}
    return Standing(
        rows.position[0],
        rows.position[1],
        rows.force[0],
        power,
        {**losses, **rows.losses},
        utilisation,
        {**rows.states, **states},
    )
