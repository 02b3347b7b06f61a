"""Clocks: session time is a `float` [s], task time a `TaskTime`, which stands still in a pause."""

from __future__ import annotations

import time
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

Result = TypeVar("Result")

_ROUNDING = 1e-9  # of stamps, which are sums of periods [s]


class Clock(Protocol):
    """Session time."""

    is_real: bool  # whether it runs by itself, and the robot with it

    @property
    def lost(self) -> float:
        """How far it has fallen behind the real time that it is to keep, in all [s]."""

    def now(self) -> float:
        """Seconds since the session began [s]."""

    def sleep_until(self, stamp: float) -> None:
        """Return when `now()` is at least `stamp` [s]."""

    def due(self, work: Future[Result], seconds: float) -> Future[Result]:
        """What gets the result of work in a thread.

        In real time that is as soon as there is one. In simulated time it is `seconds` [s] from
        now, however long the computer needs, so that a run does not depend on its load.
        """


class Deliveries:
    """Results of work in threads, each due at a moment of simulated time."""

    def __init__(self) -> None:
        self._waiting: list[tuple[float, Future[Any], Future[Any]]] = []

    def add(self, work: Future[Result], stamp: float) -> Future[Result]:
        """A future that is done from session time `stamp` on [s]."""
        delivered: Future[Result] = Future()
        self._waiting.append((stamp, work, delivered))
        return delivered

    def deliver(self, now: float) -> None:
        """Wait for what is due at session time `now` [s], and hand it over."""
        for due in [one for one in self._waiting if one[0] <= now + _ROUNDING]:
            self._waiting.remove(due)
            _, work, delivered = due
            if work.cancelled():
                delivered.cancel()
            elif (error := work.exception()) is not None:
                delivered.set_exception(error)
            else:
                delivered.set_result(work.result())


_SLACK = 0.02  # by which a paced clock may lag behind real time and catch up again [s]


class SimClock:
    """Simulated time: it jumps on request, and waits for real time where it is `paced`.

    Nothing is left out: where the computer is too slow, simulated time goes slower than real time.
    """

    is_real = False

    def __init__(self, *, paced: bool = False) -> None:
        self._now = 0.0
        self._paced, self.lost = paced, 0.0
        self._began: float | None = None  # when simulated time was zero, later by what was lost [s]
        self._deliveries = Deliveries()

    def now(self) -> float:
        """Simulated seconds since the session began [s]."""
        return self._now

    def sleep_until(self, stamp: float) -> None:
        """Advance to `stamp` [s], never backwards; real time counts from the first call."""
        self._now = max(self._now, stamp)
        if self._paced:
            self._keep_pace()
        self._deliveries.deliver(self._now)

    def due(self, work: Future[Result], seconds: float) -> Future[Result]:
        """What gets the result of work `seconds` [s] from now."""
        return self._deliveries.add(work, self._now + seconds)

    def _keep_pace(self) -> None:
        """Sleep until real time has come as far; its lead beyond the slack is lost."""
        real = time.monotonic()
        began = real - self._now if self._began is None else self._began
        self._began = max(began, real - self._now - _SLACK)
        self.lost += self._began - began
        time.sleep(max(0.0, self._began + self._now - real))


class WallClock:
    """Real, monotonic time since the clock was made."""

    is_real, lost = True, 0.0

    def __init__(self) -> None:
        self._start = time.monotonic()

    def now(self) -> float:
        """Seconds since the session began [s]."""
        return time.monotonic() - self._start

    def sleep_until(self, stamp: float) -> None:
        """Sleep until `stamp` [s]; returns at once when it has passed."""
        ahead = stamp - self.now()
        if ahead > 0.0:
            time.sleep(ahead)

    def due(self, work: Future[Result], seconds: float) -> Future[Result]:
        """The work itself."""
        return work


@dataclass(frozen=True, order=True, slots=True)
class TaskTime:
    """A moment of a task; only differences between two moments are seconds, of the task."""

    seconds: float  # since the session began, without pauses [s]
    pace: float = 1.0  # seconds of the task per second of the session

    def __sub__(self, earlier: TaskTime) -> float:
        return self.pace * self.since(earlier)

    def since(self, earlier: TaskTime) -> float:
        """Seconds of the session, without pauses, whatever the pace [s]."""
        return self.seconds - earlier.seconds

    def __add__(self, seconds: float) -> TaskTime:
        return TaskTime(self.seconds + seconds / self.pace, self.pace)


class TaskClock:
    """The clock of the tree: one moment per tick, at the robot's pace; pauses do not count."""

    def __init__(self, session: Clock, pace: float = 1.0) -> None:
        self.session, self._pace = session, pace
        self._tick: float | None = None
        self._paused = 0.0
        self._held_at: TaskTime | None = None

    def begin_tick(self) -> float:
        """Fix the moment of the coming tick; returns the session's time [s]."""
        self._tick = self.session.now()
        return self._tick

    def now(self) -> TaskTime:
        """The present moment of the task."""
        return (
            TaskTime(self._session_now() - self._paused, self._pace)
            if self._held_at is None
            else self._held_at
        )

    @property
    def held(self) -> bool:
        """Whether it is paused."""
        return self._held_at is not None

    @property
    def paused_s(self) -> float:
        """Duration of all pauses until now [s]."""
        return self._session_now() - self.now().seconds

    def hold(self) -> None:
        """Pause."""
        if self._held_at is None:
            self._held_at = self.now()

    def release(self) -> None:
        """Go on after a pause."""
        if self._held_at is not None:
            self._paused = self._session_now() - self._held_at.seconds
            self._held_at = None

    def _session_now(self) -> float:
        return self.session.now() if self._tick is None else self._tick


def stopwatch() -> float:
    """Real seconds from an arbitrary start, to measure a computation [s]."""
    return time.perf_counter()


def epoch() -> float:
    """Seconds since 1970, as drivers of cameras stamp; a person may set this clock [s]."""
    return time.time()
