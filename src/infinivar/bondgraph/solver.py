"""Integration of a graph's equations in time, and of the energy of every source and loss.

Compiled steps integrate the energies together with the motion. Other methods compute them after the motion by quadrature
between the output times. If the balance does not close, because of fast changes between the nodes, the motion is computed again
with the energies as additional states.

LSODA (default), Radau and BDF come from SciPy; CVODES comes with CasADi, if installed. All methods integrate in segments
between the instants at which an input may jump: controller samples and steps of external inputs.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from infinivar.bondgraph.audit import CLOSURE, ClosureError, Trajectory, audited
from infinivar.bondgraph.compiled_step import Loop, compiled_loop
from infinivar.bondgraph.graph import BondGraph, BondGraphError
from infinivar.bondgraph.inputs import Constant, Controller, Input
from infinivar.bondgraph.march import March, Watch
from infinivar.bondgraph.model import Model, model
from infinivar.bondgraph.namespaces import FloatNamespace, casadi_namespace
from infinivar.errors import nearest

Method = Literal["auto", "LSODA", "Radau", "BDF", "CVODES"]

_ENERGY_SCALE = 1e-2
"""Energy scale of the absolute tolerance. [J]"""

_MOST_STEPS = 20_000
"""Most steps of LSODA in one segment."""

_SMALLEST_RTOL = 1e-12
"""Smallest tolerance that SciPy's solvers accept without a warning."""


def stepper(
    method: str, made: Model, parameters: Mapping[str, float], rtol: float, absolute: Any, energies_too: bool
) -> Callable[..., tuple[Any, str]]:
    """Function that integrates one segment: (state, begin, output times, inputs) to (rows, problem).

    Parameters
    ----------
    method : str                   auto, LSODA, Radau, BDF or CVODES.
    made, parameters               Model of the graph and its parameter values.
    rtol : float                   Relative tolerance.
    absolute : (n,) float          Absolute tolerances of the states.
    energies_too : bool            Whether energies of sources and losses are states as well.

    Raises
    ------
    BondGraphError
        If the method is unknown or not installed.
    """
    if method == "CVODES":
        return _cvodes(made, parameters, rtol, absolute, energies_too)
    if method not in ("auto", "LSODA", "Radau", "BDF"):
        raise BondGraphError(f"method must be one of auto, LSODA, Radau, BDF, CVODES, got {method!r}")
    extra = len(made.sources) + len(made.losses) if energies_too else 0
    tolerances = np.concatenate([absolute, np.full(extra, _ENERGY_SCALE * rtol)])
    return _scipy("LSODA" if method == "auto" else method, made, parameters, rtol, tolerances, energies_too)


def _scipy(
    method: str, made: Model, parameters: Mapping[str, float], rtol: float, tolerances: Any, energies_too: bool
) -> Callable[..., tuple[Any, str]]:
    """Function that integrates one segment by a method of SciPy, as `stepper` has it."""
    dynamics = made.function("dynamics" if energies_too else "motion", FloatNamespace, parameters)
    count = len(made.states)
    extra = len(tolerances) - count
    moving = [made.inputs.index(name) for name in made.rates]

    def piece(now: list[float], begin: float, required: Any, functions: Sequence[Input]) -> tuple[Any, str]:
        from scipy import integrate  # takes long, and compiled runs need it only where a step fails

        # Called some thousand times a second of motion: only what changes is computed again.
        given = [function.value(begin) for function in functions]
        changing = [(i, each.value) for i, each in enumerate(functions) if not isinstance(each, Constant)]
        speeds = [functions[index].rate for index in moving]
        if not changing:
            still = [0.0] * len(moving)

            def rates(time: float, row: Any) -> tuple[float, ...]:
                return dynamics(row.tolist()[:count] if extra else row.tolist(), given, still)

        else:

            def rates(time: float, row: Any) -> tuple[float, ...]:
                for i, value in changing:
                    given[i] = value(time)
                return dynamics(row.tolist()[:count] if extra else row.tolist(), given, [rate(time) for rate in speeds])

        def slopes(time: float, row: Any) -> Any:
            # Nothing depends on the energies: their columns stay zero.
            base, matrix = np.array(rates(time, row)), np.zeros((count + extra, count + extra))
            for index in range(count):
                moved = row.copy()
                moved[index] += 1e-7 * (abs(row[index]) + 1e-3)
                matrix[:, index] = (np.array(rates(time, moved)) - base) / (moved[index] - row[index])
            return matrix

        if method == "LSODA":
            rows, said = integrate.odeint(
                rates,
                now,
                np.concatenate([[begin], required]),
                Dfun=slopes if energies_too else None,
                tfirst=True,
                rtol=rtol,
                atol=tolerances,
                tcrit=[required[-1]],
                mxstep=_MOST_STEPS,
                full_output=True,
            )
            if said["message"] == "Integration successful.":
                return rows[1:], ""
        solution = integrate.solve_ivp(
            rates,
            (begin, required[-1]),
            now,
            method="Radau" if method == "LSODA" else method,
            t_eval=required,
            jac=slopes,
            rtol=max(rtol, _SMALLEST_RTOL),
            atol=tolerances,
        )
        return solution.y.T, "" if solution.success else f"{solution.message} Try a larger stick speed."

    return piece


def _cvodes(
    made: Model, parameters: Mapping[str, float], rtol: float, absolute: Any, energies_too: bool
) -> Callable[..., tuple[Any, str]]:
    """Function that integrates one piece, as `stepper` has it.

    An input that moves within a piece is taken as the cubic through its values and rates at both ends.

    Raises
    ------
    BondGraphError
        If CasADi is not installed.
    """
    try:
        import casadi
    except ImportError as problem:
        raise BondGraphError("the method CVODES needs CasADi: install infinivar[casadi]") from problem
    import numpy as np

    states, share = casadi.SX.sym("x", len(made.states)), casadi.SX.sym("share")  # type: ignore[attr-defined]
    span = casadi.SX.sym("span")  # type: ignore[attr-defined]
    ends = casadi.SX.sym("ends", 4, len(made.inputs))  # type: ignore[attr-defined]
    values, slopes = [], []
    for column in range(len(made.inputs)):
        first, last, first_rate, last_rate = (ends[row, column] for row in range(4))
        bend = last - first - first_rate * span
        turn = (last_rate - first_rate) * span - 2.0 * bend
        values.append(first + share * (first_rate * span + share * (bend - turn + share * turn)))
        slopes.append(first_rate + share * (2.0 * (bend - turn) + 3.0 * share * turn) / span)
    rates = [slopes[made.inputs.index(name)] for name in made.rates]
    code = "dynamics" if energies_too else "motion"
    result = made.function(code, casadi_namespace(), parameters)(casadi.vertsplit(states), values, rates)
    count = len(made.states)
    problem_ = {
        "x": states,
        "t": share,
        "p": casadi.vertcat(span, casadi.vec(ends)),
        "ode": span * casadi.vertcat(*result[:count]),
    }
    if energies_too:
        problem_["quad"] = span * casadi.vertcat(*result[count:])
    options = {"reltol": rtol, "abstol": float(np.min(absolute)), "max_num_steps": 100_000, "quad_err_con": True}
    made_for: dict[tuple[float, ...], Any] = {}

    def integrator(grid: tuple[float, ...]) -> Any:
        if grid not in made_for:
            made_for[grid] = casadi.integrator("piece", "cvodes", problem_, 0.0, list(grid), options)
        return made_for[grid]

    def piece(now: list[float], begin: float, required: Any, functions: Sequence[Input]) -> tuple[Any, str]:
        end = float(required[-1])
        width = end - begin
        columns = [(f.value(begin), f.value(end), f.rate(begin), f.rate(end)) for f in functions]
        grid = tuple(round(float((time - begin) / width), 12) for time in required)
        given = [width, *(number for column in columns for number in column)]
        try:
            found = integrator(grid)(x0=now[:count], p=given)
        except RuntimeError as problem:
            return np.empty((0, len(now))), f"CVODES failed: {str(problem).splitlines()[-1]}"
        rows = np.array(found["xf"])
        if energies_too:
            rows = np.vstack([rows, np.array(found["qf"]) + np.array(now[count:])[:, None]])
        return rows.T, ""

    return piece


RTOL = 1e-10
"""Default relative tolerance. LSODA restarts at every sample, each time with an error of this size in the same direction;
after a thousand samples the energy balance still closes to 1e-7."""


def solve(
    graph: BondGraph,
    times: Any,
    *,
    inputs: Mapping[str, float | Input] | None = None,
    initial: Mapping[str, float] | None = None,
    controller: Controller | None = None,
    method: Method = "auto",
    rtol: float = RTOL,
    scales: Mapping[str, float] | None = None,
    closure: float = CLOSURE,
    energies_as_states: bool = False,
    progress: Callable[[float], None] | None = None,
    watch: Watch | None = None,
) -> Trajectory:
    """Motion of a graph from given initial states.

    Parameters
    ----------
    graph : BondGraph
    times : (n,) float                    Increasing output times; the motion starts at the first. [s]
    inputs : mapping of name to value     Constants, or functions of time, by name of the source or external signal. Inputs
        set by the controller may be omitted.
    initial : mapping of name to float    States by name: flow of an inertia, displacement of a compliance, value of an
        integral signal. Default: 0.
    controller : Controller               Sets inputs at its samples.
    method : str                          auto: collocation in compiled C where the system has a compiler and every law has C,
        otherwise LSODA. LSODA (Radau replaces it in a segment where it fails), Radau, BDF, or CVODES with CasADi.
    rtol : float                          Relative tolerance of the states.
    scales : mapping of name to float     Scales of the states; the absolute tolerance is `rtol` times the scale. Default: 1.
    closure : float                       Largest residual of the energy balance, relative to the energy moved.
    energies_as_states : bool             Integrate energies together with the motion, for fast changes between output
        times and samples; about twice as slow. Compiled steps always do.
    progress : callable                   Called with the completed fraction.
    watch : callable                      Demands by key, from `Instants`: evaluated at the nodes between output times, for
        the peaks, squares and cubes of the `Trajectory`.

    Returns
    -------
    Trajectory   Truncated, with the reason in `outcome`, if the solver fails.

    Raises
    ------
    BondGraphError
        If the graph has no equations, an input is missing, a name is unknown, or times do not increase.
    AuditError
        If an element creates energy.
    ClosureError
        If the balance does not close: the tolerance is too large.

    Source: faulring2006, section V (the graphs); the solvers' own documentation.
    """
    import numpy as np

    made = model(graph)
    times = _increasing(graph, times)
    if not 0.0 < rtol < 1.0:
        raise BondGraphError(f"{graph.name}: rtol must be > 0 and < 1, got {rtol}")
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    outside: dict[str, Input] = {
        name: Constant(float(given)) if isinstance(given, (int, float)) else given
        for name, given in (inputs or {}).items()
    }
    initial = initial or {}
    _known(graph, "state", initial, made.states)
    start = [float(initial.get(name, 0.0)) for name in made.states]
    _known(graph, "input", outside, made.inputs)
    _known(graph, "state", scales or {}, made.states)
    absolute = np.array([rtol * (scales or {}).get(name, 1.0) for name in made.states])

    def attempt(energies_too: bool, loop: Loop | None = None) -> Trajectory:
        run = March(made, parameters, outside, controller, times, start, energies_too, graph, watch)
        step = stepper(method, made, parameters, rtol, absolute, energies_too) if made.states else _nothing_moves
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the outcome reports a solver failure
            outcome = run.integrate(step, loop, progress or (lambda share: None))
        return audited(graph, made, parameters, run, outcome, closure)

    if not made.states:
        return attempt(energies_too=False)
    loop = None
    if method == "auto":
        own = np.full(len(made.sources) + len(made.losses), _ENERGY_SCALE * rtol)
        loop = compiled_loop(made, parameters, controller, rtol, np.concatenate([absolute, own]))
    if not energies_as_states and loop is None:
        with contextlib.suppress(ClosureError):
            return attempt(energies_too=False)
    return attempt(energies_too=True, loop=loop)


def _increasing(graph: BondGraph, times: Any) -> Any:
    import numpy as np

    times = np.asarray(times, dtype=float)
    if times.ndim != 1 or len(times) < 2 or not np.all(np.isfinite(times)) or not np.all(np.diff(times) > 0):
        raise BondGraphError(f"{graph.name}: times must be at least two increasing values")
    return times


def _nothing_moves(now: Sequence[float], begin: float, required: Any, functions: Sequence[Input]) -> tuple[Any, str]:
    """Step of a graph without states, which the sources determine completely."""
    import numpy as np

    return np.empty((len(required), 0)), ""


def _known(graph: BondGraph, what: str, given: Mapping[str, Any], names: Sequence[str]) -> None:
    for name in given:
        if name not in names:
            raise BondGraphError(
                f"{graph.name} has no {what} {name!r}{nearest(name, names)}; it has {', '.join(names) or 'none'}"
            )
