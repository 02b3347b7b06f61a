"""The control page among many connections that say nothing: whoever has the token is heard."""

import http.client
import socket
import threading

import pytest
from sample_run import TREE, snapshot

from app.live.operator import Control, ControlPage, PageServer
from app.live.web.http_server import MOST_CONNECTIONS


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
    control, before = Control(), threading.active_count()
    with PageServer() as server:
        server.serve(ControlPage(control, TREE, inject=print, clear=print))
        server.page.show(snapshot(0))
        with Strangers(server.port, number, says):
            for method, path in [("GET", "/state"), ("POST", "/pause")] * 8:
                client = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60.0)
                client.request(method, path, headers={"X-Token": server.token})
                assert client.getresponse().status == 200
                client.close()
            assert control.state.paused
            assert threading.active_count() - before <= MOST_CONNECTIONS + 8
