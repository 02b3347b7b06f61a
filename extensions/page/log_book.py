"""The last lines of the log of a run."""

import threading
from collections import deque
from collections.abc import Iterable

from app.live import LogLine

_MOST_LINES = 300


class LogBook:
    """The last lines of a log, numbered from its beginning; for any thread."""

    def __init__(self) -> None:
        self._lines: deque[LogLine] = deque(maxlen=_MOST_LINES)
        self._count = 0
        self._lock = threading.Lock()

    def add(self, lines: Iterable[LogLine]) -> None:
        """Add lines at the end."""
        with self._lock:
            for line in lines:
                self._lines.append(line)
                self._count += 1

    def after(self, count: int) -> tuple[int, list[LogLine]]:
        """The number of lines so far, and the last of those after the first `count`."""
        with self._lock:
            new = min(self._count - count, len(self._lines))
            return self._count, list(self._lines)[len(self._lines) - new :]
