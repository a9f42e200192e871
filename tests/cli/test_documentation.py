"""What the pages of the documentation show is what the program does.

On each page, from top to bottom in one folder and one namespace: ``toml`` blocks that begin with ``# NAME.toml`` are
written to that file (appended with ``, continued``); ``python`` blocks run, and a ``text`` block after one is what it
printed; lines of ``console`` blocks that begin with ``$ `` are run, and what follows them is what they print.
"""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from internals import c_library
from run_cli import run
from sampled import sampled

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```(\w+)[^\n]*\n(.*?)^```$", re.DOTALL | re.MULTILINE)
FILE = re.compile(r"# (\S+\.toml)(, continued)?\n")


def typed(line, folder):
    """What a line typed in a folder prints: by this process if it is a command of ours alone, by a shell otherwise."""
    program, *arguments = shlex.split(line)
    if program == "infinivar" and not set(line) & set("|<>;&$*`"):
        outcome = run(*arguments, folder=folder)
        return outcome.out + outcome.err
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(line, shell=True, capture_output=True, text=True, env=environment, cwd=folder)
    return done.stdout + done.stderr


def shown_and_real(text, folder):
    """Pairs of what a page shows and what happened, for every block that shows output."""
    namespace: dict = {}
    printed = None
    for language, body in BLOCK.findall(text):
        if language == "python":
            with contextlib.redirect_stdout(io.StringIO()) as output:
                exec(compile(body, "page", "exec"), namespace)
            printed = output.getvalue()
        elif language == "text" and printed is not None:
            yield body, printed
            printed = None
        elif language == "toml" and (named := FILE.match(body)):
            with (folder / named[1]).open("a" if named[2] else "w", encoding="utf-8") as file:
                file.write(("\n" if named[2] else "") + body)
        elif language == "console":
            real = ""
            for line in re.findall(r"^\$ .*$", body, re.MULTILINE):
                real += f"{line}\n{typed(line[2:], folder)}"
            yield body, real


DAILY = ("theory", "study-file", "extending", "explorer", "use-elsewhere")
SLOW = (
    "tutorial",
    "gait-to-motor",
    "contact",
    "machines",
    "displays",
    "parts",
    "recordings",
    "errata",
)
BEFORE_A_RELEASE = (
    "cobotic-or-conventional",
    "springs",
    "cobots",
    "sessions",
    "haptic-session",
    "calibration",
    "motion-and-control",
    "figures",
    "measurements",
    "sizing",
)
"""They take up to a minute and a half each."""


@sampled(
    "page",
    [
        *(f"{name}.md" for name in DAILY),
        *(pytest.param(f"{name}.md", marks=pytest.mark.slow) for name in SLOW),
        *(pytest.param(f"{name}.md", marks=pytest.mark.full) for name in BEFORE_A_RELEASE),
    ],
    every=4,
)
def test_page(page, tmp_path, monkeypatch):
    if page == "use-elsewhere.md" and c_library.compiler() is None:
        pytest.skip("no C compiler on this machine")
    if page == "use-elsewhere.md":
        pytest.importorskip("mujoco", reason="no MuJoCo: it comes with the extra robots")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "studies").symlink_to(ROOT / "studies")
    pairs = list(shown_and_real((ROOT / "docs" / page).read_text("utf-8"), tmp_path))
    assert [shown for shown, _ in pairs] == [real for _, real in pairs]
    assert pairs
