"""Time integration in segments, between the instants at which an input may jump.

At a sample the controller measures and commands, what it commands is held, and the segment is integrated. This loop runs in
compiled C over many segments, or here over one at a time: for controllers without C, and for other methods.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from infinivar.bondgraph.graph import BondGraph, BondGraphError
from infinivar.bondgraph.inputs import Constant, Controller, Input, Segments, over
from infinivar.bondgraph.model import Model
from infinivar.bondgraph.namespaces import FloatNamespace

if TYPE_CHECKING:
    from infinivar.bondgraph.compiled_step import Loop

_SAME_TIME = 1e-9
"""Instants closer than this, relative to the duration, are equal: a sample and an output time that differ by rounding."""

_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_NODES, _WEIGHTS = 0.5 * (1.0 + _GAUSS), (0.5 * _WEIGHTS).tolist()
_STEPS = np.append(_NODES, 1.0)
"""Nodes of an interval, and its end."""

_BESIDE = 1e-6
"""Distance from the ends of a segment, over its width, at which inputs are looked at: they may jump at an end."""

_MOST_INTERVALS = 2048
"""Intervals that are integrated and summed at once; as many are held, however long the motion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Instants:
    """What a graph does at many instants; arrays (n,), SI. Efforts and flows by the (tail, head) of the bonds."""

    graph: BondGraph
    time: Any
    states: Mapping[str, Any]
    signals: Mapping[str, Any]
    efforts: Mapping[tuple[str, str], Any]
    flows: Mapping[tuple[str, str], Any]

    def at(self, name: str) -> tuple[Any, Any]:
        """Effort and flow of a one-port, or of any other element at its first bond."""
        bond = self.graph.bonds_of(self.graph[name].name)[0]
        return self.efforts[bond.tail, bond.head], self.flows[bond.tail, bond.head]


Watch = Callable[[Instants], Mapping[Any, Any]]
"""Demands over allowances at many instants, by any key."""


class Watched:
    """Demands between output times: their peaks and the integrals of their powers, however far apart the outputs are."""

    def __init__(self, outputs: int, weights: Sequence[float] = _WEIGHTS) -> None:
        """Know nothing yet; `weights` are those of the nodes of an interval in its mean."""
        self.outputs, self.weights = outputs, weights
        self.peaks: dict[Any, np.ndarray] = {}
        """Largest demand since the output before; 0 where there is none. (n,) [-]"""
        self.squares: dict[Any, np.ndarray] = {}
        """Integral of the squared demand since then. (n,) [s]"""
        self.cubes: dict[Any, np.ndarray] = {}
        """The same of its cube. (n,) [s]"""

    def add(self, demands: Mapping[Any, Any], rows: np.ndarray, widths: np.ndarray) -> None:
        """Count demands (m nodes) of intervals with the output that ends them, by its row."""
        for key, demand in demands.items():
            nodes = len(self.weights)
            values = np.broadcast_to(demand, (len(rows) * nodes,)).reshape(-1, nodes)
            np.maximum.at(self._of(self.peaks, key), rows, np.max(values, axis=1))
            for sums, power in ((self.squares, 2), (self.cubes, 3)):
                np.add.at(self._of(sums, key), rows, _mean(values**power, self.weights) * widths)

    def until(self, count: int) -> dict[str, dict[Any, np.ndarray]]:
        """Peaks, squares and cubes at the first outputs, by these names. (count,)"""
        groups = {"peaks": self.peaks, "squares": self.squares, "cubes": self.cubes}
        return {name: {key: values[:count] for key, values in group.items()} for name, group in groups.items()}

    def _of(self, kept: dict[Any, np.ndarray], key: Any) -> np.ndarray:
        return kept.setdefault(key, np.zeros(self.outputs))


_NOTHING = Constant(0.0)
"""An input that the controller commands, before it does."""


class _Chunk(NamedTuple):
    """Segments that are integrated together; r rows at the nodes and ends of i intervals."""

    segments: Segments
    bounds: np.ndarray
    """(s + 1,) [s]"""
    starts: np.ndarray
    """First row of each segment. (s,)"""
    grid: np.ndarray
    """(r,) [s]"""
    widths: np.ndarray
    """(i,) [s]"""
    values: np.ndarray
    """Inputs. (r, inputs)"""
    reached: np.ndarray
    """States, and energies that are states. (r, states)"""
    within: np.ndarray
    """Which times of the segments are rows; the others are begins."""

    def rows(self, first: int, last: int) -> slice:
        """Rows of some segments."""
        end = int(self.starts[last]) if last < len(self.starts) else len(self.grid)
        return slice(int(self.starts[first]), end)


class March:
    """One integration in progress: results at the output times reached so far."""

    def __init__(
        self,
        made: Model,
        parameters: Mapping[str, float],
        outside: Mapping[str, Input],
        controller: Controller | None,
        times: Any,
        start: list[float],
        energies_too: bool,
        graph: BondGraph,
        watch: Watch | None = None,
    ) -> None:
        """Start at the first of `times`; `energies_too` integrates energies as states instead of by quadrature."""
        self.graph, self.watch, self.watched = graph, watch, Watched(len(times) + 1)
        self.made, self.parameters = made, parameters
        self.times, self.outside, self.controller = times, outside, controller
        self.count, self.energies_too = len(start), energies_too
        own = len(made.sources) + len(made.losses)
        self.now = [*start, *([0.0] * own if energies_too else [])]
        self.extra = 0 if energies_too else own
        """Number of energies of sources and losses that are sums."""
        self.rows = np.full((len(times), len(self.now)), np.nan)
        self.held = np.full((len(times), len(made.inputs)), np.nan)
        self.reached = 0
        self.measured = made.function("measured", FloatNamespace, parameters)
        self.moving = [made.inputs.index(name) for name in made.rates]
        self.memory: Any = None
        self.commands: dict[str, float] = {}
        """Inputs that the controller holds."""
        self.passed = 0
        """Number of intervals completed."""
        self.passed_at = np.zeros(len(times), dtype=int)
        bonds = len(made.bonds)
        self.total = np.zeros(bonds + self.extra)
        """Energy through bonds, then of sources and losses unless they are states. [J]"""
        self.passed_energy = np.zeros((len(times), bonds + self.extra))
        """The same at the output times. [J]"""

    def integrate(
        self, step: Callable[..., tuple[Any, str]], loop: Loop | None, progress: Callable[[float], None]
    ) -> str:
        """Integrate all segments, in the compiled loop if there is one; returns the reason for an early stop, or ""."""
        begin, samples = float(self.times[0]), self._samples()
        bounds = self._bounds(samples)
        sampled = np.isin(bounds[:-1], samples)
        sampled[0] = self.controller is not None
        ends = np.union1d(bounds[1:], self.times[1:])
        segment_of = np.searchsorted(bounds, ends) - 1
        self.rows[0], self.reached = self.now, 1
        if self.controller is not None:
            self.memory = self.controller.start(self._measured(begin))
        if loop is not None and loop.samples and {*self.made.inputs} - {*self.outside, *loop.commands}:
            loop = None
        first, problem = 0, ""
        while first < len(bounds) - 1 and not problem:
            # As many intervals as are held at once, of whole segments.
            start = int(np.searchsorted(segment_of, first))
            last = int(segment_of[min(start + _MOST_INTERVALS, len(ends)) - 1]) + 1
            chosen = slice(start, int(np.searchsorted(segment_of, last)))
            pieces = np.bincount(segment_of[chosen] - first)
            chunk = self._chunk(bounds[first : last + 1], sampled[first:last], pieces, ends[chosen])
            first, problem = last, self._through(chunk, step, loop, progress)
        return f"stopped at {self.times[self.reached - 1]:.6g} s: {problem}" if problem else ""

    def _chunk(self, bounds: np.ndarray, sampled: np.ndarray, intervals: np.ndarray, ends: np.ndarray) -> _Chunk:
        """Segments between bounds, with the inputs from outside; `intervals` of each, which have these ends."""
        stride = len(_STEPS)
        widths = np.diff(ends, prepend=bounds[0])
        grid = (ends - widths)[:, None] + widths[:, None] * _STEPS
        grid[:, -1] = ends
        pieces = stride * intervals
        last = np.cumsum(pieces) + np.arange(len(pieces))
        first = last - pieces
        within = np.ones(len(ends) * stride + len(pieces), dtype=bool)
        within[first] = False
        times = np.empty(len(within))
        times[first], times[within] = bounds[:-1], grid.ravel()
        beside, near = times.copy(), _BESIDE * np.diff(bounds)
        beside[first] += near
        beside[last] -= near
        functions = [self.outside.get(name, _NOTHING) for name in self.made.inputs]
        moving = [self.outside.get(name, _NOTHING) for name in self.made.rates]
        inputs, rates = over(functions, beside), over(functions, beside, rate=True)
        values = inputs[within]
        values[stride - 1 :: stride] = over(functions, ends)
        for edge in (first, last):
            inputs[edge] += rates[edge] * (times - beside)[edge, None]
        segments = Segments(
            pieces=pieces.astype(np.int32),
            sampled=sampled.astype(np.int32),
            begins=bounds[:-1],
            seen=over(functions, bounds[:-1]),
            seen_rates=over(moving, bounds[:-1], rate=True),
            starts=np.append(first, len(times)),
            times=times,
            inputs=inputs,
            rates=rates,
        )
        rows = np.empty((len(values), len(self.now)))
        return _Chunk(segments, bounds, np.cumsum(pieces) - pieces, grid.ravel(), widths, values, rows, within)

    def _through(
        self, chunk: _Chunk, step: Callable[..., tuple[Any, str]], loop: Loop | None, progress: Callable[[float], None]
    ) -> str:
        """Integrate the segments of a chunk; returns the reason for an early stop, or ""."""
        done, problem, count = 0, "", len(chunk.starts)
        while done < count and not problem:
            if loop is not None and loop.samples:
                done += self._looped(loop, chunk, done, count)
            if done < count:
                self._sample(chunk, done)
                if loop is None or loop.samples or not self._looped(loop, chunk, done, done + 1):
                    problem = self._stepped(step, chunk, done)
                done += not problem
            progress((chunk.bounds[done] - self.times[0]) / (self.times[-1] - self.times[0]))
        self._keep(chunk, int(chunk.starts[done]) if done < count else len(chunk.grid))
        return problem

    def _looped(self, loop: Loop, chunk: _Chunk, first: int, last: int) -> int:
        """Integrate segments in the compiled loop; returns how many it completed."""
        own = loop.samples and self.controller is not None
        commands = [self.commands.get(name, 0.0) for name in loop.commands]
        done, rows, held, memory, commands = loop(
            chunk.segments.part(first, last), self.now, self.memory if own else (), commands
        )
        if done:
            places = chunk.rows(first, first + done)
            chunk.reached[places] = rows[: places.stop - places.start]
            self.now = chunk.reached[places.stop - 1].tolist()
            if own:
                self.memory, self.commands = tuple(memory), dict(zip(loop.commands, commands, strict=True))
                pieces = chunk.segments.pieces[first : first + done]
                chunk.values[places, loop.places] = np.repeat(held[:done], pieces, axis=0)
        return done

    def _sample(self, chunk: _Chunk, segment: int) -> None:
        """Let the controller command, at a sample, and hold what it commanded over a segment."""
        if chunk.segments.sampled[segment]:
            assert self.controller is not None
            begin = float(chunk.bounds[segment])
            given, self.memory = self.controller.sample(begin, self._measured(begin), self.memory)
            self.commands = dict(given)
        rows, starts = chunk.rows(segment, segment + 1), chunk.segments.starts
        for name, value in self.commands.items():
            if name in self.made.inputs:
                place = self.made.inputs.index(name)
                chunk.values[rows, place] = value
                chunk.segments.inputs[starts[segment] : starts[segment + 1], place] = value

    def _stepped(self, step: Callable[..., tuple[Any, str]], chunk: _Chunk, segment: int) -> str:
        """Integrate one segment by the solver's step; returns the reason for an early stop, or ""."""
        places, functions = chunk.rows(segment, segment + 1), self._functions()
        try:
            rows, problem = step(self.now, float(chunk.bounds[segment]), chunk.grid[places], functions)
        except (ArithmeticError, ValueError) as fault:  # a law was evaluated outside its domain
            return f"a law is undefined at this point ({fault}). Try another stick speed or tolerance."
        if not problem:
            chunk.reached[places] = rows
            self.now = chunk.reached[places.stop - 1].tolist()
        return problem

    def _keep(self, chunk: _Chunk, count: int) -> None:
        """Keep the outputs of a chunk whose first rows are complete, and sum over its nodes."""
        if self.reached == 1 and not self.passed:
            self.held[0] = [self._value(name, float(self.times[0]), chunk) for name in self.made.inputs]
        stride = len(_STEPS)
        ends = chunk.grid[stride - 1 : count : stride]
        last = self.reached + int(np.searchsorted(self.times[self.reached :], ends[-1:], side="right").sum())
        fresh, inside = slice(self.reached, last), np.searchsorted(ends, self.times[self.reached : last])
        self.rows[fresh] = chunk.reached[stride - 1 : count : stride][inside]
        self.held[fresh] = chunk.values[stride - 1 : count : stride][inside]
        self.passed_at[fresh] = self.passed + 1 + inside
        self.passed += len(ends)
        self.reached = last
        if len(ends):
            rates = chunk.segments.rates[chunk.within][:count, self.moving]
            self._sum(
                chunk.reached[:count], chunk.values[:count], rates, chunk.grid[:count], chunk.widths[: len(ends)], fresh
            )

    def _value(self, name: str, time: float, chunk: _Chunk) -> float:
        """Value of an input at the begin."""
        given = self.outside.get(name, _NOTHING).value(time)
        return float(chunk.values[0, self.made.inputs.index(name)]) if name in self.commands else given

    def _bounds(self, samples: np.ndarray) -> np.ndarray:
        """Bounds of the segments."""
        found = np.fromiter((at for given in self.outside.values() for at in given.breaks), dtype=float)
        breaks = self._inside(found)
        if len(samples):
            breaks = self._snapped(breaks, samples)
        return np.unique(np.concatenate([self.times[[0, -1]], breaks, samples]))

    def _samples(self) -> np.ndarray:
        """Sample times of the controller after the first."""
        if self.controller is None:
            return np.empty(0)
        first, last, period = float(self.times[0]), float(self.times[-1]), self.controller.sample_time
        return self._inside(first + np.arange(1, int((last - first) / period) + 1) * period)

    def _inside(self, found: np.ndarray) -> np.ndarray:
        """Instants within the motion, snapped to output times that differ only by rounding."""
        times = self.times
        close = _SAME_TIME * (times[-1] - times[0])
        return self._snapped(found[(found > times[0] + close) & (found < times[-1] - close)], times)

    def _snapped(self, found: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Instants, those that differ from a known one only by rounding moved there."""
        places = np.clip(np.searchsorted(known, found), 1, max(len(known) - 1, 1))
        low, high = known[places - 1], known[np.minimum(places, len(known) - 1)]
        nearest = np.where(found - low < high - found, low, high)
        return np.where(np.abs(found - nearest) <= _SAME_TIME * (self.times[-1] - self.times[0]), nearest, found)

    def _functions(self) -> list[Input]:
        functions: list[Input] = []
        for name in self.made.inputs:
            if name in self.commands:
                functions.append(Constant(self.commands[name]))
            elif name in self.outside:
                functions.append(self.outside[name])
            else:
                raise BondGraphError(f"the input {name!r} is missing")
        return functions

    def _measured(self, time: float) -> dict[str, float]:
        """Signals at a time. Inputs that are not set yet count as 0."""
        made, outside, held = self.made, self.outside, self.commands
        inputs = [outside[name].value(time) if name in outside else held.get(name, 0.0) for name in made.inputs]
        rates = [outside[name].rate(time) if name in outside else 0.0 for name in made.rates]
        return dict(zip(made.signals, self.measured(self.now[: self.count], inputs, rates), strict=True))

    def states(self) -> Any:
        """States at the output times reached. (n, states)"""
        return self.rows[: self.reached, : self.count]

    def energies(self) -> tuple[Any, Any]:
        """Cumulative energies at the output times reached: (n, sources and losses), and (n, bonds) along half arrows. [J]"""
        bonds = len(self.made.bonds)
        summed = self.passed_energy[: self.reached]
        own = self.rows[: self.reached, self.count :] if self.energies_too else summed[:, bonds:]
        return own, summed[:, :bonds]

    def _sum(
        self,
        states: np.ndarray,
        inputs: np.ndarray,
        rates: np.ndarray,
        times: np.ndarray,
        widths: np.ndarray,
        fresh: slice,
    ) -> None:
        """Quadrature over the nodes of intervals, whose ends are dropped; `fresh` are the outputs among these."""
        node = np.arange(len(times)) % len(_STEPS) < len(_NODES)
        states, inputs, rates, times = states[node, : self.count], inputs[node], rates[node], times[node]
        if not len(self.total):
            return
        values = self.made.function("outputs", np, self.parameters)(tuple(states.T), tuple(inputs.T), tuple(rates.T))
        bonds = len(self.made.bonds)
        passed = [effort * flow for effort, flow in zip(values[:bonds], values[bonds : 2 * bonds], strict=True)]
        powers = [*passed, *values[len(values) - self.extra :]]
        sums = [_mean(np.broadcast_to(power, len(states)).reshape(-1, len(_NODES))) * widths for power in powers]
        before = self.passed - len(widths)
        if self.watch is not None:
            rows = np.searchsorted(self.passed_at[: self.reached], np.arange(before + 1, self.passed + 1))
            self.watched.add(self.watch(self._instants(times, states, values)), rows, widths)
        grown = np.cumsum(np.vstack([self.total, np.array(sums).T]), axis=0)
        self.passed_energy[fresh] = grown[self.passed_at[fresh] - before]
        self.total = grown[-1]

    def _instants(self, times: np.ndarray, states: np.ndarray, values: Any) -> Instants:
        """Nodes by name, from what the model's function of outputs returns."""
        made, given = self.made, iter(values)

        def take(names: Any) -> dict[Any, Any]:
            return {name: np.broadcast_to(next(given), times.shape) for name in names}

        efforts, flows, signals = take(made.bonds), take(made.bonds), take(made.signals)
        known = dict(zip(made.states, states.T, strict=True))
        return Instants(graph=self.graph, time=times, states=known, signals=signals, efforts=efforts, flows=flows)

    def inputs(self) -> tuple[Any, Any]:
        """Inputs and their rates at the output times reached. (n, inputs), (n, rates)"""
        moving: list[Input] = [self.outside.get(name, Constant(0.0)) for name in self.made.rates]
        return self.held[: self.reached], over(moving, self.times[: self.reached], rate=True)


def _mean(powers: np.ndarray, weights: Sequence[float] = _WEIGHTS) -> np.ndarray:
    """Mean over each interval of powers at its nodes, in an order that no library's number of threads changes."""
    return sum(weight * powers[:, node] for node, weight in enumerate(weights))  # type: ignore[return-value]
