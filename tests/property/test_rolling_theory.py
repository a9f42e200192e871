"""Why the cells of exact rolling contact lie where they lie, and why its iteration converges: the facts behind the choices."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import dblquad, quad
from scipy.linalg import solve_toeplitz

import infinivar as iv
from infinivar.contact import kalker
from internals import equations_of_cells as equations
from internals import exact_equations as equations_of
from internals import exact_grid as cells_of
from internals import opposed_friction as opposed


def test_strip_without_slip():
    r"""The traction that makes the gradient of displacement 1 along a strip: force :math:`\pi a`, and a root at the front.

    Of :math:`p = \sqrt{(a - x)/(a + x)}`, by quadrature of :math:`(1/\pi) \int p(t)/(x - t) dt = 1` for a = 1.
    """

    def traction(t):
        return np.sqrt((1.0 - t) / (1.0 + t))

    for x in (-0.7, 0.1, 0.6):
        gradient = -quad(traction, -0.999999999999, 1.0, weight="cauchy", wvar=x, limit=500)[0] / np.pi
        # The missing end: p is about sqrt(2/(1 + t)) there, of integral 2 sqrt(2e).
        gradient += 2.0 * np.sqrt(2.0 * 1e-12) / (1.0 + x) / np.pi
        assert_allclose(gradient, 1.0, rtol=1e-5)
    assert_allclose(quad(traction, -1.0, 1.0)[0], np.pi, rtol=1e-6)


def _cells_more_than_there_are(count):
    """Length over which a strip of constant tractions has its exact force, less its cells' own, in cells."""

    def primitive(x):
        return x * np.log(np.abs(x))

    apart = np.arange(-count + 1, count + 1)
    displacement = -(primitive(apart + 0.5) - primitive(apart - 0.5)) / np.pi
    slip = displacement[:-1] - displacement[1:]
    traction = solve_toeplitz((slip[count - 1 :], slip[count - 1 :: -1]), np.ones(count))
    return np.sum(traction) / (0.5 * np.pi) - count


def test_inset_follows_from_the_strip():
    """Cells of constant traction with slip half a cell ahead have the force of a strip longer by 0.1507 cells."""
    found = [_cells_more_than_there_are(count) for count in (320, 640)]
    limit = found[1] + (found[1] - found[0]) / 3.0
    assert abs(found[1] - found[0]) < 1e-6
    assert_allclose(cells_of.INSET, limit, atol=1e-5)


@pytest.fixture
def moved(monkeypatch):
    """A function that sets inset and shift of the cells; no matrix of theirs is kept."""
    stored = (cells_of.grid, equations_of.influence, equations_of._corner_sums, equations_of.equations)

    def forget():
        for one in stored:
            one.cache_clear()

    def move(inset, ahead):
        monkeypatch.setattr(cells_of, "INSET", inset)
        monkeypatch.setattr(cells_of, "AHEAD", ahead)
        forget()

    yield move
    monkeypatch.undo()
    forget()


def _errors(ratio):
    """Relative errors of C11, C22, C23 from the force and C23 from the moment on 20 x 20 cells."""
    gradient = iv.contact.RollingPatch(ratio).steady(0.0, 1e-6, gradient=True).gradient
    table = kalker.coefficients(ratio, 0.3)
    found = [gradient[0, 0], gradient[1, 1], gradient[1, 2], -gradient[2, 1]]
    return np.array(found) / [table.c11, table.c22, table.c23, table.c23] - 1.0


@pytest.mark.slow
def test_what_inset_and_shift_are_worth(moved):
    """Errors of 20 x 20 cells: 0.6 % with both; 0.8 to 2.2 % without the inset; 3.5 to 6.7 % in C23 without the shift."""
    ratios = (0.2, 1.0, 5.0)
    assert np.max(np.abs([_errors(ratio) for ratio in ratios])) < 0.006
    moved(0.0, cells_of.AHEAD)
    bare = np.array([_errors(ratio) for ratio in ratios])
    assert bare.min() > 0.008
    assert bare.max() < 0.022
    moved(0.1507, 0.0)
    centred = np.array([_errors(ratio) for ratio in ratios])
    assert_allclose(centred[:, :2], np.array([[0.0028, 0.0016], [-0.0014, -0.0016], [0.0023, 0.0054]]), atol=1e-3)
    assert np.all((centred[:, 2] > 0.035) & (centred[:, 2] < 0.067))
    assert np.all((centred[:, 3] < -0.035) & (centred[:, 3] > -0.067))


def _lengthwise(patch):
    """Slip of all cells times their lengths, by tractions."""
    grid = patch.grid
    matrix = equations_of.influence(grid, patch.poisson, False).ahead
    return np.tile(np.repeat(grid.length, grid.cells), 2)[:, None] * matrix


@pytest.mark.parametrize("turned", [0.0, 0.6])
@pytest.mark.parametrize("poisson", [0.0, 0.4])
def test_shift_by_a_quarter_makes_the_grid_reciprocal(poisson, turned, moved):
    """Turned by 180 degrees, the steps along which slip is taken are the cells: the matrix is then its own transpose."""
    patch = iv.contact.RollingPatch(0.7, poisson, turned, 8)
    matrix = _lengthwise(patch)
    size = np.abs(matrix).max()
    back = np.concatenate([np.arange(63, -1, -1), np.arange(127, 63, -1)])
    assert_allclose(matrix[np.ix_(back, back)], matrix.T, atol=1e-13 * size)
    moved(cells_of.INSET, 0.0)
    other = _lengthwise(dataclasses.replace(patch))
    assert np.max(np.abs(other[np.ix_(back, back)] - other.T)) > 0.01 * size


@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_displacements_are_those_of_point_loads(poisson):
    """The influence of one cell on others against the integral of Cerruti's point loads over it."""
    patch = iv.contact.RollingPatch(1.5, poisson, 0.4, 4)
    grid = patch.grid
    matrix = equations_of.influence(grid, poisson, False).displacement.reshape(2, 4, 4, 2, 4, 4)
    row, cell = 2, 1
    half, width = 0.5 * grid.length[row], 0.5 * grid.width

    def point_load(one, other):
        def at(y, x, to_x, to_y):
            dx, dy = to_x - x, to_y - y
            r = np.hypot(dx, dy)
            product = {(0, 0): dx * dx, (0, 1): dx * dy, (1, 1): dy * dy}[one, other]
            return ((one == other) * (1.0 - poisson) / r + poisson * product / r**3) / np.pi

        return at

    for to_row, to_cell in ((0, 2), (2, 3), (3, 0)):
        to = grid.x[to_row, to_cell], grid.y[to_row]
        for one, other in ((0, 0), (0, 1), (1, 1)):
            x, y = grid.x[row, cell], grid.y[row]
            found, _ = dblquad(point_load(one, other), x - half, x + half, y - width, y + width, args=to)
            assert_allclose(matrix[one, to_row, to_cell, other, row, cell], found, atol=1e-9)
            assert_allclose(matrix[other, to_row, to_cell, one, row, cell], found, atol=1e-9)


@pytest.mark.parametrize("turned", [0.0, 0.5])
def test_chords_of_a_turned_ellipse(turned):
    """Ends of each row's chord lie on the ellipse turned by the angle."""
    grid = iv.contact.RollingPatch(2.5, 0.3, turned, 10).grid
    a, b = np.sqrt(2.5), 1.0 / np.sqrt(2.5)
    middle = grid.x.mean(axis=1) + cells_of.AHEAD * grid.length
    half = 0.5 * grid.length * (grid.cells + cells_of.INSET)
    for x in (middle - half, middle + half):
        along = x * np.cos(turned) + grid.y * np.sin(turned)
        across = -x * np.sin(turned) + grid.y * np.cos(turned)
        assert_allclose((along / a) ** 2 + (across / b) ** 2, 1.0, rtol=1e-12)


def test_friction_holds_in_every_cell():
    """Where a cell sticks, slip half a cell ahead vanishes; where it slides, the traction opposes the extrapolated slip."""
    patch = iv.contact.RollingPatch(0.8, cells=12)
    for creepage in ((0.0, 0.3, 0.2), (0.2, 0.1, -0.3)):
        rolling = equations(patch.grid, patch.poisson, False)
        found = rolling.friction.solve(rolling.free_slip(np.array(creepage)))
        slides = found.slides
        assert 0.2 < slides.mean() < 1.0
        size = np.hypot(*found.traction)
        assert np.max(np.abs(found.slip[:, ~slides])) < 1e-6
        assert_allclose(size[slides], rolling.friction.bound[slides], rtol=1e-6)
        assert np.all(size[~slides] <= rolling.friction.bound[~slides] * (1.0 + 1e-6))
        against = opposed(found.slip, rolling.friction.after)[:, slides]
        cross = found.traction[0, slides] * against[1] - found.traction[1, slides] * against[0]
        assert np.max(np.abs(cross)) < 1e-6
        assert np.all(np.sum(found.traction[:, slides] * against, axis=0) <= 1e-9)


def test_direction_of_slip_is_of_second_order():
    """Slip that turns along a row: half a cell ahead its direction errs by half of the turn, extrapolated by its square."""
    errors = []
    for step in (0.1, 0.05):
        middles = step * np.arange(12)
        ahead = middles + 0.5 * step
        slip = (1.0 + ahead) * np.array([np.cos(ahead), np.sin(ahead)])
        found = opposed(slip, np.minimum(np.arange(12) + 1, 11))[:, :-1]
        angle = np.arctan2(found[1], found[0]) - middles[:-1]
        errors.append(np.max(np.abs(angle)))
    assert errors[0] < 0.1 * 0.05
    assert errors[0] / errors[1] > 3.5


def _failures(weight_of, count=24, cells=10):
    """Cold starts that do not converge with other weights, and mean number of steps."""
    rng = np.random.default_rng(3)
    failed = steps = 0
    for number in range(count):
        ratio = float(np.exp(rng.uniform(np.log(0.1), np.log(10.0))))
        patch, linear = iv.contact.RollingPatch(ratio, cells=cells), kalker.coefficients(ratio, 0.3)
        direction = rng.normal(size=3) * [(0, 1, 1), (1, 1, 0), (0, 0, 1), (1, 1, 1)][number % 4]
        size = np.exp(rng.uniform(np.log(0.05), np.log(4.0))) / np.linalg.norm(direction)
        creepage = size * direction * np.array([3.0 / linear.c11, 3.0 / linear.c22, 1.0 / linear.c23])
        rolling = equations(patch.grid, patch.poisson, False)
        friction = dataclasses.replace(rolling.friction, weight=weight_of(rolling.friction))
        found = friction.solve(rolling.free_slip(creepage))
        failed += found.outcome != "converged"
        steps += found.steps
    return failed, steps / count


@pytest.mark.slow
def test_weights_decide_over_convergence():
    """No cold start fails with the reciprocal row sums; with 4 over the diagonal more than half of them do."""
    own, steps = _failures(lambda friction: friction.weight)
    assert own == 0
    assert steps < 12
    failed, _ = _failures(lambda friction: 4.0 / np.diag(friction.matrix)[: len(friction.bound)])
    assert failed > 12
