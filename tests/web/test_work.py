"""Who gets the next process: one computation a client, the newest of its requests, clients in turn; what overruns is ended."""

import asyncio
import json

import pytest

from internals import BusyError, FailedError, StaleError, TooLongError, UnusableError
from internals import ServerLane as Lane
from internals import ServerWorker as Worker
from internals import server_work as work


class Fake:
    """A process that answers when told; notes what it is asked, and how many computations of a client run at once."""

    title = "fake"

    def __init__(self, log):
        self.log, self.alive, self.gates = log, False, {}

    async def start(self):
        self.alive = True

    async def stop(self):
        self.alive = False

    async def call(self, name, body, seconds, report=None):
        self.log.append(body.decode())
        await asyncio.sleep(0.002)
        if b"die" in body:
            self.alive = False
            raise FailedError("died")
        return body


def lane_of(count, log):
    return Lane([Fake(log) for _ in range(count)], 1.0)


def run(coroutine):
    return asyncio.run(asyncio.wait_for(coroutine, 60))


async def outcome(call):
    try:
        return (await call).decode()
    except (StaleError, BusyError, FailedError) as problem:
        return type(problem).__name__


def test_the_newest_request_of_a_client_replaces_older_ones():
    async def scene():
        log = []
        lane = lane_of(1, log)
        await lane.start()
        calls = [lane.call("a", number, "maps", f"a{number}".encode()) for number in range(6)]
        found = await asyncio.gather(*(outcome(one) for one in calls))
        assert found == ["a0", *["StaleError"] * 4, "a5"]
        assert log == ["a0", "a5"]
        assert await outcome(lane.call("a", 3, "maps", b"late")) == "StaleError"
        assert await outcome(lane.call("a", 3, "point", b"other")) == "other"
        assert await outcome(lane.call("a", 3, "maps", b"before", "pinned maps")) == "before"
        await lane.stop()

    run(scene())


def test_requests_without_a_client_replace_none():
    async def scene():
        log = []
        lane = lane_of(1, log)
        await lane.start()
        found = await asyncio.gather(*(outcome(lane.call(None, None, "maps", f"{n}".encode())) for n in range(9)))
        assert sorted(found) == sorted(str(n) for n in range(9))
        assert not lane._clients
        await lane.stop()

    run(scene())


def test_clients_take_turns():
    async def scene():
        log = []
        lane = lane_of(1, log)
        await lane.start()
        greedy = [outcome(lane.call("greedy", 1, f"kind{n}", f"greedy{n}".encode())) for n in range(20)]
        tasks = [asyncio.create_task(one) for one in greedy]
        await asyncio.sleep(0)
        modest = asyncio.create_task(outcome(lane.call("modest", 1, "maps", b"modest")))
        await asyncio.gather(*tasks, modest)
        assert log.index("modest") <= 2
        await lane.stop()

    run(scene())


def test_one_computation_a_client_and_more_processes_on_demand():
    async def scene():
        log = []
        lane = lane_of(3, log)
        await lane.start()
        await asyncio.gather(*(outcome(lane.call("a", 1, f"kind{n}", b"x")) for n in range(6)))
        assert sum(one.alive for one in lane._workers) == 1  # one client needs one process
        await asyncio.gather(*(outcome(lane.call(f"b{n}", 1, "maps", b"x")) for n in range(40)))
        assert sum(one.alive for one in lane._workers) == 3
        await lane.stop()
        assert not any(one.alive for one in lane._workers)

    run(scene())


def test_a_process_that_dies_is_replaced():
    async def scene():
        log = []
        lane = lane_of(1, log)
        await lane.start()
        assert await outcome(lane.call("a", 1, "maps", b"die")) == "FailedError"
        assert await outcome(lane.call("a", 2, "maps", b"alive")) == "alive"
        await lane.stop()

    run(scene())


def test_waiting_requests_and_kinds_are_bounded(monkeypatch):
    monkeypatch.setattr(work, "MOST_WAITING", 30)

    async def scene():
        log = []
        lane = lane_of(1, log)
        await lane.start()
        found = await asyncio.gather(*(outcome(lane.call(f"c{n}", 1, "maps", b"x")) for n in range(60)))
        assert found.count("BusyError") >= 25
        assert found.count("x") >= 30
        kinds = await asyncio.gather(*(outcome(lane.call("k", 1, "maps", b"x", f"kind {n}")) for n in range(29)))
        kinds += await asyncio.gather(*(outcome(lane.call("k", 1, "maps", b"x", f"more {n}")) for n in range(29)))
        kinds += await asyncio.gather(*(outcome(lane.call("k", 1, "maps", b"x", f"most {n}")) for n in range(29)))
        assert "BusyError" in kinds
        await lane.stop()

    run(scene())


@pytest.mark.slow
def test_many_clients_are_forgotten():
    async def scene():
        lane = lane_of(2, [])
        await lane.start()
        for number in range(560):
            await lane.call(f"c{number}", 1, "maps", b"x")
        assert len(lane._clients) <= Lane._MOST_CLIENTS + 1
        await lane.stop()

    run(scene())


STUDY = {
    "name": "x",
    "tables": {"requirement": {"base": "faulring2006"}, "drives": {"c": {"base": "faulring2006.cobotic"}}},
}


@pytest.mark.slow
def test_a_real_process_answers_refuses_and_is_ended():
    async def scene():
        worker = Worker("knee_walking")
        await worker.start()
        assert "nee" in worker.title
        with pytest.raises(UnusableError, match="count"):
            await worker.call("maps", json.dumps({**STUDY, "count": 10**9}).encode(), 20.0)
        packed = await worker.call("maps", json.dumps({**STUDY, "count": 30}).encode(), 20.0)
        assert packed
        with pytest.raises(TooLongError, match="was ended after"):
            await worker.call("maps", json.dumps({**STUDY, "count": 400}).encode(), 0.001)  # no machine is as fast
        assert not worker.alive
        broken = Worker("no_such_study")
        with pytest.raises(UnusableError, match="no_such_study"):
            await broken.start()
        assert not broken.alive

    run(scene())


@pytest.mark.slow
def test_memory_of_a_process_is_bounded(monkeypatch):
    """A process may not take more than its share: what needs more is refused, and the next request is answered."""
    resource = pytest.importorskip("resource")
    from internals import server_worker as process

    limits = []
    monkeypatch.setattr(resource, "setrlimit", lambda what, ends: limits.append((what, ends)))
    process._bound_memory()
    ((what, (soft, _)),) = limits
    assert what == resource.RLIMIT_AS
    assert soft <= process.LARGEST_MEMORY
