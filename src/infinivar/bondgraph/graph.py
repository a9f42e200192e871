"""Bond graphs as frozen values: elements, bonds with a power direction, signals, and graphs joined from sub-graphs.

Each bond carries an effort and a flow; their product is a power, positive along the half arrow. Elements and their
constitutive equations:

- effort and flow source (Se, Sf): an input, or a law of signals (MSe, MSf);
- inertia (I) ``p = I f``, compliance (C) ``e = q/C`` or a law of the displacement q, resistance (R) ``e = R f`` or a law of
  flows and signals (or of efforts and signals: a conductance), with one port or several (a field);
- transformer (TF) ``f2 = m f1, e1 = m e2`` and gyrator (GY) ``e2 = r f1, e1 = r f2``; m and r may be laws of signals
  (MTF, MGY). The incoming bond is port 1, the outgoing bond port 2;
- 1-junction: common flow, efforts sum to zero; 0-junction: common effort, flows sum to zero.

Source: karnopp2012, chapters 2-4.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from infinivar._core.frozen import FrozenDict
from infinivar.errors import InputError, nearest

Kind = Literal["Se", "Sf", "I", "C", "R", "TF", "GY", "0", "1"]
Law = Callable[..., Any]

SOURCES, STORAGES, TWO_PORTS, JUNCTIONS = ("Se", "Sf"), ("I", "C"), ("TF", "GY"), ("0", "1")


class BondGraphError(InputError):
    """A graph that is invalid, or has no equations or solution; the message names the element at fault."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a graph: symbol (LaTeX, without dollar signs), value in SI, and unit for listings."""

    symbol: str
    value: float
    unit: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Element:
    """One element of a graph, created by the functions of this module.

    Attributes
    ----------
    name             Unique in its graph. In a joined graph it is prefixed with the names of the sub-graphs: "cylinder.J_c".
    kind             Se, Sf, I, C, R, TF, GY, 0 or 1.
    symbol           LaTeX of its parameter, input or junction variable; "" for none.
    parameter        Parameter of a linear element.
    law              Law of any other element: maps flows (R), displacement (C) and signals, by position, and `parameters`, by
                     name, to efforts (a tuple for a field), modulus or input. Written over an array namespace, so that it
                     can be traced.
    signals          Names of the law's signals.
    parameters       Parameters of the law.
    energy           For a C with a law: maps displacement and `parameters` to the stored energy, the integral of the law.
    of_effort        For an R with a law: whether it maps efforts to flows instead (a conductance).
    losses           For an R with a law: maps flows, signals and parameters as in `law`, and ``effort``, to the losses by
                     name. None: one loss under the element's title. For a source: maps its power and ``parameters`` to
                     losses upstream of it, which it must supply as well.
    title            Name in reports, and key of its loss in results. Default: `name`.
    solved           For an R whose law has one signal: the law where that signal depends on the law's own value, in an algebraic
                     loop. Maps flows, the signal without the law's effect, `parameters` and ``gain``, the change of the signal
                     per effort, to the effort. Not needed for laws that are proportional to their signal on each side of zero.
    """

    name: str
    kind: Kind
    symbol: str = ""
    parameter: Parameter | None = None
    law: Law | None = None
    signals: tuple[str, ...] = ()
    parameters: Mapping[str, Parameter] = field(default_factory=FrozenDict)
    losses: Law | None = None
    energy: Law | None = None
    of_effort: bool = False
    title: str = ""
    solved: Law | None = None

    @property
    def modulated(self) -> bool:
        """Whether a signal modulates the element."""
        return bool(self.signals)

    @property
    def group(self) -> tuple[str, ...]:
        """Names of the sub-graphs that contain the element, outermost first."""
        return tuple(self.name.split(".")[:-1])

    @property
    def label(self) -> str:
        """Kind as drawn, with the prefix M if a signal modulates it."""
        return f"M{self.kind}" if self.modulated else self.kind


def _made(kind: Kind, name: str, symbol: str, value: float | Law | None, unit: str, title: str, **law: Any) -> Element:
    parameter = None if callable(value) or value is None else Parameter(symbol, float(value), unit)
    law = {key: FrozenDict(held) if isinstance(held, dict) else held for key, held in law.items()}
    return Element(
        name=name,
        kind=kind,
        symbol=symbol,
        parameter=parameter,
        law=value if callable(value) else None,
        title=title or name,
        **law,
    )


def effort_source(name: str, symbol: str, law: Law | None = None, *, title: str = "", **modulation: Any) -> Element:
    """Se: imposes an effort: the input `name`, or a law of signals."""
    return _made("Se", name, symbol, law, "", title, **modulation)


def flow_source(name: str, symbol: str, law: Law | None = None, *, title: str = "", **modulation: Any) -> Element:
    """Sf: imposes a flow: the input `name`, or a law of signals."""
    return _made("Sf", name, symbol, law, "", title, **modulation)


def inertia(name: str, symbol: str, value: float, unit: str = "", *, title: str = "") -> Element:
    """I: stores ``I f^2/2``. Mass, moment of inertia, inductance."""
    return _made("I", name, symbol, value, unit, title)


def compliance(
    name: str,
    symbol: str,
    value: float | Law,
    unit: str = "",
    *,
    energy: Law | None = None,
    title: str = "",
    parameters: Mapping[str, Parameter] | None = None,
) -> Element:
    """C: stores ``q^2/(2 C)``. The inverse of a stiffness, or a capacitance.

    `value` is the compliance, or a law that maps the displacement q and `parameters` to the effort; `energy` then maps the
    same to the stored energy, whose derivative by q must be the effort. The audit checks that it is.
    """
    return _made("C", name, symbol, value, unit, title, energy=energy, parameters=dict(parameters or {}))


def resistance(
    name: str, symbol: str, value: float | Law, unit: str = "", *, title: str = "", **modulation: Any
) -> Element:
    """R: dissipates ``R f^2``, or the power given by a law of its flows; other arguments as in `Element`."""
    return _made("R", name, symbol, value, unit, title, **modulation)


def conductance(name: str, symbol: str, law: Law, *, title: str = "", **modulation: Any) -> Element:
    """R whose law maps efforts and signals to flows, `symbol`; such a resistance may have an infinite value."""
    return _made("R", name, symbol, law, "", title, of_effort=True, **modulation)


def transformer(
    name: str, symbol: str, modulus: float | Law, unit: str = "", *, title: str = "", **modulation: Any
) -> Element:
    """TF: ``f2 = m f1`` and ``e1 = m e2``; m is a number or a law of signals."""
    return _made("TF", name, symbol, modulus, unit, title, **modulation)


def gyrator(
    name: str, symbol: str, modulus: float | Law, unit: str = "", *, title: str = "", **modulation: Any
) -> Element:
    """GY: ``e2 = r f1`` and ``e1 = r f2``; r is a number or a law of signals."""
    return _made("GY", name, symbol, modulus, unit, title, **modulation)


def one(name: str, symbol: str = "", *, title: str = "") -> Element:
    """1-junction: its bonds share the flow `symbol`, efforts balance."""
    return _made("1", name, symbol, None, "", title)


def zero(name: str, symbol: str = "", *, title: str = "") -> Element:
    """0-junction: its bonds share the effort `symbol`, flows balance."""
    return _made("0", name, symbol, None, "", title)


@dataclass(frozen=True, slots=True)
class Bond:
    """Half arrow from `tail` to `head`: power is positive in that direction."""

    tail: str
    head: str

    def other(self, name: str) -> str:
        """The element at the other end."""
        return self.head if name == self.tail else self.tail


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """A measured quantity that modulates elements or is an output; it carries no power.

    Attributes
    ----------
    name, symbol     Name in laws and results; LaTeX.
    of               Measured element: flow of a one-port or 1-junction, effort of a 0-junction or two-port (port 1).
                     "" for a signal from outside the graph.
    integral         Whether the signal is the time integral of that quantity, and therefore a state.
    """

    name: str
    symbol: str
    of: str = ""
    integral: bool = False


@dataclass(frozen=True, slots=True, init=False)
class BondGraph:
    """A graph, complete except for junctions open to other graphs.

    Parameters
    ----------
    name       Name of the graph in drawings and messages.
    elements   Names consist of ``[A-Za-z0-9_]``.
    bonds      Chains of names such as ``"source > current > motor"``; half arrows point to the right.
    signals    Measured quantities, and signals from outside.

    Raises
    ------
    BondGraphError
        If names repeat or are unknown, a one-port does not have exactly one bond, a two-port does not have one incoming and
        one outgoing bond, a bond points away from a passive element, or a law uses an undeclared signal.
    """

    name: str
    elements: tuple[Element, ...]
    bonds: tuple[Bond, ...]
    signals: tuple[Signal, ...] = ()
    titles: Mapping[str, str] = field(default_factory=FrozenDict)
    """Names of sub-graphs, by the prefix of their elements; for drawings."""

    def __init__(
        self,
        name: str,
        elements: Iterable[Element],
        bonds: Iterable[str | Bond],
        signals: Iterable[Signal] = (),
        titles: Mapping[str, str] | None = None,
    ) -> None:
        """Freeze the sequences, parse the chains of bonds and check the graph."""
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "elements", tuple(elements))
        object.__setattr__(self, "bonds", tuple(bond for chain in bonds for bond in _bonds(chain)))
        object.__setattr__(self, "signals", tuple(signals))
        object.__setattr__(self, "titles", FrozenDict(titles or {}))
        _check(self)

    def __getitem__(self, name: str) -> Element:
        """The element of that name.

        Raises
        ------
        BondGraphError
            If the graph has no such element.
        """
        for element in self.elements:
            if element.name == name:
                return element
        names = [element.name for element in self.elements]
        raise BondGraphError(f"{self.name} has no element {name!r}{nearest(name, names)}")

    def bonds_of(self, name: str) -> tuple[Bond, ...]:
        """Bonds at an element, in the order of definition."""
        return tuple(bond for bond in self.bonds if name in (bond.tail, bond.head))

    @property
    def parameters(self) -> dict[str, Parameter]:
        """All parameters by symbol.

        Raises
        ------
        BondGraphError
            If one symbol has two values.
        """
        found: dict[str, Parameter] = {}
        for element in self.elements:
            for parameter in (*([element.parameter] if element.parameter else []), *element.parameters.values()):
                known = found.setdefault(parameter.symbol, parameter)
                if known.value != parameter.value:
                    values = f"{known.value:g} and {parameter.value:g}"
                    raise BondGraphError(f"{self.name}: the symbol {parameter.symbol} has two values, {values}")
        return found


def join(
    name: str,
    parts: Mapping[str, BondGraph],
    bonds: Iterable[str | Bond],
    *,
    elements: Iterable[Element] = (),
    signals: Iterable[Signal] = (),
) -> BondGraph:
    """Join several graphs; element names are prefixed with the name of their part and a dot.

    Parameters
    ----------
    name : str                            Name of the joined graph.
    parts : mapping of name to BondGraph  Sub-graphs.
    bonds : iterable of str               Chains between junctions of the parts, such as ``"cylinder.shaft > wheel.in"``.
    elements, signals                     Additional ones. One part may measure a signal that another one needs.

    Returns
    -------
    BondGraph

    Raises
    ------
    BondGraphError
        As `BondGraph`, and if two parts measure signals of the same name.
    """
    every = [*elements]
    chains: list[str | Bond] = []
    known: dict[str, Signal] = {}
    titles: dict[str, str] = {}
    for prefix, part in parts.items():
        every += [replace(element, name=f"{prefix}.{element.name}") for element in part.elements]
        chains += [Bond(f"{prefix}.{bond.tail}", f"{prefix}.{bond.head}") for bond in part.bonds]
        titles |= {prefix: part.name, **{f"{prefix}.{inner}": title for inner, title in part.titles.items()}}
        for signal in part.signals:
            _declare(known, replace(signal, of=f"{prefix}.{signal.of}") if signal.of else signal, name)
    for signal in signals:
        _declare(known, signal, name)
    return BondGraph(name, every, [*chains, *bonds], known.values(), titles)


def _declare(known: dict[str, Signal], signal: Signal, graph: str) -> None:
    before = known.get(signal.name)
    if before is not None and before.of and signal.of:
        raise BondGraphError(f"{graph}: the signal {signal.name!r} is measured at {before.of} and at {signal.of}")
    if before is None or signal.of:
        known[signal.name] = signal


def _bonds(chain: str | Bond) -> list[Bond]:
    if isinstance(chain, Bond):
        return [chain]
    names = [name.strip() for name in chain.split(">")]
    if len(names) < 2 or not all(names):
        raise BondGraphError(f"{chain!r} must be a chain of bonds such as 'source > junction > element'")
    return [Bond(tail, head) for tail, head in itertools.pairwise(names)]


def _check(graph: BondGraph) -> None:
    fault = next(_faults(graph), None)
    if fault is not None:
        raise BondGraphError(f"{graph.name}: {fault}")
    _ = graph.parameters


def _faults(graph: BondGraph) -> Iterator[str]:
    """Everything that keeps a graph from having a meaning; later checks rely on earlier ones finding nothing."""
    yield from _faults_of_names(graph)
    signals = {signal.name for signal in graph.signals}
    for element in graph.elements:
        yield from _faults_of_ports(element, graph.bonds_of(element.name))
        yield from _faults_of_values(element, signals)


def _faults_of_names(graph: BondGraph) -> Iterator[str]:
    """Names that repeat, and bonds and signals that name no element."""
    counts = Counter(element.name for element in graph.elements)
    for name, count in counts.items():
        if count > 1:
            yield f"{count} elements are called {name!r}"
    for bond in graph.bonds:
        for end in (bond.tail, bond.head):
            if end not in counts:
                yield f"the bond {bond.tail} > {bond.head} names {end!r}, which is no element{nearest(end, counts)}"
        if bond.tail == bond.head:
            yield f"a bond leads from {bond.tail} to itself"
    for signal in graph.signals:
        if signal.of and signal.of not in counts:
            yield f"the signal {signal.name!r} measures {signal.of!r}, which is no element{nearest(signal.of, counts)}"


def _faults_of_ports(element: Element, bonds: Sequence[Bond]) -> Iterator[str]:
    """Bonds in the wrong number or direction."""
    kind, name = element.kind, element.name
    arriving = sum(bond.head == name for bond in bonds)
    if kind in TWO_PORTS:
        if (len(bonds), arriving) != (2, 1):
            yield f"{kind} {name!r} needs one bond that arrives and one that leaves"
    elif kind == "R":
        if not bonds:
            yield f"R {name!r} has no bond"
    elif kind not in JUNCTIONS and len(bonds) != 1:
        yield f"{kind} {name!r} needs one bond, has {len(bonds)}"
    if kind in (*STORAGES, "R") and arriving != len(bonds):
        yield f"the bond of {kind} {name!r} must point towards it: it takes power"
    if kind == "R" and element.law is None and len(bonds) != 1:
        yield f"R {name!r} has {len(bonds)} bonds and no law that relates them"


def _faults_of_values(element: Element, signals: Collection[str]) -> Iterator[str]:
    """Signals that nobody declares, and a parameter out of range."""
    kind, name, parameter = element.kind, element.name, element.parameter
    for signal in element.signals:
        if signal not in signals:
            yield f"{kind} {name!r} needs the signal {signal!r}{nearest(signal, signals)}"
    if kind == "C" and element.law is not None and element.energy is None:
        yield f"C {name!r} has a law and needs its energy as well: the integral of the law over the displacement"
    if kind in STORAGES and element.signals:
        yield f"{kind} {name!r} must not be modulated: a signal would change its energy without exchanging power"
    if parameter is None:
        return
    if kind in TWO_PORTS:
        if not abs(parameter.value) > 0:
            yield f"the modulus of {kind} {name!r} must not be 0"
    elif not parameter.value > 0:
        yield f"{kind} {name!r} must be > 0, got {parameter.value}"
