"""The control page under malformed, slow and many requests: it goes on, with few threads."""

import http.client
import json
import random
import socket
import threading
import time
from contextlib import suppress

import pytest
from sample_run import TREE, snapshot

from app.live.operator import Control
from app.live.operator.page import ControlPage
from app.live.operator.page_server import PageServer
from app.live.web import FileServer, http_server
from app.live.web.http_server import MOST_CONNECTIONS


@pytest.fixture
def control():
    return Control()


@pytest.fixture
def page(control):
    with PageServer() as server:
        server.serve(ControlPage(control, TREE, inject=print, clear=print))
        server.page.show(snapshot(0))
        yield server


@pytest.fixture(autouse=True)
def silent(capfd):
    """Nothing is printed."""
    yield
    assert capfd.readouterr() == ("", "")


def alive(page: PageServer) -> bool:
    connection = http.client.HTTPConnection("127.0.0.1", page.port, timeout=5.0)
    connection.request("GET", "/state", headers={"X-Token": page.token})
    reply = connection.getresponse()
    return reply.status == 200 and "ticks" in json.loads(reply.read())


def send(port: int, data: bytes, seconds: float = 3.0) -> bytes:
    """What comes back for bytes, until the server ends the connection."""
    with socket.create_connection(("127.0.0.1", port), timeout=seconds) as connection:
        answer = b""
        try:
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            while part := connection.recv(65536):
                answer += part
        except OSError:  # ended while we were still talking
            pass
        return answer


def request(page: PageServer, line: bytes, *headers: bytes, token: bool = True) -> bytes:
    own = [b"Host: 127.0.0.1:%d" % page.port]
    own += [b"X-Token: " + page.token.encode()] if token else []
    return b"\r\n".join([line, *own, *headers, b"", b""])


MALFORMED = [
    b"",
    b"\r\n",
    bytes(1000),
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" * 20,
    b"GET\r\n\r\n",
    b"GET / state HTTP/1.1\r\n\r\n",
    b"GET / HTTP/x.y\r\n\r\n",
    b"GET / HTTP/99.0\r\n\r\n",
    b"GET /" + b"a" * 1_000_000 + b" HTTP/1.1\r\n\r\n",
    b"GET /state HTTP/1.1\r\nHost: 127",
]
REFUSED = [
    b"BREW /state HTTP/1.1",
    b"__class__ /state HTTP/1.1",
    b"HEAD /state HTTP/1.1",
    b"CONNECT example.com:443 HTTP/1.1",
    b"GET http://[ HTTP/1.1",
    b"GET http://evil.example/state HTTP/1.1",
    b"POST /%zz%f HTTP/1.1",
    b"POST /fault/%ff%fe HTTP/1.1",
    b"POST /%00 HTTP/1.1",
    b"GET /\xff\xfe HTTP/1.1",
    b"GET /../../etc/passwd HTTP/1.1",
    b"GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1",
    b"GET /viewer/..%2f..%2fsecret HTTP/1.1",
    b"GET ? HTTP/1.1",
    b"OPTIONS * HTTP/1.1",
]
HEADERS = [
    [b"X-%d: 1" % number for number in range(1000)],
    [b"X-A: " + b"a" * 1_000_000],
    [b"nothing"],
    [b"X-A: 1", b" 2", b"\t3"],
    [b"X-A: \xff\xfe\x00"],
    [b"X-Token: \xff\xfe"],
    [b"Content-Length: many"],
    [b"Content-Length: -1"],
    [b"Content-Length: 99999999999999999999"],
    [b"Transfer-Encoding: chunked"],
    [b"Host: evil.example"],
    [b"Expect: 100-continue"],
    [b"Connection: Upgrade", b"Upgrade: websocket"],
]


def test_malformed_requests_and_headers_harm_nothing(page, control):
    for data in MALFORMED:
        send(page.port, data)
        assert alive(page), data[:100]
    for headers in HEADERS:
        for line in (b"GET /state HTTP/1.1", b"POST /nothing HTTP/1.1"):
            send(page.port, request(page, line, *headers))
            assert alive(page), headers[0][:100]
    assert not control.state.paused


def test_odd_requests_are_refused(page, control):
    for line in REFUSED:
        answer = send(page.port, request(page, line))
        assert answer[:5] == b"HTTP/", line
        assert answer.split()[1][:1] in (b"4", b"5"), line
        assert alive(page), line
    for token in (b"", b"a", b"\xff" * 22, page.token.encode()[:-1], b"a" * 60_000, b"null"):
        line = request(page, b"POST /pause HTTP/1.1", b"X-Token: " + token, token=False)
        assert b" 403 " in send(page.port, line)[:30], token
    assert not control.state.paused


def test_random_requests_harm_nothing(page):
    rng = random.Random(0)
    good = request(page, b"POST /nothing HTTP/1.1", b"Content-Length: 3") + b"abc"
    for _ in range(200):
        data = bytearray(good)
        for _ in range(rng.randrange(1, 12)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        send(page.port, bytes(data[: rng.randrange(len(data))] if rng.random() < 0.3 else data))
    assert alive(page)


def test_slow_clients_are_turned_away_and_take_few_threads(page, monkeypatch):
    monkeypatch.setattr(http_server, "PATIENCE", 1.0)
    before = threading.active_count()
    slow = []
    for _ in range(3 * MOST_CONNECTIONS):
        one = socket.create_connection(("127.0.0.1", page.port), timeout=5.0)
        one.sendall(b"POST /pause HTTP/1.1\r\nX-")
        slow.append(one)
    deadline, most = time.monotonic() + 15.0, 0
    while time.monotonic() < deadline:
        most = max(most, threading.active_count() - before)
        for one in slow:
            with suppress(OSError):
                one.sendall(b"a")  # always busy, never done
        if most and threading.active_count() <= before:
            break
        time.sleep(0.1)
    assert 0 < most <= MOST_CONNECTIONS + 4  # those that were sent away may take a moment
    assert threading.active_count() <= before
    assert alive(page)
    for one in slow:
        one.close()


class Strangers:
    """Connections that say nothing, or a byte at a time, and come back when they are sent away."""

    def __init__(self, port: int, number: int, *, says: bytes) -> None:
        self._port, self._says, self._over = port, says, threading.Event()
        self._open = [self._opened() for _ in range(number)]
        self._thread = threading.Thread(target=self._go_on)

    def _opened(self) -> socket.socket:
        one = socket.create_connection(("127.0.0.1", self._port), timeout=5.0)
        one.setblocking(False)
        return one

    def _go_on(self) -> None:
        while not self._over.wait(0.02):
            for index, one in enumerate(self._open):
                try:
                    if self._says:
                        one.send(self._says)
                    if one.recv(1000) == b"":
                        raise ConnectionResetError
                except BlockingIOError:
                    continue
                except OSError:
                    one.close()
                    self._open[index] = self._opened()

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        for one in self._open:
            one.close()


@pytest.mark.parametrize(("number", "says"), [(60, b"P"), (150, b"")])
def test_connections_that_say_nothing_do_not_keep_a_person_out(page, control, number, says):
    with Strangers(page.port, number, says=says):
        for _ in range(8):
            assert alive(page)
            assert b" 200 " in send(page.port, request(page, b"POST /pause HTTP/1.1"))[:30]
            assert control.state.paused
            control.resume()


def test_connections_that_say_nothing_do_not_keep_the_viewer_out():
    server = FileServer("127.0.0.1", 0)
    try:
        with Strangers(server.port, 100, says=b""):
            for _ in range(5):
                assert b" 200 " in send(server.port, b"GET /favicon.ico HTTP/1.1\r\n\r\n")[:30]
    finally:
        server.close()


def test_an_action_that_fails_and_files_that_are_missing_are_answered(control, monkeypatch):
    def broken(name: str) -> None:
        raise OSError(name)

    monkeypatch.setattr("app.live.web.http_server.read_file", broken)
    with PageServer() as page:
        page.serve(ControlPage(control, TREE, inject=broken, clear=print))
        fault = request(page, b"POST /fault/reflex HTTP/1.1")
        assert b" 500 " in send(page.port, fault)[:30]
        viewer = request(page, b"GET /viewer/re_viewer.js HTTP/1.1")
        assert b" 502 " in send(page.port, viewer)[:30]
        assert alive(page)
