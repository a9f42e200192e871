"""Which creep law a rig's data prefer, by how much, and what that leaves open in the parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from infinivar._core.result import Frozen, result
from infinivar.calibration.fit import Fit, Robust, estimate, robust, settled
from infinivar.calibration.problem import Problem
from infinivar.contact import creep

DECIDED = 10.0
"""Chi-square by which every other law must be worse for one to be preferred: odds of 150 to 1.

With normal errors the wrong one of two laws gets there in one session of 1300 at most, however well or badly the runs
tell the two apart: the difference is normal, with the mean d^2 and the deviation 2 d of readings d deviations apart.
"""

LAW_ERROR = 0.15
"""Relative standard deviation of how far a bent law departs from the linear one.

Fitted to the curves of exact rolling theory from 8 to 75 % of slip, the shipped laws that bend do so by 7 to 30 % too
much or too little: vermeulen-johnson and fastsim 0.14 in the mean, with polach 0.18.
"""

_FREE = 1.0
"""The same where no law fits: the data alone say how much the creep bends."""

_MOST_TRIED = 3
"""Laws under which outliers are looked for; the second is nearly always the last."""


@result
class Candidate(Frozen):
    """A creep law held against the data.

    Attributes
    ----------
    law : its name.
    fit : with this law alone, as if it were exact, to the runs that all laws are fitted to.
    behind : chi-square above that of the best law, in units of what the residuals are widened by. [-]
    """

    law: str
    fit: Fit
    behind: float


@result
class LawChoice(Frozen):
    """What the data say about the creep law.

    Attributes
    ----------
    candidates : the best first.
    asked : law of the study.
    fit : estimates with the law that is used, intervals with what the law leaves open.
    design : fit from which runs to make next follow: its law may bend more or less.
    gain : chi-square by which the best law fits better once its bend is left free. [-]
    """

    candidates: tuple[Candidate, ...]
    asked: str
    fit: Fit
    design: Fit
    gain: float

    @property
    def best(self) -> Candidate:
        """The law with the least chi-square."""
        return self.candidates[0]

    @property
    def undecided(self) -> tuple[str, ...]:
        """Laws between which the data do not decide, the best first; one if they do."""
        return tuple(candidate.law for candidate in self.candidates if candidate.behind < DECIDED)

    @property
    def contradicted(self) -> bool:
        """Whether the data speak against the study's law, or it was not held against them."""
        return self.asked not in self.undecided

    @property
    def alone(self) -> Fit:
        """Fit with the law that is used as if it were exact."""
        return next(candidate.fit for candidate in self.candidates if candidate.law == self.fit.law)

    @property
    def misfit(self) -> bool:
        """Whether no law fits as it stands: the best fits better once it may bend more or less, as clearly as laws are
        told apart, or leaves residuals larger than the sensors explain."""
        return self.gain >= DECIDED or self.best.fit.widened > 1.0


def screen(problem: Problem, laws: Sequence[str] | None = None) -> tuple[Robust, dict[str, Fit]]:
    """Find the outliers by a robust fit for each creep law, and fit every law without them.

    Parameters
    ----------
    problem : Problem   With the study's law.
    laws : sequence     Names of the candidates: all there are, or the study's alone where the creep stiffness is not
        fitted, as its error would pass for another law.

    Returns
    -------
    best : Robust       Of the law that fits best without outliers, its bend left free, so that runs which contradict the
        law alone are none.
    fits : dict         By law, the best first.
    """
    if laws is None:
        laws = tuple(creep.LAWS) if "creep_stiffness" in problem.names else (problem.law,)
    found = {law: robust(problem.under(law)) for law in laws}
    starts = {law: found[law].unknowns for law in sorted(found, key=lambda law: found[law].cost)}
    best, fits, tried = next(iter(found.values())), {}, set()
    # Outliers may have made another law look best: that which fits best without them finds them anew.
    while (law := next(iter(starts))) not in tried and len(tried) < _MOST_TRIED:
        tried.add(law)
        best, beside = found[law], _beside(law, tuple(starts))
        if beside is not None:
            best = robust(best.problem.bending(beside, _FREE), np.append(starts[law], 0.0))
        best = settled(best)
        fits = _ranked(estimate(problem.under(name), start, best.beyond) for name, start in starts.items())
        starts = {name: fit.unknowns for name, fit in fits.items()}
    return best, fits


def _ranked(fits: Iterable[Fit]) -> dict[str, Fit]:
    return {fit.law: fit for fit in sorted(fits, key=lambda fit: fit.chi_square)}


def choose(problem: Problem, fits: Mapping[str, Fit], outliers: np.ndarray) -> LawChoice:
    r"""Hold the creep laws, fitted to the same runs, against one another, and say what they decide.

    Laws have the same number of parameters, so differences of chi-square are those of Akaike's criterion, and
    :math:`\exp(-\Delta/2)` is the likelihood of a law over that of the best. Where the residuals are larger than the
    sensors explain, :math:`\Delta` counts in units of what they are widened by.

    The law used is the study's if the data leave it open, else the best. With Akaike's weights w of the laws left open,
    the covariance about the values of the law used is the mean square over the laws,

    .. math:: \Sigma = \sum_i w_i \left(\Sigma_i + (\theta_i - \theta)(\theta_i - \theta)^T\right),

    in which each law that bends does so with the relative deviation `LAW_ERROR`, since none is exact. Where the best law
    fits better with its bend left free by `DECIDED`, the bend is free in all.

    Parameters
    ----------
    problem : Problem       With the study's law.
    fits : mapping          By law, as `screen` found them; fitted again where the outliers are others.
    outliers : (n,) bool    Runs that are left out.

    Returns
    -------
    LawChoice

    Source: burnham2002, sections 2.9 (weights), 2.5 (overdispersion) and 4.3 (averaging), about the values of the law used.
    """
    rows = tuple(np.flatnonzero(outliers).tolist())
    fits = _ranked(
        fit if fit.outliers == rows else estimate(problem.under(law), fit.unknowns, outliers)
        for law, fit in fits.items()
    )
    ranked = tuple(fits)
    best = fits[ranked[0]]
    unit = best.widened**2
    candidates = tuple(
        Candidate(law=law, fit=fit, behind=(fit.chi_square - best.chi_square) / unit) for law, fit in fits.items()
    )
    gain = 0.0
    beside = _beside(best.law, ranked)
    if beside is not None:
        freed = _bent(best, beside, _FREE)
        gain = (best.chi_square - (freed.chi_square - float(freed.unknowns[-1]) ** 2)) / unit
    left = [candidate for candidate in candidates if candidate.behind < DECIDED]
    used = next((candidate.fit for candidate in left if candidate.law == problem.law), best)
    weights = np.exp([-0.5 * candidate.behind for candidate in left])
    covariance = np.zeros_like(used.covariance)
    design = used
    for candidate, weight in zip(left, weights / weights.sum(), strict=True):
        fit = _with_error(candidate.fit, ranked, free=gain >= DECIDED)
        design = fit if candidate.fit is used else design
        apart = np.asarray([fit.values[name] - used.values[name] for name in used.names])
        covariance += weight * (fit.covariance + np.outer(apart, apart))
    return LawChoice(
        candidates=candidates, asked=problem.law, fit=replace(used, covariance=covariance), design=design, gain=gain
    )


def _beside(law: str, ranked: Sequence[str]) -> str | None:
    """The law from which a law's bend is counted: the linear one, or for a straight law the best that bends."""
    if creep.LAWS[law].straight:
        return next((other for other in ranked if not creep.LAWS[other].straight), None)
    return "linear"


def _with_error(fit: Fit, ranked: Sequence[str], *, free: bool) -> Fit:
    """The fit with what is not known of its law: a straight one has no bend to be in doubt about, unless no law fits."""
    beside = _beside(fit.law, ranked)
    if beside is None or (creep.LAWS[fit.law].straight and not free):
        return fit
    return _bent(fit, beside, _FREE if free else LAW_ERROR)


def _bent(fit: Fit, beside: str, deviation: float) -> Fit:
    problem = fit.problem.bending(beside, deviation)
    return estimate(problem, np.append(fit.unknowns, 0.0), np.zeros(len(problem.data), dtype=bool))
