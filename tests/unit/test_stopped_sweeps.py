"""Sweeps in processes of their own that are killed, interrupted, or lose their workers."""

import json
import os
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import psutil
import pytest

import infinivar as iv
from dummy_sweep import Toy
from internals import SweepJob as Job
from internals import in_processes

pytestmark = pytest.mark.slow

TESTS = Path(__file__).parents[1]
CHUNKS = 120
CLUSTER = """
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


def environment():
    paths = [str(TESTS), *(path for path in sys.path if path)]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def started(options, **fields):
    """A process of its own group that sweeps a toy, once it is ready."""
    code = "import dummy_sweep; dummy_sweep.main()"
    fields = {"chunks": CHUNKS, **fields}
    process = subprocess.Popen(
        [sys.executable, "-c", code, json.dumps(fields), json.dumps(options)],
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout.readline() == "ready\n", process.stderr.read()
    return process


def ended(process):
    """Exit code and errors of a process that ends by itself."""
    _, errors = process.communicate(timeout=120)
    return process.returncode, errors


def files(folder):
    return {file.name: file.read_bytes() for file in sorted(folder.glob("chunk-*.parquet"))}


def alive(pid):
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def wait_until(condition, seconds=120.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "s"
    iv.sweep(Toy(chunks=CHUNKS), folder)
    return folder


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    file = tmp_path_factory.mktemp("cluster") / "cluster.py"
    file.write_text(CLUSTER, "utf-8")
    pipe = subprocess.PIPE
    command = [sys.executable, str(file)]
    with subprocess.Popen(
        command, env=environment(), cwd=file.parent, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True
    ) as process:
        yield process.stdout.readline().strip()
        process.stdin.close()


@pytest.fixture(params=["processes", pytest.param("cluster", marks=pytest.mark.full)])
def where(request):
    """Options that choose the workers."""
    return {"workers": 2} if request.param == "processes" else {"dask": request.getfixturevalue("cluster")}


def check_whole(folder, whole):
    """The files, the front, the best and the counts are those of a sweep that was never stopped."""
    assert files(folder) == files(whole)
    assert not list(folder.glob(".*writing"))
    found, expected = iv.load_sweep(folder), iv.load_sweep(whole)
    assert found.finished
    assert found.candidates == expected.candidates == CHUNKS * Toy().size
    for name in ("rows", "counts"):
        assert repr(getattr(found, name)) == repr(getattr(expected, name))


@pytest.mark.parametrize("most", [1, pytest.param(20, marks=pytest.mark.full)])
def test_killed_at_random_moments_a_sweep_ends_with_the_same_result(where, whole, tmp_path, most):
    rng, kills, midway, place = np.random.default_rng(4), 0, 0, 0
    while kills < most:
        folder, done, place = tmp_path / f"s{place}", 0, place + 1
        while kills < most:
            process = started({"folder": str(folder), "resume": True, **where}, pause=0.02)
            if kills % 2:  # half of the kills come once chunks arrive, the others while workers start
                wait_until(lambda: len(files(folder)) > done or process.poll() is not None)  # noqa: B023
            time.sleep(rng.uniform(0.0, 0.4))
            if process.poll() is not None:
                ended(process)
                break
            os.kill(process.pid, signal.SIGKILL)
            process.communicate(timeout=60)
            kills, done = kills + 1, len(files(folder))
            midway += 0 < done < CHUNKS
        code, errors = ended(started({"folder": str(folder), "resume": True, **where}))
        assert (code, errors) == (0, "")
        check_whole(folder, whole)
    assert midway >= most // 3


def test_workers_that_wait_for_a_first_chunk_end_when_their_parent_is_killed(tmp_path):
    folder = tmp_path / "s"
    process = started({"folder": str(folder), "workers": 6}, pause=2.0, chunks=1)
    parent = psutil.Process(process.pid)
    wait_until(lambda: sum("popen_loky" in " ".join(child.cmdline()) for child in parent.children()) == 6)
    children = parent.children()
    os.kill(process.pid, signal.SIGKILL)
    wait_until(lambda: not any(child.is_running() for child in children))
    process.communicate(timeout=60)
    assert not files(folder)


def test_workers_end_when_their_parent_is_killed(tmp_path):
    trace = tmp_path / "trace"
    process = started({"folder": str(tmp_path / "s"), "workers": 2}, pause=0.1, trace=str(trace))
    wait_until(lambda: trace.exists() and len(trace.read_text("utf-8").splitlines()) > 4)
    workers = {int(line.split()[1]) for line in trace.read_text("utf-8").splitlines()}
    assert process.pid not in workers
    assert all(map(alive, workers))
    os.kill(process.pid, signal.SIGKILL)
    _, errors = process.communicate(timeout=60)
    assert errors == ""
    assert not list(Path("/dev/shm").glob(f"*[-_]{process.pid}[-_]*"))
    wait_until(lambda: not any(map(alive, workers)))
    computed = len(trace.read_text("utf-8").splitlines())
    time.sleep(0.5)
    assert len(trace.read_text("utf-8").splitlines()) == computed


def test_the_chunk_of_a_lost_worker_is_computed_by_another(where, whole, tmp_path):
    trace = tmp_path / "trace"
    code, errors = ended(started({"folder": str(tmp_path / "s"), **where}, trace=str(trace), fatal=7, pause=0.01))
    assert code == 0, errors
    computed = [int(line.split()[0]) for line in trace.read_text("utf-8").splitlines()]
    assert computed.count(7) == 2
    check_whole(tmp_path / "s", whole)


@pytest.mark.parametrize("workers", [None, 2])
def test_ctrl_c_ends_at_once_and_the_sweep_continues(workers, whole, tmp_path):
    folder = tmp_path / "s"
    process = started({"folder": str(folder), "workers": workers}, pause=0.03)
    wait_until(lambda: len(files(folder)) > 5)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: also to the workers
    code, errors = ended(process)
    assert (code, errors) == (130, "")
    assert 5 < len(files(folder)) < CHUNKS
    assert (iv.sweep(Toy(chunks=CHUNKS), folder, resume=True)).finished
    check_whole(folder, whole)


@pytest.mark.parametrize("within", ["here", "there"])
def test_chunks_that_are_done_and_not_fetched_are_not_complained_about(within):
    """The processes have done more than what was fetched when the sweep ends; Ctrl-C may come while a chunk is written."""
    chunks = in_processes(Job(Toy(chunks=40), "sweep", {}), range(40), workers=2)
    next(chunks)
    time.sleep(0.5)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        if within == "here":
            chunks.close()
        else:
            with pytest.raises(KeyboardInterrupt):
                chunks.throw(KeyboardInterrupt)
    assert caught == []
