"""Time integration in segments, between the instants at which an input may jump."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar.bondgraph.graph import BondGraph, BondGraphError
from infinivar.bondgraph.inputs import Constant, Controller, Input, over
from infinivar.bondgraph.model import Model
from infinivar.bondgraph.namespaces import FloatNamespace

_SAME_TIME = 1e-9
"""Instants closer than this, relative to the duration, are equal: a sample and an output time that differ by rounding."""

_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_NODES, _WEIGHTS = 0.5 * (1.0 + _GAUSS), (0.5 * _WEIGHTS).tolist()
_STEPS = np.append(_NODES, 1.0)
"""Nodes of an interval, and its end."""

_MOST_NODES = 8192
"""Nodes whose powers are summed at once; as many are held, however long the motion."""


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
        self.nodes: list[tuple[Any, Any, Any, Any]] = []
        """States, inputs, rates of inputs, and times, at the nodes and ends of intervals."""
        self.widths: list[Any] = []
        self.passed = 0
        """Number of intervals completed."""
        self.passed_at = np.zeros(len(times), dtype=int)
        bonds = len(made.bonds)
        self.total = np.zeros(bonds + self.extra)
        """Energy through bonds, then of sources and losses unless they are states, over the intervals summed. [J]"""
        self.summed = 0
        """Number of intervals summed."""
        self.passed_energy = np.zeros((len(times), bonds + self.extra))
        """The same at the output times. [J]"""

    def integrate(self, step: Callable[..., tuple[Any, str]], progress: Callable[[float], None]) -> str:
        """Integrate all segments; returns the reason for an early stop, or ""."""
        times, samples = self.times, self._samples()
        held: dict[str, float] = {}
        bounds = self._bounds(samples)
        sampled = np.isin(bounds, samples).tolist()
        for piece, (begin, end) in enumerate(itertools.pairwise(bounds.tolist())):
            if self.controller is not None and (piece == 0 or sampled[piece]):
                measured = self._measured(begin, held)
                if piece == 0:
                    self.memory = self.controller.start(measured)
                given, self.memory = self.controller.sample(begin, measured, self.memory)
                held = dict(given)
            functions = self._functions(held)
            if piece == 0:
                self.rows[0], self.reached = self.now, 1
                self.held[0] = [function.value(begin) for function in functions]
            problem = self._piece(step, begin, end, functions)
            if problem:
                self._sum()
                return f"stopped at {times[self.reached - 1]:.6g} s: {problem}"
            progress((end - times[0]) / (times[-1] - times[0]))
        self._sum()
        return ""

    def _piece(self, step: Callable[..., tuple[Any, str]], begin: float, end: float, functions: Sequence[Input]) -> str:
        """Integrate one segment; returns the reason for an early stop, or ""."""
        last = int(np.searchsorted(self.times, end, side="right"))
        inside = self.times[self.reached : last]
        requested = inside if len(inside) and inside[-1] == end else np.append(inside, end)
        widths = np.array([end - begin]) if len(requested) == 1 else np.diff(requested, prepend=begin)
        stride = len(_STEPS)
        grid = ((requested - widths)[:, None] + widths[:, None] * _STEPS).ravel()
        grid[stride - 1 :: stride] = requested
        try:
            rows, problem = step(self.now, begin, grid, functions)
        except (ArithmeticError, ValueError) as problem:  # a law was evaluated outside its domain
            return f"a law is undefined at this point ({problem}). Try another stick speed or tolerance."
        if problem:
            return problem
        ends = rows[stride - 1 :: stride]
        first, values = self.reached, over(functions, grid)
        self.rows[first:last] = ends[: len(inside)]
        self.held[first:last] = values[stride - 1 :: stride][: len(inside)]
        self.passed_at[first:last] = range(self.passed + 1, self.passed + 1 + len(inside))
        self.passed += len(requested)
        self.reached = last
        self.nodes.append((rows, values, over([functions[place] for place in self.moving], grid, rate=True), grid))
        self.widths.append(widths)
        if (self.passed - self.summed) * len(_NODES) >= _MOST_NODES:
            self._sum()
        self.now = ends[-1].tolist()
        return ""

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

    def _functions(self, held: Mapping[str, float]) -> list[Input]:
        functions: list[Input] = []
        for name in self.made.inputs:
            if name in held:
                functions.append(Constant(held[name]))
            elif name in self.outside:
                functions.append(self.outside[name])
            else:
                raise BondGraphError(f"the input {name!r} is missing")
        return functions

    def _measured(self, time: float, held: Mapping[str, float]) -> dict[str, float]:
        """Signals at a time. Inputs that are not set yet count as 0."""
        made, outside = self.made, self.outside
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

    def _sum(self) -> None:
        """Quadrature over the nodes of the intervals since the last call, which are then dropped."""
        if not self.nodes or not len(self.total):
            self.nodes, self.widths, self.summed = [], [], self.passed
            return
        whole = [np.concatenate(parts) for parts in zip(*self.nodes, strict=True)]
        states, inputs, rates, times = (part[np.arange(len(part)) % len(_STEPS) < len(_NODES)] for part in whole)
        states = states[:, : self.count]
        values = self.made.function("outputs", np, self.parameters)(tuple(states.T), tuple(inputs.T), tuple(rates.T))
        bonds = len(self.made.bonds)
        passed = [effort * flow for effort, flow in zip(values[:bonds], values[bonds : 2 * bonds], strict=True)]
        powers = [*passed, *values[len(values) - self.extra :]]
        widths = np.concatenate(self.widths)
        sums = [_mean(np.broadcast_to(power, len(states)).reshape(-1, len(_NODES))) * widths for power in powers]
        if self.watch is not None:
            ends = np.arange(self.summed + 1, self.passed + 1)
            rows = np.searchsorted(self.passed_at[: self.reached], ends)
            self.watched.add(self.watch(self._instants(times, states, values)), rows, widths)
        grown = np.cumsum(np.vstack([self.total, np.array(sums).T]), axis=0)
        fresh = slice(int(np.searchsorted(self.passed_at[: self.reached], self.summed, side="right")), self.reached)
        self.passed_energy[fresh] = grown[self.passed_at[fresh] - self.summed]
        self.total, self.summed = grown[-1], self.passed
        self.nodes, self.widths = [], []

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
