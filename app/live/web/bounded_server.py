"""An HTTP server whose threads are bounded, however slow or many its clients are."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from http.server import ThreadingHTTPServer
from typing import Any

from hw import stopwatch

PATIENCE = 10.0
"""A connection that is older is ended, whatever is still to come [s]."""
MOST_CONNECTIONS = 32
"""At a time; each has a thread. Whoever comes on top is turned away."""


class BoundedServer(ThreadingHTTPServer):
    """A thread for each connection, but a bounded number, and none for longer than `PATIENCE`."""

    patience: float | None = None
    """Another limit than `PATIENCE` [s]."""
    daemon_threads = True
    request_queue_size = MOST_CONNECTIONS

    def __init__(self, *arguments: Any) -> None:
        self._begun: dict[socket.socket, float] = {}
        self._lock = threading.Lock()
        super().__init__(*arguments)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection on a thread of its own, or turn it away."""
        with self._lock:
            is_free = len(self._begun) < MOST_CONNECTIONS
            if is_free:
                self._begun[request] = stopwatch()
        if is_free:
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def shutdown_request(self, request: Any) -> None:
        """End a connection."""
        with self._lock:
            self._begun.pop(request, None)
        super().shutdown_request(request)

    def service_actions(self) -> None:
        """Called at every poll: end the connections that have had their time."""
        now, patience = stopwatch(), PATIENCE if self.patience is None else self.patience
        with self._lock:
            late = [one for one, begun in self._begun.items() if now - begun > patience]
        for request in late:
            with suppress(OSError):  # its thread has ended it meanwhile
                request.shutdown(socket.SHUT_RDWR)

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a browser that disconnects in the middle of a reply."""
