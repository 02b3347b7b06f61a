"""The modifiers: branches that wrap one node and change how often it runs or what it returns.

The first line of each docstring is what `frankie-task nodes` and an editor show of the word.
"""

from __future__ import annotations

from typing import Any, ClassVar, TypeAlias

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from trees.words.branch import (
    ROUNDING,
    Again,
    Branch,
    Counterpart,
    Need,
    Now,
    Ticking,
    failed_node,
    is_out_of_reach,
    reason,
)
from trees.words.composites import Reactive
from trees.words.outcomes import (
    Change,
    Outcome,
    always_fails,
    always_succeeds,
    as_the_node,
    fails_early,
    succeeds_early,
)
from trees.words.value_types import ValueType

_SECONDS = ValueType(types=(float,), above=0.0, most=604_800.0)
_COUNT = ValueType(types=(int,), least=1, most=100_000)

Built: TypeAlias = "type[ModifierWord]"


class ModifierWord(Branch):
    """A branch with one child; in a file a key beside that, which has a value.

    The value of a guard is a built condition; `now` is the clock of the task.
    """

    word: ClassVar[str] = ""  # in a file, if it is not the key
    type: ClassVar[ValueType | None]  # of its value; None is a condition
    runs_on: ClassVar[Outcome | None] = None
    """The outcome of its condition with which the node runs; None if it has no condition."""
    again: ClassVar[Outcome | None] = None  # after which the node starts anew
    outcomes: ClassVar[Change] = as_the_node

    def __init__(self, child: Behaviour, value: Any, now: Now) -> None:
        super().__init__(self.key, [child])
        self.value, self.now = value, now

    @classmethod
    def of(cls, value: object) -> Built:
        """The branch that it is with this value."""
        return cls

    @property
    def child(self) -> Behaviour:
        """The node; a hook may have replaced it."""
        return self.children[-1]


class Timeout(ModifierWord):
    """Fails when the node is still running after this time; each attempt has the whole time.

    The node is then not ticked any more.
    """

    key, word, needs = "timeout", "timeout_s", Need.TIME
    type, outcomes = _SECONDS, fails_early
    counterpart = Counterpart("Timeout", port="msec", scale=1000)

    def restart(self) -> None:
        """Start the time."""
        self.start = self.now()

    def advance(self) -> Ticking:
        """Tick the child if there is time left."""
        if self.now() - self.start >= self.value - ROUNDING:
            self.feedback_message = f"not done within {self.value:g} s ({reason(self.child)})"
            return Status.FAILURE
        return (yield from self.run(self.child))


class Retry(ModifierWord):
    """Starts the node again after a failure, up to this number of attempts.

    The next attempt begins at the next tick; a node that fails at once again and again gets a pause
    between two attempts. What cannot be reached gets no other attempt.
    """

    key, type, takes_time, needs = "retry", _COUNT, True, Need.FAILURE
    counterpart = Counterpart("RetryUntilSuccessful", port="num_attempts")
    again = Outcome.FAILURE

    def __init__(self, child: Behaviour, value: int, now: Now) -> None:
        super().__init__(child, value, now)
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
            self.feedback_message = f"attempt {self._failures + 1} of {self.value}: {message}"
            return status
        self._failures += 1
        failed = failed_node(self.child)
        self._again.ended(failed)
        if self._failures < self.value and not is_out_of_reach(failed):
            count = f"attempt {self._failures} of {self.value}"
            self.feedback_message = f"{count} failed: {message}"
            return Status.RUNNING
        self.feedback_message = f"gave up after attempt {self._failures}: {message}"
        return status


class Repeat(ModifierWord):
    """Starts the node again after a success, until it has succeeded this number of times.

    The next round begins at the next tick.
    """

    key, type, takes_time = "repeat", _COUNT, True
    counterpart = Counterpart("Repeat", port="num_cycles")
    again = Outcome.SUCCESS

    def restart(self) -> None:
        """Reset the count."""
        self._done = 0

    def advance(self) -> Ticking:
        """One tick of the child; a success is followed by a new round at the next tick."""
        status = yield from self.run(self.child)
        self.feedback_message = f"round {self._done + 1} of {self.value}: {self.feedback_message}"
        if status is not Status.SUCCESS:
            return status
        self._done += 1
        return Status.SUCCESS if self._done == self.value else Status.RUNNING


class Force(ModifierWord):
    """Succeeds or fails, as it says, when the node ends, however it ends."""

    key, type = "force", ValueType(types=(), choices=("success", "failure"))

    @classmethod
    def of(cls, value: object) -> Built:
        """One for each outcome."""
        return {"success": ForceSuccess, "failure": ForceFailure}.get(str(value), cls)


class ForceSuccess(Force):
    """Succeeds when the node ends, however it ends."""

    key, needs, counterpart = "force_success", Need.FAILURE, Counterpart("ForceSuccess")
    outcome, outcomes = Status.SUCCESS, always_succeeds

    def advance(self) -> Ticking:
        """Tick the child."""
        status = yield from self.run(self.child)
        if status is Status.RUNNING:
            return status
        self.feedback_message = f"{self.outcome.value.lower()} forced ({self.feedback_message})"
        return self.outcome


class ForceFailure(ForceSuccess):
    """Fails when the node ends, however it ends."""

    key, needs, counterpart = "force_failure", Need.SUCCESS, Counterpart("ForceFailure")
    outcome, outcomes = Status.FAILURE, always_fails


class _Guard(Reactive, ModifierWord):
    """A condition that is asked at every tick, before the node."""

    type = None

    def __init__(self, child: Behaviour, value: Behaviour, now: Now) -> None:
        super().__init__(child, value, now)
        self.insert_child(value, 0)


class While(_Guard):
    """Asks a condition at every tick; when it fails, halts the node and fails.

    While the answer is not known, the node waits.
    """

    key, counterpart = "while", Counterpart("ReactiveSequence")
    runs_on, proceeds_on, outcomes = Outcome.SUCCESS, Status.SUCCESS, fails_early


class Unless(_Guard):
    """Asks a condition at every tick; when it succeeds, halts the node and succeeds.

    While the answer is not known, the node waits; what stays not known fails.
    """

    key, counterpart = "unless", Counterpart("ReactiveFallback")
    runs_on, proceeds_on, outcomes = Outcome.FAILURE, Status.FAILURE, succeeds_early
