"""Rolling of an elliptical patch: tractions, slip, forces and their derivatives in steady state; changing creepage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from annotated_types import Interval

from infinivar._core.arrays import shown
from infinivar._core.described import at, derived, reported
from infinivar._core.fields import check_number
from infinivar._core.result import Result, result
from infinivar.contact.exact.equations import Equations, equations, totals
from infinivar.contact.exact.grid import CELLS, FEWEST, OF_GRID, Floats, Grid, grid
from infinivar.contact.exact.newton import Change, Outcome, Solution
from infinivar.contact.exact.transient import (
    LONGEST_STEP,
    TransientRolling,
    checked_distances,
    checked_keep,
    checked_series,
    transient,
)
from infinivar.errors import require

_ROUNDING = 1e-6
"""Share of the power of all cells by which their sum may be negative."""

_HALVINGS = 4
"""Times that the step from no creepage to the given one is halved if the iteration does not converge."""


@result
class SteadyRolling(Result):
    """Steady state of one patch. Forces and tractions act on the track: a positive creepage causes a positive force.

    Attributes
    ----------
    outcome : str                 "converged"; "too few cells" where the tractions do not take power from the slip: the moment
        then errs by more than itself, as that by a small spin may on long patches of nearly incompressible material;
        "not converged": then every number is nan.
    fx, fy, mz : float            Forces over mu N, and moment about the normal over mu N c. [-]
    power : float                 Frictional power times G c^2/((mu N)^2 V) with the rolling speed V, from tractions and slip. [-]
    traction : (2, rows, cells)   x and y, times c^2/(mu N). [-]
    slip : (2, rows, cells)       Slip of the wheel on the track in the middle of each cell, times G c^2/(mu N V). [-]
    slides : (rows, cells) bool   Cells on their friction bound.
    grid : Grid                   The cells.
    steps : int                   Newton steps.
    gradient : (3, 3) or None     Derivatives of fx, fy, mz (rows) by longitudinal and lateral creepage and spin, exact for the
        grid, if requested. [-]
    """

    outcome: Outcome = reported(attribute="outcome")
    fx: float = reported("1", dims=(), key="+")
    fy: float = reported("1", dims=(), key="+")
    mz: float = reported("1", dims=(), key="+")
    power: float = reported("1", dims=(), key="+")
    traction: Floats = reported("1", "traction on the track times c^2/(mu N)", ("component", *CELLS))
    slip: Floats = reported("1", "slip of the wheel times G c^2/(mu N V)", ("component", *CELLS))
    slides: np.ndarray = reported("1", "1 on the friction bound", CELLS, convert=np.int8)
    grid: Grid
    steps: int
    gradient: Floats | None = None

    _also = (
        *OF_GRID,
        at("grid.bound", "1", "largest traction times c^2/(mu N)", CELLS),
    )

    @derived("1", "over c^2", CELLS)
    def _area(self) -> Floats:
        return np.broadcast_to(self.grid.area, self.slides.shape)

    @property
    def forces(self) -> Floats:
        """fx, fy and mz, (3,). [-]"""
        return np.array([self.fx, self.fy, self.mz])

    @property
    def slip_share(self) -> float:
        """Fraction of the patch's area that slides, in whole cells. [-]"""
        area = np.broadcast_to(self.grid.area, self.slides.shape)
        return float(area[self.slides].sum() / area.sum())


@dataclass(frozen=True, slots=True)
class RollingPatch:
    """An elliptical patch of two half-spaces of one isotropic material under Hertz pressure, on a grid of cells.

    Creepages are scaled: c = sqrt(a b) is the unit of length, mu N of force, and the shear modulus G of stress, so that a
    creepage is given as G c^2 upsilon/(mu N) and a spin, the relative turning about the normal per distance rolled, as
    G c^3 phi/(mu N). Kalker's linear theory is then fx = C11 upsilon_x, fy = C22 upsilon_y + C23 phi and
    mz = C33 phi - C23 upsilon_y.

    Attributes
    ----------
    a_over_b : float   Semi-axis along the rolling direction over the other, before the turn, 0.05 to 20. [-]
    poisson : float    Poisson ratio, 0 to 0.5. [-]
    turned : float     Angle from the rolling direction to the semi-axis a, positive towards +y. [rad]
    cells : int        Cells in each row; even, 4 to 60. At 20 the forces by creepage err by about 0.002 of mu N, those by a
        large spin by 0.01 on a circle and 0.03 at a/b = 20. There are as many rows, fewer on patches longer than 12 widths.

    Raises
    ------
    ParameterError
        If a value is out of range.

    Source: kalker1990 for the problem; `contact.exact.grid` and `contact.exact.newton` for the method.
    """

    a_over_b: float
    poisson: float = 0.3
    turned: float = 0.0
    cells: int = 20

    def __post_init__(self) -> None:
        """Validate the fields; plain floats serve as keys of the stored grids."""
        check_number("a_over_b", self.a_over_b, "1", Interval(ge=0.05, le=20.0))
        check_number("poisson", self.poisson, "1", Interval(ge=0.0, le=0.5))
        check_number("turned", self.turned, "rad", Interval())
        for name in ("a_over_b", "poisson", "turned"):
            object.__setattr__(self, name, float(getattr(self, name)))
        self.grid  # noqa: B018  Raises if the others are out of range.

    @property
    def grid(self) -> Grid:
        """The cells."""
        return grid(self.a_over_b, self.turned, self.cells)

    def steady(
        self,
        longitudinal: float = 0.0,
        lateral: float = 0.0,
        spin: float = 0.0,
        *,
        start: SteadyRolling | None = None,
        gradient: bool = False,
    ) -> SteadyRolling:
        """Steady state under constant creepages.

        Parameters
        ----------
        longitudinal, lateral, spin : float   Scaled creepages of the wheel on the track. [-]
        start : SteadyRolling                 State to begin with, of any patch; by default that of a coarser grid.
        gradient : bool                       Whether to compute the derivatives of the forces, too.

        Returns
        -------
        SteadyRolling

        Raises
        ------
        ParameterError
            If a creepage is not finite.
        """
        creepage = _checked(longitudinal, lateral, spin)
        require(start is None or isinstance(start, SteadyRolling), "start", shown(start), "a SteadyRolling or None")
        rolling = equations(self.grid, self.poisson, self.grid.symmetric and longitudinal == 0.0)
        if start is None and self.cells >= 2 * FEWEST:
            start = replace(self, cells=self.cells // 4 * 2).steady(*creepage)
        found = rolling.friction.solve(rolling.free_slip(creepage), self._begin(rolling, start))
        if found.outcome != "converged":
            found = _by_steps(rolling, creepage)
        traction, slip = rolling.unfolded(-found.traction), rolling.unfolded(rolling.slip(creepage, found.traction))
        fx, fy, mz = totals(self.grid, traction).tolist()
        taken = self.grid.area * traction * slip
        power, converged = float(np.sum(taken)), found.outcome == "converged"
        return SteadyRolling(
            outcome="too few cells" if power < -_ROUNDING * float(np.sum(np.abs(taken))) else found.outcome,
            fx=fx,
            fy=fy,
            mz=mz,
            power=power,
            traction=traction,
            slip=slip,
            slides=rolling.unfolded_scalar(found.slides),
            grid=self.grid,
            steps=found.steps,
            gradient=self._gradient(rolling, found) if gradient and converged else None,
        )

    def transient(
        self,
        distance: Any,
        longitudinal: Any = 0.0,
        lateral: Any = 0.0,
        spin: Any = 0.0,
        *,
        start: SteadyRolling | TransientRolling | None = None,
        step: float | None = None,
        keep: Sequence[int] = (),
        progress: Callable[[float], None] | None = None,
    ) -> TransientRolling:
        """States while creepages and spin change with the distance rolled.

        Parameters
        ----------
        distance : (n,) float      Distances rolled since the start, increasing from above 0, over c. [-]
        longitudinal, lateral, spin : (n,) or one float   Scaled creepages, each constant from the distance before, or the
            start, to its own. [-]
        start : SteadyRolling or TransientRolling   State of this patch at the distance 0, of the latter the last one; by
            default without traction.
        step : float               Longest step: longer distances are rolled in equal steps. By default an eighth of half of
            the longest row, which is a/8 if the patch is not turned: forces then err by about 0.001 of mu N after jumps of
            creepage and spin. The error falls with the square of the step. [-]
        keep : sequence of int     Indices of the distances whose tractions are kept, besides the last; -2 is the one before it.
        progress : callable        Receives the share done, 0 to 1, after each distance.

        Returns
        -------
        TransientRolling   Constant creepages lead to the state that `steady` finds.

        Raises
        ------
        ParameterError
            If a distance, a creepage or the step is out of range, or `start` is of another patch or has not converged.

        Source: `contact.exact.transient.Path`.
        """
        found = checked_distances(distance)
        count = len(found)
        creepages = {"longitudinal": longitudinal, "lateral": lateral, "spin": spin}
        series = np.stack([checked_series(name, value, count) for name, value in creepages.items()], axis=1)
        longest = LONGEST_STEP / self.grid.reach if step is None else step
        check_number("step", longest, "1", Interval(gt=0.0))
        begin = None if start is None else self._tractions(start)
        return transient(self.grid, self.poisson, found, series, begin, longest, checked_keep(keep, count), progress)

    def _tractions(self, start: SteadyRolling | TransientRolling) -> Floats:
        """Tractions on the track of a state of this patch."""
        is_state = isinstance(start, SteadyRolling | TransientRolling)
        require(is_state, "start", shown(start), "a SteadyRolling, a TransientRolling or None")
        steady = isinstance(start, SteadyRolling)
        theirs, own = ((of.a_over_b, of.turned, of.cells) for of in (start.grid, self.grid))
        require(theirs == own, "start", f"one of {theirs}", f"a state of a patch with a_over_b, turned, cells = {own}")
        outcome = start.outcome if steady else start.outcome[-1]
        require(outcome != "not converged", "start", "one that has not", "a state that has converged")
        return start.traction if steady else start.traction[-1]

    def _begin(self, rolling: Equations, start: SteadyRolling | None) -> Floats | None:
        """Tractions with the shares of the bound that another state has, on whatever grid."""
        if start is None or start.outcome == "not converged":
            return None
        theirs = start.grid.bound.shape
        row, cell = (np.arange(own) * other // own for own, other in zip(self.grid.bound.shape, theirs, strict=True))
        share = (start.traction / start.grid.bound)[:, row[:, None], cell]
        return rolling.folded(-share * self.grid.bound)

    def _gradient(self, rolling: Equations, found: Solution) -> Floats:
        """Derivatives of the forces on the track by the creepages, (3, 3)."""
        whole = equations(self.grid, self.poisson, False)
        traction, slip = (rolling.unfolded(part).reshape(2, -1) for part in (found.traction, found.slip))
        slides = rolling.unfolded_scalar(found.slides).ravel()
        change = Change(whole.friction, traction, slip, slides)
        steps = change.solve(-np.array([change.by_slip(one) for one in whole.ahead]).T)
        return np.array([totals(self.grid, -whole.unfolded(change.tractions(step))) for step in steps.T]).T


def _by_steps(rolling: Equations, creepage: Floats) -> Solution:
    """Solution reached from no creepage in steps, ever shorter ones until all converge."""
    for halving in range(1, _HALVINGS + 1):
        traction = None
        for share in np.linspace(0.0, 1.0, 2**halving + 1)[1:]:
            found = rolling.friction.solve(rolling.free_slip(share * creepage), traction)
            if found.outcome != "converged":
                break
            traction = found.traction
        else:
            break
    return found  # pyright: ignore[reportPossiblyUnboundVariable]


def _checked(*creepages: float) -> Floats:
    """Creepages as an array, all finite."""
    for name, value in zip(("longitudinal", "lateral", "spin"), creepages, strict=True):
        check_number(name, value, "1", Interval())
    return np.array(creepages, dtype=float)
