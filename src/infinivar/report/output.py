"""Write results: one run at a time per folder, with all files of a result replaced together."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from infinivar.errors import InputError, printable

_LOCK, _MANIFEST = ".infinivar.lock", ".infinivar.json"


@contextlib.contextmanager
def claimed(directory: Path) -> Iterator[None]:
    """Create the directory if needed and reserve it for this run while the block lasts.

    Raises
    ------
    InputError
        If the directory cannot be made or written to, or another run has claimed it.
    """
    from filelock import FileLock, Timeout

    there = directory.is_dir()
    try:
        directory.mkdir(parents=True, exist_ok=True)
        lock = FileLock(directory / _LOCK, is_singleton=True)
        with lock.acquire(timeout=0):
            yield
    except Timeout as problem:
        raise InputError(
            f"{printable(directory)}: another run is writing its results there; wait until it ends, or choose another folder"
        ) from problem
    except OSError as problem:
        raise InputError(f"{printable(directory)}: cannot be written to: {_why(directory, problem)}") from problem
    finally:
        if not there:
            _remove_empty(directory)


def _why(directory: Path, problem: OSError) -> str:
    """Reason why a folder cannot be created or written to."""
    taken = next((place for place in (directory, *directory.parents) if place.is_file()), None)
    return str(problem.strerror) if taken is None else f"{printable(taken)} is a file, not a folder"


def _remove_empty(directory: Path) -> None:
    """Remove a folder that was created and stayed empty."""
    with contextlib.suppress(OSError):
        if [made.name for made in directory.iterdir()] == [_LOCK]:
            (directory / _LOCK).unlink()
            directory.rmdir()


@contextlib.contextmanager
def all_or_nothing(directory: Path, kind: str) -> Iterator[Path]:
    """Scratch folder whose files replace the results of the same kind when the block ends without error.

    Old results are taken away before new ones come, so that the two are never mixed; files of others stay.

    Parameters
    ----------
    directory : Path   Of the results.
    kind : str         What they are results of, such as "compare".

    Raises
    ------
    InputError
        If the directory cannot be written to, or a result would replace a folder.
    """
    with claimed(directory):
        try:
            with tempfile.TemporaryDirectory(dir=directory, prefix=".infinivar-") as scratch:
                made, old = Path(scratch) / "made", Path(scratch) / "old"
                made.mkdir()
                old.mkdir()
                yield made
                _replace(directory, kind, made, old)
        except OSError as problem:
            raise InputError(f"{printable(directory)}: cannot be written to: {problem.strerror}") from problem


@contextlib.contextmanager
def all_files_or_none(*files: Path) -> Iterator[tuple[Path, ...]]:
    """Files of other names to write, in a scratch folder, which replace the files when the block ends without error.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    for file in files:
        check_file(file)
    folder = files[0].parent
    try:
        with tempfile.TemporaryDirectory(dir=folder, prefix=".infinivar-") as scratch:
            made = tuple(Path(scratch) / file.name for file in files)
            yield made
            for one, file in zip(made, files, strict=True):
                one.replace(file)
    except OSError as problem:
        raise InputError(f"{printable(files[0])}: cannot be written: {problem.strerror}") from problem


def check_inputs(directory: Path, kind: str, inputs: Mapping[Path, str], writes: Callable[[str], bool]) -> None:
    """Raise an error if results would replace or remove a file that they are computed from.

    Parameters
    ----------
    directory : Path     Of the results.
    kind : str           What they are results of, as for `all_or_nothing`: its old results are removed.
    inputs : mapping     What each input is, in words, by file.
    writes : callable    Whether a file of this name may be written.

    Raises
    ------
    InputError
        With the first such file.
    """
    folder, old = directory.resolve(), _manifest(directory).get(kind, ())
    for file, words in inputs.items():
        # A link is replaced itself; elsewhere, what it leads to.
        for place in (file.parent.resolve() / file.name, file.resolve()):
            if place.parent == folder and (writes(place.name) or place.name in old):
                raise InputError(
                    f"{printable(file)}: is {words}, and the results in {printable(directory)} would replace it; choose another "
                    "folder for them"
                )


def _replace(directory: Path, kind: str, made: Path, old: Path) -> None:
    names = sorted(file.name for file in made.iterdir())
    for name in names:
        if (directory / name).is_dir():
            raise InputError(f"{directory / name}: cannot be replaced: is a folder")
    manifest = _manifest(directory)
    # Both names until all files are in place: the next run removes what a killed run left behind.
    _note(directory, {**manifest, kind: sorted({*manifest.get(kind, ()), *names})})
    for name in {*manifest.get(kind, ()), *names}:
        with contextlib.suppress(FileNotFoundError):
            (directory / name).replace(old / name)
    for name in names:
        (made / name).replace(directory / name)
    _note(directory, {**manifest, kind: names})


def _manifest(directory: Path) -> dict[str, list[str]]:
    """Files in the folder by kind of result; empty if unknown."""
    try:
        known = json.loads((directory / _MANIFEST).read_text("utf-8"))
        return {
            kind: [name for name in names if isinstance(name, str) and Path(name).name == name]
            for kind, names in known.items()
        }
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


def _note(directory: Path, manifest: dict[str, list[str]]) -> None:
    (directory / _MANIFEST).write_text(json.dumps(manifest, indent=1) + "\n", "utf-8")


def check_file(path: Path) -> None:
    """Raise an error early if the file cannot be written.

    Raises
    ------
    InputError
        If it is a folder, or its folder cannot be made or written to.
    """
    if path.is_dir():
        raise InputError(f"{printable(path)}: is a folder, not a file to write")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as problem:
        raise InputError(f"{printable(path)}: cannot be written: {_why(path.parent, problem)}") from problem
