"""Write the plant of a drive or machine as an FMU or as C, or a drive as an actuator of MuJoCo."""

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

from infinivar._core.c_library import FLAGS, CompilerError, binary, compiler, zig
from infinivar._core.threads import in_order
from infinivar.analysis.sessions.session import Setup
from infinivar.bondgraph.c_code import array_of
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import check_drive, refuse_machine
from infinivar.errors import ParameterError, path_of, printable, require
from infinivar.exports.description import build_description, model_description, token
from infinivar.exports.laws import law_files
from infinivar.exports.machine_plant import machine_plant, moves, moving_machine, moving_plant, session_plant
from infinivar.exports.mujoco import mujoco_files
from infinivar.exports.plant import Plant, Role, plant
from infinivar.motion.scenario import Scenario, check_scenario
from infinivar.report.output import all_files_or_none
from infinivar.study.provenance import Provenance
from infinivar.study.sessions import SessionTask, session_arguments

FORMATS = ("fmu2", "fmu3", "c", "mujoco")
"""What a drive is written as."""

_VERSIONS = {"fmu2": "2.0", "fmu3": "3.0"}
_FIRST_DAY = (1980, 1, 1, 0, 0, 0)
"""Time of every file in an FMU, so that the same model gives the same bytes."""


_SMALL = ("-O1", "-Wl,-s")
"""Flags of a compiler that is half as quick and makes a smaller file."""

_INTERFACE = ("-fvisibility=hidden",)
"""Flag of a library that shows the interface's functions alone."""


class Platform(NamedTuple):
    """What zig and the versions of FMI call a platform, and the ending of its libraries; "" without a name."""

    target: str
    fmi2: str
    fmi3: str
    ending: str


PLATFORMS = (
    Platform("x86_64-linux-gnu.2.17", "linux64", "x86_64-linux", "so"),
    Platform("aarch64-linux-gnu.2.17", "", "aarch64-linux", "so"),
    Platform("x86_64-windows-gnu", "win64", "x86_64-windows", "dll"),
    Platform("x86_64-macos", "darwin64", "x86_64-darwin", "dylib"),
    Platform("aarch64-macos", "", "aarch64-darwin", "dylib"),
)
"""For these an FMU has binaries where zig is installed; else for this one."""


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
    scenario: Scenario | SessionTask | None = None,
    load_mass: float | None = None,
    closed: bool = False,
    sources: Iterable[Provenance] = (),
) -> Exported:
    """Write the plant of a drive, without its controllers or with them, for other programs.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive, or a machine   With the inertias that motion requires. A machine of a study, or
        one that moves: it starts at home, at rest but for its cylinder, with wheels straight ahead; currents of motors and
        servos, or rates of steering without servos, and what a user exerts on coordinates and handle are its inputs.
    kind : str             "fmu2" or "fmu3": an FMU for Model Exchange and Co-Simulation, NAME.fmu; "c": NAME.c, a program that
        runs it, NAME_main.c, and its arguments, NAME.md; for controllers NAME_laws.c, NAME_laws.h and their test; and with
        the extra `compiled` NAME_binaries.zip, its libraries;
        "mujoco": an actuator as a plugin of MuJoCo, NAME.so, its source, NAME_mujoco.c, and MJCF: NAME_actuator.xml, to include
        in a model that has a joint NAME, and NAME.xml, a model that runs at once.
    out : str or Path      Folder; created if missing.
    name : str             Of the files, in letters, digits, "-" and "_"; and owner of the drive's values in `sources`.
    title : str            Of the model. Default: `name`.
    scenario : Scenario or SessionTask   States what the amplifier imposes (a current, or a voltage through its current loop),
        whether the load is pushed or moved, its mass, and where the motion starts. Default: currents, a load that a force pushes,
        at rest, with the cylinder at its speed. Of a machine, or a drive that moves a handle, one of ``study.sessions``: the
        user, with an arm or a force, is at the handle, and the motion starts as the session. Does not apply to "mujoco".
    load_mass : float      Mass of the load of the default scenario, or its moment of inertia. [kg] or [kg m^2]
    closed : bool          Whether the controllers of the scenario are part of it: they follow a goal, position, speed and
        acceleration, which are inputs; that of a session has its sensors, and has taken its first sample.
    sources : iterable of Provenance   Such as ``study.provenance``: where the values of parameters come from.

    Returns
    -------
    Exported   Files, and notes: with the extra `compiled` an FMU holds binaries for Linux, Windows and macOS, with another
        C compiler for this platform, without one sources only.

    Raises
    ------
    ParameterError
        If it lacks a value that motion requires, or a machine has a scenario without a user or is to be an actuator of MuJoCo.
    InputError
        If a law or the controller of a session has no C, or a file cannot be written; for "mujoco", if MuJoCo or a C compiler is
        missing.

    Source: fmi2014, fmi2022.
    """
    require(kind in FORMATS, "kind", repr(kind), f"one of {', '.join(FORMATS)}")
    session = isinstance(scenario, SessionTask)
    several = session or moves(drive)
    if not several:
        check_drive(drive, "drive")
        if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
            raise ParameterError(f"a drive of type {type(drive).__name__} has no bond graph")
    elif kind == "mujoco":
        refuse_machine(drive, "export as mujoco")
    require(isinstance(name, str) and bool(name), "name", repr(name), "a name of one letter or more")
    sources = tuple(sources) if isinstance(sources, Iterable) else sources
    stated = isinstance(sources, tuple) and all(isinstance(row, Provenance) for row in sources)
    require(stated, "sources", repr(sources), "rows of provenance, such as study.provenance")
    identifier = identifier_of(name)
    if several:
        if isinstance(scenario, SessionTask):
            require(load_mass is None, "load_mass", load_mass, "left out: a session states its masses")
            arguments = session_arguments(scenario, drive, "scenario", "drive")
            moving = session_plant(Setup(**arguments), closed=closed)
        else:
            require(
                scenario is None and not closed, "scenario", "one", "a session of a study for a machine, or left out"
            )
            moving = moving_plant(moving_machine(drive, load_mass))
        made = machine_plant(moving, identifier, title or name)
        content, notes = _source(made, None) if kind == "c" else _fmu(made, _VERSIONS[kind])
        notes = (*moving.notes, *notes)
    elif kind == "mujoco":
        require(scenario is None and not closed, "scenario", "one", "left out: MuJoCo has the load and the motion")
        content, notes = mujoco_files(drive, identifier, load_mass)
    else:
        assert not isinstance(scenario, SessionTask)
        used = _usual(drive, load_mass) if scenario is None else scenario
        check_scenario(used)
        own = [row for row in sources if row.owner == name]
        made = plant(drive, used, identifier, title or name, own, closed=closed)
        content, notes = _source(made, drive) if kind == "c" else _fmu(made, _VERSIONS[kind])
    folder = path_of(out, "out")
    with all_files_or_none(*(folder / file for file in content)) as files:
        for file in files:
            file.write_bytes(content[file.name])
    return Exported(tuple(folder / file for file in content), notes)


def identifier_of(name: str) -> str:
    """Name of a drive in C and of its files, of which none is a file of a drive with another name."""
    made = re.sub(r"\W", "_", name, flags=re.ASCII)[:48]
    made = made if made[:1].isalpha() else f"drive_{made}"
    return f"{made}_drive" if re.search(r"_(main|laws|laws_test|mujoco|actuator)(_drive)*$", made) else made


def _usual(drive: CoboticDrive | ConventionalDrive, load_mass: float | None) -> Scenario:
    cobotic = {"steering": "locked"} if isinstance(drive, CoboticDrive) else {}
    mass = "load_inertia" if drive.axis.rotary else "load_mass"
    return Scenario(duration=1.0, link="free", **cobotic, **{mass: load_mass})  # type: ignore[arg-type]


def _data(name: str) -> str:
    return (resources.files("infinivar.exports") / "data" / name).read_text("utf-8")


def _fmu(made: Plant, version: str) -> tuple[Mapping[str, bytes], tuple[str, ...]]:
    from infinivar import __version__

    parameters = [made.variables[place] for place in made.places("parameter")]
    settable = (str(int(not one.fixed)) for one in parameters)
    known = [
        f'static const char token[] = "{token(made, version)}";',
        f"static const int settable[] = {{{', '.join(settable) or '0'}}};",
        *array_of([one.least for one in parameters], "least"),
        *array_of([one.most for one in parameters], "most"),
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
    compiled, notes = _binaries(text, made.name, version, *_INTERFACE)
    files |= compiled
    return {f"{made.name}.fmu": _packed(files)}, notes


def _packed(files: Mapping[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for file, content in sorted(files.items()):
            one = zipfile.ZipInfo(file, _FIRST_DAY)
            one.external_attr = 0o644 << 16
            archive.writestr(one, content, zipfile.ZIP_DEFLATED, 9)
    return packed.getvalue()


def _binaries(text: str, name: str, version: str, *flags: str) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Binaries by file: for every platform if there is zig, which gives the same everywhere, else for this one."""
    own, every, failures = _own(), zig() is not None, list[str]()

    def named(one: Platform) -> str:
        return one.fmi2 if version == "2.0" else one.fmi3

    def compiled(one: Platform) -> bytes | None:
        within = (f"-Wl,-install_name,@rpath/{name}.dylib",) if every and one.ending == "dylib" else ()
        target = one.target if every else ""
        try:
            return binary(text, f"{name}.{one.ending}", *FLAGS, *_SMALL, *flags, *within, target=target)
        except CompilerError as problem:
            failures.append(printable(str(problem)))
            return None

    wanted = [one for one in (PLATFORMS if every else [own] if own else []) if named(one)]
    found = {
        f"binaries/{named(one)}/{name}.{one.ending}": content
        for one, content in zip(wanted, in_order(compiled, wanted), strict=True)
        if content is not None
    }
    if found and len(found) == len(wanted):
        return found, ()
    failed = ": ".join(["the C compiler failed", *failures[:1]])
    if found:
        return found, (f"binaries for {', '.join(sorted(file.split('/')[1] for file in found))} only: {failed}",)
    why = failed if wanted else f"FMI {version} has no name for this platform"
    why = "no C compiler" if compiler() is None and not every else why
    return {}, (f"sources only ({why}): the importer must compile the FMU",)


def _own() -> Platform | None:
    """This platform, if FMI has a name for it."""
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    system = f"{machine}-{sys.platform}"
    return next((one for one in PLATFORMS if one.fmi3 == system), None)


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
        f"{made.name}.md": "",
    }
    notes: tuple[str, ...] = ()
    try:
        texts |= {} if drive is None else law_files(drive, f"{made.name}_laws")
    except (
        TypeError,
        AttributeError,
        ParameterError,
    ) as problem:  # the plant may have C where the motion has no formula
        notes = (f"without {made.name}_laws, the functions for a controller: {problem}",)
    texts[f"{made.name}.md"] = "\n".join(_arguments(made, f"{made.name}_laws.h" in texts)) + "\n"
    files = {name: text.encode() for name, text in texts.items()}
    if zig() is not None:
        compiled, more = _binaries(texts[f"{made.name}.c"], made.name, "3.0")
        files |= {f"{made.name}_binaries.zip": _packed(compiled)} if compiled else {}
        notes += more
    return files, notes


def _named(text: str, name: str) -> str:
    """C whose functions have the name of the plant before their own for a linker, so that several plants go together."""
    functions = re.findall(r"^(?:void|int|double) (\w+)\(", text, re.MULTILINE)
    return "\n".join([*(f"#define {one} {name}_{one}" for one in functions), "", text])


def _arguments(made: Plant, laws: bool) -> Iterator[str]:
    """Yield the lines that describe the arguments of the C functions; laws: whether there are those for a controller."""
    yield from (f"# {made.title}", "")
    yield from _data("arguments.md").replace("NAME", made.name).splitlines()
    if laws:
        yield from ("", f"`{made.name}_laws.c` has what a controller needs: see `{made.name}_laws.h`.")
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
