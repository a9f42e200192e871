"""C99 of a model's equations: one text without dependencies, allocation or global state, the same for the same model.

What depends on parameters alone is computed once, by a function of its own. The derivatives of the rates by the states are exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

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
_GIVEN = {"states": "x", "inputs": "u", "rates": "du", "seeds": "d", "parameters": "p", "settled": "settled"}
"""Arguments of the C functions, by group."""
_WRITTEN = {"slopes": "j", "signals": "s", "outputs": "y", "directions": "dy"}
"""Arrays that functions write into, where they are not called f."""


@dataclass(frozen=True, slots=True)
class Code:
    """C of a model."""

    text: str
    tape: Tape
    constants: int
    """Length of the array `k` of what depends on parameters alone."""
    behind: tuple[frozenset[tuple[str, int]], ...]
    """Groups and places of the states, inputs, rates and parameters behind each derivative of a state and each output."""

    def given(self, parameters: Mapping[str, float]) -> np.ndarray:
        """The array `p` for values of the parameters: these, and the data held."""
        own = np.array([parameters[name] for name in self.tape.parameters], dtype=float)
        return np.concatenate([own, *map(flat, self.tape.data(parameters))])


def flat(data: Any) -> np.ndarray:
    """Numbers of what is held as data, in order."""
    if isinstance(data, tuple):
        return np.concatenate([flat(one) for one in data])
    return np.ravel(np.asarray(data, dtype=float))


class Added(NamedTuple):
    """What C has beside a model: states that do not act on it, and outputs."""

    states: Sequence[str]
    read: Callable[
        [Sequence[Number], Mapping[str, Number], Sequence[Number]], tuple[Sequence[Number], Sequence[Number]]
    ]
    """Outputs, and rates of these states, from what the model's function "outputs" returns, the parameters by symbol, and the
    states."""


def c_code(made: Model, parameters: Mapping[str, float], added: Added | None = None) -> Code:
    """C of the motion of a model: ``constants``, ``motion``, ``slopes``, ``signals``, and the ``powers`` of sources and losses.

    With what is added also ``outputs`` and ``directions``.

    Parameters
    ----------
    made : Model
    parameters : mapping   Values by symbol, of which the text has nothing: they state the shapes of tables.
    added : Added          States, after those of the model, and what ``outputs`` writes. ``directions`` writes the change of
        the states' derivatives, then that of the outputs, by a change of states, inputs and rates.

    Returns
    -------
    Code

    Raises
    ------
    TypeError, AttributeError
        If a law has no C: it decides by a value, or calls what the tape has not.
    """
    tape = Tape({name: parameters[name] for name in sorted(parameters)})
    every = [*made.states, *(added.states if added else ())]
    groups = {"states": every, "inputs": made.inputs, "rates": made.rates, "parameters": tape.parameters}
    states, inputs, rates, values = (
        [tape.input(group, place) for place in range(len(own))] for group, own in groups.items()
    )
    own, more = states[: len(made.states)], states[len(made.states) :]
    symbols: Any = dict(zip(tape.parameters, values, strict=True))
    results = made.function("motion", TapeNamespace(tape), symbols)(own, inputs, rates)
    written: Sequence[Number] = []
    if added is not None:
        found = made.function("outputs", TapeNamespace(tape), symbols)(own, inputs, rates)
        written, grown = added.read(found, symbols, more)
        results = [*results, *grown]
    slopes = [tape.slope(one, by) for one in results for by in states]
    powers = made.function("dynamics", TapeNamespace(tape), symbols)(own, inputs, rates)[len(own) :]
    signals = made.function("measured", TapeNamespace(tape), symbols)(own, inputs, rates)
    known = [*states, *inputs, *rates] if written else []
    seeds = [(tape.input("seeds", place), by) for place, by in enumerate(known)]
    changes = tape.changes([*results, *written], seeds) if known else []
    functions = {"motion": results, "slopes": slopes, "powers": powers, "signals": signals}
    if written:
        functions |= {"outputs": written, "directions": changes}
    text, writer, once = _program(tape, every, made.inputs, made.rates, functions)
    return Code(text, tape, once, writer.behind([*results, *written]))


def c_motion(
    tape: Tape,
    states: Sequence[str],
    inputs: Sequence[str],
    functions: Mapping[str, Sequence[Number]],
    rates: Sequence[str] = (),
) -> Code:
    """C of ``constants``, of functions of recorded states, inputs and rates of some inputs, and of the ``slopes`` of the one
    called ``motion``.

    With one called ``outputs`` also of ``directions``, as `c_code`.
    """
    by = [tape.input("states", place) for place in range(len(states))]
    known = [*by, *(tape.input("inputs", place) for place in range(len(inputs)))]
    known += [tape.input("rates", place) for place in range(len(rates))]
    slopes = [tape.slope(one, state) for one in functions["motion"] for state in by]
    functions = {"signals": (), **functions, "slopes": slopes}
    written = [*functions["motion"], *functions.get("outputs", ())]
    if "outputs" in functions:
        functions["directions"] = tape.changes(
            written, [(tape.input("seeds", place), one) for place, one in enumerate(known)]
        )
    text, writer, once = _program(tape, states, inputs, rates, functions)
    return Code(text, tape, once, writer.behind(written))


def _program(
    tape: Tape,
    states: Sequence[str],
    inputs: Sequence[str],
    rates: Sequence[str],
    functions: Mapping[str, Sequence[Number]],
) -> tuple[str, _Writer, int]:
    """The text of functions that write values into arrays, what has written it, and how many constants there are."""
    writer = _Writer(tape, _begins(tape))
    once = writer.once([one for values in functions.values() for one in values])
    bodies: list[str] = []
    for name, values in functions.items():
        array = _WRITTEN.get(name, "f")
        body = writer.body(once, [(f"{array}[{place}]", one) for place, one in enumerate(values)])
        bodies += _function(name, array, body, *("d" for _ in [0] if name == "directions"))
    text = "\n".join(
        [
            "#include <math.h>",
            "",
            f"enum {{ STATES = {len(states)}, POWERS = {len(functions['powers'])} }};",
            f"enum {{ INPUTS = {len(inputs)}, RATES = {len(rates)}, SIGNALS = {len(functions['signals'])} }};",
            f"static const int moving[] = {{{', '.join(str(inputs.index(name)) for name in rates) or '0'}}};",
            "",
            *(f"/* x[{place}]: {_plain(name)} */" for place, name in enumerate(states)),
            *(f"/* u[{place}]: {_plain(name)} */" for place, name in enumerate(inputs)),
            *(f"/* p[{place}]: {_plain(name)} */" for place, name in enumerate(tape.parameters)),
            "",
            "void constants(const double *p, double *k)",
            "{",
            *writer.body(once, [(f"k[{place}]", Value(tape, one)) for place, one in enumerate(once)], constants=False),
            "}",
            "",
            *bodies,
        ]
    )
    return text, writer, len(once)


def statements(tape: Tape, results: Sequence[Number], array: str, numbers: list[float] | None = None) -> list[str]:
    """Statements that compute results of a tape without parameters into an array, from the inputs `u` and the data `p`.

    With a list, the numbers of the formulas are added to it and read from an array `c`, so that the text has none of them.
    """
    writer = _Writer(tape, _begins(tape), numbers)
    return [*writer.body([], [(f"{array}[{place}]", one) for place, one in enumerate(results)], constants=False)]


def table_of(tape: Tape, name: str) -> list[str]:
    """The data of a tape without parameters as an array."""
    return array_of(data_of(tape).tolist(), name)


def data_of(tape: Tape) -> np.ndarray:
    """The data of a tape without parameters."""
    return np.concatenate([np.zeros(0), *map(flat, tape.data({}))])


def array_of(numbers: Sequence[float], name: str) -> list[str]:
    """Numbers as an array of C."""
    return [f"static const double {name}[] = {{", *(f"    {c_number(one)}," for one in numbers or [0.0]), "};", ""]


def _begins(tape: Tape) -> dict[str, int]:
    """Where each group of data begins in the array `p`, after the parameters."""
    sizes = [len(flat(one)) for one in tape.data(tape.parameters)]
    return {f"held{place}": len(tape.parameters) + sum(sizes[:place]) for place in range(len(sizes))}


def _function(name: str, out: str, body: Iterable[str], *more: str) -> list[str]:
    """A function of the states, inputs and rates that writes into an array."""
    given = ("p", "k", "x", "u", "du", *more)
    return [
        f"static void {name}({', '.join([*(f'const double *{one}' for one in given), f'double *{out}'])})",
        "{",
        f"    {' '.join(f'(void){one};' for one in (*given, out))}",
        *body,
        "}",
        "",
    ]


def _plain(name: str) -> str:
    return name.replace("*/", "").replace("\\", "/")


class _Loop(NamedTuple):
    """What a loop begins with, carries, computes in each step, and when it ends: numbers, and places of nodes."""

    begins: Sequence[float | int]
    values: Sequence[float | int]
    new: Sequence[float | int]
    ends: float | int
    steps: int
    inner: set[int]


class _Writer:
    """Prints nodes of a tape."""

    def __init__(self, tape: Tape, begins: Mapping[str, int], numbers: list[float] | None = None) -> None:
        self.tape, self.begins, self.numbers = tape, begins, numbers
        self.fixed: set[int] = set()
        for place, (operation, arguments) in enumerate(tape.nodes):
            if (
                operation == "parameters"
                or operation in begins
                or (operation not in _GIVEN and all(one in self.fixed for one in arguments if isinstance(one, int)))
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

    def behind(self, results: Iterable[Number]) -> tuple[frozenset[tuple[str, int]], ...]:
        """Groups and places of what is given behind each of some results."""
        nodes = ([self.tape.nodes[place] for place in self.needed([one])] for one in results)
        given = ([one for one in each if one.operation in _GIVEN] for each in nodes)
        return tuple(frozenset((operation, int(place)) for operation, (place,) in each) for each in given)

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

    def _loop(self, place: int) -> _Loop:
        """A loop: arguments, and the nodes that are computed anew in each step, as its values are behind them."""
        *numbers, ends, steps = self.tape.nodes[place].arguments
        count = len(numbers) // 3
        begins, values, new = (numbers[count * part : count * (part + 1)] for part in range(3))
        found = set(map(int, values))
        for one in range(int(values[0]) + 1, place):
            if found & {int(other) for other in self.tape.nodes[one].arguments if isinstance(other, int)}:
                found.add(one)
        behind = self.needed(Value(self.tape, one) for one in (*new, ends) if isinstance(one, int))
        return _Loop(begins, values, new, ends, int(steps), found & set(behind))

    def _looped(self, place: int, one: _Loop, known: Mapping[int, str]) -> Iterator[str]:
        """Yield the statements of a loop."""
        for begin, value in zip(one.begins, one.values, strict=True):
            yield f"    double v{value} = {self._name(begin, known)};"
        yield f"    for (int i{place} = 0; i{place} < {one.steps}; i{place}++) {{"
        yield from (f"    {line}" for line in self._statements(sorted(one.inner), known))
        for number, new in enumerate(one.new):
            yield f"        const double n{place}_{number} = {self._name(new, known)};"
        for number, value in enumerate(one.values):
            yield f"        v{value} = n{place}_{number};"
        if isinstance(one.ends, int):
            yield f"        if ({self._name(one.ends, known)}) {{"
            yield "            break;"
            yield "        }"
        yield "    }"

    def _statements(self, places: Sequence[int], known: Mapping[int, str]) -> Iterator[str]:
        """Yield statements that compute nodes, in order."""
        loops = {place: self._loop(place) for place in places if self.tape.nodes[place].operation == "loop"}
        later = set().union(*(one.inner for one in loops.values()))
        for place in places:
            operation = self.tape.nodes[place].operation
            if place in known or place in later or operation in ("looped", "last") or self._is_given(place):
                continue
            if operation == "loop":
                yield from self._looped(place, loops[place], known)
                continue
            kind = "int" if operation in CONDITIONS else "double"
            yield f"    const {kind} v{place} = {self._text(place, known)};"

    def body(
        self, once: Sequence[int], results: Sequence[tuple[str, Number]], *, constants: bool = True
    ) -> Iterator[str]:
        """Yield statements that compute results into places, from `k` if it has constants."""
        known = {place: f"k[{number}]" for number, place in enumerate(once)} if constants else {}
        yield from self._statements(self.needed((one for _, one in results), known), known)
        for target, one in results:
            yield f"    {target} = {self._name(one.place if isinstance(one, Value) else float(one), known)};"

    def _name(self, one: float | int, known: Mapping[int, str]) -> str:
        if isinstance(one, float):
            if self.numbers is None:
                return c_number(one)
            self.numbers.append(one)
            return f"c[{len(self.numbers) - 1}]"
        if one in known:
            return known[one]
        operation, arguments = self.tape.nodes[one]
        if operation in _GIVEN:
            return f"{_GIVEN[operation]}[{arguments[0]}]"
        if operation in self.begins:
            return f"p[{self.begins[operation] + int(arguments[0])}]"
        return f"v{arguments[1] if operation == 'last' else one}"

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


def c_number(value: float) -> str:
    """A number as C has it."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return f"({value!r})" if value < 0 else repr(value)
