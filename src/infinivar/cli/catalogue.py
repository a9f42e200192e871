"""Commands on sets of parts: list, show, search, check, import."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from infinivar.cli.arguments import Json, named_path
from infinivar.cli.shared import print_json
from infinivar.console import NOT_FEASIBLE, complain, say
from infinivar.errors import InputError, nearest, printable
from infinivar.options import headings_of

if TYPE_CHECKING:
    from infinivar.parts.tables.importing import PartImport

app = typer.Typer(no_args_is_help=False)

Kind = Annotated[
    str,
    typer.Argument(help="motors, gearheads, bearings, rails, belts, springs, tubes or materials.", show_default=False),
]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", help="Only this set, by name or as a file; repeat for more sets. [default: all sets]"),
]


@app.callback(invoke_without_command=True)
def catalogue(context: typer.Context, as_json: Json = False) -> None:
    """List the catalogue parts that a study can use.

    Show the shipped motors, gearheads, bearings, rails, belts, springs, tubes and materials with the key to give as `part`. The
    commands below work on other sets of parts as well: your own, those beside a study, and those of installed packages.
    """
    if context.invoked_subcommand is not None:
        if as_json:
            raise InputError(f"--json must come after {context.invoked_subcommand}")
        return
    if as_json:
        from infinivar.parts.catalogue import PARTS
        from infinivar.study import catalogue

        parts = {kind: getattr(catalogue, kind)() for kind in PARTS}
        print_json(
            {kind: {key: dataclasses.asdict(part) for key, part in group.items()} for kind, group in parts.items()}
        )
        return
    from infinivar.report.catalogue import text

    _say_all(text())


@app.command("list")
def list_sets(
    name: Annotated[
        str | None, typer.Argument(metavar="[SET]", help="List the parts of this set, by name or as a file.")
    ] = None,
    kind: Annotated[str | None, typer.Option("--kind", help="Only parts of this kind, such as motors.")] = None,
    as_json: Json = False,
) -> None:
    """List all sets of parts, or the parts of one set."""
    from infinivar.parts.tables.columns import check_kind
    from infinivar.parts.tables.stores import places
    from infinivar.report import catalogue as report

    if kind is not None:
        check_kind(kind)
    if name is None and kind is None:
        found = [(place, _contents(place.name)) for place in places(_beside())]
        if as_json:
            print_json([{"name": place.name, "contents": contents, "where": place.where} for place, contents in found])
        else:
            for line in report.sets(found):
                say(line)
        return
    parts = _found(name or "shipped").parts
    if as_json:
        kinds = [kind] if kind else [one for one, table in parts.tables.items() if table]
        print_json({one: [report.row_values(parts, one, key) for key in parts.tables[one].part_keys] for one in kinds})
        return
    _say_all(report.text(parts, [kind] if kind else ()))


@app.command()
def show(
    part: Annotated[str, typer.Argument(help="KEY of a shipped part, or SET:KEY.", show_default=False)],
    as_json: Json = False,
) -> None:
    """Show all that a set states of a part, what follows from it, and what fits it."""
    from infinivar.report import catalogue as report

    name, colon, key = part.partition(":")
    name, key = (name, key) if colon else ("shipped", part)
    found = _found(name)
    parts = found.parts
    kinds = [kind for kind, table in parts.tables.items() if key in table.part_keys]
    if not kinds:
        refused = next((fault for fault in found.faults if fault.what == key), None)
        if refused is not None:
            raise InputError(f"{part!r} was refused: {refused}")
        known = [one for table in parts.tables.values() for one in table.part_keys]
        raise InputError(f"{key!r} is not in the set {name}{nearest(key, known)}")
    if as_json:
        print_json({kind: report.row_values(parts, kind, key) for kind in kinds})
        return
    for kind in kinds:
        for line in report.part(parts, kind, key):
            say(line)


@app.command()
def search(
    kind: Kind,
    conditions: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[CONDITION]...",
            help='Such as "mass < 0.3 kg", "voltage = 24 V" or "manufacturer = maxon"; all must hold.',
        ),
    ] = None,
    of: Sets = None,
    fits: Annotated[
        str | None,
        typer.Option("--fits", metavar="SET:KEY", help="Only gearheads for this motor, or motors for this gearhead."),
    ] = None,
    sort: Annotated[str | None, typer.Option("--sort", help="Column to sort by, the smallest first.")] = None,
    descending: Annotated[bool, typer.Option("--descending", help="The largest first.")] = False,
    limit: Annotated[int, typer.Option("--limit", help="Most parts to print.", min=1)] = 20,
    columns: Annotated[
        list[str] | None, typer.Option("--show", help="Also print this column; repeat for more columns.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Find parts by conditions on their columns, with units.

    Exit with code 1 if no part meets all conditions. Parts that do not state a column are counted and left out.
    """
    from infinivar.parts.tables.search import search_parts
    from infinivar.report import catalogue as report

    if descending and sort is None:
        raise InputError("--descending is of the column to sort by: add --sort COLUMN")
    usual = {
        "motors": ("voltage", "continuous_torque", "mass"),
        "gearheads": ("ratio", "efficiency", "continuous_torque", "mass"),
        "bearings": ("bore", "outside_diameter", "dynamic_rating"),
        "rails": ("static_rating", "width", "carriage_mass"),
        "belts": ("pitch", "width", "belt_density", "permissible_force"),
        "springs": ("stiffness", "permissible_force", "outer_diameter", "mass"),
        "tubes": ("metal", "outer_diameter", "wall", "tube_density"),
        "materials": ("youngs_modulus", "poisson", "yield_strength"),
    }
    found = search_parts(
        (one.parts for one in _selected(of)[0]),
        kind,
        conditions or (),
        sort=sort,
        descending=descending,
        limit=limit,
        fits=fits,
        show=[*(columns or ()), *usual.get(kind, ())],
    )
    if as_json:
        hits = [{"part": hit.part, "set": hit.set, "key": hit.key, **hit.values} for hit in found.hits]
        print_json({"count": found.count, "searched": found.searched, "unstated": dict(found.unstated), "parts": hits})
    else:
        for line in report.search(found):
            say(line)
    raise typer.Exit(0 if found.count else NOT_FEASIBLE)


@app.command()
def check(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[SET]...", help="Sets, by name or as files. [default: all sets]")
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="List every contradiction, not only the ten worst.")] = False,
    as_json: Json = False,
) -> None:
    """Find rows whose figures contradict each other.

    Compare stated figures of each row with those that follow from its other figures: no-load speed, stall torque and current,
    efficiency, friction, heat, and bounds between them. Exit with code 1 if a row contradicts itself or was refused, or a set
    cannot be read.
    """
    from infinivar.parts.tables.consistency import check_parts
    from infinivar.report import catalogue as report

    sets, unread = _selected(names)
    clean, results = not unread, []
    for found in sets:
        outcome = check_parts(found.parts)
        clean = clean and outcome.consistent and not found.faults
        if as_json:
            results.append(
                {
                    "set": outcome.name,
                    "rows": dict(outcome.rows),
                    "tested": dict(outcome.tested),
                    "incomplete": dict(outcome.incomplete),
                    "unusable": list(outcome.unusable),
                    "refused": [str(fault) for fault in found.faults],
                    "contradictions": [dataclasses.asdict(one) for one in outcome.contradictions],
                }
            )
            continue
        for line in report.check(outcome, every):
            say(line)
    if as_json:
        print_json(results)
    raise typer.Exit(0 if clean else NOT_FEASIBLE)


@app.command("import")
def import_files(
    name: Annotated[str, typer.Argument(help="Name of the set; studies write NAME:KEY.", show_default=False)],
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="CSV with units in its headings, CSV of the MGDB format, or TOML."),
    ],
    source: Annotated[
        str | None, typer.Option("--source", help="Source of rows that state none. [default: their file]")
    ] = None,
    date: Annotated[
        str | None, typer.Option("--date", help="Date of the source of rows that state none. [default: today]")
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            "--columns", help='Headings by name of a column, where they differ, such as "resistance=R [Ohm]".'
        ),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to", parser=named_path, metavar="PATH", help="Folder to write the set to. [default: your folder of sets]"
        ),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a set of that name.")] = False,
    as_json: Json = False,
) -> None:
    """Read files of parts into a set that studies and searches can use.

    Good rows are kept. Bad ones are reported with file, line and reason, and the exit code is 1.
    """
    from infinivar.parts.tables import importing
    from infinivar.parts.tables.importing import import_parts
    from infinivar.parts.tables.stores import NAME, SHIPPED, users_folder
    from infinivar.report import catalogue as report

    if not NAME.fullmatch(name) or name == SHIPPED:
        raise InputError(f"{name!r} is not a name for a set: use letters, digits, - and _, and not {SHIPPED!r}")
    path = (to or users_folder()) / f"{name}.npz"
    if path.exists() and not overwrite:
        raise InputError(f"{printable(path)}: already exists; add --overwrite to replace it")
    found = import_parts(files, name=name, source=source, date=date, columns=headings_of("--columns", columns))
    importing.write(found.parts, path)
    for fault in found.faults:
        complain(str(fault))
    if as_json:
        print_json(
            {
                "file": str(path),
                "contents": {kind: len(table) for kind, table in found.parts.tables.items()},
                "pairs": len(found.parts.pairs) if found.parts.pairs_stated else None,
                "unstated": found.unstated,
                "incomplete": found.incomplete,
                "refused": [dataclasses.asdict(fault) for fault in found.faults],
                "remarks": [dataclasses.asdict(remark) for remark in found.remarks],
            }
        )
    else:
        for line in report.imported(found):
            say(line)
        say(f"Wrote {path}")
    raise typer.Exit(NOT_FEASIBLE if found.faults else 0)


def _say_all(text: str) -> None:
    for line in text.rstrip("\n").split("\n"):
        say(line)


def _beside() -> tuple[Path, ...]:
    """Folder of sets beside the studies of the current folder."""
    return (Path("parts"),)


def _selected(names: list[str] | None) -> tuple[list[PartImport], int]:
    """The sets named; by default all that can be read, and how many cannot, which are reported on stderr."""
    from infinivar.parts.tables.stores import readable

    if names:
        return [_found(name) for name in names], 0
    found, problems = readable(_beside())
    for line in [*problems, *(str(fault) for one in found for fault in one.faults)]:
        complain(line)
    return found, len(problems)


def _found(name: str) -> PartImport:
    """A set, its refused rows reported on stderr."""
    from infinivar.parts.tables.stores import find

    found = find(name, _beside())
    for fault in found.faults:
        complain(str(fault))
    return found


def _contents(name: str) -> str:
    """What a set contains; why it cannot be read, if so."""
    from infinivar._core.text import counted
    from infinivar.parts.tables.stores import find

    try:
        found = find(name, _beside())
    except InputError as problem:
        return f"cannot be read: {problem}"
    refused = f"; {counted(len(found.faults), 'rows')} refused" if found.faults else ""
    return f"{found.parts.contents}{refused}"
