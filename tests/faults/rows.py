"""Faults as rows of data, read from the TOML files beside: a name, what is changed in a good text, and what is said of it."""

import json
import re
import tomllib
from pathlib import Path
from string import Template

from run_cli import run


def sections(topic):
    """The tables of a file, by name."""
    return tomllib.loads(Path(__file__).with_name(f"{topic}.toml").read_text("utf-8"))


STUDIES = sections("studies")
PIECES = STUDIES.pop("pieces")
PIECES["good"] = PIECES["requirement"] + PIECES["mine"] + PIECES["geared"]
VALUES = STUDIES.pop("values")
SETTINGS = ("study", "command", "says")


def rows(tables):
    """Each row of tables as (id, settings, change, words); a table's settings are its title and what SETTINGS names."""
    for title, table in tables.items():
        settings = {"title": title} | {name: value for name, value in table.items() if name in SETTINGS}
        for name, row in table.items():
            if name not in settings:
                yield f"{title}: {name}", settings, row[0], row[1:]


def changed(text, changes):
    """The text with other lines, by number, and other parts."""
    for old, new in changes.items():
        if old.isdigit():
            lines = text.splitlines()
            lines[int(old) - 1] = new
            text = "\n".join(lines) + "\n"
        else:
            assert old in text
            text = text.replace(old, new)
    return text


def study(change, pieces=PIECES, around="$row"):
    """A study that is written out, in which pieces may stand, or the good one with changes."""
    if isinstance(change, dict):
        return changed(pieces["good"], change)
    return Template(around.replace("$row", change)).substitute(pieces)


def toml(value):
    return (
        f'"{value}"' if isinstance(value, str) else json.dumps(value).replace("Infinity", "inf").replace("NaN", "nan")
    )


def with_value(field, value):
    """A good study in which one field is overridden."""
    owner, _, key = field.rpartition(".")
    line = f"{key} = {toml(value)}\n"
    if owner == "requirement":
        return re.sub(rf"{key} = .*\n", "", PIECES["requirement"]) + line + PIECES["mine"]
    return PIECES["requirement"] + PIECES["mine"] + ("" if owner == "drives.mine" else f"[{owner}]\n") + line


def check_lines(outcome, words, begins=""):
    """Assert exit code 2 and a message of so many short lines, each of which names the file and holds its words."""
    said = outcome.err.removeprefix("infinivar: ").splitlines()
    expected = words if isinstance(words[0], list) else [words]
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("infinivar: ")
    assert len(said) == len(expected), outcome.err
    assert len(outcome.err) < 500 * len(said)
    for line, held in zip(said, expected, strict=True):
        assert line.startswith("study.toml: " + begins), line
        assert line.isprintable(), line
        missing = [word for word in held if word not in line]
        assert not missing, f"{missing} not in: {line}"


def refused(folder, command, files, words, begins=""):
    """Run a command on files that have a fault; assert the message, and that nothing is written."""
    files = {name: content if isinstance(content, bytes) else content.encode() for name, content in files.items()}
    for name, content in files.items():
        (folder / name).write_bytes(content)
    check_lines(run(*command.split(), folder=folder), words, begins)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == files
