"""The plant of a drive as other programs see it: variables with units and sources, and C without dependencies."""

from __future__ import annotations

import contextlib
import functools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any, Literal, NamedTuple

from infinivar._core.fields import quantities_of, value_at, with_values
from infinivar.bondgraph.c_code import Code, c_code
from infinivar.bondgraph.graph import SOURCES, STORAGES, BondGraph
from infinivar.bondgraph.inputs import Constant
from infinivar.bondgraph.model import Model, model
from infinivar.drivetrain.graphs.closed_loop import closed_loop, scenario_graph
from infinivar.errors import InputError
from infinivar.exports.domains import domains, unit_of_input, unit_of_signal, unit_of_state
from infinivar.motion.scenario import Scenario
from infinivar.study.provenance import Provenance

Role = Literal["time", "state", "derivative", "input", "rate", "output", "parameter"]

_CHANGE = 1e-6
"""Relative change of a field by which the parameters that it decides are found."""

_MOST_LETTERS = 64
"""In a name: longer ones are cut, as some importers refuse them."""


class Variable(NamedTuple):
    """One number of a plant.

    `start` is None where it is computed. `fixed`: a parameter that decides tables, which are data of the export.
    """

    name: str
    role: Role
    unit: str
    description: str
    start: float | None = None
    fixed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Plant:
    """Variables in the order of their value references, and C.

    Attributes
    ----------
    name, title     Identifier of at most 64 letters, and headline.
    variables       Time, states, their derivatives, inputs, rates of inputs, outputs, parameters.
    code            C of the equations; `text` has with it what a run needs.
    behind          Places of the variables behind each derivative and output, by its place.
    """

    name: str
    title: str
    variables: tuple[Variable, ...]
    code: Code
    text: str
    behind: Mapping[int, tuple[int, ...]]

    def places(self, *roles: Role) -> list[int]:
        """Places of the variables of these roles."""
        return [place for place, one in enumerate(self.variables) if one.role in roles]


def plant(drive: Any, scenario: Scenario, name: str, title: str, sources: Iterable[Provenance]) -> Plant:
    """The plant of a drive in a scenario, without its controllers.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive
    scenario : Scenario   States what the amplifier imposes, what the load is, and where the motion starts.
    name, title : str
    sources : iterable of Provenance   Of the drive's values.

    Raises
    ------
    InputError
        If a value that motion requires is missing, or a law has no C.
    """
    loop = closed_loop(drive, scenario)
    graph, made = loop.graph, model(loop.graph)
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    found = domains(graph, rotary=drive.axis.rotary)
    values = {name: given.value(0.0) if hasattr(given, "value") else given for name, given in loop.inputs.items()}  # type: ignore[union-attr]
    units = {name: unit_of_input(graph, name, found) for name in made.inputs}
    of = {one.name: one.of or one.name for one in graph.signals}

    def described(name: str, role: Role, unit: str, start: float | None = None) -> Variable:
        return Variable(name, role, unit, _said(graph, of.get(name, name), unit), start)

    states = [
        described(name, "state", unit_of_state(graph, name, kind, found), float(loop.initial.get(name, 0.0)))
        for name, kind in zip(made.states, made.state_kinds, strict=True)
    ]
    signals = [
        (made.signals.index(one.name), described(one.name, "output", unit_of_signal(graph, one, found)))
        for one in graph.signals
        if one.name not in {*made.states, *made.inputs}
    ]
    ports = list(_ports(graph, made, found))
    try:
        code = c_code(made, parameters, functools.partial(_outputs, made, graph, [place for place, _ in signals], ports))
    except (TypeError, AttributeError) as problem:
        raise InputError(
            f"a law of the drive has no C, as it is not written over the array namespace alone: {problem}"
        ) from problem
    tables = {name for _, names in code.tape.held for name in names}
    stated = _stated(drive, scenario, graph, sources)
    rows = [
        Variable("time", "time", "s", "time"),
        *states,
        *(Variable(f"der({one.name})", "derivative", _rate(one.unit), f"time derivative of {one.name}") for one in states),
        *(described(one, "input", units[one], float(values.get(one, 0.0))) for one in made.inputs),
        *(Variable(f"{one}_rate", "rate", _rate(units[one]), f"time derivative of {one}", 0.0) for one in made.rates),
        *(one for _, one in signals),
        *(one for _, one in ports),
        *_powers(graph, made),
        *(
            Variable(_short(f"parameter.{_plain(one)}"), "parameter", graph.parameters[one].unit or "1", stated[one], value, one in tables)
            for one, value in ((one, parameters[one]) for one in code.tape.parameters)
        ),
    ]
    variables = tuple(_distinct(rows))
    return Plant(
        name=name,
        title=title,
        variables=variables,
        code=code,
        text=_text(code, parameters, variables),
        behind=_behind(code, variables),
    )


_WORDS = {
    "A": "current",
    "V": "voltage",
    "N": "force",
    "N m": "torque",
    "m": "position",
    "rad": "angle",
    "m/s": "speed",
    "rad/s": "angular speed",
}
"""What is measured in a unit."""


def _said(graph: BondGraph, of: str, unit: str) -> str:
    """What a variable is: its quantity and its element."""
    element = next((one for one in graph.elements if one.name == of), None)
    return f"{_WORDS.get(unit, 'value')} of {of if element is None else element.title}"


def _rate(unit: str) -> str:
    return f"{unit}/s" if unit and "/" not in unit else {"m/s": "m/s^2", "rad/s": "rad/s^2"}.get(unit, "")


def _ports(graph: BondGraph, made: Model, found: Mapping[tuple[str, str], Any]) -> Iterator[tuple[int, Variable]]:
    """Yield what the sources meet, with its place in the outputs of a model: the voltage of a current, the speed of a force."""
    ends = [(bond.tail, bond.head) for bond in graph.bonds]
    for name in made.sources:
        place, element = next(i for i, bond in enumerate(made.bonds) if name in bond), graph[name]
        domain = found[ends[next(i for i, end in enumerate(ends) if name in end)]]
        kinds = {"effort": 0, "flow": len(made.bonds)}
        if name in made.inputs:
            del kinds["effort" if element.kind == "Se" else "flow"]
        for kind, offset in kinds.items():
            unit = getattr(domain, kind)
            word = _WORDS.get(unit, kind)
            yield offset + place, Variable(f"{_plain(word)}.{name}", "output", unit, f"{word} at {element.title}")


def _outputs(
    made: Model, graph: BondGraph, signals: Sequence[int], ports: Sequence[tuple[int, Variable]], values: Sequence[Any]
) -> list[Any]:
    """What the export computes, from all outputs of a model."""
    bonds, given = len(made.bonds), list(values)
    after = 2 * bonds
    stored = after + len(made.signals)
    energies, powers = given[stored : stored + len(made.storages)], given[stored + len(made.storages) :]
    taken = [
        given[place] * given[bonds + place]
        for place in (next(i for i, bond in enumerate(made.bonds) if name in bond) for name in made.storages)
    ]
    return [*(given[after + place] for place in signals), *(given[place] for place, _ in ports), *energies, *taken, *powers]


def _powers(graph: BondGraph, made: Model) -> Iterator[Variable]:
    """Yield energies and powers, in the order of `_outputs`."""
    for name in made.storages:
        yield Variable(f"energy.{name}", "output", "J", f"energy stored in {graph[name].title}")
    for name in made.storages:
        yield Variable(f"power.{name}", "output", "W", f"power taken up by {graph[name].title}")
    for name in made.sources:
        yield Variable(f"power.{name}", "output", "W", f"power supplied to the plant by {graph[name].title}")
    several = [element for element, _ in made.losses]
    for element, loss in made.losses:
        where = f".{_plain(loss)}" if several.count(element) > 1 else ""
        before = " before the plant, which the supply adds" if graph[element].kind in SOURCES else ""
        yield Variable(_short(f"loss.{element}{where}"), "output", "W", f"power lost: {loss}{before}")


def _stated(
    drive: Any, scenario: Scenario, graph: BondGraph, sources: Iterable[Provenance]
) -> dict[str, str]:
    """What each parameter belongs to, and the fields of the drive that decide it, with kind and source.

    A field decides the parameters that change with it.
    """
    known = {row.field: row for row in sources}
    fields: dict[str, list[str]] = {symbol: [] for symbol in graph.parameters}
    for path in quantities_of(drive):
        value = value_at(drive, path)
        if not isinstance(value, float):
            continue
        with contextlib.suppress(InputError):  # values that no drive has
            other = scenario_graph(with_values(drive, {path: value * (1.0 + _CHANGE) or _CHANGE}), scenario)
            for symbol, parameter in other.parameters.items():
                if symbol in fields and parameter.value != graph.parameters[symbol].value:
                    fields[symbol].append(path)
    found = {}
    for symbol in graph.parameters:
        owners = [
            one.title
            for one in graph.elements
            if symbol in [each.symbol for each in (*([one.parameter] if one.parameter else []), *one.parameters.values())]
        ]
        paths = [_source(path, known.get(path)) for path in fields[symbol]] or ["program or scenario"]
        found[symbol] = f"{symbol} of {', '.join(dict.fromkeys(owners))}; from {'; '.join(paths)}"
    return found


def _source(path: str, row: Provenance | None) -> str:
    return path if row is None else f"{path} = {row.written} ({', '.join(filter(None, (row.kind, row.where)))})"


def _plain(symbol: str) -> str:
    """A symbol in letters, digits and underscores."""
    text = symbol.replace("'", "_back").replace("/", "_over_")
    return re.sub(r"\W+", "_", text).strip("_")


def _short(name: str) -> str:
    return name[:_MOST_LETTERS]


def _distinct(rows: Iterable[Variable]) -> Iterator[Variable]:
    """Yield variables of different names: of two of one name the second has a number."""
    known: set[str] = set()
    for one in rows:
        name = next(
            name
            for name in (one.name, *(f"{one.name[: _MOST_LETTERS - 4]}_{count}" for count in range(2, 1000)))
            if name not in known
        )
        known.add(name)
        yield one._replace(name=name)


def _behind(code: Code, variables: Sequence[Variable]) -> dict[int, tuple[int, ...]]:
    begins = {
        group: next((place for place, one in enumerate(variables) if one.role == role), 0)
        for group, role in (("states", "state"), ("inputs", "input"), ("rates", "rate"), ("parameters", "parameter"))
    }
    computed = [place for place, one in enumerate(variables) if one.role in ("derivative", "output")]
    return {
        place: tuple(sorted(begins[group] + number for group, number in groups))
        for place, groups in zip(computed, code.behind, strict=True)
    }


def _text(code: Code, parameters: Mapping[str, float], variables: Sequence[Variable]) -> str:
    """C of the equations and of a run, with the numbers that the plant starts from."""
    given = code.given(parameters).tolist()

    def starts(role: Role) -> list[float]:
        return [one.start or 0.0 for one in variables if one.role == role]

    return "\n".join(
        [
            code.text,
            (resources.files("infinivar.bondgraph") / "data" / "collocation.c").read_text("utf-8"),
            f"enum {{ OUTPUTS = {sum(one.role == 'output' for one in variables)}, PARAMETERS = {len(starts('parameter'))}, "
            f"GIVEN = {len(given)}, CONSTANTS = {code.constants} }};",
            _array("start_given", given),
            _array("start_states", starts("state")),
            _array("start_inputs", [*starts("input"), *starts("rate")]),
            "",
        ]
    )


def _array(name: str, values: Iterable[float]) -> str:
    return f"static const double {name}[] = {{{', '.join(map(repr, values)) or '0'}}};"
