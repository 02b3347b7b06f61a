"""The way from the control loop to disk and viewer: a bounded queue and a thread that empties it.

The loop only appends. When the writer falls behind, a simulation that goes as fast as it can waits
for it and keeps every tick; whatever runs in real time cannot wait and loses the oldest ones,
counted.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Feed(Generic[Item]):
    """Hands items to a slow writer, in order and in batches, from a thread of its own.

    Args:
        write: called with one batch at a time, never empty, always from the same thread. The first
            exception ends the writing, not the run.
        lossless: wait when the queue is full, instead of dropping the oldest item.
        period: nothing waits longer than this for a full batch [s of real time].
        capacity: most items that wait.
        batch: items that are worth a call of `write`.
    """

    def __init__(
        self,
        write: Callable[[Sequence[Item]], None],
        *,
        lossless: bool,
        period: float = 0.5,
        capacity: int = 400,
        batch: int = 100,
    ) -> None:
        self.dropped = 0
        self.error: Exception | None = None
        self._write = write
        self._lossless = lossless
        self._period = period
        self._capacity = capacity
        self._batch = min(batch, capacity)
        self._items: deque[Item] = deque()
        self._closing = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def put(self, item: Item) -> None:
        """Add an item; nothing happens once the writer has failed or the feed is closed."""
        with self._changed:
            if self._lossless:
                self._changed.wait_for(lambda: self._has_room() or self._is_over())
            if self._is_over():
                return
            if not self._has_room():
                self._items.popleft()
                self.dropped += 1
            self._items.append(item)
            if len(self._items) == 1 or len(self._items) >= self._batch:
                self._changed.notify_all()

    def close(self, patience: float) -> bool:
        """Write what is left and end the thread.

        Args:
            patience: longest time to wait for it [s of real time].

        Returns:
            Whether the thread has ended.
        """
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._thread.join(patience)
        return not self._thread.is_alive()

    def _has_room(self) -> bool:
        return len(self._items) < self._capacity

    def _is_over(self) -> bool:
        return self._closing or self.error is not None

    def _run(self) -> None:
        while batch := self._next_batch():
            try:
                self._write(batch)
            except Exception as error:  # whatever it is, the robot must go on
                with self._changed:
                    self.error = error
                    self._items.clear()
                    self._changed.notify_all()
                return

    def _next_batch(self) -> list[Item]:
        """What has come together; empty only at the end."""
        with self._changed:
            while not self._items and not self._closing:
                self._changed.wait()
            self._changed.wait_for(
                lambda: len(self._items) >= self._batch or self._closing, timeout=self._period
            )
            batch = list(self._items)
            self._items.clear()
            self._changed.notify_all()
            return batch
