"""The plant of a drive, or its closed loop, as other programs see it: variables with units and sources, and C."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from annotated_types import Ge, Gt

from infinivar._core.bounds import FINITE, Bound, ends, fits
from infinivar._core.fields import quantities_of, value_at, with_values
from infinivar.analysis.cycles.performance import motors_of
from infinivar.analysis.simulate import demands_at
from infinivar.bondgraph.c_code import Added, Code, array_of, c_code
from infinivar.bondgraph.compiled_step import NO_CONTROLLER, Recorded, data, recorded
from infinivar.bondgraph.graph import SOURCES, Bond, BondGraph, Parameter
from infinivar.bondgraph.inputs import Input
from infinivar.bondgraph.march import Instants
from infinivar.bondgraph.model import Model, model
from infinivar.bondgraph.recorded import Recorded as RecordedArray
from infinivar.bondgraph.tape import Number, Value
from infinivar.drivetrain.graphs.closed_loop import ClosedLoop, closed_loop, scenario_graph
from infinivar.errors import InputError, printable
from infinivar.exports import temperatures
from infinivar.exports.domains import Domain, domains, unit_of_input, unit_of_signal, unit_of_state
from infinivar.exports.variables import MOST_LETTERS, Role, Variable, demand_of, distinct, letters, rate_of
from infinivar.limits import Limit
from infinivar.motion.scenario import Scenario
from infinivar.study.provenance import Provenance

_CHANGE = 1e-6
"""Relative change of a field by which the parameters that it decides are found."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plant:
    """Variables in the order of their value references, and C.

    Attributes
    ----------
    name, title     Identifier of at most 64 letters, and headline.
    variables       Time, states, their derivatives, inputs, rates of inputs, outputs, parameters, goal of the controller. Of
        the inputs those that the controller commands have a role of their own.
    text            C of the equations, and of what a run needs.
    behind          Places of the variables behind each derivative and output, by its place.
    """

    name: str
    title: str
    variables: tuple[Variable, ...]
    text: str
    behind: Mapping[int, tuple[int, ...]]
    control: str
    """C of the controller, or of none."""
    signals: tuple[str, ...] = ()
    """What the controller reads after its goal; empty without one."""

    def places(self, *roles: Role) -> list[int]:
        """Places of the variables of these roles."""
        return [place for place, one in enumerate(self.variables) if one.role in roles]


def plant(
    drive: Any, scenario: Scenario, name: str, title: str, sources: Iterable[Provenance], *, closed: bool = False
) -> Plant:
    """The plant of a drive in a scenario, without its controllers or with them.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive
    scenario : Scenario   States what the amplifier imposes, what the load is, and where the motion starts.
    name, title : str
    sources : iterable of Provenance   Of the drive's values.
    closed : bool         Whether the controllers are part of it, which follow a goal.

    Raises
    ------
    InputError
        If a value that motion requires is missing, or a law has no C.
    """
    loop = closed_loop(drive, scenario)
    graph = loop.graph
    with naming_laws():
        made = model(graph)
    symbols = _parameters(drive, graph)
    parameters = {symbol: parameter.value for symbol, parameter in symbols.items()}
    found = domains(graph, rotary=drive.axis.rotary)
    of = {one.name: one.of or one.name for one in graph.signals}

    def described(name: str, role: Role, unit: str, start: float | None = None) -> Variable:
        return Variable(name[: MOST_LETTERS - 8], role, unit, _said(graph, of.get(name, name), unit), start)

    states = [
        described(name, "state", unit_of_state(graph, name, kind, found), float(loop.initial.get(name, 0.0)))
        for name, kind in zip(made.states, made.state_kinds, strict=True)
    ]
    heated = temperatures.with_data(motors_of(drive))
    thermal = list(temperatures.states(heated))
    commanded = loop.controller.outputs if closed else ()
    inputs = [
        described(name, "command", unit_of_input(graph, name, found))
        if name in commanded
        else described(name, "input", unit_of_input(graph, name, found), _begun(loop.inputs.get(name, 0.0)))
        for name in made.inputs
    ]
    signals = [
        (made.signals.index(one.name), described(one.name, "output", unit_of_signal(graph, one, found)))
        for one in graph.signals
        if one.name not in {*made.states, *made.inputs}
    ]
    ports = list(_ports(graph, made, found))
    single = [2 * len(made.bonds) + place for place, _ in signals] + [place for place, _ in ports]
    limits: list[Variable] = []

    def read(
        values: Sequence[Number], given: Mapping[str, Number], added: Sequence[Number]
    ) -> tuple[list[Number], list[Number]]:
        judged = _judged(drive, graph, made, values)
        lost = dict(zip((name for _, name in made.losses), values[-len(made.losses) :], strict=True))
        motors = [_warmed(what, given, lost) for what in heated]
        if motors:
            judged += temperatures.demands(motors, added, given[temperatures.AMBIENT])
        limits.extend(variable for variable, _ in judged)
        written = [*_outputs(made, single, values), *(demand for _, demand in judged)]
        return written, [*temperatures.rates(motors, added, given[temperatures.AMBIENT])] if motors else []

    with naming_laws():
        code = c_code(made, parameters, Added([one.name for one in thermal], read))
        control = recorded(made, loop.controller, numbers_apart=False) if closed else NO_CONTROLLER
    tables = {symbol for _, held in code.tape.held for symbol in held}
    stated = _stated(drive, scenario, graph, sources)
    bounds = {symbol: ends(_bound(drive, graph, symbols[symbol], paths)) for symbol, (_, paths) in stated.items()}
    rows = [
        Variable("time", "time", "s", "time"),
        *states,
        *thermal,
        *(rate_of(one, f"der({one.name})", "derivative", None) for one in (*states, *thermal)),
        *inputs,
        *(rate_of(one, f"{one.name}_rate", "rate", 0.0) for one in inputs if one.name in made.rates),
        *(one for _, one in (*signals, *ports)),
        *_powers(graph, made),
        *limits,
        *(
            Variable(
                _plain(one),
                "parameter",
                symbols[one].unit or "1",
                stated[one][0],
                parameters[one],
                one in tables,
                *bounds[one],
            )
            for one in code.tape.parameters
        ),
        *(_goal(drive, loop) if closed else []),
    ]
    variables = tuple(distinct(rows))
    begun = Begun(loop.controller.start({}), loop.controller.sample_time) if closed else Begun()
    return Plant(
        name=name,
        title=printable(title),
        variables=variables,
        text=plant_text(code, code.given(parameters).tolist(), variables),
        control=control_text(control, variables, begun),
        behind=behind_of(code, variables),
        signals=made.signals if closed else (),
    )


@contextlib.contextmanager
def naming_laws(of: str = "drive") -> Iterator[None]:
    """Report a law that decides by values, or calls what no other program has, as an input error."""
    try:
        yield
    except (TypeError, AttributeError) as problem:
        raise InputError(
            f"a law of the {of} has no C, as it is not written over the array namespace alone: {problem}"
        ) from problem


def _goal(drive: Any, loop: ClosedLoop) -> list[Variable]:
    """What the controllers follow: the motion of the load, or of the drive's side of springs, linkage and elastic stage."""
    start = loop.controller.goal(*loop.controller.goals([0.0])[0].tolist())
    length = drive.output.linkage.rotary_drive if drive.output.linkage else drive.axis.rotary
    unit = "rad" if length else "m"
    of = "of the drive's side of its output" if getattr(loop.controller, "planned", None) else "of the load"
    rows = [
        Variable("goal.position", "goal", unit, f"position {of} to follow", start.position),
        Variable("goal.speed", "goal", f"{unit}/s", f"speed {of} to follow", start.speed),
        Variable("goal.acceleration", "goal", f"{unit}/s^2", f"acceleration {of} to follow", start.acceleration),
    ]
    if getattr(loop.controller, "planned", None):
        rows.append(Variable("goal.load", "goal", "A", "current for the planned force of the load", start.load))
    return rows


def _begun(given: float | Input) -> float:
    """Value of an input at the start."""
    return float(given) if isinstance(given, (int, float)) else given.value(0.0)


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


def _ports(graph: BondGraph, made: Model, found: Mapping[Bond, Domain]) -> Iterator[tuple[int, Variable]]:
    """Yield what the sources meet, with its place in the outputs of a model: the voltage of a current, the speed of a force."""
    for name in made.sources:
        element, place = graph[name], _bond_of(made, name)
        for kind, imposed, offset in (("effort", "Se", 0), ("flow", "Sf", len(made.bonds))):
            if name not in made.inputs or element.kind != imposed:
                unit = getattr(found[graph.bonds_of(name)[0]], kind)
                word = _WORDS.get(unit, kind)
                described = Variable(f"{letters(word)}.{name}", "output", unit, f"{word} at {element.title}")
                yield offset + place, described


def _bond_of(made: Model, name: str) -> int:
    """Place of the bond of a one-port."""
    return next(place for place, bond in enumerate(made.bonds) if name in bond)


def _outputs(made: Model, single: Sequence[int], values: Sequence[Any]) -> list[Any]:
    """What the export computes, from all outputs of a model: single ones, energies, what storages take up, the other powers."""
    bonds, given = len(made.bonds), list(values)
    begin = 2 * bonds + len(made.signals)
    end = begin + len(made.storages)
    taken = [given[place] * given[bonds + place] for place in (_bond_of(made, name) for name in made.storages)]
    return [*(given[place] for place in single), *given[begin:end], *taken, *given[end:]]


def _judged(drive: Any, graph: BondGraph, made: Model, values: Sequence[Number]) -> list[tuple[Variable, Number]]:
    """Demands on limits, as a simulation judges them, from all outputs of a model."""
    tape = next(one.tape for one in values if isinstance(one, Value))
    rows = [RecordedArray(tape, [one]) for one in values]
    count = len(made.bonds)
    at = Instants(
        graph=graph,
        time=np.zeros(1),
        states={name: RecordedArray(tape, [tape.input("states", place)]) for place, name in enumerate(made.states)},
        signals=dict(zip(made.signals, rows[2 * count :], strict=False)),
        efforts=dict(zip(made.bonds, rows, strict=False)),
        flows=dict(zip(made.bonds, rows[count:], strict=False)),
    )
    return [
        (demand_of(limit, part), demand)
        for (limit, part), row in demands_at(drive, at).items()
        for demand in np.ravel(row).tolist()[:1]
        if isinstance(demand, Value) and limit != Limit.LIFE
    ]


def _warmed(what: str, given: Mapping[str, Number], lost: Mapping[str, Number]) -> temperatures.Warmed:
    """What warms a motor, from the losses of its drive."""
    friction = lost[f"{what} friction"] + lost.get(f"{what} iron", 0.0)
    winding = lost[what.replace("motor", "winding")]
    return temperatures.warmed(what, lambda name: given[f"{name} {what}"], winding, friction)


def _powers(graph: BondGraph, made: Model) -> Iterator[Variable]:
    """Yield energies and powers, in the order of `_outputs`."""
    for kind, unit, words, names in (
        ("energy", "J", "energy stored in", made.storages),
        ("power", "W", "power taken up by", made.storages),
        ("power", "W", "power supplied to the plant by", made.sources),
    ):
        yield from (Variable(f"{kind}.{name}", "output", unit, f"{words} {graph[name].title}") for name in names)
    several = [element for element, _ in made.losses]
    for element, loss in made.losses:
        where = f".{letters(loss)}" if several.count(element) > 1 else ""
        before = " before the plant, which the supply adds" if graph[element].kind in SOURCES else ""
        yield Variable(f"loss.{element}{where}", "output", "W", f"power lost: {loss}{before}")


def _stated(
    drive: Any, scenario: Scenario, graph: BondGraph, sources: Iterable[Provenance]
) -> dict[str, tuple[str, Sequence[str]]]:
    """What each parameter belongs to, in words with kind and source, and the fields of the drive that decide it.

    A field decides the parameters that change with it.
    """
    known = {row.field: row for row in sources}
    usual = _parameters(drive, graph)
    fields: dict[str, list[str]] = {symbol: [] for symbol in usual}
    for path in quantities_of(drive):
        value = value_at(drive, path)
        if not isinstance(value, float):
            continue
        with contextlib.suppress(InputError):  # values that no drive has
            changed = with_values(drive, {path: value * (1.0 + _CHANGE) or _CHANGE})
            for symbol, parameter in _parameters(changed, scenario_graph(changed, scenario)).items():
                if symbol in usual and parameter.value != usual[symbol].value:
                    fields[symbol].append(path)
    owners: dict[str, dict[str, None]] = {symbol: {} for symbol in usual}
    for one in graph.elements:
        for parameter in (*([one.parameter] if one.parameter else []), *one.parameters.values()):
            owners[parameter.symbol][one.title] = None
    sourced = {
        symbol: "; ".join(_source(path, known.get(path)) for path in paths) or "program or scenario"
        for symbol, paths in fields.items()
    }
    said = {
        symbol: f"{symbol} of {', '.join(titles)}" if titles else symbol.replace(" ", " of the ", 1)
        for symbol, titles in owners.items()
    }
    return {symbol: (f"{words}; from {sourced[symbol]}", fields[symbol]) for symbol, words in said.items()}


def _parameters(drive: Any, graph: BondGraph) -> dict[str, Parameter]:
    """Parameters of a drive's graph and of the temperatures of its motors, by symbol."""
    return {**graph.parameters, **temperatures.parameters(motors_of(drive))}


def _bound(drive: Any, graph: BondGraph, parameter: Parameter, paths: Sequence[str]) -> Bound:
    """What a parameter may be: that of the field that it is, that of a linear element, or the sign that its fields have.

    A ratio of several fields may have either sign.
    """
    fields = quantities_of(drive)
    bounds = [fields[path].metadata["bound"] for path in paths]
    if len(paths) == 1 and value_at(drive, paths[0]) == parameter.value:
        return bounds[0]
    if any(one.kind in ("I", "C", "R") and one.parameter == parameter for one in graph.elements):
        return Gt(0)
    if parameter.unit in ("", "1") or parameter.value < 0.0 or any(fits(one, -1.0) for one in bounds):
        return FINITE
    return Ge(0) if parameter.value == 0.0 or any(fits(one, 0.0) for one in bounds) else Gt(0)


def _source(path: str, row: Provenance | None) -> str:
    if row is None:
        return path
    return printable(f"{path} = {row.written} ({', '.join(filter(None, (row.kind, row.where)))})")


def _plain(symbol: str) -> str:
    """Name of a parameter, from its symbol."""
    return f"parameter.{letters(symbol.replace(chr(39), '_back').replace('/', '_over_'))}"


def behind_of(code: Code, variables: Sequence[Variable]) -> dict[int, tuple[int, ...]]:
    """Places of the variables behind each derivative and output, by its place."""
    begins: dict[str, int] = {}
    groups = {"state": "states", "input": "inputs", "command": "inputs", "rate": "rates", "parameter": "parameters"}
    for place, one in enumerate(variables):
        if one.role in groups:
            begins.setdefault(groups[one.role], place)
    computed = [place for place, one in enumerate(variables) if one.role in ("derivative", "output")]
    return {
        place: tuple(sorted(begins[group] + number for group, number in known if group in begins))
        for place, known in zip(computed, code.behind, strict=True)
    }


def plant_text(code: Code, given: Sequence[float], variables: Sequence[Variable]) -> str:
    """C of the equations and of a run, with the numbers that the plant starts from, `given` among them."""
    outputs, settable = (len(_starts(variables, role)) for role in ("output", "parameter"))
    return "\n".join(
        [
            code.text,
            data("collocation.c"),
            f"enum {{ OUTPUTS = {outputs}, PARAMETERS = {settable}, GIVEN = {len(given)}, CONSTANTS = {code.constants} }};",
            _array("start_given", given),
            _array("start_states", _starts(variables, "state")),
            _array("start_inputs", [*_starts(variables, "input", "command"), *_starts(variables, "rate")]),
            "",
        ]
    )


class Begun(NamedTuple):
    """What a controller starts from."""

    memory: Sequence[float] = ()
    period: float = 1.0
    """Time between samples. [s]"""
    samples: int = 0
    """How many have been taken."""


def control_text(control: Recorded, variables: Sequence[Variable], begun: Begun) -> str:
    """C of the controller, with the numbers that it starts from."""
    goal = _starts(variables, "goal")
    return "\n".join(
        [
            control.text,
            "",
            f"enum {{ SHOWN = {len(goal)}, BEGUN = {begun.samples} }};",
            _array("start_goal", goal),
            _array("start_memory", begun.memory),
            *array_of(control.data.tolist(), "control_data")[:-1],
            f"static const double period = {begun.period!r};",
            "",
        ]
    )


def _starts(variables: Sequence[Variable], *roles: Role) -> list[float]:
    return [one.start or 0.0 for one in variables if one.role in roles]


def _array(name: str, values: Iterable[float]) -> str:
    return f"static const double {name}[] = {{{', '.join(map(repr, values)) or '0'}}};"
