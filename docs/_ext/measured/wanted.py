"""What to measure on the paper's rig, over which range and how well: by the program's own elasticities and proposed runs."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import infinivar as iv
from infinivar._core.fields import quantities_of, value_at, with_values
from infinivar._core.result import Frozen, result
from infinivar.analysis.robustness.outcomes import outcome
from infinivar.calibration import virtual_rig
from infinivar.study.spreads import NORMAL_95
from infinivar.units import plain, show

EFFECT = 0.01
"""Change of the energy per cycle, or of the loss at the largest force, that an error of one quantity may make. [-]"""

_RATIOS, _PRELOADS = (20.0, 2.0), (0.4, 0.7, 1.0)

_STEP = 0.01
"""Relative step of the elasticities."""


@result
class WantedRow(Frozen):
    """A quantity on the rig.

    Attributes
    ----------
    name, unit : of the quantity.
    value : by the calibration of a virtual session. [SI]
    energy, loss : elasticities of the energy per cycle, and of the loss at the largest force. [-]
    needed : relative error that changes either by `EFFECT`. [-]
    reached : half-width of the 95 % interval over the value, after the proposed runs; of a sum before them. [-]
    """

    name: str
    unit: str
    value: float
    energy: float
    loss: float
    needed: float
    reached: float


@result
class Wanted(Frozen):
    """Rows of the sheet, and the range of settings: largest steering angle [rad], mass [kg] and preload [N]."""

    rows: tuple[WantedRow, ...]
    runs: int
    settings: tuple[float, float, float]


@functools.cache
def sheet() -> Wanted:
    """The sheet for the rig of docs/calibration.md and the shaking load of the paper.

    Source: faulring2006, section IV-B, for the rig; D-optimal runs by `infinivar.calibration.plan`.
    """
    rig = {
        "link_resolution": "2 um",
        "current_noise": "20 mA",
        "current_gain_deviation": 0.005,
        "mass_deviation": "1 g",
    }
    study = iv.Study.from_dict(
        {
            "requirement": {"base": "faulring2006"},
            "drives": {"cobotic": {"base": "faulring2006.cobotic"}},
            "duty": {"shake": {"base": "faulring2006.shake"}},
            "rig": {**rig, "preload_deviation": 0.01},
        },
        name="bench",
    )
    drive = study.drives["cobotic"]
    settings = virtual_rig.protocol(drive, study.rig, ratios=_RATIOS, preloads=_PRELOADS)
    data = virtual_rig.experiment(drive, study.rig, settings, simulated=False).data
    found = iv.calibrate(study, "cobotic", data)
    outcomes = [outcome(study, "energy", duty="shake"), outcome(study, "loss")]
    alone = {(name,): (found.fit.values[name], found.plan.deviations[name]) for name in found.fit.identifiable}
    sums = {tuple(one.weights): (one.value, one.deviation) for one in found.fit.combinations if len(one.weights) > 1}
    rows = []
    for names, (value, deviation) in {**alone, **sums}.items():
        energy, loss = (_elasticity(found, one.of, names) for one in outcomes)
        rows.append(
            WantedRow(
                name=" + ".join(names),
                unit=found.fit.parameters[names[0]].unit,
                value=value,
                energy=energy,
                loss=loss,
                needed=EFFECT / max(abs(energy), abs(loss)),
                reached=NORMAL_95 * deviation / value,
            )
        )
    largest = np.max(np.abs(np.asarray([*settings, *found.plan.settings], dtype=float)), axis=0)
    return Wanted(rows=tuple(rows), runs=len(settings) + len(found.plan.settings), settings=tuple(largest.tolist()))


def _elasticity(found: Any, of: Callable[[Any], Any], names: tuple[str, ...]) -> float:
    """Elasticity of an outcome of the calibrated drive with respect to fitted values that change together. [-]"""

    def at(factor: float) -> float:
        values = {**found.fit.values, **{name: factor * found.fit.values[name] for name in names}}
        laws = replace(found.laws, fit=replace(found.fit, values=values))
        return float(of(replace(found, laws=laws).calibrated))

    return (at(1.0 + _STEP) - at(1.0 - _STEP)) / (2.0 * _STEP * at(1.0))


def lines() -> Iterator[str]:
    """Rows of the page's table."""
    for row in sheet().rows:
        needed = f"{plain(100 * row.needed, 2)} %"
        yield (
            f"| `{row.name}` | {show(row.value, row.unit, 3)} | {plain(row.energy, 2)} | {plain(row.loss, 2)} | {needed} | "
            f"{plain(100 * row.reached, 2)} % |"
        )


BENCHES = {
    "gear map": ("gearhead.efficiency",),
    "motor without load": ("motor.no_load_current",),
    "motor on a dynamometer": ("motor.resistance", "motor.torque_constant"),
}
"""Values that a bench for parts other than the paper's rig measures."""


def part_lines(study: str = "knee_walking") -> Iterator[str]:
    """Rows of the page's table for other benches: elasticity of the energy per cycle, and the error that changes it by `EFFECT`.

    Of an efficiency, value and error are those of the loss.
    """
    loaded = iv.load_study(study)
    (duty,) = loaded.duty
    of = outcome(loaded, "energy", duty=duty).of
    for bench, paths in BENCHES.items():
        for path, (name, drive) in itertools.product(paths, loaded.drives.items()):
            field, value = quantities_of(drive)[path], value_at(drive, path)
            loss = path.endswith("efficiency")
            size = 1.0 - value if loss else value
            high, low = (float(of(with_values(drive, {path: value + sign * _STEP * size}))) for sign in (1.0, -1.0))
            slope = (low - high if loss else high - low) / (2.0 * _STEP * float(of(drive)))
            said = f"1 - `{path}`" if loss else f"`{path}`"
            needed = f"{plain(100.0 * EFFECT / abs(slope), 2)} %"
            yield f"| {bench} | {name} | {said} | {show(size, field.metadata['unit'], 3)} | {plain(slope, 2)} | {needed} |"


if __name__ == "__main__":
    print("\n".join(lines()), sheet().settings, sheet().runs)
