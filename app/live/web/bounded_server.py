"""An HTTP server whose threads are bounded, however slow or many its clients are.

Who shows that it is known, by a token, is never sent away for others: where there are too many
connections, the oldest of the strangers goes. One that keeps its connection open and says nothing
thus keeps nobody out.
"""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from http.server import ThreadingHTTPServer
from typing import Any

from hw import stopwatch

PATIENCE = 10.0
"""A connection that is older is ended, whatever is still to come [s]."""
MOST_CONNECTIONS = 64
"""At a time; each has a thread."""
_PACE = 0.002
"""Where there are too many, one comes in so often: whoever does has `MOST_CONNECTIONS` times that
to say what it wants, and a flood of them takes no more of the processor [s]."""


class BoundedServer(ThreadingHTTPServer):
    """A thread for each connection, but a bounded number, and none for longer than `PATIENCE`."""

    patience: float | None = None
    """Another limit than `PATIENCE` [s]."""
    daemon_threads = True
    request_queue_size = 4 * MOST_CONNECTIONS

    def __init__(self, *arguments: Any) -> None:
        self._begun: dict[socket.socket, float] = {}
        self._known: set[socket.socket] = set()
        self._lock = threading.Lock()
        super().__init__(*arguments)

    def keep(self, request: socket.socket) -> None:
        """Never end this connection for another: its client is known."""
        with self._lock:
            self._known.add(request)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection on a thread of its own, if need be instead of a stranger's."""
        with self._lock:
            is_free = len(self._begun) < MOST_CONNECTIONS
            strangers = (one for one in self._begun if one not in self._known)
            oldest = None if is_free else next(strangers, None)
            if oldest is not None:
                del self._begun[oldest]
            if is_free or oldest is not None:
                self._begun[request] = stopwatch()
        if oldest is not None:
            _end(oldest)
            threading.Event().wait(_PACE)
        if is_free or oldest is not None:
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def shutdown_request(self, request: Any) -> None:
        """End a connection."""
        with self._lock:
            self._begun.pop(request, None)
            self._known.discard(request)
        super().shutdown_request(request)

    def service_actions(self) -> None:
        """Called at every poll: end the connections that have had their time."""
        now, patience = stopwatch(), PATIENCE if self.patience is None else self.patience
        with self._lock:
            late = [one for one, begun in self._begun.items() if now - begun > patience]
        for request in late:
            _end(request)

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a browser that disconnects in the middle of a reply."""


def _end(request: socket.socket) -> None:
    with suppress(OSError):  # it has ended it meanwhile
        request.shutdown(socket.SHUT_RDWR)
