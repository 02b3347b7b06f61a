"""Bounded queue from the control loop to a writer thread, and a throttle by stamps.

The loop only appends and takes no lock, which could make it wait for the interpreter. When the
writer falls behind, a simulation at full speed waits for it and keeps every tick; a run in real
time drops and counts the oldest ticks.
"""

import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

Item = TypeVar("Item")

_ROUNDING = 1e-6  # tolerance, since stamps are sums of periods [s]


class Feed(Generic[Item]):
    """Passes items to a slow writer, in order and in batches, on a thread of its own.

    `write` gets non-empty batches; its first exception ends the writing. A full queue (`capacity`)
    waits if it is `lossless`, or else drops its oldest item. Items are written every `period` [s of
    real time], or as soon as there are `batch` of them. No thread to write with is such an error.
    """

    def __init__(
        self,
        write: Callable[[Sequence[Item]], None],
        *,
        lossless: bool,
        period: float = 0.5,
        capacity: int = 400,
        batch: int = 100,
        name: str = "recorder",
    ) -> None:
        self.dropped = 0
        self.error: Exception | None = None
        self._write, self._lossless, self._period = write, lossless, period
        self._capacity, self._batch = capacity, min(batch, capacity)
        self._items: deque[Item] = deque()
        self._closing = False
        self._wake, self._room = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        try:
            self._thread.start()
        except RuntimeError as error:
            self.error = error

    def put(self, item: Item) -> None:
        """Add an item, from one thread only; ignored after an error of the writer or `close`."""
        while len(self._items) >= self._capacity and not self._is_over():
            if self._lossless:
                self._room.clear()
                self._wake.set()
                self._room.wait(self._period)
            else:
                self.dropped += len(self._taken(1))
        if self._is_over():
            return
        self._items.append(item)
        if len(self._items) >= self._batch:
            self._wake.set()

    def offer(self, item: Item) -> None:
        """Add an item; raises the exception that ended the writing."""
        if self.error is not None:
            raise self.error
        self.put(item)

    def close(self, patience: float) -> bool:
        """Write the rest within `patience` [s]; returns whether the thread has ended."""
        self._closing = True
        self._wake.set()
        if self._thread.is_alive():
            self._thread.join(patience)
        return not self._thread.is_alive()

    def _is_over(self) -> bool:
        return self._closing or self.error is not None

    def _taken(self, count: int) -> list[Item]:
        """The oldest items, at most so many; both threads take them."""
        items: list[Item] = []
        try:
            while len(items) < count:
                items.append(self._items.popleft())
        except IndexError:
            pass
        return items

    def _run(self) -> None:
        last = False
        while not last:
            self._wake.wait(self._period)
            self._wake.clear()
            last = self._closing
            batch = self._taken(len(self._items))
            self._room.set()
            try:
                if batch:
                    self._write(batch)
            except Exception as error:  # whatever it is, the robot must go on
                self.error = error
                self._items.clear()
                self._room.set()
                return


class Throttle:
    """Passes at most one stamp per period [s]."""

    def __init__(self, period: float) -> None:
        self._period, self._next = period, float("-inf")

    def due(self, stamp: float) -> bool:
        """Whether `stamp` [s] passes, which starts the next period."""
        if stamp < self._next - _ROUNDING:
            return False
        self._next = stamp + self._period
        return True
