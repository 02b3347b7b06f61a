"""The modifiers: branches that wrap one node and change how often it runs or what it returns.

The first line of each docstring is what `frankie-task nodes` and an editor show of the word.
"""

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from hw import TaskTime
from trees.words.branch import (
    OPPOSITE,
    ROUNDING,
    Again,
    Branch,
    Now,
    Ticking,
    failed_node,
    is_out_of_reach,
    is_unknown,
    reason,
)
from trees.words.composites import ReactiveFallback, ReactiveSequence


class _Modifier(Branch):
    """A branch with one child, named by its key."""

    def __init__(self, child: Behaviour) -> None:
        super().__init__(self.key, [child])

    @property
    def child(self) -> Behaviour:
        """The node; a hook may have replaced it."""
        return self.children[0]


class _Timed(_Modifier):
    """A modifier with a duration [s], by a clock."""

    def __init__(self, child: Behaviour, seconds: float, now: Now) -> None:
        super().__init__(child)
        self.seconds, self.now = seconds, now

    def restart(self) -> None:
        """Start the time."""
        self.start = self.now()


class Timeout(_Timed):
    """Fails when the node is still running after this time; each attempt has the whole time.

    The node is then not ticked any more.
    """

    key = "timeout"

    def advance(self) -> Ticking:
        """Tick the child if there is time left."""
        if self.now() - self.start >= self.seconds - ROUNDING:
            self.feedback_message = f"not done within {self.seconds:g} s ({reason(self.child)})"
            return Status.FAILURE
        return (yield from self.run(self.child))


class Delay(_Timed):
    """Waits for this time before each attempt; the timeout does not count it."""

    key = "delay"

    def advance(self) -> Ticking:
        """Tick the child once the time is over."""
        remaining = self.seconds - (self.now() - self.start)
        if remaining > ROUNDING:
            self.feedback_message = f"starts in {remaining:.1f} s"
            return Status.RUNNING
        return (yield from self.run(self.child))


class Cooldown(_Timed):
    """Fails at once when started sooner than this after the node's last end or halt."""

    key = "cooldown"
    _ready: TaskTime | None = None

    def restart(self) -> None:
        """Compute how long it still has to rest."""
        self._resting = 0.0 if self._ready is None else self._ready - self.now()

    def advance(self) -> Ticking:
        """Tick the child unless it is too soon."""
        if self._resting > ROUNDING:
            self.feedback_message = f"not again for {self._resting:.1f} s"
            return Status.FAILURE
        status = yield from self.run(self.child)
        self._ready = self.now() + self.seconds
        return status

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End; a halt counts as an end of the child."""
        if self.status is Status.RUNNING:
            self._ready = self.now() + self.seconds
        super().stop(new_status)


class Invert(_Modifier):
    """Swaps success and failure."""

    key = "invert"

    def advance(self) -> Ticking:
        """Tick the child and swap its outcome; what is not known stays so."""
        status = yield from self.run(self.child)
        if status is Status.FAILURE and is_unknown(self.child):
            return status
        self.feedback_message = f"inverted ({self.feedback_message})"
        return OPPOSITE.get(status, status)


class Retry(_Modifier):
    """Starts the node again after a failure, up to this number of attempts.

    The next attempt begins at the next tick; a node that fails at once again and again gets a pause
    between two attempts. What cannot be reached gets no other attempt.
    """

    key = "retry"

    def __init__(self, child: Behaviour, attempts: int, now: Now) -> None:
        super().__init__(child)
        self._attempts = attempts
        self._again = Again(now)

    def restart(self) -> None:
        """Reset the count."""
        self._failures = 0

    def advance(self) -> Ticking:
        """One tick of the child; a failure is followed by a new attempt."""
        if self._again.waits():
            return Status.RUNNING
        status = yield from self.run(self.child)
        message = self.feedback_message
        if status is Status.SUCCESS:
            self._again.ended(None)
        if status is not Status.FAILURE:
            self.feedback_message = f"attempt {self._failures + 1} of {self._attempts}: {message}"
            return status
        self._failures += 1
        failed = failed_node(self.child)
        self._again.ended(failed)
        if self._failures < self._attempts and not is_out_of_reach(failed):
            count = f"attempt {self._failures} of {self._attempts}"
            self.feedback_message = f"{count} failed: {message}"
            return Status.RUNNING
        self.feedback_message = f"gave up after attempt {self._failures}: {message}"
        return status


class Repeat(_Modifier):
    """Starts the node again after a success, until it has succeeded this number of times.

    The next round begins at the next tick.
    """

    key = "repeat"

    def __init__(self, child: Behaviour, rounds: int) -> None:
        super().__init__(child)
        self._rounds = rounds

    def restart(self) -> None:
        """Reset the count."""
        self._done = 0

    def advance(self) -> Ticking:
        """One tick of the child; a success is followed by a new round at the next tick."""
        status = yield from self.run(self.child)
        self.feedback_message = f"round {self._done + 1} of {self._rounds}: {self.feedback_message}"
        if status is not Status.SUCCESS:
            return status
        self._done += 1
        return Status.SUCCESS if self._done == self._rounds else Status.RUNNING


class Once(_Modifier):
    """Runs the node to its end a single time, and returns that outcome from then on.

    A node that is halted before its end starts again.
    """

    key = "once"
    _outcome = Status.RUNNING

    def advance(self) -> Ticking:
        """Tick the child if it has not ended before."""
        if self._outcome is Status.RUNNING:
            self._outcome = yield from self.run(self.child)
        return self._outcome


class ForceSuccess(_Modifier):
    """Succeeds when the node ends, however it ends."""

    key = "force_success"
    outcome = Status.SUCCESS

    def advance(self) -> Ticking:
        """Tick the child."""
        status = yield from self.run(self.child)
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

    A reactive sequence of the condition and the node. While the answer is not known, the node
    waits.
    """

    key = "while"

    def __init__(self, condition: Behaviour, child: Behaviour) -> None:
        super().__init__(self.key, [condition, child])


class Unless(ReactiveFallback):
    """Asks a condition at every tick; when it succeeds, halts the node and succeeds.

    A reactive fallback of the condition and the node. While the answer is not known, the node
    waits; what stays not known fails.
    """

    key = "unless"

    def __init__(self, condition: Behaviour, child: Behaviour) -> None:
        super().__init__(self.key, [condition, child])
