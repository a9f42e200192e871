"""Where the elements of a bond graph are drawn.

Junctions, two-ports and the sources at their ends run from left to right in the direction of power, laid out by igraph.
Branches that end there are drawn above or below. Sub-graphs are placed side by side in the order of the bonds that join
them; a sub-graph joined by signals only is placed above the one it modulates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from infinivar._core import extras
from infinivar.bondgraph.graph import JUNCTIONS, SOURCES, TWO_PORTS, BondGraph, Element

COLUMN, ROW, SPREAD = 1.0, 0.85, 0.95
"""Distance between columns, between rows, and between branches side by side. [inch]"""

_PADDING, _GAP = 0.5, 0.35

Point = tuple[float, float]
Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Layout:
    """Positions of elements by name, and frames (left, bottom, right, top) of sub-graphs by prefix. [inch]"""

    positions: Mapping[str, Point]
    frames: Mapping[str, Box]


def layout(graph: BondGraph) -> Layout:
    """Layout of a graph: elements do not coincide, and frames of sub-graphs do not overlap.

    Parameters
    ----------
    graph : BondGraph

    Returns
    -------
    Layout
    """
    groups: dict[str, list[str]] = {}
    for element in graph.elements:
        groups.setdefault(_group_of(graph, element), []).append(element.name)
    placed = {group: _place_group(graph, names) for group, names in groups.items()}
    offsets = _offsets(graph, placed)
    positions = {
        name: (x + offsets[group][0], y + offsets[group][1])
        for group, places in placed.items()
        for name, (x, y) in places.items()
    }
    frames = {group: _box([positions[name] for name in names]) for group, names in groups.items() if group}
    return Layout(positions, frames)


def _group_of(graph: BondGraph, element: Element) -> str:
    """The sub-graph in which an element is drawn: a resistance or storage of none belongs where it is attached."""
    group, bonds = element.group, graph.bonds_of(element.name)
    if not group and len(bonds) == 1 and element.kind not in (*JUNCTIONS, *TWO_PORTS, *SOURCES):
        group = graph[bonds[0].other(element.name)].group
    return group[0] if group else ""


def _box(points: Sequence[Point]) -> Box:
    across, up = [x for x, _ in points], [y for _, y in points]
    return min(across) - _PADDING, min(up) - _PADDING, max(across) + _PADDING, max(up) + _PADDING + 0.1


def _place_group(graph: BondGraph, names: list[str]) -> dict[str, Point]:
    """Positions of the elements of one sub-graph around its main row at y = 0."""
    inside = set(names)
    neighbours = {
        name: [bond.other(name) for bond in graph.bonds_of(name) if bond.other(name) in inside] for name in names
    }
    ports = {name for name in names if len(neighbours[name]) < len(graph.bonds_of(name))}
    core = _core(graph, names, neighbours, ports)
    columns = _columns(graph, core, neighbours, ports)
    rows = _rows(core, columns, neighbours)
    children = {name: [other for other in neighbours[name] if other not in core] for name in core}
    hanging = {name: _split(children[name], rows[name]) for name in core}
    x = _spaced(columns, {name: max(len(up), len(down), 1) for name, (up, down) in hanging.items()})
    places = {name: (x[columns[name]], ROW * rows[name]) for name in core}
    for name in core:
        for side, group in zip((1, -1), hanging[name], strict=True):
            _hang(places, neighbours, name, group, side)
    return places


def _core(graph: BondGraph, names: list[str], neighbours: Mapping[str, list[str]], ports: set[str]) -> list[str]:
    """Elements on the power path: all except dead-end branches."""
    kinds = {name: graph[name].kind for name in names}
    sources = [name for name in names if kinds[name] in SOURCES and _ends_a_chain(graph, name, kinds, neighbours)]
    kept = {name for name in names if kinds[name] in (*JUNCTIONS, *TWO_PORTS)} | set(sources)
    inner = ports | set(sources)
    while True:
        blind = {name for name in kept - inner if _ends_blindly(name, kept, kinds, neighbours)}
        # What is left of a chain without ports keeps its last junction.
        if not blind or len(blind) == len(kept):
            return [name for name in names if name in kept]
        kept -= blind


def _ends_blindly(name: str, kept: set[str], kinds: Mapping[str, str], neighbours: Mapping[str, list[str]]) -> bool:
    """Whether a branch ends here: of what is kept, one junction alone holds it."""
    onward = [other for other in neighbours[name] if other in kept]
    return len(onward) == 1 and kinds[onward[0]] in JUNCTIONS and len(neighbours[name]) > 1


def _ends_a_chain(graph: BondGraph, name: str, kinds: Mapping[str, str], neighbours: Mapping[str, list[str]]) -> bool:
    """Whether a source is at an end of the path: it absorbs power, or it alone supplies its junction here."""
    (bond,) = graph.bonds_of(name)
    junction = bond.other(name)
    if kinds.get(junction, "") not in JUNCTIONS:
        return False
    if bond.head == name:
        return True
    givers = [b.tail for b in graph.bonds_of(junction) if b.head == junction]
    leads_on = any(b.tail == junction and b.head != name for b in graph.bonds_of(junction))
    return givers[0] == name and all(kinds.get(giver, "") in SOURCES for giver in givers) and leads_on


def _columns(graph: BondGraph, core: list[str], neighbours: Mapping[str, list[str]], ports: set[str]) -> dict[str, int]:
    """Column of each element: steps from where power enters."""
    columns = {_first(graph, core, neighbours, ports): 0}
    waiting = list(columns)
    while waiting:
        name = waiting.pop(0)
        for other in neighbours[name]:
            if other in core and other not in columns:
                columns[other] = columns[name] + 1
                waiting.append(other)
    for name in core:  # parts connected to the rest by signals only
        columns.setdefault(name, 0)
    return columns


def _first(graph: BondGraph, core: list[str], neighbours: Mapping[str, list[str]], ports: set[str]) -> str:
    """Where power enters: at a source, at a port that receives it from another sub-graph, or where nothing arrives."""
    givers = {name: {bond.tail for bond in graph.bonds_of(name) if bond.head == name} for name in core}
    begins = [name for name in core if givers[name].isdisjoint(core)]
    sources = [name for name in begins if graph[name].kind in SOURCES]
    entering = [name for name in core if name in ports and givers[name] - neighbours.keys()]
    return (sources or entering or begins or core)[0]


def _rows(core: list[str], columns: Mapping[str, int], neighbours: Mapping[str, list[str]]) -> dict[str, float]:
    """Rows around 0 in each column, with few crossings: igraph's layered layout decides the order."""
    igraph = extras.load("igraph", "graph", "drawing a bond graph")
    index = {name: number for number, name in enumerate(core)}
    edges = sorted(
        {(index[a], index[b]) for a in core for b in neighbours[a] if b in index and columns[b] == columns[a] + 1}
    )
    found = igraph.Graph(n=len(core), edges=edges, directed=True).layout_sugiyama(
        layers=[columns[name] for name in core], hgap=1, vgap=1
    )
    rows: dict[str, float] = {}
    for column in set(columns.values()):
        here = sorted((name for name in core if columns[name] == column), key=lambda name: found[index[name]][0])
        for place, name in enumerate(here):
            rows[name] = (len(here) - 1) / 2.0 - place
    # Two elements in a column leave the middle row free for the elements they enclose.
    return {name: 2.0 * row if abs(row) == 0.5 else row for name, row in rows.items()}


def _split(children: list[str], row: float) -> tuple[list[str], list[str]]:
    """Branches drawn above, and those drawn below."""
    if row > 0:
        return children, []
    if row < 0:
        return [], children
    return children[0::2], children[1::2]


def _spaced(columns: Mapping[str, int], widths: Mapping[str, int]) -> dict[int, float]:
    """Distance of each column from the first, with room for branches side by side."""
    room = {
        column: max(widths[name] for name in columns if columns[name] == column) for column in set(columns.values())
    }
    at, places = 0.0, {}
    for column in sorted(room):
        if column:
            at += max(COLUMN, SPREAD * 0.5 * (room[column] + room[column - 1]))
        places[column] = at
    return places


def _hang(
    places: dict[str, Point], neighbours: Mapping[str, list[str]], name: str, group: list[str], side: int
) -> None:
    x, y = places[name]
    for place, child in enumerate(group):
        places[child] = (x + SPREAD * (place - (len(group) - 1) / 2.0), y + side * ROW)
        _hang(places, neighbours, child, [other for other in neighbours[child] if other not in places], side)


def _offsets(graph: BondGraph, placed: Mapping[str, Mapping[str, Point]]) -> dict[str, Point]:
    """Offset of the origin of each sub-graph."""
    group_of = {name: group for group, places in placed.items() for name in places}
    offsets: dict[str, Point] = {}
    right = 0.0
    for group in _along(graph, list(placed), group_of):
        left, _, end, _ = _box(list(placed[group].values()))
        offsets[group] = (right - left, 0.0)
        right += end - left + _GAP
    for group in placed:
        if group not in offsets:
            offsets[group] = _above(graph, placed, offsets, group, group_of)
    return offsets


def _along(graph: BondGraph, groups: list[str], group_of: Mapping[str, str]) -> list[str]:
    """Sub-graphs that bonds join, in the direction of power."""
    ends = [(group_of[bond.tail], group_of[bond.head]) for bond in graph.bonds]
    joins = [(tail, head) for tail, head in ends if tail != head]
    tails, heads = {tail for tail, _ in joins}, {head for _, head in joins}
    order = [group for group in groups if group in tails - heads] or groups[:1]
    for group in order:  # grows while it is walked
        order += [head for tail, head in joins if tail == group and head not in order]
    return order


def _above(
    graph: BondGraph,
    placed: Mapping[str, Mapping[str, Point]],
    offsets: Mapping[str, Point],
    group: str,
    group_of: Mapping[str, str],
) -> Point:
    """Offset above all other sub-graphs, with the measured element above the elements it modulates."""
    tops = [_box(list(placed[other].values()))[3] + offset[1] for other, offset in offsets.items()]
    measured = {signal.name: signal.of for signal in graph.signals if group_of.get(signal.of) == group}
    modulated = [
        placed[group_of[element.name]][element.name][0] + offsets[group_of[element.name]][0]
        for element in graph.elements
        if group_of[element.name] in offsets and set(element.signals) & set(measured)
    ]
    left, bottom, _, _ = _box(list(placed[group].values()))
    if not modulated:
        return -left, max(tops, default=0.0) + _GAP - bottom
    abroad = {name for element in graph.elements if group_of[element.name] != group for name in element.signals}
    name = next(of for signal, of in measured.items() if signal in abroad)
    required = sum(modulated) / len(modulated) - placed[group][name][0]
    return required, max(tops) + _GAP - bottom
