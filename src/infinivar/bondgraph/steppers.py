"""Common interface to the solvers: integrate from a state over one segment without input jumps."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from infinivar.bondgraph.graph import BondGraphError
from infinivar.bondgraph.inputs import Constant, Input
from infinivar.bondgraph.model import Model
from infinivar.bondgraph.namespaces import FloatNamespace

Method = Literal["LSODA", "Radau", "BDF", "CVODES"]

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
    method : str                   LSODA, Radau, BDF or CVODES.
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
        from infinivar.bondgraph import cvodes

        return cvodes.stepper(made, parameters, rtol, absolute, energies_too)
    if method not in ("LSODA", "Radau", "BDF"):
        raise BondGraphError(f"method must be one of LSODA, Radau, BDF, CVODES, got {method!r}")
    from scipy import integrate

    dynamics = made.function("dynamics" if energies_too else "motion", FloatNamespace, parameters)
    count = len(made.states)
    extra = len(made.sources) + len(made.losses) if energies_too else 0
    tolerances = np.concatenate([absolute, np.full(extra, _ENERGY_SCALE * rtol)])
    moving = [made.inputs.index(name) for name in made.rates]

    def piece(now: list[float], begin: float, wanted: Any, functions: Sequence[Input]) -> tuple[Any, str]:
        # Asked some thousand times a second of motion: only what changes is computed again.
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
                np.concatenate([[begin], wanted]),
                Dfun=slopes if energies_too else None,
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
            rtol=max(rtol, _SMALLEST_RTOL),
            atol=tolerances,
        )
        return solution.y.T, "" if solution.success else f"{solution.message} Try a larger stick speed."

    return piece
