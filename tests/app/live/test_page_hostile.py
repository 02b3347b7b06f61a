"""The control page under malformed, slow and many requests: it goes on, with few threads."""

import http.client
import http.server
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
from app.live.web import FileServer, bounded_server
from app.live.web.bounded_server import MOST_CONNECTIONS


@pytest.fixture
def control():
    return Control()


@pytest.fixture
def page(control):
    with http.server.HTTPServer(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler) as probe:
        port = probe.server_port
    with PageServer(port) as server:
        server.serve(ControlPage(control, TREE, inject=print, clear=print))
        server.page.show(snapshot(0))
        yield server


def alive(page: PageServer) -> bool:
    connection = http.client.HTTPConnection("127.0.0.1", page.port, timeout=5.0)
    connection.request("GET", "/state", headers={"X-Token": page.token})
    reply = connection.getresponse()
    return reply.status == 200 and "ticks" in json.loads(reply.read())


def send(page: PageServer, data: bytes, seconds: float = 3.0) -> bytes:
    return send_to(page.port, data, seconds)


def send_to(port: int, data: bytes, seconds: float = 3.0) -> bytes:
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


MALFORMED = {
    "nothing": b"",
    "a line end": b"\r\n",
    "zeros": bytes(1000),
    "no HTTP": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" * 20,
    "a word": b"GET\r\n\r\n",
    "two words": b"GET /state\r\n\r\n",
    "four words": b"GET / state HTTP/1.1\r\n\r\n",
    "no version": b"GET / HTTP/x.y\r\n\r\n",
    "version 99": b"GET / HTTP/99.0\r\n\r\n",
    "version 0.9": b"GET / HTTP/0.9\r\n\r\n",
    "a line of a megabyte": b"GET /" + b"a" * 1_000_000 + b" HTTP/1.1\r\n\r\n",
    "half a request": b"GET /state HTTP/1.1\r\nHost: 127",
}
LINES = {
    "an unknown method": b"BREW /state HTTP/1.1",
    "a method that is dangerous": b"__class__ /state HTTP/1.1",
    "DELETE": b"DELETE / HTTP/1.1",
    "HEAD": b"HEAD /state HTTP/1.1",
    "CONNECT": b"CONNECT example.com:443 HTTP/1.1",
    "an open bracket": b"GET http://[ HTTP/1.1",
    "an open bracket to post": b"POST http://[::1 HTTP/1.1",
    "a whole address": b"GET http://evil.example/state HTTP/1.1",
    "a bad escape": b"POST /%zz%f HTTP/1.1",
    "an escape that is no text": b"POST /fault/%ff%fe HTTP/1.1",
    "an escape of nothing": b"POST /%00 HTTP/1.1",
    "bytes that are no text": b"GET /\xff\xfe HTTP/1.1",
    "up and away": b"GET /../../etc/passwd HTTP/1.1",
    "up and away, escaped": b"GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1",
    "a file of the viewer": b"GET /viewer/..%2f..%2fsecret HTTP/1.1",
    "no path": b"GET ? HTTP/1.1",
    "a star": b"OPTIONS * HTTP/1.1",
}
HEADERS = {
    "a thousand": [b"X-%d: 1" % number for number in range(1000)],
    "one of a megabyte": [b"X-A: " + b"a" * 1_000_000],
    "no colon": [b"nothing"],
    "a folded line": [b"X-A: 1", b" 2", b"\t3"],
    "bytes that are no text": [b"X-A: \xff\xfe\x00"],
    "a token of bytes": [b"X-Token: \xff\xfe"],
    "a length that is no number": [b"Content-Length: many"],
    "a length below zero": [b"Content-Length: -1"],
    "an endless length": [b"Content-Length: 99999999999999999999"],
    "chunks": [b"Transfer-Encoding: chunked"],
    "two hosts": [b"Host: evil.example"],
    "expectations": [b"Expect: 100-continue"],
    "an upgrade": [b"Connection: Upgrade", b"Upgrade: websocket"],
}


@pytest.mark.parametrize("kind", MALFORMED)
def test_what_is_no_request_harms_nothing(page, control, kind, capfd):
    send(page, MALFORMED[kind])
    assert alive(page)
    assert not control.state.paused
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", LINES)
def test_an_odd_request_is_refused(page, control, kind, capfd):
    answer = send(page, request(page, LINES[kind]))
    assert answer[:5] == b"HTTP/"
    assert answer.split()[1][:1] in (b"4", b"5"), answer[:100]
    assert alive(page)
    assert not control.state.paused
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", HEADERS)
@pytest.mark.parametrize("line", [b"GET /state HTTP/1.1", b"POST /nothing HTTP/1.1"])
def test_odd_headers_harm_nothing(page, line, kind, capfd):
    send(page, request(page, line, *HEADERS[kind]))
    assert alive(page)
    assert capfd.readouterr() == ("", "")


def test_a_wrong_token_of_any_kind_is_refused(page, control):
    for token in (b"", b"a", b"\xff" * 22, page.token.encode()[:-1], b"a" * 60_000, b"null"):
        line = request(page, b"POST /pause HTTP/1.1", b"X-Token: " + token, token=False)
        assert b" 403 " in send(page, line)[:30]
    assert not control.state.paused


def test_random_requests_harm_nothing(page, capfd):
    rng = random.Random(0)
    good = request(page, b"POST /nothing HTTP/1.1", b"Content-Length: 3") + b"abc"
    for _ in range(300):
        data = bytearray(good)
        for _ in range(rng.randrange(1, 12)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        send(page, bytes(data[: rng.randrange(len(data))]) if rng.random() < 0.3 else bytes(data))
    assert alive(page)
    assert capfd.readouterr() == ("", "")


def test_slow_clients_are_turned_away_and_take_few_threads(page, monkeypatch, capfd):
    monkeypatch.setattr(bounded_server, "PATIENCE", 1.0)
    before = threading.active_count()
    slow = []
    for _ in range(3 * MOST_CONNECTIONS):
        one = socket.create_connection(("127.0.0.1", page.port), timeout=5.0)
        one.sendall(b"POST /pause HTTP/1.1\r\nX-")
        slow.append(one)
    deadline = time.monotonic() + 15.0
    most = 0
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
    assert capfd.readouterr() == ("", "")


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


@pytest.mark.parametrize("number", [60, 150])
@pytest.mark.parametrize("says", [b"", b"P"])
def test_connections_that_say_nothing_do_not_keep_a_person_out(page, control, number, says):
    with Strangers(page.port, number, says=says):
        for _ in range(8):
            assert alive(page)
            assert b" 200 " in send(page, request(page, b"POST /pause HTTP/1.1"))[:30]
            assert control.state.paused
            control.resume()


def test_connections_that_say_nothing_do_not_keep_the_viewer_out():
    server = FileServer("127.0.0.1", 0)
    try:
        with Strangers(server.port, 100, says=b""):
            for _ in range(5):
                assert b" 200 " in send_to(server.port, b"GET /favicon.ico HTTP/1.1\r\n\r\n")[:30]
    finally:
        server.close()


def test_an_action_that_fails_is_answered(control, capfd):
    def broken(name: str) -> None:
        raise RuntimeError(name)

    with PageServer() as page:
        page.serve(ControlPage(control, TREE, inject=broken, clear=print))
        answer = send(page, request(page, b"POST /fault/reflex HTTP/1.1"))
        assert b" 500 " in answer[:30]
        assert alive(page)
    assert capfd.readouterr() == ("", "")


def test_a_viewer_whose_files_are_not_to_be_had_is_a_bad_gateway(page, monkeypatch):
    def no_files(name: str) -> None:
        raise OSError("no space left")

    monkeypatch.setattr("app.live.web.replies.read_file", no_files)
    assert b" 502 " in send(page, request(page, b"GET /viewer/re_viewer.js HTTP/1.1"))[:30]
    assert alive(page)
