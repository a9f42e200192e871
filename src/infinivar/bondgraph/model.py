"""Computable model of a graph: names, and generated code for dynamics and outputs, cached between runs."""

from __future__ import annotations

import functools
import hashlib
import inspect
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, is_dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from infinivar._core import kept
from infinivar.bondgraph.code import compiled
from infinivar.bondgraph.graph import BondGraph
from infinivar.bondgraph.namespaces import FloatNamespace


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """The parts of a graph's equations that a computation needs, as plain text that can be cached in a file.

    Attributes
    ----------
    states, state_kinds   Names of elements (inertias, compliances) and integral signals, and their kinds.
    inputs, rates         Names of inputs, and of the inputs whose time derivative is needed.
    losses                Element and name of every loss.
    sources               Names of the sources.
    bonds                 Tail and head of every bond.
    signals, storages     Their names.
    measured              Code: signals.
    motion                Code: time derivatives of the states.
    dynamics              Code: time derivatives of the states, power of every source, power of every loss.
    outputs               Code: efforts and flows of the bonds, signals, stored energies, power of every source, of every loss.
    """

    states: tuple[str, ...]
    state_kinds: tuple[str, ...]
    inputs: tuple[str, ...]
    rates: tuple[str, ...]
    losses: tuple[tuple[str, str], ...]
    sources: tuple[str, ...]
    bonds: tuple[tuple[str, str], ...]
    signals: tuple[str, ...]
    storages: tuple[str, ...]
    measured: str
    motion: str
    dynamics: str
    outputs: str

    def function(self, which: str, xp: Any, parameters: Mapping[str, float]) -> Callable[..., tuple[Any, ...]]:
        """The function "measured", "motion", "dynamics" or "outputs" of (states, inputs, rates), over an array namespace."""
        return compiled(getattr(self, which), floats=xp is FloatNamespace)(xp, parameters)


def model(graph: BondGraph) -> Model:
    """Model of a complete graph, from the cache if its equations were derived before.

    Parameters
    ----------
    graph : BondGraph

    Returns
    -------
    Model   The same for all values of the parameters.

    Raises
    ------
    BondGraphError
        As `infinivar.bondgraph.equations.derive`, and if a law uses a function that the array namespace lacks.
    """
    key = _fingerprint(graph)
    if key is None:
        return _derived(graph)
    if key not in _MODELS:
        _MODELS[key] = _kept(key) or _keep(key, _derived(graph))
    return _MODELS[key]


_MODELS: dict[str, Model] = {}
"""Models of this process, by their fingerprint."""


def _kept(key: str) -> Model | None:
    path = kept.find(key, ".json")
    if path is None:
        return None
    try:
        return Model(**{name: _tuples(value) for name, value in json.loads(path.read_text("utf-8")).items()})
    except (OSError, ValueError, TypeError):
        return None  # gone since, or of an older program: derive it again


def _keep(key: str, made: Model) -> Model:
    kept.keep(key, ".json", json.dumps(asdict(made)).encode())
    return made


def _derived(graph: BondGraph) -> Model:
    from infinivar.bondgraph.code import source
    from infinivar.bondgraph.equations import derive
    from infinivar.bondgraph.graph import SOURCES

    equations = derive(graph)
    sources = [element.name for element in graph.elements if element.kind in SOURCES]
    losses = {(element, name): loss for element, shares in equations.losses.items() for name, loss in shares.items()}
    derivatives = {
        f"d {state.name}": value for state, value in zip(equations.states, equations.derivatives, strict=True)
    }
    powers = {
        **{f"P {name}": equations.power[name] for name in sources},
        **{f"loss {element} {name}": value for (element, name), value in losses.items()},
    }
    outputs = {
        **{f"e {bond}": value for bond, value in equations.efforts.items()},
        **{f"f {bond}": value for bond, value in equations.flows.items()},
        **{f"s {name}": value for name, value in equations.signals.items()},
        **{f"E {name}": value for name, value in equations.stored.items()},
        **powers,
    }
    return Model(
        states=tuple(state.name for state in equations.states),
        state_kinds=tuple(state.kind for state in equations.states),
        inputs=tuple(equations.inputs),
        rates=tuple(equations.rates),
        losses=tuple(losses),
        sources=tuple(sources),
        bonds=tuple((bond.tail, bond.head) for bond in equations.efforts),
        signals=tuple(equations.signals),
        storages=tuple(equations.stored),
        measured=source(equations, dict(equations.signals)),
        motion=source(equations, derivatives),
        dynamics=source(equations, {**derivatives, **powers}),
        outputs=source(equations, outputs),
    )


def _tuples(value: Any) -> Any:
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value


def _fingerprint(graph: BondGraph) -> str | None:
    """Key that two graphs share only if they have the same model; None if a law is not part of the package.

    The name and closure identify a law of the package; the digest of the package's source covers its content.
    """
    try:
        described = [_described(element) for element in graph.elements]
    except _OutsideLawError:
        return None
    signals = [(signal.name, signal.symbol, signal.of, signal.integral) for signal in graph.signals]
    bonds = [(bond.tail, bond.head) for bond in graph.bonds]
    text = repr((_sources(), described, bonds, signals))
    return hashlib.sha256(text.encode()).hexdigest()[:32]


class _OutsideLawError(Exception):
    pass


def _described(value: Any) -> Any:
    from infinivar.bondgraph.graph import Parameter

    if isinstance(value, Parameter):
        return value.symbol  # values are not part of a model
    if is_dataclass(value) and not isinstance(value, type):
        return type(value).__name__, *(_described(getattr(value, field.name)) for field in fields(value))
    if isinstance(value, Mapping):
        return tuple((key, _described(item)) for key, item in value.items())
    if isinstance(value, tuple):
        return tuple(map(_described, value))
    if isinstance(value, functools.partial):
        return tuple(map(_described, (value.func, value.args, value.keywords)))
    if inspect.isfunction(value):
        if not value.__module__.startswith("infinivar."):
            raise _OutsideLawError
        held = inspect.getclosurevars(value).nonlocals
        return (
            value.__module__,
            value.__qualname__,
            value.__code__.co_firstlineno,
            tuple(map(_described, held.values())),
        )
    if callable(value):
        raise _OutsideLawError
    return repr(value)


@functools.cache
def _sources() -> str:
    """Digest of the package's source and of SymPy's version: a changed formula invalidates every cached model."""
    digest = hashlib.sha256(metadata.version("sympy").encode())
    root = Path(__file__).parents[1]
    for folder in ("_core", "contact", "parts", "transmission", "motion", "bondgraph", "drivetrain"):
        for file in sorted(root.joinpath(folder).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()
