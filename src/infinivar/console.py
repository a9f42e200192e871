"""Terminal output: exit codes, messages, results, progress."""

from __future__ import annotations

import contextlib
import io
import os
import shlex
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from infinivar import __version__
from infinivar.errors import InputError, printable

NOT_FEASIBLE, BAD_INPUT, OWN_FAULT, INTERRUPTED = 1, 2, 3, 130


def run(command: Callable[[], Any]) -> None:
    """Run a command and exit: 0 done, 1 not feasible, 2 invalid input, 3 internal error, 130 interrupted."""
    _usable_streams()
    _quiet_libraries()
    try:
        try:
            command()
        finally:
            flush()
    except InputError as problem:
        complain(str(problem))
        sys.exit(BAD_INPUT)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    except OSError as problem:
        complain(f"{problem.filename or 'standard output'}: {problem.strerror}")
        sys.stdout = None  # the stream is gone; a flush at exit would fail again
        sys.exit(BAD_INPUT)
    except Exception as problem:
        complain(f"internal error: {_in_one_line(problem)}; {_keep_traceback(problem)}")
        sys.exit(OWN_FAULT)


class _Tolerant(io.TextIOWrapper):
    """A standard stream that drops what nobody can read any more, so that the answer still decides the exit code.

    A reader that has gone, as after head, ends no command; nor does anything that happens to messages.
    """

    ignored: type[OSError] = OSError

    def write(self, text: str, /) -> int:
        """Write; the text is lost if the stream is."""
        with self._dropping():
            super().write(text)
        return len(text)

    def flush(self) -> None:
        """Flush; what is left is lost if the stream is."""
        with self._dropping():
            super().flush()

    @contextlib.contextmanager
    def _dropping(self) -> Iterator[None]:
        try:
            yield
        except self.ignored:
            with contextlib.suppress(OSError):  # what is buffered goes there as well
                os.dup2(os.open(os.devnull, os.O_WRONLY), self.fileno())


class _Output(_Tolerant):
    ignored = BrokenPipeError


def _usable_streams() -> None:
    """Make both streams writable, even if the shell closed them, nobody reads them, or their encoding lacks a character."""
    for name, tolerant in (("stdout", _Output), ("stderr", _Tolerant)):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 (as long as the program runs)
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
            if stream is getattr(sys, f"__{name}__"):
                lines = stream.line_buffering
                setattr(sys, name, tolerant(stream.buffer, stream.encoding, "replace", line_buffering=lines))


def _quiet_libraries() -> None:
    """Keep what libraries log, such as a cache that they cannot write, from the streams of a command."""
    import logging

    logging.getLogger().addHandler(logging.NullHandler())


def flush() -> None:
    """Hand over what is printed so far."""
    sys.stdout.flush()


def say(text: str = "") -> None:
    """Print a line of the result, with control characters escaped."""
    write(printable(text) + "\n")


def write(text: str) -> None:
    """Write a part of the result unchanged."""
    sys.stdout.write(text)


def complain(text: str) -> None:
    """Print an error message on stderr."""
    print(f"infinivar: {printable(text, keep=chr(10))}", file=sys.stderr)


def _in_one_line(problem: Exception) -> str:
    message = " ".join(str(problem).split())
    return f"{type(problem).__name__}{': ' if message else ''}{message[:200]}"


def _keep_traceback(problem: Exception) -> str:
    """Write the traceback to a file and return a sentence that names the file."""
    import tempfile
    import traceback

    request = "please report it with your study"
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="infinivar-", suffix=".txt", delete=False, encoding="utf-8"
        ) as file:
            file.write(f"infinivar {__version__}, {shlex.join(sys.argv)}\n\n")
            traceback.print_exception(problem, file=file)
    except OSError:
        return request
    return f"the traceback is in {file.name}; {request}"


@contextlib.contextmanager
def progress_bar() -> Iterator[Callable[[str, float], None]]:
    """Show a progress bar on stderr if it is a terminal."""
    if not sys.stderr.isatty():
        yield lambda title, share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description:<40.40}", markup=False), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading", total=1.0)
        yield lambda title, share: bar.update(task, description=title, completed=share)
