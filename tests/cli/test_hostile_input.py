"""Files, folders and titles that would hang, flood, mix up or steer: refused, or made harmless, before anything is computed."""

import json
import os
import subprocess
import sys
import threading
import time
import tomllib
from pathlib import Path

import pytest

import infinivar as iv
from folders import results
from infinivar import InputError
from internals import FaultyError, all_or_nothing, file_formats, tables_of
from internals import claimed_output as claimed
from internals import core_files as files
from internals import study_loading as load
from internals import toml_tables as toml

STUDY = """
{top}
[requirement]
force = "20 N"
speed = "0.3 m/s"
[drives.{name}]
base = "faulring2006.{base}"
{rest}
"""
RECORDED = '[duty.recorded]\nshape = "file"\nfile = "{file}"\n'


def study(top="", name="mine", base="motor2-gear4", rest=""):
    return STUDY.format(top=top, name=name, base=base, rest=rest)


def refused(outcome, *words):
    assert outcome.code == 2
    assert outcome.out == ""
    for word in words:
        assert word in outcome.err
    return True


@pytest.mark.parametrize("command", ["check", "compare", "contact"])
def test_a_pipe_does_not_hang(infinivar, write, tmp_path, command):
    os.mkfifo(tmp_path / "motion.csv")
    write(study(rest=RECORDED.format(file="motion.csv")))
    assert refused(infinivar(command, "study.toml"), "motion.csv: is not a regular file")
    os.mkfifo(tmp_path / "pipe.toml")
    assert refused(infinivar(command, "pipe.toml"), "pipe.toml: is not a regular file")


def test_a_device_is_not_read(infinivar, write):
    write(study(rest=RECORDED.format(file="/dev/zero")))
    assert refused(infinivar("check", "study.toml"), "/dev/zero: is not a regular file")
    assert refused(infinivar("check", "/dev/zero"), "/dev/zero: is not a regular file")


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="only Linux has tables of the system as files")
def test_a_table_of_the_system_is_no_regular_file(infinivar, write, tmp_path):
    """They look like empty files; one of them never ends, and one has nothing to read until something happens."""
    write('extends = "/proc/self/status"\n')
    assert refused(
        infinivar("check", "study.toml"), 'extends = "/proc/self/status": /proc/self/status: is not a regular file'
    )
    os.mkfifo(tmp_path / "pipe")
    write('extends = "pipe"\n')
    assert refused(infinivar("check", "study.toml"), 'extends = "pipe": pipe: is not a regular file')
    write('extends = "/dev/zero"\n')
    assert refused(infinivar("check", "study.toml"), "/dev/zero: is not a regular file")


def test_a_regular_file_that_has_nothing_to_read_yet(monkeypatch, tmp_path):
    """As the kernel's log: a read that would wait."""
    os.mkfifo(tmp_path / "log")
    writer = os.open(tmp_path / "log", os.O_RDWR)
    monkeypatch.setattr(files.stat, "S_ISREG", lambda mode: True)
    try:
        with pytest.raises(InputError, match="log: cannot be read: "):
            files.read(tmp_path / "log", 5)
    finally:
        os.close(writer)


@pytest.mark.parametrize(
    "read",
    [
        lambda path: iv.transmission.load_urdf(path, legs=("a",), frame="b", pulley_radius=0.1),
        lambda path: iv.motion.TriangleMesh.read(path, unit="m"),
    ],
    ids=["robot", "mesh"],
)
def test_a_pipe_in_place_of_a_robot_or_a_mesh_does_not_hang(read, tmp_path):
    os.mkfifo(tmp_path / "pipe.stl")
    with pytest.raises(InputError, match=r"pipe\.stl: is not a regular file"):
        read(tmp_path / "pipe.stl")


DEEP = {
    "dotted key": ".".join(["a"] * 30_000) + " = 1",
    "quoted, spaced": " . ".join(['"a"'] * 12_000) + " = 1",
    "heading": "[" + ".".join(["a"] * 30_000) + "]",
    "inline table": "x = {" + ".".join(["a"] * 30_000) + " = 1}",
    "after a text": 'description = """\n[\n"""\n' + ".".join(["a"] * 30_000) + " = 1",
}


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
def test_keys_that_a_parser_pays_for_are_refused_before_it_sees_them(monkeypatch, text):
    """One of 30,000 parts takes the parser 5 GB."""
    monkeypatch.setattr(toml.tomllib, "loads", lambda given: pytest.fail("the parser saw it"))
    with pytest.raises(InputError, match=r"has a key of more than 64 parts \(at line \d\)"):
        toml.loads(text)


def test_a_deep_or_long_key_is_refused_in_every_file(infinivar, write, tmp_path):
    write(DEEP["dotted key"])
    assert refused(infinivar("check", "study.toml"), "study.toml: has a key of more than 64 parts (at line 1)")
    (tmp_path / "mine.toml").write_text(DEEP["dotted key"])
    found = infinivar("catalogue", "import", "mine", "mine.toml")
    assert refused(found, "mine.toml: has a key of more than 64 parts (at line 1)")
    with pytest.raises(FaultyError, match="more than 64 parts"):
        tables_of(DEEP["dotted key"], "mine")
    write("a" * 60_000 + " = 1")
    outcome = infinivar("check", "study.toml")
    assert refused(outcome, "has a key of 60000 characters, which begins with 'aaaa")
    assert len(outcome.err) < 200
    write("x = " + "[" * 300 + "]" * 300)
    assert refused(infinivar("check", "study.toml"), "is nested too deeply (at line 1)")


def test_dots_and_brackets_in_texts_and_comments_are_no_keys():
    dots, brackets = ".".join(["a"] * 200), "[" * 200
    text = f"""# {dots} {brackets} it's
    a = "{dots} {brackets} # \\" {dots}"
    b = '{dots}'
    c = {'"' * 3}\n{dots} "" {brackets}{'"' * 3}
    d = [{", ".join(["[1.5, {x.y = 2}]"] * 200)}]
    """
    assert toml.loads(text) == tomllib.loads(text)


def test_large_files_are_refused_before_reading(infinivar, write, tmp_path):
    """Sparse files: to read them would take their size in memory."""
    for name, most in (("motion.csv", file_formats._MOST_BYTES), ("huge.toml", load._MOST_BYTES)):
        with (tmp_path / name).open("wb") as file:
            file.truncate(most + 1)
    write(study(rest=RECORDED.format(file="motion.csv")))
    assert refused(infinivar("check", "study.toml"), "motion.csv: has 200 MB, more than the 200 MB allowed")
    assert refused(infinivar("check", "huge.toml"), "huge.toml: has 4 MB, more than the 4 MB allowed")


def test_files_are_read_as_they_are(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert files.read(path, 5) == b"12345"
    with pytest.raises(InputError, match="more than"):
        files.read(path, 4)
    with pytest.raises(InputError, match="is a folder"):
        files.read(tmp_path, 4)
    with pytest.raises(InputError, match="no such file"):
        files.read(tmp_path / "gone", 4)
    with pytest.raises(InputError, match="cannot be read"):
        files.read(Path("nul\0"), 4)


def test_a_file_that_is_no_recording_is_not_echoed(infinivar, write, tmp_path):
    """What stands in a file that a study names by mistake, or by intent, is nobody's business."""
    (tmp_path / "secret.csv").write_text("root:x:0:0:hunter2\nmore,of,it\n", "utf-8")
    write(study(rest=RECORDED.format(file="secret.csv")))
    outcome = infinivar("check", "study.toml")
    assert refused(outcome, "line 1: must name columns of a motion, such as 'time [s]' and 'position [mm]'")
    assert "hunter2" not in outcome.err
    (tmp_path / "secret.csv").write_text(f"time [s],position [m]\n{'0123456789' * 50},1\n", "utf-8")
    assert len(infinivar("check", "study.toml").err) < 200


def test_a_description_may_have_several_lines(infinivar, write):
    write(study(top='description = """one\ntwo"""'))
    assert infinivar("check", "study.toml").code == 0


def test_names_from_the_command_line_are_spelt_out(infinivar):
    outcome = infinivar("check", "\x1b[31m.toml")
    assert refused(outcome, r"\x1b[31m.toml: no such file")


@pytest.mark.parametrize("command", ["compare", "contact", "simulate", "sensitivity"])
def test_an_empty_folder_name_is_no_folder(infinivar, write, tmp_path, command):
    write(study())
    outcome = infinivar(command, "study.toml", "--out", "")
    assert outcome.code == 2
    assert "must name a folder or file" in outcome.err
    assert results(tmp_path) == ["study.toml"]


@pytest.mark.parametrize(
    "command",
    [
        ["compare", "study.toml"],
        ["reproduce"],
        ["sensitivity", "study.toml", "--of", "loss"],
        ["simulate", "study.toml", "--scenario", "s"],
    ],
    ids=lambda command: command[0],
)
def test_a_folder_that_cannot_be_written_to_is_named_at_once(infinivar, write, tmp_path, command):
    write(
        study(
            rest='[scenarios.s]\nduration = "100 s"\nmotion = { shape = "sinusoid", distance = "1 mm", frequency = "1 Hz" }'
        )
    )
    (tmp_path / "taken").write_text("a file")
    start = time.process_time()
    assert refused(infinivar(*command, "--out", "taken/below"), "taken/below: cannot be written to")
    assert time.process_time() - start < 3.0  # the maps alone take longer


@pytest.mark.parametrize(
    ("command", "out", "said"),
    [
        (["reproduce"], "taken", "taken: cannot be written to: taken is a file, not a folder"),
        (["compare", "study.toml"], "taken/a/b", "taken/a/b: cannot be written to: taken is a file"),
        (["graph", "study.toml", "mine"], "taken/g.svg", "taken/g.svg: cannot be written: taken is a file"),
    ],
)
def test_a_file_in_place_of_a_folder_is_said_to_be_one(infinivar, write, tmp_path, command, out, said):
    write(study())
    (tmp_path / "taken").write_text("a file")
    assert refused(infinivar(*command, "--out", out), said)


@pytest.mark.slow
def test_names_of_files_stay_within_their_line(infinivar, write, tmp_path):
    write(study(base="cobotic"))
    done = infinivar("contact", "study.toml", "--out", "a\nb")
    assert "Report: a\\nb/contact.html" in done.out.splitlines()[-1]
    assert refused(infinivar("check", "no\nsuch.toml"), "no\\nsuch.toml: no such file")
    (tmp_path / "taken").write_text("a file")
    assert refused(
        infinivar("contact", "study.toml", "--out", "taken/a\nb"), "taken/a\\nb: cannot be written to: taken"
    )


def test_two_runs_do_not_share_a_folder(infinivar, write, tmp_path):
    """Another process that holds the folder, as a run does from beginning to end, sends the second away."""
    write(study())
    code = (
        "import sys, pathlib\nfrom infinivar.report.output import claimed\n"
        "with claimed(pathlib.Path('out')):\n print('mine', flush=True)\n sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=tmp_path
    ) as other:
        assert other.stdout.readline() == "mine\n"
        assert refused(infinivar("compare", "study.toml", "--out", "out"), "out: another run is writing its results")
        other.stdin.close()
    with claimed(tmp_path / "out"), claimed(tmp_path / "out"):
        pass  # free again, also for the same process twice


def test_results_are_replaced_whole(tmp_path):
    """Results of the same kind that the new run has not are gone; those of others and the user's own files stay."""
    (tmp_path / "notes.txt").write_text("mine", "utf-8")
    for kind, names in (("compare", "abc"), ("contact", "xy"), ("compare", "bd")):
        with all_or_nothing(tmp_path, kind) as scratch:
            for name in names:
                (scratch / name).write_text(f"{kind} {names}", "utf-8")
    assert results(tmp_path) == ["b", "d", "notes.txt", "x", "y"]
    assert (tmp_path / "b").read_text("utf-8") == "compare bd"


def write_half(folder):
    with all_or_nothing(folder, "compare") as scratch:
        (scratch / "a").write_text("half", "utf-8")
        raise RuntimeError("stop")


def test_a_failed_run_changes_nothing(tmp_path):
    with all_or_nothing(tmp_path, "compare") as scratch:
        (scratch / "a").write_text("before", "utf-8")
    with pytest.raises(RuntimeError, match="stop"):
        write_half(tmp_path)
    assert results(tmp_path) == ["a"]
    assert (tmp_path / "a").read_text("utf-8") == "before"
    made = tmp_path / "new"
    with pytest.raises(RuntimeError, match="stop"), claimed(made):
        raise RuntimeError("stop")
    assert not made.exists()


def test_a_manifest_that_is_wrong_takes_nothing_away(tmp_path):
    """Names in it that lead out of the folder are passed over."""
    outside = tmp_path / "outside.txt"
    outside.write_text("keep", "utf-8")
    folder = tmp_path / "out"
    folder.mkdir()
    for text in ('{"compare": ["../outside.txt"]}', "[]", "not json", '{"compare": 3}'):
        (folder / ".infinivar.json").write_text(text, "utf-8")
        with all_or_nothing(folder, "compare") as scratch:
            (scratch / "a").write_text("new", "utf-8")
        assert outside.read_text("utf-8") == "keep"
        assert json.loads((folder / ".infinivar.json").read_text("utf-8")) == {"compare": ["a"]}


def test_check_finds_what_motion_lacks(infinivar, write):
    """Named in under a second, and the same words by compare before it computes anything."""
    lacks = study(base="motor2-gear4", rest='[duty.d]\nshape = "hold"\ntime = "1 s"\n').replace(
        'base = "faulring2006.motor2-gear4"',
        'type = "conventional"\n[drives.mine.motor]\nvoltage = "24 V"\nresistance = "1 ohm"\ntorque_constant = "25 mN m/A"\n'
        'no_load_current = "50 mA"\ncontinuous_torque = "50 mN m"\n[drives.mine.gearhead]\nratio = 4\n'
        'efficiency = 0.9\n[drives.mine.pulley]\nradius = "5 mm"',
    )
    write(lacks)
    words = "study.toml: drives.mine: motor.rotor_inertia is missing: motion needs it, for duty.d"
    for command in ("check", "compare"):
        start = time.monotonic()
        assert refused(infinivar(command, "study.toml"), words)
        assert time.monotonic() - start < 1.5
    write(study(base="cobotic", rest='transmission.creep_law = "faulring"\n[duty.d]\nshape = "hold"\ntime = "1 s"\n'))
    assert refused(
        infinivar("check", "study.toml"), "drives.mine: transmission.creep_law must be one of linear, ", "for duty.d"
    )


def test_check_finds_scenarios_that_nothing_can_run(infinivar, write):
    write(study(rest='[scenarios.s]\nduration = "1 s"\nsteering = "locked"\n'))
    assert refused(
        infinivar("check", "study.toml"),
        "scenarios.s: no drive can run it: drives.mine: steering = 'locked' requires a",
    )
    write(study(base="cobotic", rest='[scenarios.s]\nduration = "1 s"\nsteering = "locked"\n'))
    outcome = infinivar("check", "study.toml")
    assert (outcome.code, outcome.out) == (0, "study.toml: 1 drive, 1 scenario; no faults found\n")


def test_check_writes_nothing(infinivar, write, tmp_path):
    write(study())
    assert infinivar("check", "study.toml").code == 0
    assert results(tmp_path) == ["study.toml"]


def test_runs_at_once_in_one_process(tmp_path):
    """Threads that save into one folder take turns or are sent away; whatever wins is whole."""
    refusals = []

    def save(mark):
        try:
            with all_or_nothing(tmp_path, "compare") as scratch:
                for name in "abcdef":
                    (scratch / name).write_text(mark, "utf-8")
        except InputError:
            refusals.append(mark)

    threads = [threading.Thread(target=save, args=(str(place),)) for place in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({(tmp_path / name).read_text("utf-8") for name in "abcdef"}) == 1
