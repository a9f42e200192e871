"""Figures: the paper's numbers, the loss where braking power is burnt, names that stand clear, legends of what is drawn."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.image import imread
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from infinivar import DutyCycle, Limit, Requirement, plant_graph, steady_map
from infinivar.contact import hertz
from infinivar.motion import Walking
from internals import PAPER_FIGURES as FIGURES
from internals import (
    PaperMachine,
    architectures,
    at_ratio,
    efficiency_by,
    operating_map,
    paper_curves,
    paper_maps,
    paper_polygons,
    steered_wheel,
    style,
    work_through,
)
from internals import duty_cycle_figure as duty_cycle
from internals import losses_figure as losses
from made import parameter_study
from sampled import sampled

STUDY = parameter_study("faulring2006")
SPEED, FORCE = np.linspace(-1.0, 1.0, 80), np.linspace(-45.0, 45.0, 90)
BOTH = [(1, 1), (1, -1), (-1, 1), (-1, -1)]


def numbers(name, quadrants, amplifier=None):
    drive = STUDY.drives[name]
    if amplifier is not None:
        drive = replace(drive, amplifier=amplifier)
    required = Requirement(force=40.0, speed=0.7, power=12.0, quadrants=quadrants)
    speed = SPEED if quadrants == 4 else SPEED[SPEED > 0]
    force = FORCE if quadrants > 1 else FORCE[FORCE > 0]
    steady = steady_map(drive, speed, force)
    return steady, operating_map.data(steady, required)


@pytest.mark.parametrize("name", ["cobotic", "cobotic-b", "motor2-gear4"])
@pytest.mark.parametrize("quadrants", [2, 4])
def test_loss_is_shown_where_returned_power_is_burnt(name, quadrants):
    steady, shown = numbers(name, quadrants)
    braking = np.signbit(steady.speed[:, None] * steady.force[None, :]) & (steady.limit == Limit.OK)
    assert braking.mean() > 0.2
    assert_array_equal(np.isfinite(shown["loss"]), braking)
    assert not np.isfinite(shown["efficiency"][braking]).any()
    # By hand: what the load gives, and what is drawn besides.
    given = -steady.speed[:, None] * steady.force[None, :]
    assert_allclose(shown["loss"][braking], (given + steady.power_in)[braking], rtol=1e-12)
    burnt = braking & (steady.power_in == 0.0)
    assert burnt.mean() > 0.1
    assert_allclose(shown["loss"][burnt], given[burnt], rtol=1e-9)
    driving = (steady.speed[:, None] * steady.force[None, :] > 0) & (steady.limit == Limit.OK)
    assert np.isfinite(shown["efficiency"][driving]).all()
    assert shown["largest_loss"] == pytest.approx(np.nanmax(shown["loss"][given <= 12.0 * (1 + 1e-9)]), rel=0.2)


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_one_quadrant_has_no_loss_to_show(name):
    _, shown = numbers(name, 1)
    assert not np.isfinite(shown["loss"]).any()
    assert operating_map.loss_levels([shown]).size == 0


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_efficiency_is_shown_where_power_comes_back(name):
    steady, shown = numbers(name, 4, iv.parts.Amplifier(regeneration="store", storage_efficiency=0.8))
    back = (steady.power_in < 0) & (steady.limit == Limit.OK)
    assert back.mean() > 0.1
    assert np.all(shown["efficiency"][back] > 0)
    assert not np.isfinite(shown["loss"][back]).any()


@sampled("quadrants", [4, 1, 2], every=3)
@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_maps_have_a_scale_for_each_colour(name, quadrants):
    _, shown = numbers(name, quadrants)
    with style.styled():
        made, ax = style.figure(5, 4)
        drawn = operating_map.draw(ax, shown)
        operating_map.colour_bar(made, drawn, ax)
    labels = [other.get_ylabel() for other in made.axes[1:]]
    assert [label.split()[0].strip(",") for label in labels] == ["loss", "efficiency"][quadrants == 1 :]


def test_a_figure_is_laid_out_once_for_all_formats(tmp_path, monkeypatch):
    """As it would be alone: the same picture. Its layout goes on afterwards."""

    def drawn():
        made, axes = style.stack(("force", "a long name of a speed"), 4, 3)
        for place, (name, ax) in enumerate(axes.items()):
            style.curves(ax, [0.0, 1.0], {name: [0.0, 10.0 ** (3 * place)]}, f"{name} [unit]")
        return made

    with style.styled():
        drawn().savefig(tmp_path / "alone.png")
        made, executed = drawn(), []
    layout = made.get_layout_engine()
    execute = type(layout).execute
    monkeypatch.setattr(type(layout), "execute", lambda self, figure: executed.append(figure) or execute(self, figure))
    files = style.write(made, tmp_path / "all", style.FORMATS)
    assert len(files) == len(style.FORMATS)
    assert executed == [made]
    assert made.get_layout_engine() is layout
    alone, beside = (imread(tmp_path / f"{name}.png") for name in ("alone", "all"))
    assert_array_equal(alone, beside)


def boxes_of(made, artists):
    canvas = FigureCanvasAgg(made)
    canvas.draw()
    return [artist.get_window_extent(canvas.get_renderer()) for artist in artists]


def overlapping(boxes):
    return [
        (first, second)
        for place, first in enumerate(boxes)
        for second in boxes[place + 1 :]
        if first.overlaps(second) and not (first.width == 0 or second.width == 0)
    ]


@pytest.mark.slow
@pytest.mark.source("faulring2006", "Fig 17")
def test_names_of_limits_stand_clear_in_figure_17():
    """Names, the bars under them, titles and the plots themselves: none of their boxes overlap, none leaves the page."""
    with style.styled():
        made = paper_maps.draw_all_dynamic(PaperMachine())
        for ax in made.axes:
            named = [artist for artist in (*ax.texts, *ax.lines) if artist.get_gid() == "limit"]
            words = [artist for artist in named if artist in ax.texts]
            assert len(words) >= 4
            boxes = boxes_of(made, [*named, ax.title])
            assert not overlapping(boxes)
            plot = ax.get_window_extent()
            assert all(box.y0 > plot.y1 for box in boxes)
            assert all(plot.x0 - 2 <= box.x0 and box.x1 <= plot.x1 + 2 for box in boxes)


def heat_panel(found):
    shown = duty_cycle.data(found)
    with style.styled():
        _, ax = style.figure(4, 3)
        duty_cycle.draw_heat(ax, shown)
    curves = {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}
    legend = ax.get_legend()
    return shown["heat"], curves, [] if legend is None else [text.get_text() for text in legend.get_texts()]


def visible(ax, line):
    """Whether a curve has any length within the plot."""
    y = line.get_ydata()
    inside = (y >= ax.get_ylim()[0]) & (y <= ax.get_ylim()[1]) & np.isfinite(y)
    return inside.sum() >= 2


ANKLE = {"joint": "ankle", "body_mass": 75.0, "stride_time": 1.1, "lever_arm": 0.05}


@pytest.fixture(scope="module")
def knee():
    """With the straight creep law, under which the steering motor moves, and warms, even where the wheel slips."""
    found = iv.load_study(Path(__file__).parents[2] / "studies" / "knee_walking.toml")
    cobotic = found.drives["cobotic"]
    straight = replace(cobotic, transmission=replace(cobotic.transmission, creep_law="linear"))
    return replace(found, drives={**found.drives, "cobotic": straight})


@pytest.mark.parametrize("share", [0.05, 0.25, 1.0])
@pytest.mark.parametrize("known", [True, False])
def test_heat_legend_names_what_is_drawn(knee, share, known, monkeypatch):
    """An ankle: the wheel of the cobotic drive slips, and the geared motor runs away or has no thermal data."""
    # Searching for cylinder speeds and simulating take most of the time, and the panel of heat shows nothing of either.
    monkeypatch.setattr("infinivar.analysis.compare.policies", lambda drive, duty: ())
    monkeypatch.setattr("infinivar.analysis.cycles.tracking.LONGEST", 0.0)
    study = knee
    if not known:
        geared = knee.drives["geared"]
        bare = replace(geared.motor, winding_to_housing=None)
        study = replace(knee, drives={**knee.drives, "geared": replace(geared, motor=bare)})
    found = work_through(study, "walking", DutyCycle(title="ankle", motion=Walking(share=share, **ANKLE)))
    heat, curves, named = heat_panel(found)
    assert named == list(curves)
    assert set(named) <= set(heat)
    assert curves
    for line in curves.values():
        assert visible(line.axes, line)
    geared = f"{knee.titles['geared']}, motor"
    assert (geared in named) == known


def test_a_winding_that_runs_away_at_once_is_drawn_to_the_edge():
    time, winding = np.array([0.0, 0.02, 0.04]), np.array([25.0, 4000.0, np.inf])
    x, y = duty_cycle._up_to(time, winding, 160.0)
    assert_allclose(y, [25.0, 160.0])
    assert_allclose(x, [0.0, 0.02 * 135.0 / 3975.0])
    assert duty_cycle._up_to(time, np.full(3, np.nan), 160.0) is None
    cool = np.array([25.0, 30.0, 31.0])
    assert_array_equal(duty_cycle._up_to(time, cool, 160.0)[1], cool)


def test_no_bar_where_a_loss_is_not_known():
    """Where the wheel slips some losses are not defined: the sum of the others would be too small."""
    given = {
        "title": "a cycle",
        "unit": "J",
        "losses": {"slips": {"winding": np.nan, "gearhead": 2.0}, "works": {"winding": 1500.0, "gearhead": 43.2}},
        "power_in": {"slips": np.nan, "works": 3000.0},
        "limit": {"slips": Limit.SLIP, "works": Limit.OK},
    }
    with style.styled():
        _, ax = style.figure(4, 2)
        losses.draw(ax, given)
    notes = [text.get_text().strip() for text in ax.texts]
    assert notes == ["beyond wheel slip", "1540 J"]
    widths = [[bar.get_width() for bar in group] for group in ax.containers]
    assert widths == [[0.0, 1500.0], [0.0, 43.2]]


@pytest.fixture(scope="module")
def machine():
    return PaperMachine()


def test_all_figures_of_the_paper_are_there_in_its_order():
    assert list(FIGURES) == list(range(1, 18))
    for number, drawn in FIGURES.items():
        assert drawn.title, number
        assert not drawn.title.endswith(".")
        assert drawn.caption.endswith("."), number


def test_the_page_of_figures_leads_through_them_in_order():
    page = (Path(__file__).parents[2] / "docs" / "figures.md").read_text("utf-8")
    heads = re.findall(r"^## Figure (\d+): (.+)\n\n```\{include\} reference/generated/paper_fig(\d+)\.md$", page, re.M)
    assert heads == [(str(number), drawn.title, str(number)) for number, drawn in FIGURES.items()]


@pytest.mark.source("faulring2006", "Fig 1")
def test_steered_wheel_is_to_scale(machine):
    """Figure 1: radii, patch and speeds by hand from the parameter set."""
    shown = steered_wheel.data(machine)
    assert (shown["cylinder_radius"], shown["wheel_radius"], shown["crown_radius"]) == (0.05, 0.01, 0.008)
    speeds = [snapshot["speed"] for snapshot in shown["snapshots"]]
    assert_allclose(speeds, [0.0, 0.125, 1.0, -0.125, np.nan], atol=1e-12)
    assert_allclose([snapshot["ratio"] for snapshot in shown["snapshots"]], [np.inf, 8.0, 1.0, 8.0, 0.0], rtol=1e-12)
    # The patch at 0 and at a right angle has its axes along and across: Hertz with the sums of the curvatures.
    e_star = 210e9 / (1 - 0.3**2) / 2
    locked, decoupled = shown["snapshots"][0], shown["snapshots"][-1]
    by_hand = hertz.ellipse(650.0, 1 / 0.01 + 1 / 0.05, 1 / 0.008, e_star)
    assert_allclose([locked["a"], locked["b"], locked["turn"]], [by_hand.a, by_hand.b, 0.0], rtol=1e-9)
    by_hand = hertz.ellipse(650.0, 1 / 0.01, 1 / 0.008 + 1 / 0.05, e_star)
    assert_allclose(
        [decoupled["a"], decoupled["b"], decoupled["turn"]], [by_hand.a, by_hand.b, 0.0], rtol=1e-9, atol=1e-12
    )
    # Opposite angles are mirror images.
    forward, backward = shown["snapshots"][1], shown["snapshots"][3]
    assert_allclose([forward["a"], forward["b"], forward["turn"]], [backward["a"], backward["b"], -backward["turn"]])


@pytest.mark.source("faulring2006", "Fig 1")
@pytest.mark.parametrize("angle", [0.0, -0.124, -0.785, 1.3])
def test_patch_is_drawn_as_the_surfaces_lie(machine, angle):
    """Separation of both surfaces over the drawn plane: least curved along the long axis of the ellipse as drawn."""
    contact = machine.element.geometry.press(
        wheel_radius=0.01, cylinder_radius=0.05, preload=650.0, steering_angle=angle
    )
    _, ax = style.figure(2, 2)
    snapshot = {"angle": angle, "a": contact.patch.a, "b": contact.patch.b, "turn": contact.rotation}
    steered_wheel.draw_patch(ax, snapshot)
    ellipse = ax.patches[0]
    long_side = np.radians(ellipse.angle + (0.0 if ellipse.width > ellipse.height else 90.0))
    lateral, rolling = steered_wheel.directions(angle)
    around = np.array([0.0, 1.0])  # circumference of the cylinder, seen from above
    curvature = np.outer(rolling, rolling) / 0.01 + np.outer(lateral, lateral) / 0.008 + np.outer(around, around) / 0.05
    flattest = np.linalg.eigh(curvature)[1][:, 0]
    assert abs(flattest @ [np.cos(long_side), np.sin(long_side)]) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.source("faulring2006", "Fig 1")
def test_silhouette_of_the_wheel():
    """10 mm at the rim's middle and less towards its sides, by the crown; turned with the wheel."""
    outline = steered_wheel.silhouette(10.0, 8.0, 4.0, 0.0)
    assert np.abs(outline[:, 1]).max() == pytest.approx(10.0)
    side = outline[np.isclose(np.abs(outline[:, 0]), 4.0)]
    assert_allclose(np.abs(side[:, 1]), 10.0 - 8.0 + np.sqrt(64.0 - 16.0))
    turned = steered_wheel.silhouette(10.0, 8.0, 4.0, -np.pi / 2)
    assert np.abs(turned[:, 0]).max() == pytest.approx(10.0)


@pytest.mark.source("faulring2006", "Fig 3")
def test_velocities_close(machine):
    """Figure 3: link and surface speed are rolling and creep; components by the paper's equations, by hand."""
    shown = paper_polygons.velocities(machine)
    vectors, amounts, phi = shown["vectors"], shown["amounts"], shown["angle"]
    assert_allclose(vectors["link"] + vectors["cylinder"], vectors["rolling"] + vectors["lateral"], rtol=0, atol=1e-12)
    assert phi == pytest.approx(-np.arctan(0.5), rel=1e-12)
    assert amounts["cylinder"] == pytest.approx(0.05 * 14.0, rel=1e-12)
    link, surface = amounts["link"], amounts["cylinder"]
    assert amounts["lateral"] == pytest.approx(link * np.cos(phi) + surface * np.sin(phi), abs=1e-15)  # Eq 3
    assert amounts["rolling"] == pytest.approx(link * np.sin(phi) - surface * np.cos(phi), abs=1e-15)  # Eq 4
    for name, vector in vectors.items():
        assert np.hypot(*vector) == pytest.approx(abs(amounts[name]), rel=1e-12)
    assert vectors["rolling"] @ vectors["lateral"] == pytest.approx(0.0, abs=1e-15)
    # Without creep the wheel would roll where it heads, and the tip would be on the ray of its rolling direction.
    assert shown["ideal"] @ vectors["lateral"] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.source("faulring2006", "Fig 3", "Fig 4")
def test_forces_close_and_powers_balance(machine):
    """Figure 4: forces on the wheel add up, oppose the velocities of Figure 3, and their powers are the losses."""
    shown, moving = paper_polygons.forces(machine), paper_polygons.velocities(machine)
    vectors, amounts, phi = shown["vectors"], shown["amounts"], shown["angle"]
    total = vectors["link"] + vectors["cylinder"]
    assert_allclose(total, vectors["rolling"] + vectors["lateral"], rtol=0, atol=1e-12)
    assert phi == moving["angle"]
    assert amounts["link"] == pytest.approx(0.5 * 0.12 * 650.0, rel=1e-12)
    lateral, rolling = amounts["lateral"], amounts["rolling"]
    assert amounts["cylinder"] == pytest.approx(lateral * np.sin(phi) - rolling * np.cos(phi), rel=1e-12)  # Eq 5
    assert amounts["link"] == pytest.approx(-lateral * np.cos(phi) - rolling * np.sin(phi), rel=1e-12)  # Eq 6
    sliding = moving["vectors"]["link"] + moving["vectors"]["cylinder"]
    assert -(total @ sliding) == pytest.approx(shown["power"]["lateral"] + shown["power"]["rolling"], rel=1e-12)
    powers = {name: amounts[name] * moving["amounts"][name] for name in amounts}
    assert_allclose([powers[name] for name in powers], [shown["power"][name] for name in powers], rtol=1e-12)
    assert powers["cylinder"] - powers["link"] == pytest.approx(powers["lateral"] + powers["rolling"], rel=1e-12)


@pytest.mark.source("faulring2006", "Fig 7")
def test_element_efficiency_curves_are_eqs_16_and_17(machine):
    """Figure 7's curves by the printed equations, which the element does not use."""
    shown = paper_curves.efficiency(machine, count=50)
    groups = machine.element.groups(14.0)
    r, slip = 0.01, 78.0
    h, k = r * float(groups.rolling_force), r * float(groups.creep_stiffness)
    phi = np.arctan(1.0 / shown["ratio"])
    for load in paper_curves.LOADS:
        f = load * slip
        cos, sin = np.cos(phi), np.sin(phi)
        top = -r * cos**2 * f * (sin * (h - k) + r * f)
        expected = top / ((r * sin * f + h) * (k * cos**2 + r * sin * f + sin**2 * h))
        lateral = f / cos + h / r * np.tan(phi)
        within = (lateral <= slip) & (expected > 0)
        assert within.sum() > 20
        assert_allclose(shown["linear"][load][within], expected[within], rtol=1e-9)
        factor = np.where(lateral > 0.7 * slip, 1.0 - ((lateral - 0.7 * slip) / (0.3 * slip)) ** 2, 1.0)
        inside = within & (lateral < 0.999 * slip) & (expected * factor > 0.01)
        assert_allclose(shown["faulring"][load][inside], (expected * factor)[inside], rtol=1e-6)


@pytest.mark.source("faulring2006", "Fig 7")
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_simulated_measurements_stand_on_their_curves(machine, seed):
    """Figure 7's points: the paper's ratios and loads, intervals that hold the true efficiency, the same in every run."""
    found = paper_curves.measured(machine, seed)
    assert list(found) == [0.15, 0.5]
    pulls = []
    for load, points in found.items():
        assert_allclose(points["ratio"], [1.0, 2.0, 4.0, 8.0, 20.0, 50.0, 100.0], rtol=1e-9)
        true = efficiency_by(machine.element, load, points["ratio"])
        step = 1e-3 * points["ratio"]
        slope = (efficiency_by(machine.element, load, points["ratio"] + step) - true) / step
        spread = np.hypot(points["efficiency_deviation"], slope * points["ratio_deviation"])
        assert np.all((spread > 0) & (spread < 0.03))
        pulls += ((points["efficiency"] - true) / spread).tolist()
        # By hand: an encoder's zero off by 0.2 mrad turns 100:1 into 98:1 or 102:1.
        assert points["ratio_deviation"][-1] == pytest.approx(2.0, rel=0.01)
    assert np.abs(pulls).max() < 3.5
    assert np.mean(np.abs(pulls) < 2.0) > 0.7  # errors of a session are common to its points
    assert np.abs(pulls).max() > 0.2  # they are measurements, not the curve
    again = paper_curves.measured(machine, seed)
    assert_array_equal(again[0.5]["efficiency"], found[0.5]["efficiency"])


@pytest.mark.source("faulring2006", "Fig 9")
def test_architectures_balance_power(machine):
    """Figure 9: what enters leaves at the load or as a named loss, part by part, at 50 N and 12 W."""
    shown = architectures.data(machine)
    assert shown["force"] * shown["speed"] == pytest.approx(12.0, rel=1e-12)
    for letter, architecture in shown["architectures"].items():
        point = machine.moving(architectures.DRIVES[letter]).operate(speed=0.24, force=50.0)
        named = [loss for _, lost, _ in architecture["stages"] for loss in lost]
        assert sorted(named) == sorted(point.losses)
        last = architecture["stages"][-1][2]
        assert last == pytest.approx(architecture["power_out"], rel=1e-12)
        assert architecture["power_out"] == pytest.approx(12.0, rel=1e-12)
        lost = sum(watts for _, parts, _ in architecture["stages"] for watts in parts.values())
        assert architecture["power_in"] - lost == pytest.approx(12.0, rel=1e-12)
        assert architecture["efficiency"] == pytest.approx(12.0 / architecture["power_in"], rel=1e-12)
    # What leaves the wheel is the element's own, and by hand: 50 N and the guideway's 0.65 N at 0.24 m/s.
    stages = {part: left for part, _, left in shown["architectures"]["A"]["stages"]}
    assert stages["cylinder\nand wheel"] == pytest.approx(50.65 * 0.24, rel=1e-12)
    assert at_ratio(machine.element, 50.65 / 78.0, 2.0).power_out > 0


@sampled("number", [2, 6, 10, 11, 12, 13, 14], every=4)
def test_bond_graphs_of_the_paper_are_those_that_are_simulated(machine, number):
    pytest.importorskip("igraph")
    drawn = FIGURES[number]
    drive, plant = drawn.plant
    shown = drawn.data(machine)
    mass = {"load_mass": machine.load_mass} if plant == "system" else {}
    graph = plant_graph(machine.study.drives[drive], plant, **mass)
    assert set(shown["elements"]) == {element.name for element in graph.elements}
    assert len(shown["bonds"]) == len(graph.bonds)
    kinds = {element.kind for element in graph.elements}
    assert kinds  # the losses of the transmission are in Figure 6 and not in Figure 2
    assert any("f_u" in element["text"] for element in shown["elements"].values()) == (number in (6, 10))


def texts_of(made):
    return [
        text for ax in made.axes for text in (*ax.texts, ax.title) if text.get_text().strip() and text.get_visible()
    ]


@pytest.mark.slow
@sampled("number", [1, 3, 4, 9], every=2)
def test_words_of_drawn_figures_do_not_collide(machine, number):
    """Texts neither overlap one another nor leave the page."""
    made = FIGURES[number].draw_all(machine)
    with style.styled():
        texts = texts_of(made)
        boxes = boxes_of(made, texts)
    assert len(boxes) > 5
    for place, box in enumerate(boxes):
        for other, second in zip(texts[place + 1 :], boxes[place + 1 :], strict=True):
            assert not box.overlaps(second), (texts[place].get_text(), other.get_text())
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= made.bbox.x1
        assert box.y1 <= made.bbox.y1
