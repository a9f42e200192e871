"""Integration of a graph's equations in time, and of the energy of every source and loss.

Energies are computed after the motion by quadrature between the output times. If the balance does not close, because of fast
changes between the nodes, the motion is computed again with the energies as additional states.

LSODA (default), Radau and BDF come from SciPy; CVODES comes with CasADi, if installed. All methods integrate in segments
between the instants at which an input may jump: controller samples and steps of external inputs.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from infinivar.bondgraph.audit import CLOSURE, ClosureError, Trajectory, audited
from infinivar.bondgraph.graph import BondGraph, BondGraphError
from infinivar.bondgraph.inputs import Constant, Controller, Input
from infinivar.bondgraph.march import March, Watch
from infinivar.bondgraph.model import model
from infinivar.bondgraph.steppers import Method, stepper
from infinivar.errors import nearest

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
    method: Method = "LSODA",
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
    method : str                          LSODA (Radau replaces it in a segment where it fails), Radau, BDF, or CVODES with
        CasADi.
    rtol : float                          Relative tolerance of the states.
    scales : mapping of name to float     Scales of the states; the absolute tolerance is `rtol` times the scale. Default: 1.
    closure : float                       Largest residual of the energy balance, relative to the energy moved.
    energies_as_states : bool             Integrate energies together with the motion, for fast changes between output
        times and samples; about twice as slow.
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

    def attempt(energies_too: bool) -> Trajectory:
        run = March(made, parameters, outside, controller, times, start, energies_too, graph, watch)
        step = stepper(method, made, parameters, rtol, absolute, energies_too) if made.states else _nothing_moves
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the outcome reports a solver failure
            outcome = run.integrate(step, progress or (lambda share: None))
        return audited(graph, made, parameters, run, outcome, closure)

    if not made.states:
        return attempt(energies_too=False)
    if not energies_as_states:
        with contextlib.suppress(ClosureError):
            return attempt(energies_too=False)
    return attempt(energies_too=True)


def _increasing(graph: BondGraph, times: Any) -> Any:
    import numpy as np

    times = np.asarray(times, dtype=float)
    if times.ndim != 1 or len(times) < 2 or not np.all(np.isfinite(times)) or not np.all(np.diff(times) > 0):
        raise BondGraphError(f"{graph.name}: times must be at least two increasing values")
    return times


def _nothing_moves(now: Sequence[float], begin: float, wanted: Any, functions: Sequence[Input]) -> tuple[Any, str]:
    """Step of a graph without states, which the sources determine completely."""
    import numpy as np

    return np.empty((len(wanted), 0)), ""


def _known(graph: BondGraph, what: str, given: Mapping[str, Any], names: Sequence[str]) -> None:
    for name in given:
        if name not in names:
            raise BondGraphError(
                f"{graph.name} has no {what} {name!r}{nearest(name, names)}; it has {', '.join(names) or 'none'}"
            )
