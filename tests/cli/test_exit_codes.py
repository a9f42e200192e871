"""Exit codes as documented: 0 done, 1 not feasible, 2 invalid input, 3 internal error, 130 interrupted."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from internals import engine
from internals import study_loading as load
from sampled import sampled

STUDY = Path(__file__).parents[2] / "studies" / "knee_walking.toml"


def _fails(problem):
    def load_study(path):
        raise problem

    return load_study


@pytest.mark.parametrize(
    "problem",
    [ValueError("operands could not be broadcast together"), ZeroDivisionError("division"), KeyError("kne")],
    ids=["NumPy's ValueError", "arithmetic", "look-up"],
)
def test_a_crash_is_a_fault_of_the_program_and_keeps_its_traceback(infinivar, monkeypatch, problem):
    monkeypatch.setattr(load, "load_study", _fails(problem))
    found = infinivar("check", STUDY)
    assert found.code == 3
    assert found.err.startswith(f"infinivar: internal error: {type(problem).__name__}")
    assert found.err.count("\n") == 1
    kept = Path(re.search(r"the traceback is in (\S+\.txt);", found.err)[1])
    text = kept.read_text("utf-8")
    kept.unlink()
    assert "Traceback (most recent call last)" in text
    assert "load_study" in text


def test_interrupted(infinivar, monkeypatch):
    monkeypatch.setattr(load, "load_study", _fails(KeyboardInterrupt()))
    assert infinivar("check", STUDY).code == 130


def _shell(command: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        ["bash", "-c", command.replace("infinivar", f"{sys.executable} -m infinivar")],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@sampled(
    ("command", "code"),
    [
        ("infinivar catalogue >&-", 0),
        ("infinivar catalogue 2>&-", 0),
        ("infinivar catalogue | head -n 1; exit ${PIPESTATUS[0]}", 0),
        ("infinivar catalogue >/dev/full", 2),
        ("infinivar catalogue nonsense", 2),
        ("infinivar --help | true; exit ${PIPESTATUS[0]}", 0),
        ("infinivar --help >/dev/full", 2),
        ("infinivar check nope.toml 2>/dev/full", 2),
        ("infinivar check nope.toml 2>&-", 2),
        ("infinivar check nope.toml 2>&1 >/dev/full | true; exit ${PIPESTATUS[0]}", 2),
        ("infinivar check nope.toml >/dev/full 2>/dev/full", 2),
        ("infinivar check --nonsense 2>/dev/full", 2),
        ("infinivar 2>/dev/full", 2),
        ("infinivar catalogue >/dev/full 2>/dev/full", 2),
        ("infinivar catalogue 2>/dev/full", 0),
        ("infinivar catalogue search motors 'mass < 1 mg' 2>/dev/full", 1),
    ],
    every=3,
)
@pytest.mark.slow
def test_streams_that_are_closed_or_full_give_no_traceback(command, code):
    found = _shell(command)
    assert found.returncode == code, found.stderr
    assert "Traceback" not in found.stderr
    assert "Exception ignored" not in found.stderr


@pytest.mark.slow
@pytest.mark.parametrize("home", ["HOME=/dev/null/none", "-u HOME"])
def test_without_a_home_no_library_speaks(home, tmp_path):
    """Matplotlib then has no folder for its cache of fonts, and logs that twice."""
    found = _shell(
        f"env -u XDG_CACHE_HOME -u XDG_CONFIG_HOME -u MPLCONFIGDIR {home} infinivar graph {STUDY} cobotic --out {tmp_path}/g.svg"
    )
    assert found.returncode == 0
    assert [line for line in found.stderr.splitlines() if not line.startswith("infinivar: ")] == []


@pytest.mark.slow
def test_a_user_whom_the_system_does_not_know_has_no_cache(monkeypatch, infinivar, tmp_path):
    """As in a container that runs under a number of its own."""
    for name in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("os.path.expanduser", lambda path: path)
    monkeypatch.chdir(tmp_path)
    assert engine.cache_folder() is None
    assert infinivar("graph", STUDY, "cobotic", "--out", "g.svg").code == 0
    assert infinivar("catalogue", "list").code == 0
    (tmp_path / "mine.csv").write_text("key,resistance [ohm]\n")
    found = infinivar("catalogue", "import", "mine", "mine.csv")
    assert (found.code, found.out) == (2, "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["g.svg", "mine.csv"]
