"""CVODES through CasADi: the generated code as a symbolic expression, integrated by compiled code."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from infinivar.bondgraph.graph import BondGraphError
from infinivar.bondgraph.inputs import Input
from infinivar.bondgraph.model import Model
from infinivar.bondgraph.namespaces import casadi_namespace


def stepper(
    made: Model, parameters: Mapping[str, float], rtol: float, absolute: Any, energies_too: bool
) -> Callable[..., tuple[Any, str]]:
    """Function that integrates one piece, as `infinivar.bondgraph.steppers.stepper` has it.

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

    def piece(now: list[float], begin: float, wanted: Any, functions: Sequence[Input]) -> tuple[Any, str]:
        end = float(wanted[-1])
        width = end - begin
        columns = [(f.value(begin), f.value(end), f.rate(begin), f.rate(end)) for f in functions]
        grid = tuple(round(float((time - begin) / width), 12) for time in wanted)
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
