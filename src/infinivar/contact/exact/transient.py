"""Rolling while creepage and spin change: tractions, forces and energies by distance rolled."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from infinivar._core.arrays import real_array
from infinivar._core.described import derived, reported
from infinivar._core.result import Result, result
from infinivar.contact.exact.equations import Equations, equations, half_cell_displacements, times, totals
from infinivar.contact.exact.grid import CELLS, OF_GRID, Floats, Grid
from infinivar.contact.exact.newton import Friction, Outcome
from infinivar.errors import require

LONGEST_STEP = 0.125
"""Default of the longest step over half of the patch's longest row."""

_STAGE = 1.0 - math.sqrt(0.5)
"""Part of a step that each of its two stages takes, at which the method is of second order and damps what is stiff.

Source: alexander1977, the method of two stages.
"""

_STAGES = ((_STAGE, 1.0 - _STAGE), (_STAGE, _STAGE))
_HALVINGS = 4
"""Times that a step is halved if the iteration does not converge."""


def _converged(outcome: tuple[Outcome, ...]) -> np.ndarray:
    return np.array([one == "converged" for one in outcome], np.int8)


@result
class TransientRolling(Result):
    """States of one patch by distance rolled. Forces and tractions act on the track, as in `SteadyRolling`.

    Attributes
    ----------
    distance : (n,)               Distance rolled since the start, over c. [-]
    fx, fy, mz : (n,)             Forces over mu N, and moment about the normal over mu N c. [-]
    energy : (n,)                 Elastic energy stored by the tractions, times G c/(mu N)^2: half of the tractions times the
        displacements, these averaged over half cells as slip is. [-]
    work : (n,)                   Work of the creepages against forces and moment since the start, in the same unit. [-]
    dissipated : (n,)             Energy dissipated by slip since the start, from tractions and slip in the middle of each cell,
        the mean of that half a cell ahead and behind. It never falls. [-]
    outcome : (n,) of str         "converged", or "not converged": from then on every number is nan.
    start_energy : float          Elastic energy at the start. [-]
    kept : (m,) int               Indices of the distances whose tractions are kept; the last is always kept.
    traction : (m, 2, rows, cells)    x and y, times c^2/(mu N). [-]
    slip : (m, 2, rows, cells)    Slip of the wheel on the track per distance rolled, times G c^2/(mu N). [-]
    slides : (m, rows, cells) bool    Cells on their friction bound.
    grid : Grid                   The cells.
    steps : int                   Newton steps.
    """

    distance: Floats = reported("1", "distance rolled over c", ("distance",))
    fx: Floats = reported("1", dims=("distance",))
    fy: Floats = reported("1", dims=("distance",))
    mz: Floats = reported("1", dims=("distance",))
    energy: Floats = reported("1", dims=("distance",))
    work: Floats = reported("1", dims=("distance",))
    dissipated: Floats = reported("1", dims=("distance",))
    outcome: tuple[Outcome, ...] = reported("1", dims=("distance",), variable="converged", convert=_converged)
    start_energy: float = reported("1", attribute="start_energy")
    kept: np.ndarray
    traction: Floats = reported("1", "traction on the track times c^2/(mu N)", ("kept", "component", *CELLS))
    slip: Floats = reported("1", "slip of the wheel per distance times G c^2/(mu N)", ("kept", "component", *CELLS))
    slides: np.ndarray = reported("1", "1 on the friction bound", ("kept", *CELLS), convert=np.int8)
    grid: Grid
    steps: int

    _also = OF_GRID

    @derived("1", "distance rolled over c", ("kept",), variable="kept")
    def _kept_distance(self) -> Floats:
        return self.distance[self.kept]

    @property
    def balance(self) -> Floats:
        """Work that is neither stored nor dissipated, (n,): the error of the grid and the steps. [-]"""
        return self.work - (self.energy - self.start_energy) - self.dissipated


class State(NamedTuple):
    """Tractions at the end of a step, and the energies until then. Tractions act on the wheel."""

    traction: Floats
    slip: Floats
    slides: np.ndarray
    work: float
    dissipated: float


class Path:
    r"""Equations of one patch for steps along its path.

    In a frame that moves with the patch, a particle of the surfaces moves backwards by the distance rolled, s, so that slip is

    .. math:: S = w + \frac{\partial u}{\partial s} - \frac{\partial u}{\partial x}

    with the slip w of rigid bodies and the difference u of the surfaces' displacements. A stage of a step that ends with
    tractions p has

    .. math:: S = w + C p + U (p - p_0)/\delta ,

    half a cell ahead of each cell, with C of the steady problem, displacements U by tractions at those places, and the
    tractions p0 and distance of the stage. Without a change of p it is the steady problem. A step of length h is two such
    stages, both with :math:`\delta = \gamma h, \gamma = 1 - 1/\sqrt2`: the first from the tractions at the start, the second from
    those extrapolated from start and first stage by :math:`(1-\gamma)/\gamma`.

    Source: kalker1990 for the problem; alexander1977 for the stages.
    """

    def __init__(self, grid: Grid, poisson: float, mirrored: bool) -> None:
        """Of all cells or, for a mirrored state, of one half."""
        self.rolling: Equations = equations(grid, poisson, mirrored)
        self.ahead, behind = half_cell_displacements(grid, poisson, mirrored)
        self.mean = 0.5 * (self.ahead + behind)
        self.bound = grid.bound[grid.counted(mirrored)]
        whole = np.broadcast_to(grid.area, grid.x.shape)
        self.area = (2.0 if mirrored else 1.0) * whole[grid.counted(mirrored)].ravel()
        self.steps = 0
        self._friction: tuple[float, Friction] | None = None

    def energy(self, traction: Floats) -> float:
        """Elastic energy stored."""
        return 0.5 * float(np.sum(self.area * np.sum(traction * times(self.mean, traction), axis=0)))

    def advance(self, state: State, creepage: Floats, length: float, halvings: int = _HALVINGS) -> State | None:
        """State after a step under constant creepages, in parts if need be; None if even short ones do not converge."""
        found = self._step(state, creepage, length)
        if found is not None or halvings == 0:
            return found
        middle = self.advance(state, creepage, 0.5 * length, halvings - 1)
        return None if middle is None else self.advance(middle, creepage, 0.5 * length, halvings - 1)

    def _step(self, state: State, creepage: Floats, length: float) -> State | None:
        """State after both stages of a step."""
        rolling, before, found = self.rolling, state.traction, state
        work, dissipated = state.work, state.dissipated
        origin = before
        for part, weight in _STAGES:
            distance = part * length
            free = rolling.free_slip(creepage) - times(self.ahead, origin) / distance
            solution = self._frictional(distance).solve(free, found.traction)
            self.steps += solution.steps
            if solution.outcome != "converged":
                return None
            traction = solution.traction
            slip = rolling.slip(creepage, traction) + times(self.mean, traction - origin) / distance
            force = totals(rolling.grid, rolling.unfolded(-traction))
            work += weight * length * float(creepage @ force)
            # Slip at the trailing edge opposes no traction if the last cell sticks, as for some cells after a reversal.
            power = np.maximum(-np.sum(traction * slip, axis=0), 0.0)
            dissipated += weight * length * float(self.area @ power)
            found = State(traction, slip, solution.slides, work, dissipated)
            origin = before + (1.0 - _STAGE) / _STAGE * (traction - before)
        return found

    def _frictional(self, distance: float) -> Friction:
        """Friction with the slip of a stage; kept for stages of the same length."""
        if self._friction is None or self._friction[0] != distance:
            matrix = self.rolling.influence.ahead + self.ahead / distance
            self._friction = distance, Friction.of(matrix, self.bound)
        return self._friction[1]


def transient(
    grid: Grid,
    poisson: float,
    distance: Floats,
    creepage: Floats,
    start: Floats | None,
    step: float,
    keep: Sequence[int],
    progress: Callable[[float], None] | None,
) -> TransientRolling:
    """States at the given distances; see `RollingPatch.transient`.

    Parameters
    ----------
    grid, poisson         Of the patch.
    distance : (n,)       Increasing from above 0. [-]
    creepage : (n, 3)     Until each distance. [-]
    start : (2, rows, cells)   Tractions on the track at the distance 0; none by default. [-]
    step : float          Longest step. [-]
    keep, progress        As for `RollingPatch.transient`.

    Returns
    -------
    TransientRolling
    """
    begin = np.zeros((2, *grid.x.shape)) if start is None else -start
    path = Path(grid, poisson, grid.symmetric and not np.any(creepage[:, 0]) and _mirrored(begin))
    rolling = path.rolling
    traction = rolling.folded(begin)
    nothing = np.zeros(traction.shape[1], dtype=bool)
    start_energy = path.energy(traction)
    state = State(traction, np.zeros_like(traction), nothing, 0.0, 0.0)
    unknown = np.full_like(traction, np.nan)
    missing = State(unknown, unknown, nothing, math.nan, math.nan)
    kept = sorted({int(index) % len(distance) for index in (*keep, -1)})
    rows, shown = [], {}
    outcome: list[Outcome] = []
    for index, length in enumerate(np.diff(distance, prepend=0.0).tolist()):
        state = _after(path, state, creepage[index], length, step)
        outcome.append("not converged" if state is None else "converged")
        last = missing if state is None else state
        on_track = rolling.unfolded(-last.traction)
        rows.append([*totals(grid, on_track), path.energy(last.traction), last.work, last.dissipated])
        if index in kept:
            shown[index] = on_track, rolling.unfolded(last.slip), rolling.unfolded_scalar(last.slides)
        if progress is not None:
            progress((index + 1) / len(distance))
    fx, fy, mz, energy, work, dissipated = np.array(rows).T
    tractions, slips, slides = (np.array(part) for part in zip(*shown.values(), strict=True))
    return TransientRolling(
        distance=distance,
        fx=fx,
        fy=fy,
        mz=mz,
        energy=energy,
        work=work,
        dissipated=dissipated,
        outcome=tuple(outcome),
        start_energy=start_energy,
        kept=np.array(kept),
        traction=tractions,
        slip=slips,
        slides=slides,
        grid=grid,
        steps=path.steps,
    )


def _after(path: Path, state: State | None, creepage: Floats, length: float, step: float) -> State | None:
    """State after a distance in equal steps not longer than `step`; None after a state that was not found."""
    count = max(1, math.ceil(length / step * (1.0 - 1e-9)))
    # Differences of equally spaced distances differ by rounding; equal steps share their matrices.
    part = float(f"{length / count:.12g}")
    for _ in range(count):
        if state is not None:
            state = path.advance(state, creepage, part)
    return state


def _mirrored(traction: Floats) -> bool:
    """Whether the half y < 0 mirrors the other, as without longitudinal creepage."""
    x, y = traction
    return np.array_equal(x, -x[::-1]) and np.array_equal(y, y[::-1])


def checked_distances(distance: object) -> Floats:
    """Distances as an array, which must increase from above 0."""
    found = np.atleast_1d(real_array("distance", distance))
    fits = found.ndim == 1 and found.size > 0 and bool(np.all(np.isfinite(found)))
    fits = fits and bool(np.all(np.diff(found, prepend=0.0) > 0.0))
    require(fits, "distance", _shortened(found), "a list of finite distances that increase, the first above 0")
    return found


def checked_series(name: str, value: object, count: int) -> Floats:
    """A creepage until each of several distances, from one value or as many."""
    found = real_array(name, value)
    fits = found.shape in ((), (count,)) and bool(np.all(np.isfinite(found)))
    require(fits, name, _shortened(found), f"one finite value, or {count}: one until each distance")
    return np.broadcast_to(found, count)


def checked_keep(keep: Sequence[int], count: int) -> Sequence[int]:
    """Indices of distances."""
    require(isinstance(keep, Iterable), "keep", repr(keep), f"indices of the {count} distances")
    for index in keep:
        fits = not isinstance(index, bool) and isinstance(index, int | np.integer) and -count <= index < count
        require(fits, "keep", index, f"indices of the {count} distances")
    return keep


def _shortened(values: Floats) -> str:
    return np.array2string(values, threshold=6, edgeitems=2, separator=", ")
