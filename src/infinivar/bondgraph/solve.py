"""Integration of a graph's equations in time, with the energy of every source and loss integrated beside the states.

LSODA (default), Radau and BDF are SciPy's; CVODES comes with CasADi, if that is installed. All integrate in pieces, from
one instant at which an input may jump to the next: a sample of the controller, a step of an outside input.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from infinivar.bondgraph.audit import Trajectory, audited
from infinivar.bondgraph.code import FloatNamespace
from infinivar.bondgraph.graph import BondGraph, BondGraphError
from infinivar.bondgraph.model import Model, model
from infinivar.errors import nearest

Method = Literal["LSODA", "Radau", "BDF", "CVODES"]

RTOL = 1e-10
"""Relative tolerance unless another is given. LSODA starts afresh at every sample, each time with an error of this size
in the same direction: a thousand samples on, the energy balance still closes to 1e-7."""

_ENERGY_SCALE = 1e-2
"""Energies below this count as small, for the tolerance. [J]"""

_MOST_STEPS = 20_000
"""Of LSODA in one piece."""

_SAME_TIME = 1e-9
"""Instants closer than this, relative to the whole motion, are one: a sample and an output written differently."""


class Input(Protocol):
    """An outside input as a function of time."""

    @property
    def breaks(self) -> Sequence[float]:
        """Instants at which the value or its slope jumps. [s]"""
        ...

    def value(self, time: float) -> float:
        """Value at a time."""
        ...

    def rate(self, time: float) -> float:
        """Time derivative of the value."""
        ...


class Controller(Protocol):
    """A sampled controller: its outputs are held from one sample to the next."""

    @property
    def sample_time(self) -> float:
        """Time between samples, > 0. [s]"""
        ...

    def start(self, measured: Mapping[str, float]) -> Any:
        """What the controller remembers before its first sample."""
        ...

    def sample(self, time: float, measured: Mapping[str, float], memory: Any) -> tuple[Mapping[str, float], Any]:
        """Values of inputs by name, and what to remember, from the graph's signals at a time."""
        ...


@dataclass(frozen=True, slots=True)
class Constant:
    """An input that never changes."""

    size: float
    breaks: tuple[float, ...] = ()

    def value(self, time: float) -> float:
        """The constant."""
        return self.size

    def rate(self, time: float) -> float:
        """Zero."""
        return 0.0


def solve(
    graph: BondGraph,
    times: Any,
    *,
    inputs: Mapping[str, float | Input] | None = None,
    initial: Mapping[str, float] | None = None,
    controller: Controller | None = None,
    method: Method = "LSODA",
    rtol: float = RTOL,
    scales: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Motion of a graph from given initial states.

    Parameters
    ----------
    graph : BondGraph
    times : (n,) float                    Increasing; the motion begins at the first. [s]
    inputs : mapping of name to value     Constants, or functions of time; for sources by element, for outside signals by
        name. Those of the controller may be left out.
    initial : mapping of name to float    States by name: flow of an inertia, displacement of a compliance, value of an
        integral signal. 0 where left out.
    controller : Controller               Sets inputs at its samples.
    method : str                          LSODA (Radau takes over for a piece in which it gives up), Radau, BDF, or CVODES
        with CasADi.
    rtol : float                          Relative tolerance of the states.
    scales : mapping of name to float     Sizes of the states below which errors do not matter, times `rtol`; 1 where
        left out.
    progress : callable                   Called with the share done.

    Returns
    -------
    Trajectory   Cut short, with the reason in `outcome`, where the solver gives up.

    Raises
    ------
    BondGraphError
        If the graph has no equations, an input is missing or a name is not known.
    AuditError
        If an element creates energy.

    Source: faulring2006, section V (the graphs); the solvers' own documentation.
    """
    import numpy as np

    made = model(graph)
    times = np.asarray(times, dtype=float)
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    outside: dict[str, Input] = {
        name: Constant(float(given)) if isinstance(given, (int, float)) else given
        for name, given in (inputs or {}).items()
    }
    start = _start(graph, made, initial or {})
    _known(graph, "input", outside, made.inputs)
    _known(graph, "state", scales or {}, made.states)
    run = _Run(made, parameters, outside, controller, times, start)
    absolute = np.array([rtol * (scales or {}).get(name, 1.0) for name in made.states])
    step = _stepper(method, made, parameters, rtol, absolute)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a solver that gives up says so in the outcome
        outcome = run.integrate(step, progress or (lambda share: None))
    return audited(graph, made, parameters, times[: run.reached], run.states(), run.energies(), run.inputs(), outcome)


def _start(graph: BondGraph, made: Model, initial: Mapping[str, float]) -> list[float]:
    _known(graph, "state", initial, made.states)
    return [float(initial.get(name, 0.0)) for name in made.states]


def _known(graph: BondGraph, what: str, given: Mapping[str, Any], names: Sequence[str]) -> None:
    for name in given:
        if name not in names:
            raise BondGraphError(
                f"{graph.name} has no {what} {name!r}{nearest(name, names)}; it has {', '.join(names) or 'none'}"
            )


class _Run:
    """One integration underway: what is known at the output times reached."""

    def __init__(
        self,
        made: Model,
        parameters: Mapping[str, float],
        outside: Mapping[str, Input],
        controller: Controller | None,
        times: Any,
        start: list[float],
    ) -> None:
        import numpy as np

        self.made, self.times, self.controller = made, times, controller
        self.outside = outside
        self.count = len(start)
        self.extra = len(made.sources) + len(made.losses)
        self.rows = np.full((len(times), self.count + self.extra), np.nan)
        self.held = np.full((len(times), len(made.inputs)), np.nan)
        self.now = [*start, *([0.0] * self.extra)]
        self.reached = 0
        self.outputs = made.function("outputs", FloatNamespace, parameters)
        self.memory: Any = None

    def integrate(self, step: Callable[..., tuple[Any, str]], progress: Callable[[float], None]) -> str:
        """March through the pieces; returns why it stopped early, "" if it did not."""
        import numpy as np

        times, sampled = self.times, set(self._samples())
        bounds = self._bounds(sampled)
        held: dict[str, float] = {}
        for piece, (begin, end) in enumerate(itertools.pairwise(bounds)):
            if self.controller is not None and (piece == 0 or begin in sampled):
                measured = self._measured(begin, held)
                if piece == 0:
                    self.memory = self.controller.start(measured)
                given, self.memory = self.controller.sample(begin, measured, self.memory)
                held = dict(given)
            functions = self._functions(held)
            if piece == 0:
                self._record(0, begin, functions)
            last = int(np.searchsorted(times, end, side="right"))
            inside = times[self.reached : last]
            wanted = inside if len(inside) and inside[-1] == end else np.append(inside, end)
            try:
                rows, problem = step(self.now, begin, wanted, functions)
            except (ArithmeticError, ValueError) as left:  # a law left the range in which it means something
                rows, problem = [], f"a law has no value there ({left}). Try another stick speed or tolerance."
            done = min(len(rows), len(inside))
            if done:
                self.rows[self.reached : self.reached + done] = rows[:done]
            for index in range(self.reached, self.reached + done):
                self.held[index] = [function.value(times[index]) for function in functions]
            self.reached += done
            if problem:
                return f"stopped at {times[self.reached - 1]:.6g} s: {problem}"
            self.now = rows[-1].tolist()
            progress((end - times[0]) / (times[-1] - times[0]))
        return ""

    def _bounds(self, sampled: set[float]) -> list[float]:
        """Ends of the pieces."""
        breaks = self._inside(at for given in self.outside.values() for at in given.breaks)
        return sorted({float(self.times[0]), float(self.times[-1]), *breaks, *sampled})

    def _samples(self) -> list[float]:
        """Instants after the first at which the controller samples."""
        if self.controller is None:
            return []
        first, last, period = float(self.times[0]), float(self.times[-1]), self.controller.sample_time
        return self._inside(first + index * period for index in range(1, int((last - first) / period) + 1))

    def _inside(self, instants: Iterable[float]) -> list[float]:
        """Those within the motion, as the output times next to them have it."""
        import numpy as np

        times = self.times
        close = _SAME_TIME * (times[-1] - times[0])
        found = np.fromiter(instants, dtype=float)
        found = found[(found > times[0] + close) & (found < times[-1] - close)]
        right = np.clip(np.searchsorted(times, found), 1, len(times) - 1)
        nearest_time = np.where(found - times[right - 1] < times[right] - found, times[right - 1], times[right])
        return np.where(np.abs(found - nearest_time) <= close, nearest_time, found).tolist()

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

    def _record(self, index: int, time: float, functions: Sequence[Input]) -> None:
        self.rows[index] = self.now
        self.held[index] = [function.value(time) for function in functions]
        self.reached = index + 1

    def _measured(self, time: float, held: Mapping[str, float]) -> dict[str, float]:
        """Signals at a time. Inputs not set yet count as 0, where a signal depends on one."""
        made = self.made
        outside = self.outside
        inputs = [outside[name].value(time) if name in outside else held.get(name, 0.0) for name in made.inputs]
        rates = [outside[name].rate(time) if name in outside else 0.0 for name in made.rates]
        values = self.outputs(self.now[: self.count], inputs, rates)
        first = 2 * len(made.bonds)
        return dict(zip(made.signals, values[first : first + len(made.signals)], strict=True))

    def states(self) -> Any:
        return self.rows[: self.reached, : self.count]

    def energies(self) -> Any:
        return self.rows[: self.reached, self.count :]

    def inputs(self) -> Any:
        import numpy as np

        rates = np.zeros((self.reached, len(self.made.rates)))
        for column, name in enumerate(self.made.rates):
            if name in self.outside:
                rates[:, column] = [self.outside[name].rate(time) for time in self.times[: self.reached]]
        return self.held[: self.reached], rates


def _stepper(
    method: str, made: Model, parameters: Mapping[str, float], rtol: float, absolute: Any
) -> Callable[..., tuple[Any, str]]:
    """Function that integrates one piece: (state, begin, times wanted, inputs) to (rows, problem)."""
    if method == "CVODES":
        from infinivar.bondgraph.cvodes import stepper

        return stepper(made, parameters, rtol, absolute)
    if method not in ("LSODA", "Radau", "BDF"):
        raise BondGraphError(f"method must be one of LSODA, Radau, BDF, CVODES, got {method!r}")
    import numpy as np
    from scipy import integrate

    dynamics = made.function("dynamics", FloatNamespace, parameters)
    count, size = len(made.states), len(made.states) + len(made.sources) + len(made.losses)
    tolerances = np.concatenate([absolute, np.full(size - count, _ENERGY_SCALE * rtol)])
    rated = [made.inputs.index(name) for name in made.rates]

    def piece(now: list[float], begin: float, wanted: Any, functions: Sequence[Input]) -> tuple[Any, str]:
        if all(isinstance(function, Constant) for function in functions):
            fixed, still = [function.value(begin) for function in functions], [0.0] * len(rated)

            def rates(time: float, row: Any) -> tuple[float, ...]:
                return dynamics(row.tolist()[:count], fixed, still)

        else:

            def rates(time: float, row: Any) -> tuple[float, ...]:
                given = [function.value(time) for function in functions]
                return dynamics(row.tolist()[:count], given, [functions[index].rate(time) for index in rated])

        def slopes(time: float, row: Any) -> Any:
            # Nothing depends on the energies: their columns stay zero.
            base, matrix = np.array(rates(time, row)), np.zeros((size, size))
            for index in range(count):
                moved = row.copy()
                moved[index] += 1e-7 * (abs(row[index]) + 1e-3)
                matrix[:, index] = (np.array(rates(time, moved)) - base) / (moved[index] - row[index])
            return matrix

        if method == "LSODA":
            rows, said = integrate.odeint(
                rates,
                now,
                np.concatenate([[begin], wanted]),
                Dfun=slopes,
                tfirst=True,
                rtol=rtol,
                atol=tolerances,
                tcrit=[wanted[-1]],
                mxstep=_MOST_STEPS,
                full_output=True,
            )
            if said["message"] == "Integration successful.":
                return rows[1:], ""
        solution = integrate.solve_ivp(
            rates,
            (begin, wanted[-1]),
            now,
            method="Radau" if method == "LSODA" else method,
            t_eval=wanted,
            jac=slopes,
            rtol=max(rtol, 1e-12),
            atol=tolerances,
        )
        return solution.y.T, "" if solution.success else f"{solution.message} Try a larger stick speed."

    return piece
