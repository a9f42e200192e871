"""Bond graphs of machines, pinned: every element with its parameters and a value of its law, every bond and every signal.

``python tests/golden/test_machine_graphs.py`` writes the file anew.
"""

import sys
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import infinivar as iv
from infinivar.parts import CylinderBearings
from machines import LEG, MACHINES

PINNED = Path(__file__).with_name("machine_graphs.txt")
BEARINGS = CylinderBearings(
    bearing=LEG.steering.bell_bearing, span=0.14, pull=80.0, pull_position=-0.02, backing_rollers=1
)
SUPPORTED = {"leg": replace(LEG, cylinder_bearings=BEARINGS, guideway=iv.parts.Guideway(friction=1.0))}


def graphs():
    """Title and graph of each machine."""
    for name, (machine, _) in MACHINES.items():
        steered = getattr(machine, "steering", LEG.steering) is not None
        yield name, iv.machine_graph(machine, servos=steered, source=steered)
    for name in ("platform", "arm"):
        machine = replace(MACHINES[name][0], **SUPPORTED)
        yield f"{name} on bearings", iv.machine_graph(machine, stick_speed=1e-3, servos=False, source=False)


def lines():
    for title, graph in graphs():
        yield f"# {title}: {graph.name}"
        for element in graph.elements:
            yield " ; ".join(
                [f"{element.kind} {element.name}", element.symbol, element.title, *_values(graph, element)]
            )
        yield from sorted(f"{bond.tail} > {bond.head}" for bond in graph.bonds)
        for signal in graph.signals:
            yield f"signal {signal.name} ; {signal.symbol} ; {signal.of} ; {signal.integral}"


def _values(graph, element):
    for one in ([element.parameter] if element.parameter else []) + [*element.parameters.values()]:
        yield f"{one.symbol} = {one.value:.12g} {one.unit}"
    if element.law is not None:
        ports = len(graph.bonds_of(element.name)) if element.kind == "R" else 0
        given = [0.3 / (place + 1) for place in range(ports + len(element.signals))]
        named = {name: one.value for name, one in element.parameters.items()}
        found = element.law(*given, **named)
        every = found if isinstance(found, tuple) else (found,)
        yield f"{', '.join(element.signals)}: " + ", ".join(f"{float(one):.9g}" for one in every)
        if element.losses is not None:
            lost = element.losses(*given, effort=found, **named)
            yield ", ".join(f"{name} {float(one):.9g}" for name, one in lost.items())


def test_graphs_are_those_pinned():
    expected, found = PINNED.read_text("utf-8").splitlines(), list(lines())
    assert found == expected


if __name__ == "__main__":
    PINNED.write_text("\n".join(lines()) + "\n", "utf-8")
