"""Figures: the loss where braking power is burnt, names that stand clear of one another, legends of what is drawn."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from infinivar.analysis.compare import work_through
from infinivar.analysis.steady_map import steady_map
from infinivar.figures import duty_cycle, losses, operating_map, style
from infinivar.limits import Limit
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.paper.claims.claim import Machine
from infinivar.paper.figures import fig17_dynamic_performance
from infinivar.study.load import shipped_study
from infinivar.study.requirement import Requirement

STUDY = shipped_study("faulring2006")
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
    steady, shown = numbers(name, 4, iv.Amplifier(regeneration="store", storage_efficiency=0.8))
    back = (steady.power_in < 0) & (steady.limit == Limit.OK)
    assert back.mean() > 0.1
    assert np.all(shown["efficiency"][back] > 0)
    assert not np.isfinite(shown["loss"][back]).any()


@pytest.mark.parametrize("quadrants", [1, 2, 4])
@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_maps_have_a_scale_for_each_colour(name, quadrants):
    _, shown = numbers(name, quadrants)
    with style.styled():
        made, ax = style.figure(5, 4)
        drawn = operating_map.draw(ax, shown)
        operating_map.colour_bar(made, drawn, ax)
    labels = [other.get_ylabel() for other in made.axes[1:]]
    assert [label.split()[0].strip(",") for label in labels] == ["loss", "efficiency"][quadrants == 1 :]


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


@pytest.mark.source("faulring2006", "Fig 17")
def test_names_of_limits_stand_clear_in_figure_17():
    """Names, the bars under them, titles and the plots themselves: none of their boxes overlap, none leaves the page."""
    with style.styled():
        made = fig17_dynamic_performance.draw_all(Machine())
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


ANKLE = {"shape": "walking", "joint": "ankle", "body_mass": 75.0, "stride_time": 1.1, "lever_arm": 0.05}


@pytest.fixture(scope="module")
def knee():
    return iv.load_study(Path(__file__).parents[2] / "studies" / "knee_walking.toml")


@pytest.mark.parametrize("share", [0.05, 0.25, 1.0])
@pytest.mark.parametrize("known", [True, False])
def test_heat_legend_names_what_is_drawn(knee, share, known):
    """An ankle: the wheel of the cobotic drive slips, and the geared motor runs away or has no thermal data."""
    study = knee
    if not known:
        geared = knee.drives["geared"]
        bare = replace(geared.motor, winding_to_housing=None)
        study = replace(knee, drives={**knee.drives, "geared": replace(geared, motor=bare)})
    found = work_through(study, "walking", DutyCycle(title="ankle", share=share, **ANKLE))
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
