"""Page of a run whose process does not serve it: JSON lines over a socket to the one that does.

Out go `about`, `state`, `log` and `picture`; in come the paths of buttons, a line each. When the
other process is gone, the run ends and the robot comes to rest.
"""

from __future__ import annotations

import json
import socket
import threading
from contextlib import suppress

from app.live.operator.page import ControlPage, Told
from config import UserError

_PERIOD = 0.2  # of the state [s]


class PagePipe:
    """Tells another process about the newest page; use it in a `with` statement."""

    def __init__(self, file: int) -> None:
        self._socket = socket.socket(fileno=file)
        self._page: ControlPage | None = None
        self._closing = threading.Event()
        self._threads = [
            threading.Thread(target=target, name=f"page {name}", daemon=True)
            for name, target in (("out", self._tell), ("in", self._listen))
        ]

    def serve(self, page: ControlPage) -> None:
        """Tell of a run from now on. Raises UserError: no thread can be started."""
        self._page = page
        try:
            for thread in self._threads:
                thread.start()
        except RuntimeError as error:
            text = f"the page cannot be served ({error}); end other programs and start again"
            raise UserError(text) from error

    def __enter__(self) -> PagePipe:
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.set()
        if self._threads[0].is_alive():
            self._threads[0].join(_PERIOD * 10)
        with suppress(OSError):  # the other process is gone
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _listen(self) -> None:
        assert self._page is not None
        with suppress(OSError), self._socket.makefile("r", encoding="utf-8") as lines:
            for line in lines:
                with suppress(Exception):  # the run reports it; Stop has to work afterwards
                    self._page.act(line.rstrip("\n"))
        if not self._closing.is_set():
            self._page.stop()

    def _tell(self) -> None:
        page, logged, last = self._page, 0, False
        assert page is not None
        sent: Told | None = None
        with suppress(OSError):
            self._send(about=page.about())
            while not last:
                last = self._closing.wait(_PERIOD)
                page.catch_up()
                logged, lines = page.log.after(logged)
                shown = page.picture()
                news: Told = {"state": page.state()}
                news |= {"log": lines} if lines else {}
                news |= {"picture": shown} if shown is not sent else {}
                sent = shown
                self._send(**news)

    def _send(self, **news: object) -> None:
        self._socket.sendall(json.dumps(news).encode() + b"\n")
