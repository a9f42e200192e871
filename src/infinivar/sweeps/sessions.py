"""Sweep over measuring sessions on a virtual rig: how well a rig and a protocol would determine the parameters of a drive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from infinivar._core.described import reported
from infinivar._core.result import Frozen, Result, result
from infinivar.calibration import transmission
from infinivar.calibration.calibrate import calibrate_cobotic
from infinivar.calibration.fit import Fit
from infinivar.calibration.options import LOADS, RATIOS
from infinivar.calibration.result import cobotic
from infinivar.calibration.virtual_rig import Setting, experiment, protocol
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import InputError, require
from infinivar.study.check import check_study
from infinivar.study.spreads import NORMAL_95
from infinivar.study.study import Study
from infinivar.sweeps.fingerprint import fingerprint
from infinivar.sweeps.problem import CANDIDATES, Chunk, Problem
from infinivar.sweeps.sweep import Sweep, check_finished
from infinivar.units import plain, show

SESSIONS = 1000
SIZE = 20
_ERROR, _DEVIATION, _SUM = "error: ", "deviation: ", " + "


@result
class Determined(Frozen):
    """How well many sessions determine a parameter, or a sum of parameters that no session identifies separately.

    Attributes
    ----------
    name          As `calibrate` names it.
    identifiable  Share of sessions in which it is identifiable. [-]
    bias          Mean of the estimates of these sessions, less the truth. [SI]
    scatter       Standard deviation of the estimates. [SI]
    stated        Root mean square of the standard deviations that the fits state. [SI]
    covered       Share of the 95 % intervals that contain the truth; nan if it is identifiable in no session. [-]
    unit          SI unit.
    """

    name: str
    identifiable: float = reported()
    bias: float = reported()
    scatter: float = reported()
    stated: float = reported()
    covered: float = reported()
    unit: str = reported()

    @property
    def verdict(self) -> str:
        """One line."""
        if not self.identifiable:
            return "not identifiable by itself"
        bias, scatter, stated = (show(value, self.unit, 2) for value in (self.bias, self.scatter, self.stated))
        often = (
            ""
            if self.identifiable == 1.0
            else f"; identifiable in {plain(100.0 * self.identifiable, 3)} % of the sessions"
        )
        return (
            f"bias {bias}, scatter {scatter}, stated {stated}; {plain(100.0 * self.covered, 3)} % of the 95 % intervals "
            f"contain the truth{often}"
        )


@result
class Sessions(Result):
    """Calibrations of many sessions.

    Attributes
    ----------
    sessions       Number of sessions.
    refused        Of these, sessions whose data `calibrate` refuses.
    laws           Number of sessions by the creep law that was fitted.
    parameters     By name: those requested, and their sums, such as "rolling_torque + bearing_torque".
    """

    sessions: int = reported()
    refused: int = reported()
    laws: Mapping[str, int] = reported()
    parameters: Mapping[str, Determined] = reported()

    @property
    def verdict(self) -> str:
        """One line on the sessions."""
        laws = ", ".join(f"{name} {number}" for name, number in self.laws.items())
        refused = f", {self.refused} refused" if self.refused else ""
        return f"{self.sessions} sessions{refused}; creep law fitted: {laws or 'none'}"

    def _rows(self) -> Any:
        yield "verdict", self.verdict
        for name, one in self.parameters.items():
            yield name, one.verdict


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SessionsSweep(Problem):
    """Sessions by their number, which is the seed of their errors: those of the command `rig` with that seed, in steady state.

    Attributes
    ----------
    study       With the drive, taken as true, and the rig.
    drive       Name of the drive.
    settings    Runs of each session.
    fitted      Parameters to fit.
    creep_laws  Candidates; None for those that `calibrate` takes.
    sessions    Number of sessions.
    size        Sessions in a chunk.
    """

    kind: ClassVar[str] = "sessions"
    study: Study
    drive: str
    settings: tuple[Setting, ...]
    fitted: tuple[str, ...] = transmission.USUAL
    creep_laws: tuple[str, ...] | None = None
    sessions: int = SESSIONS
    size: int = SIZE

    @property
    def title(self) -> str:
        """See `Problem`."""
        return f"{self.study.name}, sessions with {self.drive}"

    @property
    def chunks(self) -> int:
        """See `Problem`."""
        return -(-self.sessions // self.size)

    @property
    def identity(self) -> Mapping[str, Any]:
        """See `Problem`."""
        return {
            "study": self.study.name,
            "drive": self.drive,
            "values of the drive": fingerprint(self.study.drives[self.drive]),
            "rig": fingerprint(self.study.rig),
            "runs of a session": fingerprint(self.settings),
            "parameters": list(self.fitted),
            "creep laws": None if self.creep_laws is None else list(self.creep_laws),
            "sessions": self.sessions,
            "sessions in a chunk": self.size,
        }

    def run(self, number: int) -> Chunk:
        """See `Problem`."""
        seeds = range(number * self.size, min((number + 1) * self.size, self.sessions))
        true, laws, found = transmission.known_values(self._true), [], []
        for seed in seeds:
            data = experiment(self._true, self.study.rig, self.settings, seed=seed, simulated=False).data
            try:
                made = calibrate_cobotic(
                    self.study, self.drive, data, parameters=self.fitted, creep_laws=self.creep_laws
                )
            except InputError:
                laws.append("")
                found.append({})
                continue
            laws.append(made.fit.law)
            found.append(_errors(made.fit, true))
        names = [*self.fitted, *sorted({name for one in found for name in one} - {*self.fitted})]
        nothing = np.nan, np.nan
        rows: dict[str, np.ndarray] = {"session": np.array(seeds), "law": np.array(laws, dtype=str)}
        for name in names:
            rows[f"{_ERROR}{name}"], rows[f"{_DEVIATION}{name}"] = np.array([one.get(name, nothing) for one in found]).T
        return Chunk(rows, {CANDIDATES: len(seeds), "refused": laws.count("")})

    def result(self, sweep: Sweep) -> Sessions:
        """What the sessions tell.

        Raises
        ------
        InputError
            If the sweep is not finished.
        """
        check_finished(sweep)
        rows = sweep.rows
        laws, number = np.unique(rows["law"][rows["law"] != ""], return_counts=True)
        names = [column.removeprefix(_ERROR) for column in rows if column.startswith(_ERROR)]
        return Sessions(
            sessions=sweep.candidates,
            refused=int(np.sum(rows["law"] == "")),
            laws=dict(zip(laws.tolist(), number.tolist(), strict=True)),
            parameters={
                name: _determined(name, rows[f"{_ERROR}{name}"], rows[f"{_DEVIATION}{name}"]) for name in names
            },
        )

    @property
    def _true(self) -> CoboticDrive:
        return cobotic(self.study, self.drive)


def _errors(fit: Fit, true: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """Error and stated deviation of each identifiable parameter or sum, by name. [SI]"""
    found = {name: (fit.values[name] - true[name], fit.deviations[name]) for name in fit.identifiable}
    for one in fit.combinations:
        truth = sum(weight * true[name] for name, weight in one.weights.items())
        found[_SUM.join(one.weights)] = one.value - truth, one.deviation
    return found


def _determined(name: str, errors: np.ndarray, deviations: np.ndarray) -> Determined:
    """Statistics of the errors of an estimate; nan in sessions in which it is not identifiable."""
    identifiable = np.isfinite(errors)
    off, stated = errors[identifiable], deviations[identifiable]
    some = bool(identifiable.any())
    return Determined(
        name=name,
        identifiable=float(identifiable.mean()),
        bias=float(off.mean()) if some else np.nan,
        scatter=float(off.std()) if some else np.nan,
        stated=float(np.sqrt(np.mean(stated**2))) if some else np.nan,
        covered=float(np.mean(np.abs(off) <= NORMAL_95 * stated)) if some else np.nan,
        unit=transmission.PARAMETERS[name.partition(_SUM)[0]].unit,
    )


def sessions_sweep(
    study: Study,
    drive: str,
    *,
    ratios: Sequence[float] = RATIOS,
    loads: Sequence[float] = LOADS,
    preloads: Sequence[float] = (1.0,),
    parameters: Sequence[str] = transmission.USUAL,
    creep_laws: Sequence[str] | None = None,
    sessions: int = SESSIONS,
    size: int = SIZE,
) -> SessionsSweep:
    """Prepare calibrations of many sessions on a virtual rig as a sweep.

    The drive of the study is taken as true. Each session has other errors of sensors and settings, within the deviations of the
    study's rig, and is calibrated as measured data would be.

    Parameters
    ----------
    study : Study               With the rig.
    drive : str                 Name of a cobotic drive.
    ratios, loads, preloads     Runs of a session, as for `virtual_rig.protocol`.
    parameters, creep_laws      As for `calibrate`.
    sessions : int              Number of sessions.
    size : int                  Sessions in a chunk.

    Raises
    ------
    InputError
        If the drive does not exist or has no wheel, a number is out of range, or a parameter or law is not known.
    """
    check_study(study)
    for name, number in (("sessions", sessions), ("size", size)):
        whole = isinstance(number, int) and not isinstance(number, bool) and number >= 1
        require(whole, name, number, "a whole number >= 1")
    true = cobotic(study, drive)
    settings = protocol(true, study.rig, ratios=ratios, loads=loads, preloads=preloads)
    made = SessionsSweep(
        study=study,
        drive=drive,
        settings=settings,
        fitted=tuple(parameters),
        creep_laws=None if creep_laws is None else tuple(creep_laws),
        sessions=sessions,
        size=size,
    )
    # The first session without errors tells what is wrong with the question itself.
    data = experiment(true, study.rig, settings, exact=True, simulated=False).data
    calibrate_cobotic(study, drive, data, parameters=made.fitted, creep_laws=made.creep_laws)
    return made
