"""C99 of a model's equations: one text without dependencies, allocation or global state, the same for the same model.

What depends on parameters alone is computed once, by a function of its own. The derivatives of the rates by the states are exact.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar.bondgraph.model import Model
from infinivar.bondgraph.tape import CONDITIONS, Number, Tape, TapeNamespace, Value

_INFIX = {
    "add": "+",
    "sub": "-",
    "mul": "*",
    "truediv": "/",
    "lt": "<",
    "le": "<=",
    "gt": ">",
    "ge": ">=",
    "eq": "==",
    "ne": "!=",
    "and": "&&",
    "or": "||",
}
_CALLED = {"abs": "fabs"}
_GIVEN = {"states": "x", "inputs": "u", "rates": "du", "parameters": "p"}
"""Arguments of the C functions, by group."""


@dataclass(frozen=True, slots=True)
class Code:
    """C of a model."""

    text: str
    tape: Tape
    constants: int
    """Length of the array `k` of what depends on parameters alone."""

    def given(self, parameters: Mapping[str, float]) -> np.ndarray:
        """The array `p` for values of the parameters: these, and the data held."""
        own = np.array([parameters[name] for name in self.tape.parameters], dtype=float)
        return np.concatenate([own, *map(_flat, self.tape.data(parameters))])


def _flat(data: Any) -> np.ndarray:
    if isinstance(data, tuple):
        return np.concatenate([_flat(one) for one in data])
    return np.ravel(np.asarray(data, dtype=float))


def c_code(made: Model, parameters: Mapping[str, float]) -> Code:
    """C of the motion of a model: ``constants``, ``motion``, ``slopes``, and the ``powers`` of its sources and losses.

    Parameters
    ----------
    made : Model
    parameters : mapping   Values by symbol, of which the text has nothing: they state the shapes of tables.

    Returns
    -------
    Code

    Raises
    ------
    TypeError, AttributeError
        If a law has no C: it decides by a value, or calls what the tape has not.
    """
    tape = Tape({name: parameters[name] for name in sorted(parameters)})
    groups = {"states": made.states, "inputs": made.inputs, "rates": made.rates, "parameters": tape.parameters}
    states, inputs, rates, values = (
        [tape.input(group, place) for place in range(len(own))] for group, own in groups.items()
    )
    symbols: Any = dict(zip(tape.parameters, values, strict=True))
    results = made.function("motion", TapeNamespace(tape), symbols)(states, inputs, rates)
    slopes = [tape.slope(one, by) for one in results for by in states]
    powers = made.function("dynamics", TapeNamespace(tape), symbols)(states, inputs, rates)[len(states) :]
    sizes = [len(_flat(one)) for one in tape.data(tape.parameters)]
    begins = {f"held{place}": len(tape.parameters) + sum(sizes[:place]) for place in range(len(sizes))}
    writer = _Writer(tape, begins)
    once = writer.once([*results, *slopes, *powers])
    text = "\n".join(
        [
            "#include <math.h>",
            "",
            f"enum {{ STATES = {len(made.states)}, POWERS = {len(powers)} }};",
            f"enum {{ INPUTS = {len(made.inputs)}, RATES = {len(made.rates)} }};",
            f"static const int moving[] = {{{', '.join(str(made.inputs.index(name)) for name in made.rates) or '0'}}};",
            "",
            *(f"/* x[{place}]: {_plain(name)} */" for place, name in enumerate(made.states)),
            *(f"/* u[{place}]: {_plain(name)} */" for place, name in enumerate(made.inputs)),
            *(f"/* p[{place}]: {_plain(name)} */" for place, name in enumerate(tape.parameters)),
            "",
            "void constants(const double *p, double *k)",
            "{",
            *writer.body(once, [(f"k[{place}]", Value(tape, one)) for place, one in enumerate(once)], constants=False),
            "}",
            "",
            *_function("motion", "f", writer.body(once, [(f"f[{place}]", one) for place, one in enumerate(results)])),
            *_function("slopes", "j", writer.body(once, [(f"j[{place}]", one) for place, one in enumerate(slopes)])),
            *_function("powers", "f", writer.body(once, [(f"f[{place}]", one) for place, one in enumerate(powers)])),
        ]
    )
    return Code(text, tape, len(once))


def _function(name: str, out: str, body: Iterable[str]) -> list[str]:
    """A function of the states, inputs and rates that writes into an array."""
    arguments = ", ".join([*(f"const double *{one}" for one in ("p", "k", "x", "u", "du")), f"double *{out}"])
    return [
        f"static void {name}({arguments})",
        "{",
        f"    (void)p; (void)k; (void)x; (void)u; (void)du; (void){out};",
        *body,
        "}",
        "",
    ]


def _plain(name: str) -> str:
    return name.replace("*/", "").replace("\\", "/")


class _Writer:
    """Prints nodes of a tape."""

    def __init__(self, tape: Tape, begins: Mapping[str, int]) -> None:
        self.tape, self.begins = tape, begins
        self.fixed: set[int] = set()
        for place, (operation, arguments) in enumerate(tape.nodes):
            if (
                operation == "parameters"
                or operation in begins
                or (
                    operation not in ("states", "inputs", "rates")
                    and all(one in self.fixed for one in arguments if isinstance(one, int))
                )
            ):
                self.fixed.add(place)

    def needed(self, results: Iterable[Number], until: Iterable[int] = ()) -> list[int]:
        """Places of the nodes behind some results, in order; not those behind `until`."""
        stop, found = set(until), set()
        waiting = [one.place for one in results if isinstance(one, Value)]
        while waiting:
            place = waiting.pop()
            if place in found:
                continue
            found.add(place)
            if place not in stop and not self._is_given(place):
                waiting += [one for one in self.tape.nodes[place].arguments if isinstance(one, int)]
        return sorted(found)

    def once(self, results: Sequence[Number]) -> list[int]:
        """Nodes of parameters alone that nodes of states use directly, or that are results."""
        needed = self.needed(results)
        direct = {one.place for one in results if isinstance(one, Value)}
        for place in needed:
            if place not in self.fixed:
                direct |= {one for one in self.tape.nodes[place].arguments if isinstance(one, int)}
        computed = (place for place in direct & self.fixed if not self._is_given(place))
        return sorted(place for place in computed if self.tape.nodes[place].operation not in CONDITIONS)

    def _is_given(self, place: int) -> bool:
        operation = self.tape.nodes[place].operation
        return operation in _GIVEN or operation in self.begins

    def body(
        self, once: Sequence[int], results: Sequence[tuple[str, Number]], *, constants: bool = True
    ) -> Iterator[str]:
        """Yield statements that compute results into places, from `k` if it has constants."""
        known = {place: f"k[{number}]" for number, place in enumerate(once)} if constants else {}
        for place in self.needed((one for _, one in results), known):
            if place in known or self._is_given(place):
                continue
            kind = "int" if self.tape.nodes[place].operation in CONDITIONS else "double"
            yield f"    const {kind} v{place} = {self._text(place, known)};"
        for target, one in results:
            yield f"    {target} = {self._name(one.place, known) if isinstance(one, Value) else _number(one)};"

    def _name(self, one: float | int, known: Mapping[int, str]) -> str:
        if isinstance(one, float):
            return _number(one)
        if one in known:
            return known[one]
        operation, arguments = self.tape.nodes[one]
        if operation in _GIVEN:
            return f"{_GIVEN[operation]}[{arguments[0]}]"
        if operation in self.begins:
            return f"p[{self.begins[operation] + int(arguments[0])}]"
        return f"v{one}"

    def _text(self, place: int, known: Mapping[int, str]) -> str:
        operation, arguments = self.tape.nodes[place]
        parts = [self._name(one, known) for one in arguments]
        if operation in _INFIX:
            return f"{parts[0]} {_INFIX[operation]} {parts[1]}"
        if operation == "neg":
            return f"-{parts[0]}"
        if operation == "not":
            return f"!{parts[0]}"
        if operation == "where":
            return f"{parts[0]} ? {parts[1]} : {parts[2]}"
        if operation == "sign":
            return f"(double)(({parts[0]} > 0.0) - ({parts[0]} < 0.0))"
        if operation.startswith("take"):
            _, group, begin = operation.split()
            return f"p[{self.begins[group] + int(begin)} + (int){parts[0]}]"
        return f"{_CALLED.get(operation, operation)}({', '.join(parts)})"


def _number(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return f"({value!r})" if value < 0 else repr(value)
