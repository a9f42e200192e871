"""The march of a machine through time: from sample to sample, with limits as events and a balance of energies.

Runs under a scenario and sessions with a user are marched alike; they differ in who commands, and in what is reported of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from infinivar._core.collocation import Collocation, Rates, Step, StuckError
from infinivar._core.fields import given
from infinivar.analysis import run_limits
from infinivar.analysis.run_limits import Event
from infinivar.bondgraph.audit import CLOSURE, ClosureError
from infinivar.bondgraph.march import Watched
from infinivar.limits import Demand, Limit
from infinivar.machines.compiled import CompiledSteps, Motion
from infinivar.machines.motors import Shaft
from infinivar.machines.sampled import Recordable, SampledSteps, Segment
from infinivar.machines.system import Inputs, System
from infinivar.motion.machine_scenario import check_continuous

_RESULTS = 1000
"""Default number of results of a run."""

_MOST_SAMPLES = 1024
"""Samples whose motors are judged at once; as many are held, however long the run."""

_HALVINGS = 40
"""Of the step in which a demand passes its allowance."""


class Sampler(Protocol):
    """Who commands."""

    @property
    def saturated(self) -> Mapping[str, float]:
        """Commanded over largest current of the last sample, by motor."""
        ...

    def sample(self, time: float, state: np.ndarray) -> Inputs:
        """Inputs until the next sample."""
        ...


@dataclass(slots=True)
class _Log:
    """What a run leaves behind at its results, and at those of its steps that a limit needs: it grows with neither duration
    nor samples, unless demands pass their allowances again and again."""

    states: list[np.ndarray] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    energies: list[np.ndarray] = field(default_factory=list)
    inputs: list[Inputs] = field(default_factory=list)
    instants: list[float] = field(default_factory=list)
    demands: list[np.ndarray] = field(default_factory=list)
    needed: bool = True
    """Whether the last instant stays whatever follows."""
    sampled: list[tuple[float, dict[str, float]]] = field(default_factory=list)
    """Samples at which what is saturated changes."""
    ended: list[tuple[float, float, int, np.ndarray, Inputs]] = field(default_factory=list)
    """Samples whose motors are not judged yet: begin, end, the result that follows, state at the end, and inputs."""
    watched: Watched = field(default_factory=lambda: Watched(0))
    """Demands on the motors between results."""

    def watch(self, time: float, demand: np.ndarray, needed: bool) -> None:
        """Add an instant, and drop the last one if it says nothing that its neighbours do not.

        That is so where every demand is on one side of its allowance at all three, and none is largest in the middle.
        """
        if not self.needed and len(self.instants) > 1:
            before, middle = self.demands[-2:]
            side = run_limits.side(middle)
            same = np.all((run_limits.side(before) == side) & (run_limits.side(demand) == side))
            if same and np.all((side == 0) | (middle <= before) | (middle <= demand)):
                self.instants.pop()
                self.demands.pop()
        self.instants.append(time)
        self.demands.append(demand)
        self.needed = needed

    def sample(self, time: float, saturated: Mapping[str, float]) -> None:
        """Add a sample if another part is saturated than at the last one."""
        if not self.sampled or _full(saturated) != _full(self.sampled[-1][1]):
            self.sampled.append((time, dict(saturated)))


def _crossing(step: Step, passed: Callable[[float, np.ndarray], bool]) -> float:
    """Instant of a step at which something passes, of which a time and a row of states tell whether it has. [s]"""
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        time = step.begin + middle * (step.end - step.begin)
        low, high = (low, middle) if passed(time, step.at(np.array([middle]))) else (middle, high)
    return step.begin + high * (step.end - step.begin)


def _full(saturated: Mapping[str, float]) -> set[str]:
    return {part for part, share in saturated.items() if share >= 1.0}


class Record(NamedTuple):
    """What is known of a motion afterwards; t results, i instants at the ends of steps."""

    time: np.ndarray
    """(t,) [s]"""
    states: np.ndarray
    """(t, n)"""
    columns: dict[str, np.ndarray]
    """Configuration, rates, steering, currents, voltages and slip demands, (t,) each."""
    supplied: dict[str, np.ndarray]
    """(t,) each. [J]"""
    lost: dict[str, np.ndarray]
    """(t,) each. [J]"""
    stored: dict[str, np.ndarray]
    """(t,) each. [J]"""
    residual: np.ndarray
    """(t,) [-]"""
    events: tuple[Event, ...]
    root_mean_squares: dict[Demand, float]
    outcome: str
    """Empty, or why the run ended early."""
    instants: np.ndarray
    """Those between which a demand may be taken as linear where it passes its allowance. (i,) [s]"""
    watched: np.ndarray
    """Demands that the system watches, at the instants. (i, w)"""

    def of_result(self, more: Mapping[str, np.ndarray]) -> dict[str, Any]:
        """What the results of runs take over, by the names of their fields; with more columns."""
        names = ("time", "supplied", "lost", "stored", "residual", "events", "root_mean_squares", "outcome")
        return {"columns": {**self.columns, **more}, **{name: getattr(self, name) for name in names}}


@dataclass(slots=True)
class March:
    """A system set up for a run."""

    system: System
    motion: Motion | None
    """Of the system, where it is compiled."""
    state: np.ndarray
    """At the start."""
    controller: Sampler | None
    """None: nothing is sampled."""
    period: float
    """Of the samples. [s]"""
    duration: float
    output_step: float | None = None
    settling_time: float | None = None
    tolerance: float = 1e-4
    log: _Log = field(default_factory=_Log)

    def over(self, progress: Callable[[float], None]) -> Record:
        """The run.

        Raises
        ------
        ClosureError
            If the energy balance does not close: an error in the program.
        """
        system, log = self.system, self.log
        inputs = system.idle()
        total = np.zeros(len(system.sources) + len(system.losses))
        state = self.state

        def rates(time: np.ndarray, states: np.ndarray) -> Rates:
            return system.rates(inputs, time, states)

        ends, kept = self._segments()
        # A run may stop after its last result.
        log.watched = Watched(len(kept) + 2, weights=(1.0,))
        if system.angles is not None:
            check_continuous("steering", system.angles, [0.0, *ends])
        marching = self._integrator(rates, lambda: inputs, len(ends))

        def accept(step: Step) -> None:
            total[:] += step.energy
            self._watch(step, rates)

        def keep(time: float) -> None:
            log.times.append(time)
            log.states.append(state)
            log.energies.append(total.copy())
            log.inputs.append(inputs.copy())
            log.needed = True

        outcome = ""

        def ended(place: int) -> None:
            log.ended.append((bounds[place], bounds[place + 1], len(log.times), state, inputs.copy()))
            self._judge_motors(_MOST_SAMPLES)
            if place + 1 in kept:
                keep(bounds[place + 1])
                progress(bounds[place + 1] / self.duration)

        at_once, place = self._at_once(marching), 0
        bounds = np.array([0.0, *ends])
        try:
            while place < len(ends):
                before = place
                for segment in at_once(bounds[place:], state):
                    inputs, state = segment.inputs, segment.state
                    log.sample(bounds[place], segment.saturated)
                    for step in segment.steps:
                        accept(step)
                    ended(place)
                    place += 1
                if place > before:
                    continue
                inputs = self._commanded(bounds[place], state)
                if place == 0:
                    keep(0.0)
                state = marching.over(bounds[place], bounds[place + 1], state, accept)
                ended(place)
                place += 1
        except StuckError as problem:
            outcome = f"stopped at {float(problem.args[0]):.6g} s: {self._why(problem.args[1], marching.last, state)}"
        return self._record(outcome)

    def _commanded(self, time: float, state: np.ndarray) -> Inputs:
        """Inputs from a sample on."""
        if self.controller is None:
            return self.system.idle()
        found = self.controller.sample(time, state)
        self.log.sample(time, self.controller.saturated)
        return found

    def _at_once(self, marching: Collocation | CompiledSteps) -> Callable[[np.ndarray, np.ndarray], Iterable[Segment]]:
        """What computes many samples at once, if both motion and controller are compiled, from bounds and a state."""
        if isinstance(marching, CompiledSteps) and isinstance(self.controller, Recordable):
            return SampledSteps(marching, self.controller).over
        return lambda bounds, state: ()

    def _integrator(
        self, rates: Callable[..., Rates], inputs: Callable[[], Inputs], segments: int
    ) -> Collocation | CompiledSteps:
        """Integrator of that many segments, with the size of each state."""
        first, second, third = self.system.places
        scale = np.full(len(self.state), 0.1)
        fastest = np.abs(self.state[first:second])
        scale[first:second] = np.maximum(0.1 * fastest, 1e-2)
        scale[third:] = 1.0
        if self.motion is not None:
            return CompiledSteps(self.motion, self.system, inputs, scale, self.tolerance)
        return Collocation(
            rates,
            self.system.balance,
            scale,
            self.tolerance,
            segments=segments,
            closure=0.5 * CLOSURE,
            placed=first,
        )

    def _segments(self) -> tuple[np.ndarray, set[int]]:
        """Ends of the segments, and the numbers of those that are results."""
        duration, sampled = self.duration, self.controller is not None
        step = self.output_step or max(duration / _RESULTS, self.period if sampled else 0.0)
        if not sampled:
            count = max(round(duration / step), 1)
            return np.linspace(0.0, duration, count + 1)[1:], set(range(1, count + 1))
        whole = math.floor(duration / self.period * (1.0 + 1e-12))
        ends = self.period * np.arange(1, whole + 1)
        if not whole or duration - ends[-1] > 1e-9 * duration:
            ends = np.append(ends, duration)
        every = max(round(step / self.period), 1)
        return ends, {*range(every, len(ends) + 1, every), len(ends)}

    def _watch(self, step: Step, rates: Callable[..., Rates]) -> None:
        """Keep the demands at the ends of a step, and at the instants at which one passes its allowance."""
        log = self.log
        if not log.instants:
            log.watch(step.begin, step.demand_before, True)
        crossed = (step.demand_before - 1.0) * (step.demand - 1.0) < 0.0
        found = []
        for place in np.flatnonzero(crossed):
            demand, rises = step.demand.copy(), step.demand[place] > 1.0

            def passed(time: float, states: np.ndarray, demand: np.ndarray = demand, at: Any = (place, rises)) -> bool:
                demand[:] = rates(np.array([time]), states).balance().demand[0]
                return (demand[at[0]] > 1.0) == at[1]

            time = _crossing(step, passed)
            demand[place] = 1.0
            found.append((time, demand))
        settled = given(self.settling_time, -1.0) * (1.0 - run_limits.ROUNDING)
        for time, demand in [*sorted(found, key=lambda pair: pair[0]), (step.end, step.demand)]:
            if time > log.instants[-1]:
                log.watch(time, demand, log.instants[-1] < settled <= time)

    def _why(self, many: bool, last: Step | None, state: np.ndarray) -> str:
        first, second, _ = self.system.places
        at = (state if last is None else last.points[-1])[None]
        stuck = self.system.mechanics.stuck(at[:, :first], at[:, first:second])
        if stuck:
            return stuck
        if many:
            return "the integration takes too many steps; contacts or forces are too stiff or large for the masses they move"
        return "the integration fails; try a larger stick_speed"

    def _judge_motors(self, fewest: int = 1) -> None:
        """Demands of the motors in the samples since the last call, if there are so many; they are then dropped."""
        log = self.log
        if len(log.ended) < fewest:
            return
        begins, ends, results, states, inputs = zip(*log.ended, strict=True)
        log.ended = []
        shafts = self._shafts(np.array(ends), np.array(states), inputs)
        log.watched.add(self._motor_demands(shafts), np.array(results), np.subtract(ends, begins))

    def _record(self, outcome: str) -> Record:
        system, log = self.system, self.log
        self._judge_motors()
        states, time, energies = np.array(log.states), np.array(log.times), np.array(log.energies)
        stored = system.energies(time, states)
        count = len(system.sources)
        supplied, lost = energies[:, :count], energies[:, count:]
        residual = _residual(supplied, lost, stored)
        shafts = self._shafts(time, states, log.inputs)
        columns = self._columns(time, states, log.inputs, shafts)
        early = run_limits.first_settled(time, self.settling_time)
        instants, demands = np.array(log.instants), np.array(log.demands)
        names = system.mechanics.demands
        found: tuple[Event, ...] = ()
        if log.instants:
            # Sub-steps in which a wheel slips count as well.
            utilisation: dict[Demand, Any] = dict(zip(names, demands.T, strict=False))
            found = run_limits.events(instants, utilisation, run_limits.first_settled(instants, self.settling_time))
            rows = np.searchsorted(instants, time - 1e-12).clip(max=len(instants) - 1)
            for place, (limit, what) in enumerate(names):
                if limit == Limit.SLIP:
                    columns[f"slip_demand_{what.replace(' ', '_')}"] = demands[rows, place]
        others = self._motor_demands(shafts)
        between = log.watched.until(len(time))
        found = tuple(
            sorted(
                (*found, *run_limits.events(time, others, early, between["peaks"]), *self._saturation()),
                key=run_limits.begins,
            )
        )
        return Record(
            time=time,
            states=states,
            columns=columns,
            supplied=dict(zip(system.sources, supplied.T, strict=True)),
            lost={name: column for name, column in zip(system.losses, lost.T, strict=True) if np.any(column)},
            stored=dict(zip(system.storages, stored.T, strict=True)),
            residual=residual,
            events=found,
            root_mean_squares=run_limits.root_mean_squares(time, others, early, between["squares"]),
            outcome=outcome,
            instants=instants,
            watched=demands[:, len(names) :] if log.instants else np.zeros((0, 0)),
        )

    def _columns(
        self, time: np.ndarray, states: np.ndarray, inputs: Sequence[Inputs], shafts: Sequence[Shaft]
    ) -> dict[str, np.ndarray]:
        system, mechanics = self.system, self.system.mechanics
        names = [*mechanics.configuration, *mechanics.coordinates]
        columns = {name: states[:, place] for place, name in enumerate(names)}
        angles, turning = system.steering(system.outside(time), states, np.array([one.turning for one in inputs]))
        for place, name in enumerate(mechanics.steered):
            columns[name] = angles[:, place]
            columns[name.replace("_rad", "_rate_rad_s")] = (turning + 0.0 * angles)[:, place]
        for one in shafts:
            columns[f"{one.name}_current_A"] = one.current
            if one.name in system.motors:
                columns[f"{one.name}_voltage_V"] = one.voltage
        return columns

    def _shafts(self, time: np.ndarray, states: np.ndarray, inputs: Sequence[Inputs]) -> list[Shaft]:
        """Motors and servos at the ends of samples."""
        held = Inputs(*map(np.array, zip(*inputs, strict=True)))
        turning = self.system.steering(self.system.outside(time), states, held.turning)[1]
        return self.system.shafts(held, states, turning)

    def _motor_demands(self, shafts: Sequence[Shaft]) -> dict[Demand, Any]:
        """Demand over allowance of the motors."""
        return {key: demand for one in shafts for key, demand in one.utilisation().items()}

    def _saturation(self) -> tuple[Event, ...]:
        """Samples at which a controller's current is at its limit."""
        log = self.log
        if not log.sampled:
            return ()
        found = []
        for part in log.sampled[-1][1]:
            limited = np.array([said.get(part, 0.0) >= 1.0 for _, said in log.sampled])
            for begin, end in run_limits.intervals(limited):
                begins = log.sampled[begin][0]
                ends = log.sampled[end][0] if end < len(log.sampled) else self.duration
                event = Event(limit=Limit.PEAK, what=f"current limit of {part}", start=begins, end=ends, worst=1.0)
                settling = given(self.settling_time, 0.0)
                if begins < settling < ends:
                    found.append(replace(event, end=settling, settling=True))
                    event = replace(event, start=settling)
                found.append(replace(event, settling=ends <= settling))
        return tuple(found)


_NOTHING = 1e-12
"""Energy moved below which a run stands still: what is stored then is rounding. [J]"""


def _residual(supplied: np.ndarray, lost: np.ndarray, stored: np.ndarray) -> np.ndarray:
    """Energy that is unaccounted for, over the energy moved. (t,)

    Raises
    ------
    ClosureError
        If it exceeds the limit.
    """
    missing = stored.sum(-1) - stored[0].sum() + lost.sum(-1) - supplied.sum(-1)
    moved = np.max(np.abs(supplied).sum(-1) + np.abs(lost).sum(-1)) + np.max(stored.sum(-1))
    residual = np.abs(missing) / max(float(moved), _NOTHING)
    if not np.max(residual) <= CLOSURE:
        raise ClosureError(
            f"the energy balance has a residual of {np.max(residual):.2g} of the energy moved, above the limit of {CLOSURE:g}"
        )
    return residual
