"""Exit codes as documented: 0 done, 1 not feasible, 2 invalid input, 3 internal error, 130 interrupted."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from infinivar.study import load
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
    ],
    every=2,
)
def test_streams_that_are_closed_or_full_give_no_traceback(command, code):
    found = _shell(command)
    assert found.returncode == code, found.stderr
    assert "Traceback" not in found.stderr
    assert "Exception ignored" not in found.stderr
