"""Commands that work on recordings of motions: motion."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from infinivar.analysis.options import MotionOptions
from infinivar.cli.arguments import Json, Out, with_options
from infinivar.cli.shared import end
from infinivar.errors import InputError, ParameterError, printable
from infinivar.options import quantity

if TYPE_CHECKING:
    from infinivar.analysis.motion_summary import MotionSummary

_WIDTH = 13
"""Width of the first column of the summary."""


@with_options
def motion(
    options: MotionOptions,
    file: Annotated[
        Path,
        typer.Argument(
            help="Recording: CSV, OpenSim .sto or .mot, Parquet, or arrays of MuJoCo, .npz.", show_default=False
        ),
    ],
    load_mass: Annotated[
        str | None,
        typer.Option("--load-mass", help='Mass of the load, for the power, such as "0.8 kg" or "0.1 kg m^2".'),
    ] = None,
    model: Annotated[
        Path | None, typer.Option("--model", help="Model of MuJoCo that an .npz file belongs to, MJCF or MJB.")
    ] = None,
    joint: Annotated[
        str | None,
        typer.Option("--joint", help="Name of the joint of that model; its motion is written as a recording."),
    ] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Show what is understood of a recorded motion.

    Columns, units, sampling, gaps, whether it closes, cutoff, spectrum, power and strides; write a page with plots.
    Of a trajectory in MuJoCo, also write the motion of one joint as a recording that a study can read.
    """
    from infinivar.analysis.motion_summary import inspect_motion
    from infinivar.report.output import claimed
    from infinivar.report.saving import save

    given = options.arguments()
    with claimed(out):
        try:
            recording = _of_joint(file, model, joint, out, given)
            found = inspect_motion(recording, **given, load_mass=_load_mass(load_mass)[0])
        except ParameterError as problem:
            raise InputError(f"{printable(file)}: {problem}") from problem
        _check_load_mass(load_mass, about_a_joint=found.axis.rotary)
        files = save(found, out)
    written = [] if recording == file else [recording]
    end(
        found.to_dict,
        _lines(found),
        [*files, *written],
        as_json=as_json,
        beside=(f"Recording: {one}" for one in written),
    )


def _of_joint(file: Path, model: Path | None, joint: str | None, out: Path, given: dict[str, Any]) -> Path:
    """The recording: of a trajectory in MuJoCo that of a joint, written first, with the columns that are chosen for it."""
    from infinivar.motion.files.joints import joint_recording

    if file.suffix.lower() != ".npz":
        option = "--model" if model is not None else "--joint" if joint is not None else None
        if option is not None:
            raise InputError(f"{option} applies to a trajectory in MuJoCo, a file .npz; got {printable(file)}")
        return file
    if model is None or joint is None:
        raise InputError(f"{printable(file)}: state the model with --model FILE.xml, and its joint with --joint NAME")
    name = "".join(one if one.isalnum() or one in "-_" else "_" for one in joint)
    return joint_recording(file, model, joint, out / f"{name}.csv", columns=given.pop("columns", None))


def _load_mass(text: str | None) -> tuple[float, bool]:
    """Mass or moment of inertia of the load, and whether it is the latter; 0 if none is given. [kg, kg m^2]"""
    if text is None:
        return 0.0, False
    for unit in ("kg", "kg m^2"):
        with contextlib.suppress(InputError):
            found = quantity("--load-mass", text, unit)
            break
    else:
        raise InputError(
            f'--load-mass {text!r} must be a mass such as "0.8 kg", or about a joint an inertia such as "0.1 kg m^2"'
        )
    if not found >= 0.0:
        raise InputError(f"--load-mass {text!r} must be >= 0")
    return found, unit != "kg"


def _check_load_mass(text: str | None, *, about_a_joint: bool) -> None:
    """Refuse a mass about a joint, and a moment of inertia along a line."""
    if text is None or _load_mass(text)[1] == about_a_joint:
        return
    wrong = "is a mass, but the motion is about a joint; state a moment of inertia, such as '0.1 kg m^2'"
    if not about_a_joint:
        wrong = "is a moment of inertia, but the motion is along a line; state a mass, such as '0.8 kg'"
    raise InputError(f"--load-mass {text!r} {wrong}")


def _lines(found: MotionSummary) -> Iterator[str]:
    """Yield the summary as lines of a compact table."""
    from infinivar.analysis.motion_summary import advice
    from infinivar.report.motion_summary import drift, extremes, powers, rows, shown
    from infinivar.units import percent, plain

    axis, sampling, spectrum = found.axis, found.sampling, found.spectrum
    yield f"{printable(found.table.file)}: {found.verdict}"
    yield f"  format        {found.table.format}"
    for column in rows(found):
        unit = f" in {column['unit']}" if column["unit"] else ""
        yield f"  {column['role'].replace('_', ' '):<{_WIDTH}} {column['heading']!r}{unit}: {column['first']}"
    if found.table.ignored:
        yield f"  not used      {', '.join(map(printable, found.table.ignored))}"
    for remark in found.table.remarks:
        yield f"  remark        {remark}"
    gaps = f"{len(sampling.gaps) or 'no'} gap{'' if len(sampling.gaps) == 1 else 's'}"
    yield f"  sampling      {plain(sampling.rate)} Hz, steps vary by {percent(sampling.jitter, 2)}, {gaps}"
    closes = "closes" if found.closed else "does not close"
    yield f"  end           {closes}: {plain(drift(found), 3)} {axis.position_unit} from the start"
    above, removed = (plain(round(100.0 * one, 4), 2) for one in (spectrum.above, spectrum.removed_speed))
    yield (
        f"  cutoff        {plain(found.motion.cutoff, 3)} Hz, {found.cutoff_from}; {above} % of the power of the {axis.position} "
        f"above it; removes {removed} % of that of the {axis.speed}, without noise"
    )
    units = {"position": axis.position_unit, "speed": axis.speed_unit, "force": axis.force_unit}
    words = {"position": axis.position, "speed": axis.speed, "force": axis.force, "acceleration": "acceleration"}
    for name, (low, high, rms) in extremes(found).items():
        unit = units.get(name, f"{axis.speed_unit}^2")
        yield f"  {words[name]:<{_WIDTH}} {plain(low, 3)} to {plain(high, 3)} {unit}, RMS {plain(rms, 3)}"
    power = powers(found)
    if power is not None:
        (low, mean, high), (given, taken) = power, shown(*found.work)
        whole = "" if found.one_cycle else " over the recording"
        yield (
            f"  power         {plain(low, 3)} to {plain(high, 3)} W, mean {plain(mean, 3)} W; "
            f"{plain(given, 3)} J to the load, {plain(taken, 3)} J from it{whole}"
        )
    if found.work_per_stride is not None:
        given, taken = shown(*found.work_per_stride)
        yield f"  per stride    {plain(given, 3)} J to the load, {plain(taken, 3)} J from it, on average"
    yield f"  at rest       {percent(found.resting, 1)} of the time"
    yield f"  strides       {found.strides.verdict if found.strides is not None else 'none: ' + found.no_strides}"
    for warning in found.warnings:
        yield f"  warning       {warning}"
    for one in advice(found):
        yield f"  for a study   {one}"
