"""Commands that work with measured data: rig, calibrate."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from infinivar.calibration.options import CalibrateOptions, RigOptions
from infinivar.cli.arguments import Json, Out, StudyFile, drives_of_study, named_path, with_figures, with_options
from infinivar.cli.shared import chosen_cobotic, end, naming_place, of_one_axis
from infinivar.console import complain, progress_bar, say
from infinivar.errors import InputError

DRIVE = "Name of a cobotic drive; defaults to the first."
MEASURED = "Name of the measured drive; defaults to the first cobotic one, or to the first."


@with_options
def rig(
    study: StudyFile,
    options: RigOptions,
    drive: Annotated[str | None, typer.Option("--drive", help=DRIVE, autocompletion=drives_of_study)] = None,
    out: Annotated[Path, typer.Option("--out", parser=named_path, metavar="PATH", help="CSV file to write.")] = Path(
        "rig.csv"
    ),
    seed: Annotated[int, typer.Option(min=0, help="Random seed for sensor noise and rig errors.")] = 0,
) -> None:
    """Simulate a test rig measuring a transmission.

    Write the data that the study's rig would record.
    """
    from infinivar.calibration import virtual_rig
    from infinivar.calibration.result import cobotic
    from infinivar.report.calibration import save_data
    from infinivar.report.output import check_file
    from infinivar.study.load import load_study

    loaded = load_study(study)
    name = chosen_cobotic(study, drive, loaded.drives)
    of_one_axis(study, loaded.drives, "rig", name)
    with naming_place(study, f"drives.{name}"):
        measured = cobotic(loaded, name)
    check_file(out)
    with progress_bar() as progress, naming_place(study, f"drives.{name}"):
        settings = virtual_rig.protocol(measured, loaded.rig, **options.arguments())
        done = virtual_rig.experiment(
            measured, loaded.rig, settings, seed=seed, progress=lambda share: progress("measuring", share)
        )
    if not len(done.data):
        raise InputError(f"{study}: drives.{name}: every run of the protocol is infeasible: {done.left_out[0]}")
    save_data(done.data, out)
    for reason in done.left_out:
        complain(f"excluded: {reason}")
    say(f"{len(done.data)} runs written to {out}. Next: {_call('calibrate', out, '--study', study, '--drive', name)}")


@with_figures("infinivar.report.calibration")
@with_options
def calibrate(
    options: CalibrateOptions,
    data: Annotated[
        Path, typer.Argument(help="CSV file of measured data, with units in its header.", show_default=False)
    ],
    study: Annotated[Path, typer.Option("--study", help="Study file with the drive and the rig.", show_default=False)],
    drive: Annotated[str | None, typer.Option("--drive", help=MEASURED, autocompletion=drives_of_study)] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Fit a drive's losses to measured data.

    A cobotic drive is measured on a rig, a geared one on a dynamometer or by a pendulum.
    Write a report, the results and the calibrated study.
    Exit with code 1 if the data cannot identify every fitted parameter.
    """
    from infinivar.calibration.calibrate import calibrate as run
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.load import load_study

    loaded = load_study(study)
    name = chosen_cobotic(study, drive, loaded.drives)
    of_one_axis(study, loaded.drives, "calibrate", name)
    with claimed(out):
        found = run(loaded, name, data, **options.arguments())
        files = save(found, out)
    for line, reason in found.data.empty.items():
        complain(f"excluded: line {line}: {reason}")
    for one in found.left_out:
        complain(f"excluded: line {one.line}: {one.reason}")
    remarks = (f"  {remark}" for remark in found.remarks[len(found.warnings) :])
    end(
        found.to_dict,
        (*found.warnings, *found.verdict.split("; "), *remarks),
        files,
        as_json=as_json,
        feasible=found.fit.identifiable == found.fit.names,
        beside=[f"Calibrated study: {files[1]}"],
    )


def _call(*words: object) -> str:
    return shlex.join(["infinivar", *map(str, words)])
