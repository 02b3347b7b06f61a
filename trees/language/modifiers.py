"""The modifiers: branches that wrap one node and change how often it runs or what it returns.

The first line of each docstring is what `frankie-task nodes` and an editor show of the word.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from hw import TaskTime
from trees.language.branch import (
    OPPOSITE,
    ROUNDING,
    Again,
    Branch,
    Now,
    Ticking,
    failed_node,
    is_out_of_reach,
    reason,
)
from trees.language.composites import ReactiveFallback, ReactiveSequence


class Timeout(Branch):
    """Fails when the node is still running after this time; each attempt has the whole time.

    The node is then not ticked any more.

    Args:
        child: the node.
        seconds: how long [s].
        now: the time [s].
    """

    key = "timeout"

    def __init__(self, child: Behaviour, seconds: float, now: Now) -> None:
        super().__init__(self.key, [child])
        self._seconds = seconds
        self._now = now

    def restart(self) -> None:
        """Start the time."""
        self._start = self._now()

    def advance(self) -> Ticking:
        """Tick the child if there is time left."""
        child = self.children[0]
        if self._now() - self._start >= self._seconds - ROUNDING:
            self.feedback_message = f"not done within {self._seconds:g} s ({reason(child)})"
            return Status.FAILURE
        return (yield from self.run(child))


class Delay(Branch):
    """Waits for this time before each attempt; the timeout does not count it.

    Args:
        child: the node.
        seconds: how long [s].
        now: the time [s].
    """

    key = "delay"

    def __init__(self, child: Behaviour, seconds: float, now: Now) -> None:
        super().__init__(self.key, [child])
        self._seconds = seconds
        self._now = now

    def restart(self) -> None:
        """Start the time."""
        self._start = self._now()

    def advance(self) -> Ticking:
        """Tick the child once the time is over."""
        left = self._seconds - (self._now() - self._start)
        if left > ROUNDING:
            self.feedback_message = f"starts in {left:.1f} s"
            return Status.RUNNING
        return (yield from self.run(self.children[0]))


class Cooldown(Branch):
    """Fails at once when started sooner than this after the node's last end or halt.

    Args:
        child: the node.
        seconds: how long [s].
        now: the time [s].
    """

    key = "cooldown"

    def __init__(self, child: Behaviour, seconds: float, now: Now) -> None:
        super().__init__(self.key, [child])
        self._seconds = seconds
        self._now = now
        self._ready: TaskTime | None = None

    def restart(self) -> None:
        """Compute how long it still has to rest."""
        self._resting = 0.0 if self._ready is None else self._ready - self._now()

    def advance(self) -> Ticking:
        """Tick the child unless it is too soon."""
        if self._resting > ROUNDING:
            self.feedback_message = f"not again for {self._resting:.1f} s"
            return Status.FAILURE
        status = yield from self.run(self.children[0])
        self._rest()
        return status

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End; a halt counts as an end of the child."""
        if self.status is Status.RUNNING:
            self._rest()
        super().stop(new_status)

    def _rest(self) -> None:
        self._ready = self._now() + self._seconds


class Invert(Branch):
    """Swaps success and failure.

    Args:
        child: the node.
    """

    key = "invert"

    def __init__(self, child: Behaviour) -> None:
        super().__init__(self.key, [child])

    def advance(self) -> Ticking:
        """Tick the child and swap its outcome."""
        status = yield from self.run(self.children[0])
        self.feedback_message = f"inverted ({self.feedback_message})"
        return OPPOSITE.get(status, status)


class Retry(Branch):
    """Starts the node again after a failure, up to this number of attempts.

    The next attempt begins at the next tick; a node that fails at once again and again gets a pause
    between two attempts. What cannot be reached gets no other attempt.

    Args:
        child: the node.
        attempts: how many times at most.
        now: the time [s].
    """

    key = "retry"

    def __init__(self, child: Behaviour, attempts: int, now: Now) -> None:
        super().__init__(self.key, [child])
        self._attempts = attempts
        self._again = Again(now)

    def restart(self) -> None:
        """Count from nothing."""
        self._failures = 0

    def advance(self) -> Ticking:
        """One tick of the child; a failure is followed by a new attempt."""
        if self._again.waits():
            return Status.RUNNING
        status = yield from self.run(self.children[0])
        message = self.feedback_message
        if status is Status.SUCCESS:
            self._again.ended(None)
        if status is not Status.FAILURE:
            self.feedback_message = f"attempt {self._failures + 1} of {self._attempts}: {message}"
            return status
        self._failures += 1
        failed = failed_node(self.children[0])
        self._again.ended(failed)
        if self._failures < self._attempts and not is_out_of_reach(failed):
            count = f"attempt {self._failures} of {self._attempts}"
            self.feedback_message = f"{count} failed: {message}"
            return Status.RUNNING
        self.feedback_message = f"gave up after attempt {self._failures}: {message}"
        return status


class Repeat(Branch):
    """Starts the node again after a success, until it has succeeded this number of times.

    The next round begins at the next tick.

    Args:
        child: the node.
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


class Once(Branch):
    """Runs the node to its end a single time, and returns that outcome from then on.

    A node that is halted before its end starts again.

    Args:
        child: the node.
    """

    key = "once"

    def __init__(self, child: Behaviour) -> None:
        super().__init__(self.key, [child])
        self._outcome = Status.RUNNING

    def advance(self) -> Ticking:
        """Tick the child if it has not ended before."""
        if self._outcome is Status.RUNNING:
            self._outcome = yield from self.run(self.children[0])
        return self._outcome


class ForceSuccess(Branch):
    """Succeeds when the node ends, however it ends.

    Args:
        child: the node.
    """

    key = "force_success"
    outcome = Status.SUCCESS

    def __init__(self, child: Behaviour) -> None:
        super().__init__(self.key, [child])

    def advance(self) -> Ticking:
        """Tick the child."""
        status = yield from self.run(self.children[0])
        if status is Status.RUNNING:
            return status
        self.feedback_message = f"{self.outcome.value.lower()} forced ({self.feedback_message})"
        return self.outcome


class ForceFailure(ForceSuccess):
    """Fails when the node ends, however it ends."""

    key = "force_failure"
    outcome = Status.FAILURE


class While(ReactiveSequence):
    """Asks a condition at every tick; when it fails, halts the node and fails.

    A reactive sequence of the condition and the node.

    Args:
        condition: what has to hold.
        child: the node.
    """

    key = "while"

    def __init__(self, condition: Behaviour, child: Behaviour) -> None:
        super().__init__(self.key, [condition, child])


class Unless(ReactiveFallback):
    """Asks a condition at every tick; when it succeeds, halts the node and succeeds.

    A reactive fallback of the condition and the node.

    Args:
        condition: what makes the node unnecessary.
        child: the node.
    """

    key = "unless"

    def __init__(self, condition: Behaviour, child: Behaviour) -> None:
        super().__init__(self.key, [condition, child])
