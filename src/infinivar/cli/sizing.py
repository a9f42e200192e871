"""Command that searches for the best drives: size."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from infinivar.cli.shared import loaded_study, naming, of_one_axis, print_json
from infinivar.console import NOT_FEASIBLE, complain, flush, progress_bar, say
from infinivar.errors import InputError, nearest
from infinivar.options import Json, Out, StudyFile, drives_of_study, numbers, quantity

Objective = Annotated[
    str | None,
    typer.Option(
        "--objective",
        help="energy, mass, or both separated by a comma: designs are ordered by the first, and two give their front as "
        "well. [default: energy,mass; mass for a study without motions]",
    ),
]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", help="Search only this set, by name or as a file; repeat for more sets. [default: all sets]"),
]
Radius = Annotated[
    tuple[str, str] | None,
    typer.Option(
        "--radius",
        metavar="LOW HIGH",
        help='Geared drives: least and largest radius of the pulley, such as "3 mm" "50 mm". '
        "[default: a fifth to five times the template's]",
    ),
]
Ranges = Annotated[
    list[str] | None,
    typer.Option(
        "--range",
        metavar="NAME=LOW..HIGH",
        help="Cobotic drives: range of cylinder_radius, cylinder_speed, wheel_radius, crown_radius or preload, such as "
        '"preload=800 N..3 kN"; repeat for more. [default: half to twice the template\'s]',
    ),
]
SteeringRatios = Annotated[
    str | None,
    typer.Option(
        "--steering-ratios",
        help="Cobotic drives: ratios between steering motor and bell to try, separated by commas. "
        "[default: five from half to twice the template's]",
    ),
]
SlipMargin = Annotated[
    float | None,
    typer.Option(
        "--slip-margin",
        help="Cobotic drives: required slip force over lateral force. [default: 1.1]",
        min=1.0,
    ),
]
Life = Annotated[
    str | None, typer.Option("--life", help='Cobotic drives: required life of the axle bearings, such as "5000 h".')
]


def size(
    study: StudyFile,
    objective: Objective = None,
    top: Annotated[
        int, typer.Option("--top", help="Number of designs to list, besides those of the front.", min=1)
    ] = 20,
    sets: Sets = None,
    drive: Annotated[
        list[str] | None,
        typer.Option(
            "--drive",
            help="Drive of the study that is a template: its other parts stay; repeat for more. "
            "[default: the first geared and the first cobotic drive]",
            autocompletion=drives_of_study,
        ),
    ] = None,
    radius: Radius = None,
    leads: Annotated[
        str | None,
        typer.Option(
            "--leads",
            help='Geared drives with a screw: leads to try, separated by commas, such as "2 mm, 5 mm, 10 mm". '
            "[default: the template's]",
        ),
    ] = None,
    ranges: Ranges = None,
    steering_ratios: SteeringRatios = None,
    slip_margin: SlipMargin = None,
    life: Life = None,
    generations: Annotated[
        int | None,
        typer.Option("--generations", help="Cobotic drives: length of the search. [default: 40]", min=1),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option("--seed", help="Cobotic drives: the same seed gives the same result. [default: 0]", min=0),
    ] = None,
    builds: Annotated[
        int,
        typer.Option(
            "--builds",
            help="Number of builds of the best designs within the spreads of their parts, a power of two; 0: none.",
            min=0,
        ),
    ] = 128,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Find the best geared and cobotic drives for a study.

    Judge motors, gearheads and pulley radii, or motors, gearhead, bearing and values of the wheel, by the requirement and the
    duty cycles of the study. Write a report, and each design as a study file that the other commands read. Exit with code 1 if
    no design is feasible; the result then names what excluded how many, and the nearest misses.
    """
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.report.sizing import keep_inputs, text
    from infinivar.sizing.size import size as run

    ends = None if radius is None else range_of_option(*radius)
    steps = None if leads is None else [quantity("--leads", part.strip(), "m") or 0.0 for part in leads.split(",")]
    wheel = wheel_options(ranges, steering_ratios, slip_margin, life)
    aims = aims_of_option(objective)
    loaded = loaded_study(study)
    of_one_axis(study, loaded.drives, "size")
    keep_inputs(loaded, out, sets)
    with claimed(out):
        with progress_bar() as progress, naming(study):
            found = run(
                loaded,
                objective=aims,
                top=top,
                sets=sets,
                drive=drive,
                radius=ends,
                leads=steps,
                **wheel,
                generations=generations,
                seed=seed,
                builds=builds,
                progress=progress,
            )
        for one in found.sets:
            for fault in one.refused:
                complain(fault)
        if not as_json:
            for line in text(found):
                say(line)
            flush()
        with progress_bar() as progress:
            progress("writing the report", 1.0)
            files = save(found, out)
    if as_json:
        print_json({**found.to_dict(), "files": [str(file) for file in files]})
    else:
        say(f"Report: {files[0]}")
    raise typer.Exit(0 if found.feasible else NOT_FEASIBLE)


def aims_of_option(objective: str | None) -> Any:
    """Objectives of an option such as "energy,mass"; None if the option is absent."""
    aims = None if objective is None else tuple(part.strip() for part in objective.split(","))
    if aims is not None and (len({*aims}) < len(aims) or not {*aims} <= {"energy", "mass"}):
        raise InputError(f"--objective {objective!r} must be energy, mass, or both, such as energy,mass")
    return aims


def wheel_options(
    ranges: list[str] | None, steering_ratios: str | None, slip_margin: float | None, life: str | None
) -> dict[str, Any]:
    """Options for cobotic drives as arguments of `size`, by name. In SI."""
    named = [_named_range(text) for text in ranges or ()]
    within = dict(named)
    if len(within) < len(named):
        raise InputError("--range names a value twice; give one range for each")
    return {
        "ranges": within,
        "steering_ratios": None if steering_ratios is None else numbers("steering-ratios", steering_ratios),
        "slip_margin": slip_margin,
        "life": quantity("--life", life, "s"),
    }


def range_of_option(least: str, largest: str) -> tuple[float, float]:
    """Radii of the option. [m]"""
    low, high = quantity("--radius", least, "m"), quantity("--radius", largest, "m")
    if low is None or high is None or not 0.0 < low <= high:
        raise InputError(f"--radius {least!r} {largest!r} must be a range above 0, the least first")
    return low, high


def _named_range(text: str) -> tuple[str, tuple[float, float]]:
    """Name and ends of a range such as "preload=800 N..3 kN". In SI."""
    from infinivar.sizing.design import COBOTIC_PATHS, UNITS

    name, equals, ends = text.partition("=")
    name, (low, dots, high) = name.strip(), ends.partition("..")
    if not equals or not dots:
        raise InputError(f'--range {text!r} must be NAME=LOW..HIGH, such as "preload=800 N..3 kN"')
    if name not in COBOTIC_PATHS:
        raise InputError(
            f"--range {text!r}: {name!r} is not searched{nearest(name, COBOTIC_PATHS)}; names: {', '.join(COBOTIC_PATHS)}"
        )
    unit = UNITS[COBOTIC_PATHS[name]]
    least, largest = (quantity(f"--range {name}", end.strip(), unit) for end in (low, high))
    if least is None or largest is None or not 0.0 < least <= largest:
        raise InputError(f"--range {text!r} must be a range above 0, the least first")
    return name, (least, largest)
