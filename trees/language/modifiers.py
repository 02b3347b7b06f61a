"""The modifiers: branches that wrap one node and change how often it runs or what it returns."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from trees.language.branch import Branch, Ticking, reason


class Timeout(Branch):
    """Fails when its child is still running after a time; the child is then not ticked any more.

    Args:
        child: what may take so long.
        seconds: how long [s].
        now: the time [s].
    """

    key = "timeout"

    def __init__(self, child: Behaviour, seconds: float, now: Callable[[], float]) -> None:
        super().__init__(self.key, [child])
        self._seconds = seconds
        self._now = now

    def restart(self) -> None:
        """Start the time."""
        self._start = self._now()

    def advance(self) -> Ticking:
        """Tick the child if there is time left."""
        child = self.children[0]
        # Stamps are sums of periods: the tolerance keeps the count of ticks from their rounding.
        if self._now() - self._start >= self._seconds - 1e-9:
            self.feedback_message = f"not done within {self._seconds:g} s ({reason(child)})"
            return Status.FAILURE
        return (yield from self.run(child))


class Invert(Branch):
    """Succeeds when its child fails and fails when it succeeds.

    Args:
        child: what is inverted.
    """

    key = "invert"
    outcomes: ClassVar = {Status.SUCCESS: Status.FAILURE, Status.FAILURE: Status.SUCCESS}

    def __init__(self, child: Behaviour) -> None:
        super().__init__(self.key, [child])

    def advance(self) -> Ticking:
        """Tick the child and swap its outcome."""
        status = yield from self.run(self.children[0])
        self.feedback_message = f"inverted ({self.feedback_message})"
        return self.outcomes.get(status, status)


class Retry(Branch):
    """Starts its child again after a failure, up to a number of attempts, one a tick.

    Args:
        child: what is attempted.
        attempts: how many times at most.
    """

    key = "retry"

    def __init__(self, child: Behaviour, attempts: int) -> None:
        super().__init__(self.key, [child])
        self._attempts = attempts

    def restart(self) -> None:
        """Count from nothing."""
        self._failures = 0

    def advance(self) -> Ticking:
        """One tick of the child; a failure is followed by a new attempt at the next tick."""
        status = yield from self.run(self.children[0])
        said = self.feedback_message
        if status is not Status.FAILURE:
            self.feedback_message = f"attempt {self._failures + 1} of {self._attempts}: {said}"
            return status
        self._failures += 1
        if self._failures < self._attempts:
            self.feedback_message = f"attempt {self._failures} of {self._attempts} failed: {said}"
            return Status.RUNNING
        self.feedback_message = f"gave up after attempt {self._failures}: {said}"
        return status


class Repeat(Branch):
    """Starts its child again after a success, a number of rounds, one a tick at most.

    Args:
        child: what is repeated.
        rounds: how many times it has to succeed.
    """

    key = "repeat"

    def __init__(self, child: Behaviour, rounds: int) -> None:
        super().__init__(self.key, [child])
        self._rounds = rounds

    def restart(self) -> None:
        """Count from nothing."""
        self._done = 0

    def advance(self) -> Ticking:
        """One tick of the child; a success is followed by a new round at the next tick."""
        status = yield from self.run(self.children[0])
        self.feedback_message = f"round {self._done + 1} of {self._rounds}: {self.feedback_message}"
        if status is not Status.SUCCESS:
            return status
        self._done += 1
        return Status.SUCCESS if self._done == self._rounds else Status.RUNNING
