"""Requests that no page sends: none makes the server fail, reads a file, or works without bound."""

import http.client
import json
import random
import socket
import time
from collections import Counter
from pathlib import Path
from urllib.parse import quote

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from internals import ANSWERS, shipped_studies
from internals import answered_request as answered
from serving import free_port, serving

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads the processes of Linux"),
]

CANARY = "canary-5f1c2a"
SECRETS = ("secret.csv", "secret.toml", "secret.stl", "parts/secret.toml")
LONGEST = 45.0
"""Seconds that a request may take: that of an answer, and some for waiting on a busy machine."""

EXPECTED = {200, 303, 400, 401, 403, 404, 405, 408, 409, 413, 415, 421, 429}


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fuzzed")
    (folder / "parts").mkdir()
    for name in SECRETS:
        (folder / name).write_text(f"time [s],position [m]\n# {CANARY}\n{CANARY} = 3\n0,{CANARY}\n")
    with serving(folder=folder) as one:
        yield one


@pytest.fixture(scope="module")
def documents():
    return [answered("shipped", {"which": name}).header for name in shipped_studies()]


strange = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(min_value=10**300, max_value=10**310),
    st.floats(allow_nan=False),
    st.sampled_from(
        [
            *SECRETS,
            *(f"{name}:x" for name in SECRETS),
            "/etc/passwd",
            "../../etc/passwd",
            "file:///etc/passwd",
            "secret",
            "50 N",
            "1e308 N",
            "-1e-320 m",
            "0 N",
            "nan",
            "inf rad/s",
            "1e20 m/s",
            "1e-20 m",
            "9e19 kg",
            "100 %",
            "faulring2006.cobotic",
            "dc-max-26-s-24v",
            "__class__",
            "\x00",
            "\ud800",
            "",
            " ",
            "x" * 5000,
            "((((((((((",
            "10**10**10 N",
            "1 N N N N",
            "m" * 300,
        ]
    ),
    st.text(max_size=30),
    st.lists(st.one_of(st.integers(), st.text(max_size=5), st.floats(allow_nan=False)), max_size=6),
    st.dictionaries(
        st.sampled_from(["value", "unit", "kind", "where", "file", "part", "shape", "x"]), st.text(max_size=9)
    ),
)
small_json = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=20)),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=12), inner, max_size=4)),
    max_leaves=12,
)
HEADERS = ["X-Client", "X-Sequence", "X-Lane", "Origin", "Content-Type", "Cookie", "Content-Encoding", "Sec-Fetch-Site"]
KEYS = [
    "name",
    "tables",
    "count",
    "drives",
    "known",
    "drive",
    "speed",
    "force",
    "task",
    "motion",
    "what",
    "kind",
    "query",
]


def mutated(value, number, change):
    """A copy of a tree with one change: a leaf or branch, chosen by a number, replaced, removed or added beside."""
    places = []

    def walk(one):
        if isinstance(one, dict):
            for key in one:
                places.append((one, key))
                walk(one[key])
        elif isinstance(one, list):
            for place in range(len(one)):
                places.append((one, place))
                walk(one[place])

    made = json.loads(json.dumps(value))
    walk(made)
    if not places:
        return change
    holder, key = places[number % len(places)]
    what = number % 7
    if what == 0:
        del holder[key]
    elif what == 1 and isinstance(holder, dict):
        holder["file" if number % 2 else "part"] = change
    elif what == 2 and isinstance(holder, dict):
        holder[f"{key}x"] = change
    else:
        holder[key] = change
    return made


@st.composite
def requests(draw, documents):
    """Answer, payload or bytes, and headers."""
    known = [*ANSWERS, "job", "progress", "cancel"]
    name = draw(st.text(max_size=20) if draw(st.integers(0, 19)) == 0 else st.sampled_from(known))
    headers = {}
    if draw(st.integers(0, 9)) == 0:
        odd = st.text(st.characters(min_codepoint=32, max_codepoint=255), max_size=20)
        names = [
            "X-Client",
            "X-Sequence",
            "X-Lane",
            "Origin",
            "Content-Type",
            "Cookie",
            "Content-Encoding",
            "Expect",
            "Sec-Fetch-Site",
        ]
        headers[draw(st.sampled_from(names))] = draw(odd)
    kind = draw(st.integers(0, 11))
    if kind == 0:
        return name, draw(st.binary(max_size=200)), headers
    if kind == 1:
        return name, json.dumps(draw(small_json)).encode("utf-8", "replace"), headers
    payload = dict(draw(st.sampled_from(documents)))
    payload |= {
        "count": draw(st.sampled_from([8, 9, 16])),
        "speed": 0.2,
        "force": 5.0,
        "kind": "motors",
        "which": "knee_walking",
    }
    payload |= {"what": "csv", "text": "title = 'x'\n", "id": "x", "job": "none"}
    for _ in range(draw(st.integers(0, 2))):
        payload[draw(st.sampled_from(KEYS))] = draw(strange)
    for _ in range(draw(st.integers(0, 3))):
        payload["tables"] = mutated(payload.get("tables"), draw(st.integers(0, 10**6)), draw(strange))
    return name, json.dumps(payload).encode("utf-8", "replace"), headers


def sent(served, name, body, headers):
    """Status and content of a request."""
    connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=LONGEST)
    given = {"Content-Type": "application/json", **headers}
    given = {
        key: value.encode("latin-1", "replace").replace(b"\r", b"").replace(b"\n", b"") for key, value in given.items()
    }
    try:
        connection.request("POST", "/api/" + quote(name, safe=""), body, given)
        reply = connection.getresponse()
        return reply.status, reply.read()
    finally:
        connection.close()


def fuzz(served, documents, count, seed=None):
    statuses, slowest = Counter(), [0.0, ""]

    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        derandomize=seed is None,
        suppress_health_check=list(HealthCheck),
    )
    @given(requests(documents))
    def run(request):
        name, body, headers = request
        begin = time.perf_counter()
        status, content = sent(served, name, body, headers)
        took = time.perf_counter() - begin
        statuses[status] += 1
        if took > slowest[0]:
            slowest[:] = took, name
        assert status in EXPECTED, (status, content[:500])
        assert CANARY.encode() not in content
        assert b"root:" not in content
        assert took < LONGEST

    run()
    print(
        f"\n{sum(statuses.values())} requests: {dict(sorted(statuses.items()))}; slowest {slowest[0]:.1f} s: {slowest[1]}"
    )
    return statuses


def test_no_request_makes_the_server_fail(served, documents):
    quick = [one for one in documents if one["name"] != "sphere_joint"]  # its tasks take seconds
    statuses = fuzz(served, quick, 200)
    assert statuses[200] > 50
    assert served.ask("start", {})[0]["study"]["name"] == "hand_controller"


@pytest.mark.parametrize("count", [300, pytest.param(10_000, marks=pytest.mark.full)])
def test_none_of_thousands_of_requests_makes_the_server_fail(served, documents, count):
    before = served.memory()
    fuzz(served, documents, count, seed=1)
    print(f"memory {before / 2**20:.0f} MiB before, {served.memory() / 2**20:.0f} MiB after")
    assert served.memory() < before + (700 << 20)
    assert served.ask("start", {})[0]["study"]["name"] == "hand_controller"
    assert served.process.poll() is None


def test_bytes_that_are_no_requests(served):
    source = random.Random(5)
    head = f"POST /api/start HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\nContent-Type: application/json\r\n"
    good = f"{head}Content-Length: 2\r\n\r\n{{}}"
    for number in range(120):
        raw = bytearray(good.encode())
        for _ in range(source.randrange(1, 12)):
            raw[source.randrange(len(raw))] = source.randrange(256)
        if number % 3 == 0:
            raw = bytearray(source.randbytes(source.randrange(1, 300)))
        with socket.create_connection(("127.0.0.1", served.port), timeout=LONGEST) as one:
            one.sendall(bytes(raw))
            one.shutdown(socket.SHUT_WR)
            received = one.recv(65536)
        assert b" 500 " not in received.split(b"\r\n")[0], raw
    assert served.ask("start", {})[0]["study"]["name"] == "hand_controller"
    assert free_port() != served.port


@pytest.mark.parametrize(
    "path", ["/", "/page/", "/page/js", "/api/", "/api/study/", "/API/study", "/%00", "/page/%ff%fe"]
)
def test_strange_paths(served, path):
    for method in ("GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "PATCH"):
        connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=LONGEST)
        connection.request(method, path, b"" if method == "GET" else b"{}", {"Content-Type": "application/json"})
        assert connection.getresponse().status < 500, (method, path)
        connection.close()
