"""The control page among strangers: many connections and requests, odd and random ones."""

import http.client
import os
import random
import socket
import threading

import pytest
from sample_run import TREE, moment

from app.live import Control
from extensions.page.control_page import ControlPage
from extensions.page.server import PageServer


class Strangers:
    """Connections that say nothing, or a byte at a time, and come back when they are ended."""

    def __init__(self, port: int, number: int, says: bytes) -> None:
        self._port, self._says, self._over = port, says, threading.Event()
        self._open = [self._opened() for _ in range(number)]
        self._thread = threading.Thread(target=self._go_on)

    def _opened(self) -> socket.socket:
        one = socket.create_connection(("127.0.0.1", self._port), timeout=60.0)
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
def test_connections_that_say_nothing_do_not_keep_a_person_out(number, says):
    control, before = Control(), threads()
    with PageServer() as server:
        server.serve(ControlPage(control, TREE))
        server.page.show(moment(0))
        with Strangers(server.port, number, says):
            for method, path in [("GET", "/state"), ("POST", "/pause")] * 8:
                client = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60.0)
                client.request(method, path, headers={"X-Token": server.token})
                assert client.getresponse().status == 200
                client.close()
            assert control.state.paused
            assert threads() - before <= 8


def threads() -> int:
    return len(os.listdir("/proc/self/task"))


def test_many_requests_are_answered_and_a_person_is_heard():
    control = Control()
    with PageServer() as server:
        server.serve(ControlPage(control, TREE))
        for line, status in (
            (b"GET /state HTTP/1.1\r\nHost: x\r\n\r\n", b"403"),
            (request(server, b"GET /state HTTP/1.1"), b"200"),
        ):
            asked = []
            for _ in range(300):
                asked.append(socket.create_connection(("127.0.0.1", server.port)))
                asked[-1].sendall(line)
            assert {one.recv(12)[9:] for one in asked} == {status}
            for one in asked:
                one.close()
        assert b" 200 " in sent(server, request(server, b"POST /pause HTTP/1.1"))
        assert control.state.paused


def sent(server: PageServer, data: bytes) -> bytes:
    """What comes back for bytes, until the server ends the connection."""
    answer = b""
    with socket.create_connection(("127.0.0.1", server.port), timeout=60.0) as connection:
        try:
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            while part := connection.recv(65536):
                answer += part
        except OSError:  # ended while we were still talking
            pass
    return answer


def request(server: PageServer, line: bytes, *headers: bytes) -> bytes:
    own = [b"Host: 127.0.0.1:%d" % server.port, b"X-Token: " + server.token.encode()]
    return b"\r\n".join([line, *own, *headers, b"", b""])


REFUSED = [
    b"BREW /state HTTP/1.1",
    b"GET http://evil.example/state HTTP/1.1",
    b"POST /%zz%f HTTP/1.1",
    b"GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1",
]


def test_odd_and_random_requests_are_refused_and_harm_nothing(capfd):
    control = Control()
    with PageServer() as server:
        server.serve(ControlPage(control, TREE))
        for line in REFUSED:
            answer = sent(server, request(server, line))
            assert answer[:5] == b"HTTP/", line
            assert answer.split()[1][:1] in (b"4", b"5"), line
        for data in (b"", bytes(1000), b"GET /" + b"a" * 1_000_000 + b" HTTP/1.1\r\n\r\n"):
            sent(server, data)
        rng = random.Random(0)
        good = request(server, b"POST /nothing HTTP/1.1", b"Content-Length: 3") + b"abc"
        for _ in range(60):
            data = bytearray(good)
            for _ in range(rng.randrange(1, 12)):
                data[rng.randrange(len(data))] = rng.randrange(256)
            sent(server, bytes(data))
        assert server.state()["ticks"] == 0
        assert not control.state.paused
        assert capfd.readouterr() == ("", "")
