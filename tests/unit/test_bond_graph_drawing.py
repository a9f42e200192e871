"""Drawings of bond graphs: nothing on top of another, and what is drawn is what the graph says."""

import itertools
from dataclasses import replace

import pytest

import infinivar as iv
from infinivar import plant_graph
from infinivar.bondgraph import BondGraph, assign
from internals import bond_graph_elements as bg
from internals import bond_graph_figure as bond_graph
from internals import style
from sampled import spread

HALF_HEIGHT = 0.09

CASES = [
    ("cobotic", "system", "current"),
    ("cobotic-b", "system", "voltage"),
    ("cobotic", "lossless", "current"),
    ("cobotic", "transmission", "current"),
    ("cobotic", "steering", "voltage"),
    ("cobotic", "cylinder", "current"),
    ("cobotic", "link", "current"),
    ("motor2-gear4", "system", "current"),
    ("motor2-gear4", "system", "voltage"),
    ("with bearings", "system", "current"),
    ("with bearings", "cylinder", "current"),
]
BEARINGS = iv.parts.CylinderBearings(friction_coefficient=0.0015, bore=0.02, span=0.2)


@pytest.fixture(params=spread(CASES, every=6), ids="-".join)
def graph(request, study):
    name, plant, electrical = request.param
    drives = {**study.drives, "with bearings": replace(study.drives["cobotic"], cylinder_bearings=BEARINGS)}
    return plant_graph(drives[name], plant, electrical=electrical, load_mass=0.8)


def test_no_element_covers_another(graph):
    elements = bond_graph.data(graph)["elements"]
    assert set(elements) == {element.name for element in graph.elements}
    for (one, a), (two, b) in itertools.combinations(elements.items(), 2):
        beside = abs(a["at"][0] - b["at"][0]) > a["half"] + b["half"]
        above = abs(a["at"][1] - b["at"][1]) > 2 * HALF_HEIGHT
        assert beside or above, (one, two)


def test_no_bond_runs_through_an_element(graph):
    numbers = bond_graph.data(graph)
    elements = numbers["elements"]
    for tail, head, _ in numbers["bonds"]:
        (x0, y0), (x1, y1) = elements[tail]["at"], elements[head]["at"]
        for name, element in elements.items():
            if name in (tail, head):
                continue
            for share in [step / 50 for step in range(51)]:
                x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
                inside = abs(x - element["at"][0]) < element["half"] and abs(y - element["at"][1]) < HALF_HEIGHT
                assert not inside, (tail, head, name)


def test_strokes_are_those_of_the_causality(study):
    graph = plant_graph(study.drives["cobotic"], load_mass=0.8)
    causality = assign(graph)
    drawn = bond_graph.data(graph)["bonds"]
    assert [(tail, head) for tail, head, _ in drawn] == [(bond.tail, bond.head) for bond in graph.bonds]
    assert [end for _, _, end in drawn] == [causality.stroke[bond] for bond in graph.bonds]


def test_frames_hold_their_own_and_do_not_meet(study):
    graph = plant_graph(study.drives["cobotic"], load_mass=0.8)
    numbers = bond_graph.data(graph)
    assert {title for _, title in numbers["frames"].values()} == {
        "Steering plant",
        "Cylinder plant",
        "Transmission plant",
        "Link plant",
    }
    for prefix, ((left, bottom, right, top), _) in numbers["frames"].items():
        for name, element in numbers["elements"].items():
            x, y = element["at"]
            inside = left < x - element["half"] and x + element["half"] < right and bottom < y < top
            assert inside == name.startswith(f"{prefix}.")
    for (a, _), (b, _) in itertools.combinations(numbers["frames"].values(), 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_the_main_row_is_straight(study):
    """From cylinder motor to load on one line, as the paper draws it."""
    elements = bond_graph.data(plant_graph(study.drives["cobotic"], load_mass=0.8))["elements"]
    row = [
        "cylinder.source",
        "cylinder.rotor",
        "cylinder.cylinder",
        "transmission.surface",
        "transmission.link",
        "output",
    ]
    across, up = zip(*(elements[name]["at"] for name in row), strict=True)
    assert set(up) == {0.0}
    assert list(across) == sorted(across)
    assert elements["steering.bell"]["at"][0] == pytest.approx(elements["transmission.creep"]["at"][0])


def test_signals_lead_to_what_they_modulate(study):
    signals = bond_graph.data(plant_graph(study.drives["cobotic"], load_mass=0.8))["signals"]
    assert (r"\phi", "steering.bell", "transmission.link_across") in signals
    assert ("v", "transmission.rolling", "transmission.creep") in signals


def test_any_graph_can_be_drawn(tmp_path):
    """Branches, a loop of junctions, a field with two ports: no crash, everything placed."""
    field = bg.resistance("field", "R", lambda a, b: (a + b, a + 2 * b))
    graph = BondGraph(
        "g",
        [
            bg.effort_source("e", "e"),
            bg.one("a", "x"),
            bg.zero("b"),
            bg.zero("c"),
            bg.one("d"),
            bg.inertia("m", "m", 1.0),
            bg.compliance("k", "k", 1.0),
            field,
            bg.resistance("r", "r", 1.0),
        ],
        ["e > a > b > d > m", "a > c > d", "b > field", "c > field", "d > k", "d > r"],
    )
    made = bond_graph.draw_all(graph, title="A loop")
    style.write(made, tmp_path / "graph")
    places = [element["at"] for element in bond_graph.data(graph)["elements"].values()]
    assert len(set(places)) == len(places) == 9


@pytest.mark.slow
def test_one_graph_gives_one_picture(study, tmp_path):
    graph = plant_graph(study.drives["cobotic"], "transmission")
    first, second = (
        style.write(bond_graph.draw_all(graph), tmp_path / name, ("svg",))[0].read_bytes() for name in ("one", "two")
    )
    assert first == second
    assert b"<svg" in first
