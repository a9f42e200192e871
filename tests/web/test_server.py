"""The server as a whole: start, stop, messages, progress, cancelling, what survives a kill, and many clients at once."""

import copy
import json
import os
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import infinivar as iv
from internals import Recovery
from serving import begun, children, serving, unpacked

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads the processes of Linux"),
]


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with serving(folder=tmp_path_factory.mktemp("served")) as one:
        yield one


@pytest.fixture
def shipped_tables(served):
    header, _ = served.ask("start", {})
    return copy.deepcopy(header["study"])


def gone(process, seconds=10.0):
    """Whether a process of a number ends in time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            state = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except FileNotFoundError:
            return True
        if state == "Z":
            return True
        time.sleep(0.05)
    return False


def test_the_page_and_the_answers_of_the_interface(served, shipped_tables):
    with served.client() as client:
        page = client.get("")
        assert page.status_code == 200
        assert page.headers["content-type"].startswith("text/html")
    header, arrays = served.ask("maps", {**shipped_tables, "count": 16, "drives": ["cobotic"]})
    steady = iv.steady_map(iv.load_study("hand_controller").drives["cobotic"], arrays["speed"], arrays["force"])
    assert (arrays["cobotic/limit"] == 0).sum() == (steady.limit == 0).sum()
    assert header["drives"]["cobotic"]["audit_residual"] < 1e-9


def test_faults_are_answers(served, shipped_tables):
    shipped_tables["tables"]["drives"]["cobotic"]["transmission"] = {"preload": "3 kg"}
    header, _ = served.ask("study", shipped_tables)
    (fault,) = header["faults"]
    assert fault["at"] == "drives.cobotic.transmission.preload"


def test_small_replies_are_sent_at_once(served, shipped_tables):
    """A reply in two packets must not wait for the acknowledgement of the first, which takes 40 ms."""
    times = []
    with served.client() as client:
        for _ in range(40):
            begin = time.perf_counter()
            reply = client.post("api/maps", json={**shipped_tables, "count": 8, "drives": ["cobotic"]})
            times.append(time.perf_counter() - begin)
            assert reply.status_code == 200
    assert min(times[20:]) < 0.03


def test_no_word_of_what_is_unknown(served):
    with served.client() as client:
        assert client.post("api/nothing", json={}).status_code == 400
        assert client.post("api/No!", json={}).status_code == 404
        assert client.get("api/study").status_code == 405
        assert client.get("nothing").status_code == 404
        assert client.post("api/progress", json={"id": "x"}).status_code == 404
        assert client.post("api/cancel", json={}).json() == {"cancelled": False}


def test_progress_and_result_of_a_long_computation(served):
    study = {
        "name": "small",
        "tables": {
            "requirement": {"base": "faulring2006"},
            "drives": {"geared": {"base": "faulring2006.motor1-gear1"}},
        },
    }
    with served.client("worker") as client:
        key = client.post("api/job", json={**study, "job": "compare"}).json()["id"]
        assert client.post("api/job", json={**study, "job": "compare"}).status_code == 429  # one a page
        shares = [0.0]
        for _ in range(600):
            state = client.post("api/progress", json={"id": key}).json()
            shares.append(state["share"])
            if state["done"]:
                break
            time.sleep(0.05)
    assert state["error"] is None
    assert shares == sorted(shares)
    assert state["result"]["verdict"] == iv.compare(iv.Study.from_dict(study["tables"], name="small")).verdict


def test_a_long_computation_is_cancelled(served, shipped_tables):
    before = set(children(served.process.pid))
    with served.client("impatient") as client:
        key = client.post("api/job", json={**shipped_tables, "job": "size", "generations": 100}).json()["id"]
        own = set()
        while not own:
            own = set(children(served.process.pid)) - before
            time.sleep(0.02)
        assert client.post("api/cancel", json={"id": key}).json() == {"cancelled": True}
        state = client.post("api/progress", json={"id": key}).json()
        assert state["done"]
        assert state["error"] == "cancelled"
        assert all(gone(one) for one in own)
        assert (
            client.post("api/job", json={**shipped_tables, "job": "none"}).status_code == 200
        )  # the page may begin another


def test_stale_requests_are_dropped(served, shipped_tables):
    """Of many maps asked at once, the last is answered; none is answered with another's numbers."""
    replies = {}

    def ask(number):
        own = copy.deepcopy(shipped_tables)
        own["tables"]["drives"] = {
            "cobotic": {"base": "faulring2006.cobotic", "transmission": {"preload": f"{500 + number} N"}}
        }
        with served.client("slider") as client:
            headers = {"X-Sequence": str(number)}
            replies[number] = client.post("api/maps", json={**own, "count": 200}, headers=headers)

    threads = [threading.Thread(target=ask, args=(number,)) for number in range(24)]
    for one in threads:
        one.start()
        time.sleep(0.002)
    for one in threads:
        one.join()
    codes = {number: reply.status_code for number, reply in replies.items()}
    assert codes[23] == 200
    assert set(codes.values()) <= {200, 409}
    drive = {"cobotic": {"base": "faulring2006.cobotic", "transmission": {"preload": "523 N"}}}
    study = iv.Study.from_dict({**shipped_tables["tables"], "drives": drive}, name="x")
    _, arrays = unpacked(replies[23].content)
    steady = iv.steady_map(study.drives["cobotic"], arrays["speed"], arrays["force"])
    assert ((arrays["cobotic/limit"] == 0) == (steady.limit.T == 0)).all()


def test_what_was_sent_last_survives_a_kill(tmp_path, shipped_tables):
    shipped_tables["tables"]["drives"]["cobotic"]["transmission"] = {"preload": "612 N"}
    with serving(folder=tmp_path) as first:
        header, _ = first.ask("start", {})
        assert header["recovered"] == []
        own = children(first.process.pid)
        with first.client("page") as client:
            for number in range(10):
                shipped_tables["tables"]["title"] = f"edit {number}"
                assert client.post("api/study", json=shipped_tables).status_code == 200
        first.stop(signal.SIGKILL)
        assert all(gone(one) for one in own)  # no process is left behind
    with serving(folder=tmp_path) as second:
        header, _ = second.ask("start", {})
        (found,) = header["recovered"]
        assert found["tables"] == shipped_tables["tables"]
        assert found["name"] == shipped_tables["name"]
        assert found["time"]
        second.stop(signal.SIGKILL)


@pytest.mark.slow
def test_what_is_offered_stays_until_a_page_has_decided(tmp_path, shipped_tables):
    shipped_tables["tables"]["title"] = "mine"
    with serving(folder=tmp_path) as first:
        with first.client("page") as client:
            assert client.post("api/study", json=shipped_tables).status_code == 200
        first.stop(signal.SIGKILL)
    with serving(folder=tmp_path) as second:
        assert second.stop() == 0  # nobody has decided
    with serving("ankle_walking", folder=tmp_path) as other:
        assert other.ask("start", {})[0]["recovered"] == []  # that of another study is not offered
    with serving(folder=tmp_path) as third:
        (found,) = third.ask("start", {})[0]["recovered"]
        assert found["tables"] == shipped_tables["tables"]
        with third.client("page") as client:
            assert client.post("api/decided", json={"id": found["id"]}).status_code == 200
        third.stop(signal.SIGKILL)
    with serving(folder=tmp_path) as fourth:
        assert fourth.ask("start", {})[0]["recovered"] == []
        assert fourth.stop() == 0


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_it_stops_cleanly(tmp_path, how):
    with serving("knee_walking", folder=tmp_path) as one:
        own = children(one.process.pid)
        assert own
        with socket.create_connection(("127.0.0.1", one.port)), one.client() as client:
            assert client.post("api/start", json={}).status_code == 200
            begin = time.perf_counter()
            assert one.stop(how) == 0
            assert time.perf_counter() - begin < 5.0
        assert one.errors.read_text() == ""
        assert "Ctrl-C" in one.process.stdout.read()
        assert all(gone(process) for process in own)


def test_ready_soon(tmp_path):
    """The address is printed within 1 s of what loading the study takes in a process of its own."""
    code = "import infinivar, time; infinivar.load_study('hand_controller')"
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    load = time.perf_counter() - begin
    with serving(folder=tmp_path) as one:
        print(f"\nready in {one.seconds:.2f} s; a process that loads the study takes {load:.2f} s")
        busy = os.getloadavg()[0] / (os.cpu_count() or 1)
        assert one.seconds < load + 1.0 + 2.0 * max(0.0, busy - 0.5)


def test_bad_study_port_and_host(tmp_path):
    (tmp_path / "bad.toml").write_text("[requirement]\nforce = '3 kg'\n")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        started = {
            "requirement.force": begun("bad.toml", folder=tmp_path),
            "no_such_study": begun("no_such_study", folder=tmp_path),
            f"--port {port}": begun("--port", port, folder=tmp_path),
            "--host 'no.such.host.invalid'": begun("--host", "no.such.host.invalid", folder=tmp_path),
        }
        for words, process in started.items():
            out, err = process.communicate(timeout=60)
            assert process.returncode == 2, (words, err)
            assert words in err
            assert err.startswith("infinivar: ")
            assert "Traceback" not in err
            assert out == ""


def test_a_missing_extra_is_named(monkeypatch):
    import importlib.util

    from internals import serve_explorer as serve

    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "uvicorn" else found(name))
    with pytest.raises(iv.InputError, match=r"needs uvicorn; install it with: pip install 'infinivar\[web\]'"):
        serve()


def test_importing_the_command_line_does_not_import_the_server():
    heavy = "('starlette', 'uvicorn', 'numpy')"
    code = f"import sys, infinivar.cli; print([n for n in sys.modules if n.partition('.')[0] in {heavy}])"
    made = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert made.stdout.strip() == "[]"


def sliders(served, shipped_tables, clients, seconds, page="page"):
    """Clients that each move a slider; the times of their replies, and what went wrong."""
    times, wrong, lock = [], [], threading.Lock()
    stop = time.monotonic() + seconds

    def move(own):
        document, number = copy.deepcopy(shipped_tables), 0
        document["tables"]["drives"] = {"cobotic": {"base": "faulring2006.cobotic"}}
        with served.client(f"{page}-{own}") as client:
            while number == 0 or time.monotonic() < stop:
                number += 1
                preload = 500 + (37 * own + number) % 300
                document["tables"]["drives"]["cobotic"]["transmission"] = {"preload": f"{preload} N"}
                begin = time.perf_counter()
                reply = client.post("api/maps", json={**document, "count": 60}, headers={"X-Sequence": str(number)})
                took = time.perf_counter() - begin
                with lock:
                    times.append(took)
                    if reply.status_code != 200:
                        wrong.append((own, number, reply.status_code, reply.text[:200]))
                        continue
                field = client.post("api/study", json=document, headers={"X-Sequence": str(number)})
                rows = unpacked(field.content)[0]["fields"]
                (found,) = (row["value"] for row in rows if row["path"] == "transmission.preload")
                if found != preload:
                    with lock:
                        wrong.append((own, number, "lost", preload, found))

    threads = [threading.Thread(target=move, args=(own,)) for own in range(clients)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    return times, wrong


def test_many_clients_at_once(served, shipped_tables):
    times, wrong = sliders(served, shipped_tables, 20, 2.0)
    assert not wrong
    assert len(times) >= 20


@pytest.mark.full
def test_twenty_clients_for_long(tmp_path, shipped_tables):
    """Memory does not grow with the maps: twenty seconds of them would show what a minute would."""
    with serving(folder=tmp_path) as one:
        sliders(one, shipped_tables, 20, 5.0, "first")
        before = one.memory()
        times, wrong = sliders(one, shipped_tables, 20, 20.0)
        after = one.memory()
        median, late = statistics.median(times), statistics.quantiles(times, n=20)[-1]
        print(
            f"\n20 clients, {len(times)} maps of 60 x 60 in 20 s: median {1e3 * median:.0f} ms, 95 % within {1e3 * late:.0f} ms; "
            f"memory {before / 2**20:.0f} MiB before, {after / 2**20:.0f} MiB after"
        )
        assert not wrong
        assert after < 1.1 * before + (32 << 20)


def test_a_recovery_file_that_is_damaged_does_not_matter(tmp_path):
    first = Recovery(None, tmp_path)
    first.sent("page", "x", {"title": "a"})
    (file,) = (tmp_path / "explorer").glob("*.json")
    assert json.loads(file.read_text())[0]["tables"] == {"title": "a"}
    second = Recovery(None, tmp_path)
    assert second.found == []  # the first still runs
    second.stop()
    for content in ("{", "3", "[3]", '[{"tables": {}}]', '{"last": {}}', "[" * 100_000):
        first._lock.release()
        file.write_text(content)
        first = Recovery(None, tmp_path)
        assert first.found == []
        first.sent("page", "y", {})
        (file,) = (tmp_path / "explorer").glob("*.json")
    first._lock.release()
    fourth = Recovery(None, tmp_path)
    assert [one["name"] for one in fourth.found] == ["y"]
    shutil.rmtree(tmp_path / "explorer")
    fifth = Recovery(None, tmp_path)
    assert fifth.found == []
    shutil.rmtree(tmp_path / "explorer")
    fifth.sent("page", "z", {})  # a folder that went away does no harm


def test_what_several_pages_edited_is_offered_until_decided(tmp_path):
    """A page that edits nothing takes no place, and an offer outlives a server that stops before anybody decides."""
    given = {"title": "given", "ratio": 2.0}
    first = Recovery(None, tmp_path)
    first.given(given)
    first.sent("a", "one", {"title": "edited in a"})
    first.sent("b", "two", {"title": "edited in b"})
    first.sent("c", "one", {"title": "given", "ratio": 2})  # as JavaScript writes it
    first.sent("a again", "one", {"title": "edited in a"})  # loaded again
    first._lock.release()  # killed
    second = Recovery(None, tmp_path)
    assert {one["tables"]["title"] for one in second.found} == {"edited in a", "edited in b"}
    assert len(second.found) == 2
    second.sent("d", "one", {"title": "edited in d"})
    second.decided(next(one["id"] for one in second.found if one["name"] == "two"))
    second.stop()
    third = Recovery(None, tmp_path)
    assert [one["tables"]["title"] for one in third.found] == ["edited in a"]
    third.given(given)
    third.sent("e", "one", {"title": "edited in e"})
    third.sent("e", "one", given)  # undone
    third._lock.release()  # killed
    fourth = Recovery(None, tmp_path)
    assert [one["tables"]["title"] for one in fourth.found] == ["edited in a"]
    fourth.decided(fourth.found[0]["id"])
    fourth.stop()
    assert list((tmp_path / "explorer").iterdir()) == []


def test_the_same_study_is_offered_once_and_not_to_the_page_that_has_it(tmp_path):
    killed = Recovery(None, tmp_path)
    killed.sent("a", "mine", {"title": "edited"})
    (file,) = (tmp_path / "explorer").glob("*.json")
    (one,) = json.loads(file.read_text())
    later = {**one, "id": "0", "time": one["time"].replace("20", "21", 1)}
    file.write_text(json.dumps([one, later, {**one, "id": "1", "tables": {"title": "edited in b"}}]))
    killed._lock.release()
    found = Recovery(None, tmp_path)
    assert [(kept["tables"]["title"], kept["id"]) for kept in found.found] == [("edited", "0"), ("edited in b", "1")]
    found.sent("a again", "mine", {"title": "edited"})
    assert [kept["tables"]["title"] for kept in found.found] == ["edited in b"]


def test_where_nothing_can_be_written_nothing_is_kept(tmp_path):
    (tmp_path / "explorer").write_text("a file")
    one = Recovery(None, tmp_path)
    one.sent("page", "x", {})
    assert one.found == []
    one.stop()
