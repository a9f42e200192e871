"""Requests of other sites, forged names, missing tokens, large and slow requests: refused, while the page's own are answered."""

import contextlib
import http.client
import json
import re
import socket
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from sampled import sampled
from serving import free_port, serving

pytestmark = pytest.mark.skipif(
    not hasattr(socket, "AF_UNIX"), reason="the helpers of this test read processes of POSIX"
)


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with serving("--port", str(free_port()), folder=tmp_path_factory.mktemp("served")) as one:
        yield one


def fetched(served, path="/api/start", method="POST", body=b"{}", **headers):
    """Status, headers and body of a request with exactly these headers."""
    connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=30)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    given = {"Host": f"127.0.0.1:{served.port}", "Content-Type": "application/json", **headers}
    for name, value in given.items():
        if value is not None:
            connection.putheader(name.replace("_", "-"), value)
    connection.putheader("Content-Length", str(len(body)))
    try:
        connection.endheaders(body)
        reply = connection.getresponse()
        return reply.status, {name.lower(): value for name, value in reply.getheaders()}, reply.read()
    finally:
        connection.close()


@pytest.mark.slow
@sampled("name", ["127.0.0.1", "localhost", "[::1]", "LOCALHOST"], every=4)
def test_own_names_are_answered(served, name):
    assert fetched(served, Host=f"{name}:{served.port}")[0] == 200


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "evil.example:{port}",
        "127.0.0.1",
        "127.0.0.1:1",
        "127.0.0.1.evil.example:{port}",
        "localhost.evil.example:{port}",
        "evil.example:{port}@127.0.0.1:{port}",
        "192.168.0.7:{port}",
        "10.0.0.1:{port}",
        "[::2]:{port}",
        "",
        None,
    ],
)
def test_a_forged_host_is_refused(served, host):
    """A name that another site resolves to this machine would make the browser take its page for ours."""
    # Without a body, nothing is left unread when the server closes: no reset can cut its reply off.
    for path, method in (("/api/start", "POST"), ("/", "GET"), ("/page/style.css", "GET")):
        named = None if host is None else host.format(port=served.port)
        status, _, body = fetched(served, path, method, body=b"", Host=named)
        assert status in (400, 421), (host, status)
        assert b"tables" not in body


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "https://127.0.0.1:{port}",
        "http://127.0.0.1",
        "http://127.0.0.1:1",
        "http://localhost:{port}",
        "http://127.0.0.1:{port}.evil.example",
        "null",
        "",
    ],
)
def test_a_forged_origin_is_refused(served, origin):
    for path, method in (("/api/start", "POST"), ("/api/job", "POST"), ("/", "GET")):
        assert fetched(served, path, method, Origin=origin.format(port=served.port))[0] == 403


def test_the_own_origin_is_answered(served):
    assert fetched(served, Origin=f"http://127.0.0.1:{served.port}")[0] == 200
    assert fetched(served, Host=f"localhost:{served.port}", Origin=f"http://localhost:{served.port}")[0] == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_requests_that_a_browser_marks_as_of_other_sites_are_refused(served, site):
    assert fetched(served, Sec_Fetch_Site=site)[0] == 403
    assert fetched(served, "/page/style.css", "GET", Sec_Fetch_Site=site)[0] == 403
    assert fetched(served, "/", "GET", Sec_Fetch_Site=site)[0] == 200  # a link to the page shows it, and no more
    assert fetched(served, Sec_Fetch_Site="same-origin")[0] == 200


@pytest.mark.parametrize("kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", "", None])
def test_what_forms_can_send_is_refused(served, kind):
    assert fetched(served, **{"Content-Type": kind})[0] == 415


def test_every_reply_has_a_strict_policy(served):
    for path, method in (
        ("/", "GET"),
        ("/api/start", "POST"),
        ("/page/style.css", "GET"),
        ("/page/js/main.js", "GET"),
        ("/nothing", "GET"),
        ("/api/no", "POST"),
        ("/api/start", "GET"),
    ):
        _, headers, _ = fetched(served, path, method)
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "http" not in policy
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["x-frame-options"] == "DENY"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["cross-origin-resource-policy"] == "same-origin"
        assert "server" not in headers
        assert "access-control-allow-origin" not in headers
        assert "no-store" in headers["cache-control"] if path.startswith("/api") and method == "POST" else True


def test_scripts_and_styles_have_their_types(served):
    assert fetched(served, "/page/js/main.js", "GET")[1]["content-type"].startswith("text/javascript")
    assert fetched(served, "/page/style.css", "GET")[1]["content-type"].startswith("text/css")


def test_the_page_asks_for_nothing_else(served):
    """No file of the page names another machine, except for links that a user follows."""
    from internals import SERVED_PAGE as PAGE

    for file in PAGE.rglob("*"):
        if file.suffix in (".html", ".css", ".js", ".svg"):
            text = file.read_text("utf-8")
            if file.suffix == ".html":
                assert not re.search(r"<script(?![^>]*\bsrc=)[^>]*>", text), file
                assert not re.search(r"\sstyle=|\son\w+=", text), file
            found = re.findall(r"(?:src|href|url|import|fetch)\W{1,3}(https?:|//)\S+", text)
            assert not found, file
            assert not re.search(r"\beval\(|new Function\(", text), file


def test_a_file_that_a_browser_has_is_not_sent_again(served):
    status, headers, body = fetched(served, "/page/js/main.js", "GET")
    assert (status, bool(body)) == (200, True)
    status, again, body = fetched(served, "/page/js/main.js", "GET", If_None_Match=headers["etag"])
    assert (status, body, again["etag"]) == (304, b"", headers["etag"])
    assert fetched(served, "/page/js/main.js", "GET", If_None_Match='"another"')[0] == 200


@pytest.mark.parametrize(
    "path",
    [
        "/page/../server/app.py",
        "/page/%2e%2e/server/app.py",
        "/page/..%2fserver%2fapp.py",
        "/page/....//server/app.py",
        "/page//etc/passwd",
        "/page/%2fetc%2fpasswd",
        "/page/js/../../server/app.py",
        "/page/..\\server\\app.py",
        "/page/index.html%00.js",
        "//etc/passwd",
        "/etc/passwd",
        "/../../etc/passwd",
    ],
)
def test_no_other_file_is_sent(served, path):
    status, _, body = fetched(served, path, "GET")
    assert status in (400, 404, 405), path
    assert b"import" not in body
    assert b"root:" not in body


def test_large_requests_are_refused(served):
    body = json.dumps({"name": "x", "tables": {"title": "x" * 1_100_000}}).encode()
    status, _, _ = fetched(served, "/api/study", body=body)
    assert status == 413
    deep = b'{"name": "x", "tables": ' + b'{"a":' * 200_000 + b"1" + b"}" * 200_000 + b"}"
    assert fetched(served, "/api/study", body=deep[:999_999])[0] == 400
    assert (
        fetched(served, "/api/study", body=b'{"name": "x", "tables": ' + b'{"a":' * 5000 + b"1" + b"}" * 5001)[0] == 400
    )
    with contextlib.suppress(ConnectionError):  # hung up on before all of it was sent
        assert fetched(served, "/", "GET", X_Large="x" * 200_000)[0] in (400, 431)


@pytest.mark.parametrize("body", [b"", b"[]", b"3", b"null", b"{", b'{"a": NaN}', b"\xff\xfe", b'{"count": 1e999}'])
def test_what_is_not_a_json_object_is_refused(served, body):
    status, _, text = fetched(served, "/api/maps", body=body)
    assert status == 400
    assert "error" in json.loads(text)


@pytest.mark.parametrize(
    "headers", [{"X_Client": "a b"}, {"X_Client": "x" * 65}, {"X_Sequence": "3"}, {"X_Client": "a", "X_Sequence": "-1"}]
)
def test_headers_of_clients_are_checked(served, headers):
    assert fetched(served, **headers)[0] == 400


def impatient(served, count):
    """Peers that send nothing, half a head, and half a body."""
    half_head = b"POST /api/start HTTP/1.1\r\nHost: 127"
    half_body = (
        f"POST /api/start HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\nContent-Type: application/json\r\n"
        "Content-Length: 100\r\n\r\n{"
    ).encode()
    with contextlib.ExitStack() as stack:
        peers = []
        for start in (b"", half_head, half_body):
            for _ in range(count):
                one = stack.enter_context(socket.create_connection(("127.0.0.1", served.port), timeout=30))
                one.sendall(start)
                peers.append(one)
        yield peers


slow_peers = contextlib.contextmanager(impatient)


def test_slow_and_half_open_connections_do_not_block_others(served):
    with slow_peers(served, 40):
        begin = time.perf_counter()
        with served.client() as client:
            for _ in range(5):
                assert client.post("api/start", json={}).status_code == 200
        assert time.perf_counter() - begin < 5.0


@pytest.mark.slow
def test_slow_and_half_open_connections_are_hung_up_on(served):
    with ThreadPoolExecutor() as pool, slow_peers(served, 1) as peers:
        trickling = pool.submit(trickle, served)
        for one in peers:
            one.settimeout(25)
            received = one.recv(4096)
            assert received == b"" or b" 408 " in received.split(b"\r\n")[0]
        assert trickling.result() < 20.0  # not longer than the others


def trickle(served):
    """Seconds for which the server listens to a request that comes byte by byte."""
    with socket.create_connection(("127.0.0.1", served.port), timeout=30) as one:
        begin = time.perf_counter()
        with contextlib.suppress(ConnectionError):
            while time.perf_counter() - begin < 25.0:
                one.sendall(b"G" if time.perf_counter() - begin < 0.5 else b"E")
                time.sleep(1.0)
        return time.perf_counter() - begin


@pytest.mark.slow
def test_a_wider_host_needs_the_token(tmp_path):
    with serving("--host", "0.0.0.0", "--port", str(free_port()), folder=tmp_path) as wide:
        assert wide.token
        assert len(wide.token) > 24
        for path, method in (("/", "GET"), ("/api/start", "POST"), ("/page/style.css", "GET"), ("/?token=x", "GET")):
            status, _, body = fetched(wide, path, method)
            assert status == 401, path
            assert b"infinivar serve printed" in body
        assert fetched(wide, Cookie="infinivar_token=wrong")[0] == 401
        assert fetched(wide, Cookie=f"infinivar_token={wide.token}")[0] == 200
        assert fetched(wide, Authorization=f"Bearer {wide.token}")[0] == 200
        # The token is no leave to come from another site, or by its name.
        assert fetched(wide, Cookie=f"infinivar_token={wide.token}", Origin="http://evil.example")[0] == 403
        assert fetched(wide, Cookie=f"infinivar_token={wide.token}", Host=f"evil.example:{wide.port}")[0] == 421
        status, headers, _ = fetched(wide, f"/?token={wide.token}", "GET")
        assert status == 303
        assert "HttpOnly" in headers["set-cookie"]
        assert "SameSite=Strict" in headers["set-cookie"]
        with wide.client() as client:
            reply = client.get(
                f"{wide.address.replace('0.0.0.0', '127.0.0.1')}?token={wide.token}", follow_redirects=True
            )
            assert reply.status_code == 200
            assert "token" not in str(reply.url)
