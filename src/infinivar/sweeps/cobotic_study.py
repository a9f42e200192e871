"""Sweep over the cobotic drives of a study, whose result is that of `size`."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import InputError
from infinivar.sizing.asked import Asked
from infinivar.sizing.cobotic.result import CoboticSizing
from infinivar.sizing.cobotic.search import excluded_of, unchecked_of
from infinivar.sizing.of_cobotic import arguments_of, found_of, objective_of
from infinivar.sizing.pool import pool_of
from infinivar.sizing.result import Sizing
from infinivar.sizing.size import (
    GENERATIONS,
    SLIP_MARGIN,
    Aim,
    aims_of,
    check_options,
    sizing_of,
    templates_of,
)
from infinivar.study.check import check_study
from infinivar.study.study import Study
from infinivar.sweeps.cobotic import CoboticSweep, cobotic_sweep
from infinivar.sweeps.demands import key_of
from infinivar.sweeps.geared import TOP_OF_CHUNK
from infinivar.sweeps.reducers import NEAREST
from infinivar.sweeps.sweep import Sweep


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoboticStudySweep(CoboticSweep):
    """Independent starts of the search of `size` over cobotic drives, one in each chunk.

    Attributes
    ----------
    asked   Study, parts, objectives and options.
    drive   Name of the template in the study.
    """

    asked: Asked
    drive: str

    @property
    def _by_mass(self) -> bool:
        return self.asked.aims[0] == "mass"

    def sizing(self, sweep: Sweep) -> Sizing:
        """The best designs of all starts as `size` returns them; the cloud of the record has no others, and no history.

        Raises
        ------
        InputError
            If the sweep is not finished.
        """
        kept, searched, counts = self.result(sweep), self.searched, sweep.counts
        both = [*kept.designs, *kept.front]
        found = CoboticSizing(
            objective=objective_of(self.asked),
            designs=kept.designs,
            front=kept.front,
            wheels=counts["wheels"],
            rolled=counts["rolled"],
            drives=sweep.candidates,
            sampled=counts["sampled"],
            excluded=excluded_of(searched.sides),
            blocked={key_of(name): number for name, number in counts["blocked"].items()},
            history=np.empty(0),
            cloud=np.array([(one.mass, one.power) for one in both]).reshape(-1, 2),
            candidates=searched.candidates,
            unchecked=unchecked_of(searched.sides),
            nearest=next(self.designs(searched, sweep.list(NEAREST)), None),
        )
        asked = self.asked
        return sizing_of(
            asked.study,
            asked.parts,
            asked.aims,
            {self.drive: found_of(asked, self.drive, self.template, found)},
            top=self.top,
            slip_margin=asked.slip_margin,
        )


def cobotic_study_sweep(
    study: Study,
    *,
    starts: int,
    objective: Aim | Sequence[Aim] | None = None,
    top: int = TOP_OF_CHUNK,
    sets: str | Path | Sequence[str | Path] | None = None,
    drive: str | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    steering_ratios: Sequence[float] | None = None,
    slip_margin: float | None = None,
    life: float | None = None,
    generations: int = GENERATIONS,
) -> CoboticStudySweep:
    """Prepare the search of `size` over cobotic drives from many starts as a sweep; arguments as for `size`.

    Raises
    ------
    InputError
        As `size` does.
    """
    check_study(study)
    names, notes = templates_of(study, drive)
    name = next((one for one in names if isinstance(study.drives[one], CoboticDrive)), None)
    if name is None:
        why = notes[0] if notes else f"drives.{names[0]} is not one"
        raise InputError(f"the study has no cobotic drive that can be a template: {why}")
    template = study.drives[name]
    assert isinstance(template, CoboticDrive)
    stated = {"ranges": ranges or None, "steering_ratios": steering_ratios}
    check_options(study, [name], {one: value for one, value in stated.items() if value is not None})
    asked = Asked(
        study=study,
        parts=pool_of(study, sets).like(study, name),
        aims=aims_of(study, objective),
        top=top,
        radius=None,
        leads=(),
        ranges=ranges or {},
        steering_ratios=None if steering_ratios is None else tuple(steering_ratios),
        slip_margin=SLIP_MARGIN if slip_margin is None else slip_margin,
        life=life,
        loss_model=None,
        generations=generations,
        seed=0,
    )
    checked = cobotic_sweep(
        template,
        starts=starts,
        title=f"{study.name}, cobotic drives like {name}",
        top=top,
        **arguments_of(asked, template),
        objective=objective_of(asked),
        generations=generations,
    )
    own = {one.name: getattr(checked, one.name) for one in dataclasses.fields(checked)}
    return CoboticStudySweep(**own, asked=asked, drive=name)
