"""The composites but `switch` and `for_each`: they decide which children run, and when.

The first line of each docstring is what `frankie-task nodes` and an editor show of the word.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from trees.words.branch import (
    OPPOSITE,
    Again,
    Branch,
    Now,
    Ticking,
    failed_node,
    halt,
    is_answer,
    is_out_of_reach,
    is_unknown,
    reason,
)

if TYPE_CHECKING:
    from behaviours import Context

GIVE_UP_AFTER = 5  # failures of the same kind in a row end `forever`
OUT_OF_REACH_AFTER = 2  # the same if the goal of the node is unreachable
FAILURES_APART = 2.0  # failures of the same kind that follow each other faster count once [s]

_NUMBER = re.compile(r"\d+(\.\d+)?")


class Sequence(Branch):
    """Runs its children in order; fails when one fails, succeeds when all have."""

    key = "sequence"
    proceeds_on = Status.SUCCESS

    def restart(self) -> None:
        """Begin at the first child."""
        self._position = 0

    def advance(self) -> Ticking:
        """Continue with the child that was running."""
        for child in self.children[self._position :]:
            status = yield from self.run(child)
            if status is not self.proceeds_on:
                return status
            self._position += 1
        return self.proceeds_on


class ResumingSequence(Sequence):
    """A sequence that goes on where it was halted or has failed, until all have succeeded."""

    key = "resuming_sequence"

    def __init__(self, name: str, children: Iterable[Behaviour]) -> None:
        super().__init__(name, children)
        self._position = 0

    def restart(self) -> None:
        """Begin where it was halted or failed."""

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End; a success forgets the place."""
        if new_status is Status.SUCCESS:
            self._position = 0
        super().stop(new_status)


class Fallback(Sequence):
    """Tries its children in order; succeeds when one succeeds, fails when all have failed."""

    key = "fallback"
    proceeds_on = Status.FAILURE


class ReactiveSequence(Branch):
    """A sequence that asks every child from the first again at every tick.

    A child that is not reached any more is halted. Only conditions belong before an action:
    whatever has succeeded is run again. While the answer of one is not known, the other conditions
    may decide, and an action is neither ticked nor halted; what stays not known fails.
    """

    key = "reactive_sequence"
    proceeds_on = Status.SUCCESS

    def advance(self) -> Ticking:
        """Start over at the first child."""
        waiting = ""
        for position, child in enumerate(self.children):
            is_asked = is_answer(child)
            if waiting and not is_asked:
                break
            status = yield from self.run(child)
            if is_asked and status is Status.RUNNING:
                waiting = waiting or self.feedback_message
            elif status is not self.proceeds_on or (is_asked and is_unknown(child)):
                for later in self.children[position + 1 :]:
                    halt(later)
                return status
        self.feedback_message = waiting or self.feedback_message
        return Status.RUNNING if waiting else self.proceeds_on


class ReactiveFallback(ReactiveSequence):
    """A fallback that asks every child from the first again at every tick."""

    key = "reactive_fallback"
    proceeds_on = Status.FAILURE


class Parallel(Branch):
    """Runs its children side by side until enough have succeeded or too many have failed.

    A child that has ended is not run again; those that still run at the end are halted. `policy` is
    how many have to succeed: `all`, `any`, or a number.
    """

    key = "parallel"

    def __init__(self, name: str, children: Iterable[Behaviour], policy: str | int = "all") -> None:
        super().__init__(name, children)
        enough = {"all": len(self.children), "any": 1}
        self._needed = policy if isinstance(policy, int) else enough[policy]

    def restart(self) -> None:
        """Nothing has ended yet."""
        self._ended: dict[Behaviour, Status] = {}

    def advance(self) -> Ticking:
        """Tick every child that has not ended yet, until their outcomes decide."""
        for child in self.children:
            if child in self._ended:
                continue
            status = yield from self.run(child)
            if status is not Status.RUNNING:
                self._ended[child] = status
            if (outcome := self._outcome()) is not Status.RUNNING:
                return outcome
        waiting = [child for child in self.children if child not in self._ended]
        self.feedback_message = "; ".join(reason(child) for child in waiting)
        return Status.RUNNING

    def _outcome(self) -> Status:
        """What the children that have ended decide; RUNNING if nothing yet."""
        ends = list(self._ended.values())
        if ends.count(Status.FAILURE) > len(self.children) - self._needed:
            return Status.FAILURE
        if ends.count(Status.SUCCESS) >= self._needed:
            succeeded = (child for child in self.children if child.status is Status.SUCCESS)
            self.feedback_message = "; ".join(reason(child) for child in succeeded)
            return Status.SUCCESS
        return Status.RUNNING


class Forever(Branch):
    """Starts its child again after every failure; gives up when it always fails alike.

    Alike: the same node, the same message but for numbers, `GIVE_UP_AFTER` times in a row (twice if
    its goal is unreachable), and no object placed in between. An answer of a condition is no
    failure, and failures within `FAILURES_APART` count once, so that a task may wait. A child that
    fails at once again and again gets a pause between two starts. `placed` is the number of objects
    placed so far.
    """

    key = "forever"

    def __init__(
        self, name: str, children: Iterable[Behaviour], now: Now, placed: Callable[[], int]
    ) -> None:
        super().__init__(name, children)
        self._now, self._placed = now, placed
        self._again = Again(now)

    @classmethod
    def from_context(cls, context: Context) -> Mapping[str, object]:
        """The clock and the log of the task."""
        return {"now": context.clock.now, "placed": lambda: context.log.placed}

    def restart(self) -> None:
        """Nothing has failed yet."""
        self._cause: tuple[Behaviour, str, int] | None = None
        self._times, self._counted = 0, self._now()

    def advance(self) -> Ticking:
        """One tick of the child; a failure is followed by a new start."""
        if self._again.waits():
            return Status.RUNNING
        status = yield from self.run(self.children[0])
        if status is not Status.FAILURE:
            return status
        failed = failed_node(self.children[0])
        self._again.ended(failed)
        most = OUT_OF_REACH_AFTER if is_out_of_reach(failed) else GIVE_UP_AFTER
        if self._count(failed) >= most:
            times = f"{most} times in a row"
            self.feedback_message = f"gave up: {self.feedback_message}, {times}"
            failed.feedback_message += f", {times}"  # which is what a summary quotes
            return Status.FAILURE
        self.feedback_message = f"starting again after {self.feedback_message}"
        return Status.RUNNING

    def _count(self, failed: Behaviour) -> int:
        """Number of failures in a row for the same reason."""
        if is_answer(failed):
            return 0
        now, message = self._now(), _NUMBER.sub("#", failed.feedback_message)
        cause = (failed, message, self._placed())
        if cause != self._cause:
            self._cause, self._times = cause, 0
        apart = 0.0 if is_out_of_reach(failed) else FAILURES_APART
        if self._times == 0 or now - self._counted >= apart:
            self._counted = now
            self._times += 1
        return self._times


class Until(Branch):
    """Asks its first child; succeeds if that does, else runs the others in order and asks again.

    Fails when one of the others fails.
    """

    key = "until"

    def restart(self) -> None:
        """Begin with the question."""
        self._position = 0

    def advance(self) -> Ticking:
        """Continue with the child that was running; a new round begins at the next tick."""
        question, *work = self.children
        if self._position > len(work):  # only now, so that how the last child ended can be seen
            self.rewind()
            self.restart()
        if self._position == 0:
            status = yield from self.run(question)
            if status is not Status.FAILURE:
                return status
            self._position = 1
        for child in work[self._position - 1 :]:
            status = yield from self.run(child)
            if status is not Status.SUCCESS:
                return status
            self._position += 1
        return Status.RUNNING


class WaitUntil(Until):
    """Waits until its condition holds; `timeout_s` beside it says how long at most."""

    key = "wait_until"


class AllOf(ReactiveSequence):
    """A condition: succeeds if all the conditions below it do; one that fails decides."""

    key = "all_of"
    is_condition = True


class AnyOf(ReactiveFallback):
    """A condition: succeeds if one of the conditions below it does; it decides."""

    key = "any_of"
    is_condition = True


class Not(Branch):
    """A condition: succeeds if the condition below it fails; of not known, not known."""

    key = "not"
    is_condition = True

    def advance(self) -> Ticking:
        """Ask, and answer the opposite."""
        status = yield from self.run(self.children[0])
        self.feedback_message = f"not ({self.feedback_message})"
        return OPPOSITE.get(status, status)
