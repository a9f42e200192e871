"""The figure of a rolling patch: what is shaded, outlined and pointed at is the state's, and nothing covers it."""

import dataclasses

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.quiver import Quiver
from numpy.testing import assert_allclose

import infinivar as iv
from internals import rolling_patch_figure as rolling_patch
from sampled import spread

CASES = {
    "lateral": (iv.contact.RollingPatch(1.0, cells=12), (0.0, 0.3, 0.0)),
    "spin": (iv.contact.RollingPatch(0.5, cells=12), (0.0, 0.0, 0.4)),
    "turned": (iv.contact.RollingPatch(0.6, turned=0.5, cells=12), (0.1, 0.2, 0.2)),
    "slender": (iv.contact.RollingPatch(15.0, cells=12), (0.0, 0.05, 0.02)),
}


@pytest.fixture(scope="module", params=spread(CASES, every=3))
def state(request):
    patch, creepages = CASES[request.param]
    return patch.steady(*creepages)


def test_numbers_are_those_of_the_state(state):
    shown = rolling_patch.data(state)
    grid = state.grid
    x, y = shown["outline"]
    assert_allclose(y.max(), grid.reach, rtol=1e-3)
    assert_allclose(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)), np.pi, rtol=1e-3)
    slides = shown["slides"]
    assert 0.05 < slides.mean() < 1.0
    assert_allclose(shown["share"][slides], 1.0, rtol=1e-6)
    assert np.all(shown["share"][~slides] < 1.0 + 1e-6)
    assert np.all(shown["slip"][:, ~slides] == 0.0)
    row = shown["row"]
    assert np.all(np.hypot(row["x"], row["y"]) <= row["bound"] * (1.0 + 1e-6))
    assert_allclose(np.diff(row["edges"]), grid.length[grid.rows // 2])
    # Friction opposes slip: the traction on the track points along the slip of the wheel.
    drives = np.sum(shown["traction"] * shown["slip"], axis=0)[slides]
    assert np.mean(drives > 0.0) > 0.9


def test_stick_area_is_outlined(state):
    """Area within the outline against that of the sticking cells: half a cell all around is what they may differ by."""
    made = state.plot()
    (outline,) = (found for found in made.axes[0].collections if type(found).__name__ == "QuadContourSet")
    area = 0.0
    for path in outline.get_paths():
        for polygon in path.to_polygons():
            x, y = polygon.T
            area += 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert area / np.pi == pytest.approx(1.0 - state.slip_share, abs=0.12)
    inside = [path.contains_points(_cells(state)) for path in outline.get_paths()]
    assert np.mean(np.any(inside, axis=0) == ~state.slides.ravel()) > 0.95


def _cells(state):
    x = state.grid.x
    return np.stack([x, np.broadcast_to(state.grid.y[:, None], x.shape)], axis=-1).reshape(-1, 2)


def test_arrows_point_as_the_vectors_do(state):
    made = state.plot()
    slip, traction = (found for found in made.axes[0].collections if isinstance(found, Quiver))
    for arrows, vectors in ((slip, state.slip), (traction, state.traction)):
        places = arrows.get_offsets()
        assert len(places) > 5
        for place, along, across in zip(places, arrows.U, arrows.V, strict=True):
            cell = np.argmin(np.hypot(*(_cells(state) - place).T))
            assert_allclose([along, across], vectors.reshape(2, -1)[:, cell])


def test_nothing_covers_the_data(state):
    """Legends, title and colour bar lie beside both panels, and on the page."""
    made = state.plot()
    FigureCanvasAgg(made).draw()
    patch, row, bar = made.axes
    page = made.bbox
    for beside in (patch.get_legend(), row.get_legend(), made._suptitle):
        box = beside.get_window_extent()
        assert page.x0 <= box.x0
        assert box.x1 <= page.x1
        assert box.y1 <= page.y1
        assert not any(box.overlaps(ax.get_window_extent()) for ax in made.axes)
    assert not bar.get_tightbbox().overlaps(patch.get_window_extent())


def test_scales_of_the_axes_are_equal_unless_the_patch_is_slender(state):
    patch = state.plot().axes[0]
    FigureCanvasAgg(patch.figure).draw()
    across, up = np.diff(patch.transData.transform([(0.0, 0.0), (1.0, 1.0)]), axis=0)[0]
    stretched = "stretched" in patch.get_ylabel()
    assert stretched == (state.grid.a_over_b == 15.0)
    assert (across == pytest.approx(up, rel=1e-6)) != stretched


@pytest.mark.parametrize("lateral", [1e-6, 0.3, 9.0])
def test_the_legend_names_what_is_drawn(lateral):
    """A patch in full slip has no outline; slip is named only if some cell slides."""
    state = iv.contact.RollingPatch(1.0, cells=8).steady(0.0, lateral)
    named = [text.get_text() for text in state.plot().axes[0].get_legend().get_texts()]
    drawn = {"traction on the track"}
    drawn |= {"slip of the wheel"} if state.slides.any() else set()
    drawn |= {"stick area"} if 0.0 < state.slip_share < 1.0 else set()
    assert set(named) == drawn
    assert (state.slip_share == 1.0) == (lateral == 9.0)


def test_a_state_that_has_not_converged_is_not_drawn():
    state = dataclasses.replace(iv.contact.RollingPatch(1.0, cells=8).steady(0.0, 0.1), outcome="not converged")
    with pytest.raises(iv.InputError, match="has not converged"):
        state.plot()


def test_labelled_arrays_hold_the_balance(state):
    """Power from the arrays alone; forces from tractions and areas."""
    found = state.to_xarray()
    assert float((found.area * found.traction * found.slip).sum()) == pytest.approx(state.power, rel=1e-12)
    forces = (found.area * found.traction).sum(("row", "cell"))
    assert_allclose(forces, [state.fx, state.fy], atol=1e-14)
    assert float((found.area * found.bound).sum()) == pytest.approx(1.0, rel=1e-12)


def test_cells_are_locked():
    """Grids are shared by all patches of a shape."""
    grid = iv.contact.RollingPatch(1.0, cells=8).grid
    with pytest.raises(ValueError, match="read-only"):
        grid.x[0, 0] = 1.0
