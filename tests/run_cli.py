"""The command line run inside the test process."""

import contextlib
import io
import sys
from dataclasses import dataclass
from pathlib import Path

from infinivar.cli import main


@dataclass(frozen=True)
class Outcome:
    code: int
    out: str
    err: str


def run(*arguments, folder: Path) -> Outcome:
    """What `infinivar ARGUMENTS` does when typed in a folder."""
    out, err, argv, code = io.StringIO(), io.StringIO(), sys.argv, 0
    sys.argv = ["infinivar", *map(str, arguments)]
    try:
        with contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                main()
            except SystemExit as stop:
                code = stop.code or 0
    finally:
        sys.argv = argv
    return Outcome(code, out.getvalue(), err.getvalue())
