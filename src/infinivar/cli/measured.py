"""Commands on measured sets: list, add, check, report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from infinivar.cli.arguments import Json, named_path
from infinivar.cli.shared import end, print_json
from infinivar.console import say

app = typer.Typer(no_args_is_help=True, help="Compare models with measurements, shipped ones or your own.")

Set = Annotated[
    str,
    typer.Argument(metavar="NAME|FOLDER", help="A known set, or a folder with measured.toml.", show_default=False),
]
Rows = Annotated[
    Path | None, typer.Option("--rows", help="CSV file in place of the set's own rows, with the same headings.")
]


@app.command("list")
def list_sets(as_json: Json = False) -> None:
    """List the measured sets, shipped ones and your own."""
    from infinivar.calibration.measured.sets import known_sets, read_set

    found = [read_set(name) for name in known_sets()]
    if as_json:
        print_json(
            [{"name": one.name, "title": one.title, "bench": one.law.name, "licence": one.licence} for one in found]
        )
        return
    for one in found:
        say(f"{one.name}: {one.title} ({one.source}, {one.licence}; bench {one.law.name})")


@app.command()
def add(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="FOLDER|CSV", help="A folder with measured.toml and rows, or a CSV file.", show_default=False
        ),
    ],
    description: Annotated[
        Path | None, typer.Option("--description", help="TOML file of a CSV file. [default: measured.toml beside it]")
    ] = None,
    name: Annotated[
        str | None, typer.Option("--name", help="Name of the set. [default: that of the folder or file]")
    ] = None,
    as_json: Json = False,
) -> None:
    """Check measurements of your own and copy them to the known sets, so that list, check and report find them by name.

    Nothing is written if columns are swapped, units are wrong, or a sensor drifts: the message names column, lines and what was
    expected.
    """
    from infinivar.calibration.measured.adding import add_set

    folder, found = add_set(source, description=description, name=name)
    one = found.set
    head = f"{folder.name}: {sum(len(part.rows) for part in found.parts)} rows added ({one.source}, {one.licence}) to {folder}"
    end(
        lambda: {"set": folder.name, "folder": str(folder), "faults": list(found.faults)},
        (head, *found.faults),
        as_json=as_json,
        feasible=True,
    )


@app.command()
def check(folder: Set, rows: Rows = None, as_json: Json = False) -> None:
    """Read a measured set and name what is misread: swapped columns, wrong units, drifting sensors, single rows.

    Exit with code 1 if anything is.
    """
    from infinivar._core.text import counted
    from infinivar.calibration.measured.report import measured_report

    found = measured_report(folder, rows=rows)
    said = found.faults
    count = sum(len(part.rows) for part in found.parts)
    verdict = counted(len(said), "faults") if said else "no faults"
    head = f"{found.set.name}: {count} rows, {verdict}"
    end(
        lambda: {"set": found.set.name, "rows": count, "faults": list(said)},
        (head, *said),
        as_json=as_json,
        feasible=found.sound,
    )


@app.command()
def report(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME|FOLDER]", help="A set. [default: all known sets with rows]")
    ] = None,
    rows: Rows = None,
    predict: Annotated[
        Path | None, typer.Option("--predict", help="CSV file of further rows to predict, with the same headings.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", parser=named_path, metavar="PATH", help="Folder for table, figures, results."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Fit a model to a measured set.

    Print residuals, parameters with their intervals, the evidence for each form of the law, and rows predicted from others.
    """
    from infinivar.calibration.measured.report import measured_report
    from infinivar.calibration.measured.sets import known_sets, read_set

    names = [name] if name is not None else [one for one in known_sets() if read_set(one).rows is not None]
    found = [measured_report(one, rows=rows, predict=predict) for one in names]
    if out is not None:
        from infinivar.report.measured import save_all
        from infinivar.report.output import claimed

        with claimed(out):
            save_all(found, out)
    if as_json:
        print_json(found[0].to_dict() if name is not None else [one.to_dict() for one in found])
        return
    for one in found:
        for line in one.lines:
            say(line)
