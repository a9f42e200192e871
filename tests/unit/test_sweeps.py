"""Sweeps in chunks: merging, continuing after every kind of stop, and refusing what does not belong together."""

import errno
import json
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from dummy_sweep import TOP, Toy
from internals import DESCRIPTION, DamagedError, compute_apart, fingerprint, merged_order, reducer_of, sweeping
from internals import BestReducer as Best
from internals import RowsReducer as Rows
from internals import SweepJob as Job
from internals import added_rows as added
from internals import decoded_chunk as decoded
from internals import encoded_chunk as encoded
from internals import stacked_rows as stacked
from internals import taken_rows as taken
from internals import worker_versions as versions

TOY = Toy()


def files(folder):
    """Content of all chunk files by name."""
    return {file.name: file.read_bytes() for file in sorted(folder.glob("chunk-*.parquet"))}


def chunk_file(folder, number):
    return folder / f"chunk-{number:08d}.parquet"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of a sweep that was never stopped."""
    folder = tmp_path_factory.mktemp("whole")
    iv.sweep(TOY, folder)
    return folder


def test_merged_chunks_are_the_whole(whole):
    found = iv.load_sweep(whole)
    number, mass, power = TOY.every()
    assert found.finished
    assert found.candidates == len(number) == found.counts["candidates"]
    top, front = found.list("top"), found.list("front")
    np.testing.assert_array_equal(top["number"], number[np.lexsort((number, power))][:TOP])
    beaten = [((mass <= m) & (power <= p) & ((mass < m) | (power < p))).any() for m, p in zip(mass, power, strict=True)]
    kept = np.flatnonzero(~np.array(beaten))
    np.testing.assert_array_equal(front["number"], kept[np.lexsort((kept, power[kept]))])
    assert found.counts["sums"] == {"mass": round(7 * mass.sum()), "of 0": 3, "of 1": 3}
    np.testing.assert_array_equal(found.counts["each"], np.bincount(number % 3))
    assert np.isnan(top["only in 0"]).any()  # a column that some chunks lack
    assert found.rate > 0.0
    assert found.elapsed > 0.0
    assert "finished; 240 candidates" in found.verdict


def test_the_same_chunk_has_the_same_bytes(whole, tmp_path):
    iv.sweep(TOY, tmp_path / "again")
    assert files(tmp_path / "again") == files(whole)
    assert len(files(whole)) == TOY.chunks


def test_only_chunks_that_are_missing_are_computed(whole, tmp_path):
    trace = tmp_path / "trace"
    iv.sweep(TOY, tmp_path / "s")
    for number in (1, 4):
        chunk_file(tmp_path / "s", number).unlink()
    assert not iv.load_sweep(tmp_path / "s").finished
    said = []
    found = iv.sweep(
        replace(TOY, trace=trace),
        tmp_path / "s",
        resume=True,
        progress=lambda words, share: said.append((words, share)),
    )
    assert [line.split()[0] for line in trace.read_text("utf-8").splitlines()] == ["1", "4"]
    assert files(tmp_path / "s") == files(whole)
    assert found.finished
    assert [share for _, share in said] == [4 / 6, 5 / 6, 1.0]
    assert said[-1][0].startswith("best: ")


def changed(content, place):
    return content[:place] + bytes([content[place] ^ 0x40]) + content[place + 1 :]


@pytest.mark.parametrize(
    "damage",
    [
        lambda content, other: content[: len(content) // 2],
        lambda content, other: b"",
        lambda content, other: changed(content, 40),
        lambda content, other: other,
        lambda content, other: b"\0" * len(content),
    ],
    ids=["cut short", "empty", "a bit flipped", "another chunk", "zeros"],
)
def test_a_damaged_chunk_is_computed_again(whole, tmp_path, damage):
    iv.sweep(TOY, tmp_path)
    file = chunk_file(tmp_path, 3)
    file.write_bytes(damage(file.read_bytes(), chunk_file(whole, 2).read_bytes()))
    found = iv.load_sweep(tmp_path)
    assert (found.done, found.damaged, found.to_dict()["damaged"]) == (TOY.chunks - 1, (3,), [3])
    assert (
        "Chunk 3 is damaged and does not count: the command of the sweep with --resume (resume=True) computes it again"
        in [*found.lines()]
    )
    assert iv.sweep(TOY, tmp_path, resume=True).damaged == ()
    assert files(tmp_path) == files(whole)


def test_every_flipped_byte_is_noticed_or_harmless(whole):
    """Some bytes of a Parquet file mean nothing, such as the name of the library that wrote it."""
    content = chunk_file(whole, 0).read_bytes()
    digest = _digest(whole)
    chunk = decoded(content, 0, digest)
    for place in range(0, len(content), 37):
        try:
            found = decoded(changed(content, place), 0, digest)
        except DamagedError:
            continue
        assert encoded(found, 0, digest) == encoded(chunk, 0, digest)


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="counts the threads of a process as Linux lists them")
@pytest.mark.slow
def test_chunk_files_are_read_and_written_without_threads():
    """A thread of pyarrow that is at work while the interpreter ends aborts the process, after the right result."""
    code = """
import os
import numpy as np
from infinivar.sweeps.problem import Chunk
from infinivar.sweeps.storage import decoded, encoded
import pyarrow.parquet
before = len(os.listdir("/proc/self/task"))
rows = {f"c{number}": np.arange(3000.0) for number in range(20)}
decoded(encoded(Chunk(rows, {}), 0, "sweep"), 0, "sweep")
assert len(os.listdir("/proc/self/task")) == before
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60.0)


def _digest(folder):
    from internals import SweepFolder

    place = SweepFolder(folder)
    place.load()
    return place.digest


def test_a_file_that_was_being_written_does_not_count(whole, tmp_path):
    iv.sweep(TOY, tmp_path)
    file = chunk_file(tmp_path, 5)
    file.rename(tmp_path / f".{file.name}.writing")
    assert iv.load_sweep(tmp_path).done == 5
    iv.sweep(TOY, tmp_path, resume=True)
    assert files(tmp_path) == files(whole)
    assert not list(tmp_path.glob(".*writing"))


def test_a_full_disk_leaves_what_is_done(whole, tmp_path, monkeypatch):
    kept = os.fsync
    calls = []

    def full(handle):
        calls.append(handle)
        if len(calls) > 6:  # two for each file: its own and the folder's
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        kept(handle)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(
        iv.InputError, match=r"No space left on device; 2 of 6 chunks are done and kept; continue with --resume"
    ):
        iv.sweep(TOY, tmp_path)
    monkeypatch.undo()
    assert list(files(tmp_path)) == ["chunk-00000000.parquet", "chunk-00000001.parquet"]
    assert not list(tmp_path.glob(".*writing"))
    iv.sweep(TOY, tmp_path, resume=True)
    assert files(tmp_path) == files(whole)


@dataclass(frozen=True, kw_only=True)
class Stopped(Toy):
    """Ctrl-C in the middle."""

    def run(self, number):
        if number == 3:
            raise KeyboardInterrupt
        return super().run(number)


def test_ctrl_c_leaves_what_is_done(whole, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        iv.sweep(Stopped(), tmp_path)
    assert iv.load_sweep(tmp_path).done == 3
    iv.sweep(TOY, tmp_path, resume=True)
    assert files(tmp_path) == files(whole)


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (replace(TOY, seed=1), "seed: 0 there, 1 here"),
        (replace(TOY, size=41), "designs in a chunk: 40 there, 41 here"),
        (replace(TOY, chunks=7), "chunks: 6 there, 7 here"),
        (replace(TOY, kind="other"), "it is a sweep of toys, not of other"),
    ],
)
def test_another_sweep_does_not_continue_one(whole, other, message):
    for resume in (False, True):
        with pytest.raises(iv.InputError, match=f"holds another sweep, which cannot be continued with this: {message}"):
            iv.sweep(other, whole, resume=resume)


def test_other_versions_do_not_continue_a_sweep(whole, monkeypatch):
    monkeypatch.setattr(sweeping, "versions", lambda: {**versions(), "numpy": "9.9"})
    with pytest.raises(iv.InputError, match=r"numpy: [\d.]+ there, 9\.9 here"):
        iv.sweep(TOY, whole, resume=True)


def test_a_folder_with_other_content_is_refused(whole, tmp_path):
    with pytest.raises(iv.InputError, match=r"holds this sweep already, 6 of 6 chunks done; continue with --resume"):
        iv.sweep(TOY, whole)
    (tmp_path / "mine.txt").write_text("mine", "utf-8")
    for resume in (False, True):
        with pytest.raises(iv.InputError, match=r"is not empty and holds no sweep \(mine\.txt\)"):
            iv.sweep(TOY, tmp_path, resume=resume)
    with pytest.raises(iv.InputError, match=r"holds no sweep: there is no file sweep\.json"):
        iv.load_sweep(tmp_path)
    (tmp_path / DESCRIPTION).write_text("{", "utf-8")
    with pytest.raises(iv.InputError, match=r"sweep\.json: cannot be read"):
        iv.load_sweep(tmp_path)
    (tmp_path / DESCRIPTION).write_text('{"format": 99, "chunks": 3}', "utf-8")
    with pytest.raises(iv.InputError, match="written by another version"):
        iv.load_sweep(tmp_path)


def test_resume_in_an_empty_folder_begins(whole, tmp_path):
    iv.sweep(TOY, tmp_path / "new", resume=True)
    assert files(tmp_path / "new") == files(whole)


def test_lines_of_the_log_that_were_cut_short_do_not_matter(whole, tmp_path):
    found = iv.sweep(TOY, tmp_path)
    log = tmp_path / "times.jsonl"
    kept = log.read_text("utf-8").splitlines()
    log.write_text("\n".join([*kept[:-1], kept[-1][:9]]), "utf-8")
    assert np.isnan(iv.load_sweep(tmp_path).rate)
    assert iv.load_sweep(tmp_path).candidates == found.candidates


def test_arguments_that_contradict_and_libraries_that_are_missing(tmp_path, monkeypatch):
    with pytest.raises(iv.InputError, match="workers and dask are both given"):
        iv.sweep(TOY, tmp_path / "s", workers=2, dask="tcp://localhost:1")
    with pytest.raises(iv.ParameterError, match="workers must be >= 1, got 0"):
        iv.sweep(TOY, tmp_path / "s", workers=0)
    for library, options in (("joblib", {"workers": 2}), ("distributed", {"dask": "tcp://localhost:1"})):
        monkeypatch.setitem(sys.modules, library, None)
        with pytest.raises(iv.InputError, match=rf"needs {library}; install it with: pip install 'infinivar\[scale\]'"):
            iv.sweep(TOY, tmp_path / "s", **options)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(iv.InputError, match="a sweep needs pyarrow"):
        iv.sweep(TOY, tmp_path / "s")
    assert not (tmp_path / "s").exists()


def test_a_worker_with_other_versions_computes_nothing():
    job = Job(TOY, "", {**versions(), "scipy": "0.1"})
    with pytest.raises(
        iv.InputError, match=r"a worker has other versions than this process: scipy [\d.]+ there, 0\.1 here"
    ):
        compute_apart(job, 0)
    job = Job(TOY, "abc", versions())
    assert compute_apart(job, 2).content == encoded(TOY.run(2), 2, "abc")


class Colour(Enum):
    RED = 1


@dataclass(frozen=True)
class Pair:
    first: object
    second: object


def doubled(value, by=2.0):
    return value * by


CONTENT = (
    Pair(1.5, "text"),
    {"a": np.arange(3.0), "b": (None, True, Colour.RED)},
    partial(doubled, by=3.0),
    np.array(["x", "yy"]),
    frozenset({"p", "q", "r"}),
    Path("a/b"),
)


@pytest.mark.slow
def test_equal_contents_have_equal_fingerprints_in_every_process():
    code = "from test_sweeps import CONTENT, fingerprint; print(fingerprint(CONTENT))"
    found = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={
                **os.environ,
                "PYTHONHASHSEED": seed,
                "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path]),
            },
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
        for seed in ("1", "2")
    }
    assert len(found) == 1
    assert len(found.pop()) == 32


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (1, 1.0),
        (1.0, np.nextafter(1.0, 2.0)),
        ("1", 1),
        (("ab", "c"), ("a", "bc")),
        ((1, (2,)), (1, 2)),
        (np.arange(4.0), np.arange(4.0).reshape(2, 2)),
        (np.arange(3), np.arange(3.0)),
        (Pair(1, 2), Pair(2, 1)),
        (partial(doubled, by=3.0), partial(doubled, by=4.0)),
        ({"a": 1}, {"b": 1}),
        (True, 1),
        (lambda value: value + 1, lambda value: value - 1),
    ],
)
def test_different_contents_have_different_fingerprints(one, other):
    assert fingerprint(one) != fingerprint(other)
    assert fingerprint(one) == fingerprint(one)


def test_a_content_that_cannot_be_seen_has_no_fingerprint():
    with pytest.raises(TypeError, match="cannot be compared with that of an earlier run"):
        fingerprint(iter(()))


def test_reducers_survive_the_description():
    best = Best(top=3, order=("value",), front=("a", "b"), same=("c",))
    for reducer in (best, replace(best, demands="demand"), Rows()):
        assert reducer_of(json.loads(json.dumps(reducer.to_dict()))) == reducer
    with pytest.raises(iv.InputError, match="unknown way to merge chunks: 'other'"):
        reducer_of({"name": "other"})


def test_the_best_of_each_kind():
    rows = {
        "list": np.array(["top"] * 4 + ["front"] * 3),
        "value": np.array([3.0, 1.0, 2.0, 1.5, 1.0, 1.0, 4.0]),
        "c": np.array([7, 8, 7, 8, 8, 8, 9]),
        "a": np.array([1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 1.0]),
        "b": np.array([3.0, 1.0, 2.0, 1.5, 1.0, 1.0, 4.0]),
    }
    found = Best(top=3, order=("value",), front=("a", "b"), same=("c",))(rows)
    assert found["list"].tolist() == ["top", "top", "front", "front"]
    assert found["value"].tolist() == [1.0, 2.0, 1.0, 4.0]


def test_the_nearest_miss_is_kept_where_nothing_is_feasible():
    """By all demands, the worst first, then the mass; a limit that one has not does not load it."""
    best = Best(top=3, order=("value",), front=("mass", "b"), demands="d: ")
    misses = {
        "list": np.array(["nearest"] * 5),
        "value": np.full(5, np.nan),
        "mass": np.array([0.1, 0.3, 0.2, 0.1, np.nan]),
        "b": np.full(5, np.nan),
        "d: one": np.array([2.0, 1.5, 1.5, 1.5, 1.5]),
        "d: two": np.array([0.1, 1.2, 1.2, np.inf, np.nan]),
        "d: three": np.array([0.1, np.nan, 0.9, 0.1, 1.3]),
    }
    (kept,) = best(misses)["mass"]
    assert kept == 0.2
    for first in range(1, 5):  # in any chunks
        parts = [best(taken(misses, np.arange(5)[some])) for some in (slice(first), slice(first, None))]
        assert best(stacked(parts))["mass"].tolist() == [0.2]
    feasible = {**taken(misses, np.array([0])), "list": np.array(["top"]), "value": np.array([1.0])}
    assert best(stacked([misses, feasible]))["list"].tolist() == ["top"]
    assert replace(best, demands="")(misses)["list"].size == 0


def test_names_keep_their_order_where_some_lists_lack_them():
    assert merged_order([["a", "d"], ["a", "b", "d"], ["b", "c", "d"]]) == ["a", "b", "c", "d"]
    assert added([{"a": 1, "n": {"x": 1.5}}, {"a": 2, "n": {"y": 1}, "l": [1, 2]}, {"l": [1, 1]}]) == {
        "a": 3,
        "n": {"x": 1.5, "y": 1},
        "l": [2, 3],
    }
