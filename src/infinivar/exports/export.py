"""Write a drive's plant as an FMU or as C."""

from __future__ import annotations

import io
import platform
import re
import sys
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from infinivar._core.c_library import FLAGS, binary, compiler
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import check_drive, refuse_machine
from infinivar.errors import ParameterError, path_of, require
from infinivar.exports.description import build_description, model_description, token
from infinivar.exports.laws import law_files
from infinivar.exports.plant import Plant, Role, plant
from infinivar.motion.scenario import Scenario, check_scenario
from infinivar.report.output import all_files_or_none
from infinivar.study.provenance import Provenance

FORMATS = ("fmu2", "fmu3", "c")
"""What a plant is written as."""

_VERSIONS = {"fmu2": "2.0", "fmu3": "3.0"}
_FIRST_DAY = (1980, 1, 1, 0, 0, 0)
"""Time of every file in an FMU, so that the same model gives the same bytes."""


_SMALL = ("-O1", "-fvisibility=hidden", "-s")
"""Flags of a compiler that is half as quick and makes a smaller file, of the interface's functions alone."""


class Exported(NamedTuple):
    """Files written, and what a user should know of them."""

    files: tuple[Path, ...]
    notes: tuple[str, ...]


def export(
    drive: Any,
    kind: str,
    out: str | Path = ".",
    *,
    name: str = "drive",
    title: str = "",
    scenario: Scenario | None = None,
    load_mass: float | None = None,
    closed: bool = False,
    sources: Iterable[Provenance] = (),
) -> Exported:
    """Write the plant of a drive, without its controllers or with them, for other programs.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive   With the inertias that motion requires.
    kind : str             "fmu2" or "fmu3": an FMU for Model Exchange and Co-Simulation, NAME.fmu; "c": NAME.c, a program that
        runs it, NAME_main.c, and its arguments, NAME.md; and for controllers NAME_laws.c, NAME_laws.h and their test.
    out : str or Path      Folder; created if missing.
    name : str             Of the files, in letters, digits, "-" and "_"; and owner of the drive's values in `sources`.
    title : str            Of the model. Default: `name`.
    scenario : Scenario    States what the amplifier imposes (a current, or a voltage through its current loop), whether the
        load is pushed or moved, its mass, and where the motion starts. Default: currents, a load that a force pushes, at
        rest, with the cylinder at its speed.
    load_mass : float      Mass of the load of the default scenario, or its moment of inertia. [kg] or [kg m^2]
    closed : bool          Whether the controllers of the scenario are part of it: they follow a goal, position, speed and
        acceleration, which are inputs.
    sources : iterable of Provenance   Such as ``study.provenance``: where the values of parameters come from.

    Returns
    -------
    Exported   Files, and notes: without a C compiler an FMU holds sources only.

    Raises
    ------
    ParameterError
        If the drive is a machine of several coordinates, or lacks a value that motion requires.
    InputError
        If a law has no C, or a file cannot be written.

    Source: fmi2014, fmi2022.
    """
    require(kind in FORMATS, "kind", repr(kind), f"one of {', '.join(FORMATS)}")
    refuse_machine(drive, "export")
    check_drive(drive, "drive")
    if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
        raise ParameterError(f"a drive of type {type(drive).__name__} has no bond graph")
    if scenario is None:
        scenario = _usual(drive, load_mass)
    check_scenario(scenario)
    identifier = re.sub(r"\W", "_", name, flags=re.ASCII)[:48]
    identifier = identifier if identifier[:1].isalpha() else f"drive_{identifier}"
    own = [row for row in sources if row.owner == name]
    made = plant(drive, scenario, identifier, title or name, own, closed=closed)
    content, notes = _source(made, drive) if kind == "c" else _fmu(made, _VERSIONS[kind])
    folder = path_of(out, "out")
    with all_files_or_none(*(folder / file for file in content)) as files:
        for file in files:
            file.write_bytes(content[file.name])
    return Exported(tuple(folder / file for file in content), notes)


def _usual(drive: CoboticDrive | ConventionalDrive, load_mass: float | None) -> Scenario:
    cobotic = {"steering": "locked"} if isinstance(drive, CoboticDrive) else {}
    mass = "load_inertia" if drive.axis.rotary else "load_mass"
    return Scenario(duration=1.0, link="free", **cobotic, **{mass: load_mass})  # type: ignore[arg-type]


def _data(name: str) -> str:
    return (resources.files("infinivar.exports") / "data" / name).read_text("utf-8")


def _fmu(made: Plant, version: str) -> tuple[Mapping[str, bytes], tuple[str, ...]]:
    from infinivar import __version__

    settable = (str(int(not made.variables[place].fixed)) for place in made.places("parameter"))
    known = [
        f'static const char token[] = "{token(made, version)}";',
        f"static const int settable[] = {{{', '.join(settable) or '0'}}};",
    ]
    text = "\n".join(
        [
            _named(made.text, made.name),
            made.control,
            *known,
            *map(_data, ("instance.c", f"fmi{version[0]}.c", "both.c")),
        ]
    )
    files = {
        "modelDescription.xml": model_description(made, version, f"infinivar {__version__}"),
        f"sources/{made.name}.c": text.encode(),
        **({"sources/buildDescription.xml": build_description(made, version)} if version == "3.0" else {}),
    }
    place, notes = _place(version), ()
    compiled = None if place is None else binary(text, *FLAGS, *_SMALL)
    if compiled is None:
        why = "the C compiler failed" if place else f"FMI {version} has no name for this platform"
        why = "no C compiler" if compiler() is None else why
        notes = (f"sources only ({why}): the importer must compile the FMU",)
    else:
        ending = "dylib" if sys.platform == "darwin" else "so"
        files[f"binaries/{place}/{made.name}.{ending}"] = compiled
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for file, content in sorted(files.items()):
            one = zipfile.ZipInfo(file, _FIRST_DAY)
            one.external_attr = 0o644 << 16
            archive.writestr(one, content, zipfile.ZIP_DEFLATED, 9)
    return {f"{made.name}.fmu": packed.getvalue()}, notes


def _place(version: str) -> str | None:
    """Folder of a binary for this platform; None where the standard has no name for it."""
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    system = {"linux": "linux", "darwin": "darwin"}.get(sys.platform)
    if system is None or machine not in ("x86_64", "aarch64"):
        return None
    if version == "3.0":
        return f"{machine}-{system}"
    return f"{system}64" if machine == "x86_64" else None


_ARRAYS: tuple[tuple[str, str, tuple[Role, ...]], ...] = (
    ("x", "States", ("state",)),
    ("f", "Derivatives of the states, from `rates_at`", ("derivative",)),
    ("u", "Inputs", ("input", "command")),
    ("du", "Rates of inputs", ("rate",)),
    ("y", "Outputs, from `outputs_at`", ("output",)),
    ("goal", "Goal of the controller, after its time", ("goal",)),
    ("p", "Parameters; what follows them in the array are tables", ("parameter",)),
)
"""Arrays of the C functions, and the roles of their variables."""


def _source(made: Plant, drive: Any) -> tuple[Mapping[str, bytes], tuple[str, ...]]:
    own, main = ("", _data("main.c"))
    if made.signals:
        own, main = made.control + _data("control.c"), _data("main_loop.c")
    texts = {
        f"{made.name}.c": _named(made.text + _data("plain.c") + own, made.name),
        f"{made.name}_main.c": main.replace("NAME", made.name),
        f"{made.name}.md": "\n".join(_arguments(made)) + "\n",
    }
    notes: tuple[str, ...] = ()
    try:
        texts |= law_files(drive, f"{made.name}_laws")
    except (
        TypeError,
        AttributeError,
        ParameterError,
    ) as problem:  # the plant may have C where the motion has no formula
        notes = (f"without {made.name}_laws, the functions for a controller: {problem}",)
    return {name: text.encode() for name, text in texts.items()}, notes


def _named(text: str, name: str) -> str:
    """C whose functions have the name of the plant before their own for a linker, so that several plants go together."""
    functions = re.findall(r"^(?:void|int|double) (\w+)\(", text, re.MULTILINE)
    return "\n".join([*(f"#define {one} {name}_{one}" for one in functions), "", text])


def _arguments(made: Plant) -> Iterator[str]:
    """Yield the lines that describe the arguments of the C functions."""
    yield from (f"# {made.title}", "")
    yield from _data("arguments.md").replace("NAME", made.name).splitlines()
    if made.signals:
        yield from ("", "## Controller", "", *_data("control.md").replace("NAME", made.name).splitlines())
        yield f"Signals, in this order: {', '.join(f'`{one}`' for one in made.signals)}."
    for array, title, roles in _ARRAYS:
        rows = [made.variables[place] for place in made.places(*roles)]
        if not rows:
            continue
        yield from ("", f"## {title}", "", "| | name | start | unit | meaning |", "| --- | --- | --- | --- | --- |")
        for number, one in enumerate(rows):
            start = "" if one.start is None else f"{one.start:.9g}"
            meaning = one.description.replace("|", "/")
            yield f"| {array}[{number}] | {one.name} | {start} | {one.unit} | {meaning} |"
