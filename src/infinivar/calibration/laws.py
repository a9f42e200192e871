"""Select a creep law from rig data, and include its uncertainty in the parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from operator import not_

import numpy as np

from infinivar._core.described import at, derived, reported
from infinivar._core.result import Frozen, result
from infinivar.calibration.fit import Fit, Robust, estimate, robust, settled
from infinivar.calibration.problem import Problem
from infinivar.contact import creep
from infinivar.drivetrain.cobotic import CoboticDrive

DECIDED = 10.0
"""Chi-square difference at which the worse law is excluded: odds of 150 to 1.

With normal errors, the wrong one of two laws is preferred in at most one session of 1300, however well the runs discriminate:
the difference is normal with mean d^2 and deviation 2 d, for readings d standard deviations apart.
"""

LAW_ERROR = 0.15
"""Relative standard deviation of the departure of a curved law from the linear one.

Fitted to exact rolling theory from 8 to 75 % of slip, the curved laws have a curvature 7 to 30 % too large or too small: 0.14
on average for vermeulen-johnson and fastsim, 0.18 with polach.
"""

FITTED_LAW_ERROR = 0.01
"""The same for a law fitted to exact rolling theory on the shape of the patch."""

_FREE = 1.0
"""The same if no law fits: the data alone determine the curvature."""

_MOST_TRIED = 3
"""Largest number of laws with which outliers are sought; two nearly always suffice."""


@result
class Candidate(Frozen):
    """A creep law fitted to the data.

    Attributes
    ----------
    law : name of the law.
    fit : fit with this law taken as exact, to the same runs as the other laws.
    behind : chi-square above that of the best law, divided by the square of the widening factor. [-]
    """

    law: str = reported()
    fit: Fit
    behind: float = reported("1", key="worse_by")

    _also = (at("fit.chi_square"), at("fit.values"))


@result
class LawChoice(Frozen):
    """Result of the selection of a creep law.

    Attributes
    ----------
    candidates : candidate laws, best first.
    of_study : its creep law.
    fit : estimates with the law used; intervals include the uncertainty of the law.
    design : fit for the choice of the next runs, with uncertain curvature.
    gain : reduction of the best law's chi-square with free curvature. [-]
    """

    candidates: tuple[Candidate, ...] = reported(key="laws")
    of_study: str = reported(key="study")
    fit: Fit
    design: Fit
    gain: float = reported("1", key="gain_of_free_bend")

    _also = (at("fit.law", key="fitted"), at("misfit", key="fits", convert=not_))

    @property
    def best(self) -> Candidate:
        """The law with the lowest chi-square."""
        return self.candidates[0]

    def candidate(self, law: str) -> Candidate | None:
        """The candidate of that law, if it was one."""
        return next((one for one in self.candidates if one.law == law), None)

    @property
    def left(self) -> tuple[str, ...]:
        """Laws that the data do not exclude, best first."""
        return tuple(candidate.law for candidate in self.candidates if candidate.behind < DECIDED)

    @derived()
    def undecided(self) -> tuple[str, ...]:
        """Of `left`, the rivals: those that approximate no other of them."""
        return rivals(self.left)

    @derived()
    def agreeing(self) -> tuple[str, ...]:
        """Of `left`, the approximations of another of them, which the data cannot tell from it."""
        return tuple(law for law in self.left if law not in self.undecided)

    @derived()
    def contradicted(self) -> bool:
        """Whether the data exclude the study's law, or it was not a candidate."""
        return self.of_study not in self.left

    @property
    def alone(self) -> Fit:
        """Fit with the law used, taken as exact."""
        return next(candidate.fit for candidate in self.candidates if candidate.law == self.fit.law)

    @property
    def misfit(self) -> bool:
        """Whether no law fits as published: free curvature improves the best fit by at least `DECIDED`, or its residuals
        exceed the sensor errors."""
        return self.gain >= DECIDED or self.best.fit.widened > 1.0


def rivals(laws: Sequence[str]) -> tuple[str, ...]:
    """The laws that approximate no other of them.

    A law and its approximation have the same unknowns and the same linear limit, and the law is never the worse description of
    a patch: where data cannot tell them apart, both answers are one, and their difference belongs into the intervals.
    """
    return tuple(law for law in laws if creep.LAWS[law].approximates not in laws)


def usual(problem: Problem) -> tuple[str, ...]:
    """Names of the laws to compare: all, but those of a patch only if the study has its geometry, or as the study's own law.

    The study's law alone if the creep stiffness is not fitted, as an error in the stiffness would be mistaken for another law.
    """
    if "creep_stiffness" not in problem.names:
        return (problem.law,)
    patch = problem.drive.transmission.contact is not None
    return tuple(name for name, law in creep.LAWS.items() if patch or law.on_patch is None or name == problem.law)


def screen(problem: Problem, laws: Sequence[str] | None = None) -> tuple[Robust, dict[str, Fit]]:
    """Find the outliers by a robust fit for each creep law, and fit every law without them.

    Parameters
    ----------
    problem : Problem   Problem with the study's law.
    laws : sequence     Names of the candidates. None for `usual`.

    Returns
    -------
    best : Robust       Robust fit of the best law with free curvature, so that runs that only contradict the law are no
        outliers.
    fits : dict         Fits by law, best first.
    """
    laws = usual(problem) if laws is None else laws
    found = {law: robust(under(problem, law)) for law in laws}
    starts = {law: found[law].unknowns for law in sorted(found, key=lambda law: found[law].cost)}
    best, fits, tried = next(iter(found.values())), {}, set()
    # Outliers may favour the wrong law, so find them again with the law that fits best without them.
    while (law := next(iter(starts))) not in tried and len(tried) < _MOST_TRIED:
        tried.add(law)
        best, beside = found[law], _beside(law, tuple(starts))
        if beside is not None:
            best = robust(_bending(best.problem, beside, _FREE), np.append(starts[law], 0.0))
        best = settled(best)
        fits = _ranked(estimate(under(problem, name), start, best.beyond) for name, start in starts.items())
        starts = {name: fit.unknowns for name, fit in fits.items()}
    return best, fits


def _ranked(fits: Iterable[Fit]) -> dict[str, Fit]:
    return {fit.law: fit for fit in sorted(fits, key=lambda fit: fit.chi_square)}


def choose(problem: Problem, fits: Mapping[str, Fit], outliers: np.ndarray) -> LawChoice:
    r"""Compare creep laws fitted to the same runs, and combine those not excluded.

    All laws have the same number of parameters, so differences of chi-square equal those of Akaike's criterion, and
    :math:`\exp(-\Delta/2)` is the likelihood of a law relative to the best. If the residuals exceed the sensor errors,
    :math:`\Delta` is divided by the square of the widening factor.

    The law used is the study's if the data do not exclude it, else the best of those left that approximates no other of them.
    With Akaike weights w of the laws not excluded, the covariance about the values of the law used is the mean square over them,

    .. math:: \Sigma = \sum_i w_i \left(\Sigma_i + (\theta_i - \theta)(\theta_i - \theta)^T\right),

    in which the curvature of each curved law has the relative deviation `LAW_ERROR`, since no law is exact. If free curvature
    improves the best fit by at least `DECIDED`, the curvature is free in all laws.

    Parameters
    ----------
    problem : Problem       Problem with the study's law.
    fits : mapping          Fits by law from `screen`; repeated if the outliers differ.
    outliers : (n,) bool    Excluded runs.

    Returns
    -------
    LawChoice

    Source: burnham2002, sections 2.9 (weights), 2.5 (overdispersion) and 4.3 (averaging), about the values of the law used.
    """
    rows = tuple(np.flatnonzero(outliers).tolist())
    fits = _ranked(
        fit if fit.outliers == rows else estimate(under(problem, law), fit.unknowns, outliers)
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
    names = tuple(candidate.law for candidate in left)
    used = fits[problem.law if problem.law in names else rivals(names)[0]]
    weights = np.exp([-0.5 * candidate.behind for candidate in left])
    covariance = np.zeros_like(used.covariance)
    design = used
    for candidate, weight in zip(left, weights / weights.sum(), strict=True):
        fit = _with_error(candidate.fit, ranked, free=gain >= DECIDED)
        design = fit if candidate.fit is used else design
        apart = np.asarray([fit.values[name] - used.values[name] for name in used.names])
        covariance += weight * (fit.covariance + np.outer(apart, apart))
    return LawChoice(
        candidates=candidates, of_study=problem.law, fit=replace(used, covariance=covariance), design=design, gain=gain
    )


def _beside(law: str, ranked: Sequence[str]) -> str | None:
    """Reference law for the curvature: the linear law, or for a straight law the best curved one."""
    if creep.LAWS[law].straight:
        return next((other for other in ranked if not creep.LAWS[other].straight), None)
    return "linear"


def _with_error(fit: Fit, ranked: Sequence[str], *, free: bool) -> Fit:
    """The fit with the error of its law; a straight law has no curvature error unless no law fits."""
    beside = _beside(fit.law, ranked)
    if beside is None or (creep.LAWS[fit.law].straight and not free):
        return fit
    return _bent(fit, beside, _FREE if free else curvature_error(fit.law))


def curvature_error(law: str) -> float:
    """Relative standard deviation of the curvature of a curved law. [-]"""
    return LAW_ERROR if creep.LAWS[law].on_patch is None else FITTED_LAW_ERROR


def _bent(fit: Fit, beside: str, deviation: float) -> Fit:
    problem = _bending(fit.problem, beside, deviation)
    return estimate(problem, np.append(fit.unknowns, 0.0), np.zeros(len(problem.data), dtype=bool))


def under(problem: Problem, law: str) -> Problem:
    """The problem with another creep law and the same weights."""
    return problem.under(_with_law(problem.drive, law))


def _bending(problem: Problem, beside: str, deviation: float) -> Problem:
    """The problem with an uncertain curvature of its law: creep varies by a share of its difference from another law."""
    return problem.bending(_with_law(problem.drive, beside), deviation)


def _with_law(drive: CoboticDrive, law: str) -> CoboticDrive:
    return replace(drive, transmission=replace(drive.transmission, creep_law=law))
