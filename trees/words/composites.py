"""The composites but `switch` and `for_each`: they decide which children run, and when.

The first line of each docstring is what `frankie-task nodes` and an editor show of the word.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from config import Plain
from trees.words.branch import (
    Again,
    Branch,
    Counterpart,
    Need,
    Now,
    Ticking,
    failed_node,
    halt,
    is_answer,
    is_out_of_reach,
    is_unknown,
    reason,
)
from trees.words.outcomes import (
    Rule,
    all_in_order,
    first_success,
    opposite,
    side_by_side,
    until_first_succeeds,
    until_success,
)
from trees.words.value_types import ValueType

if TYPE_CHECKING:
    from behaviours import Context

GIVE_UP_AFTER = 5  # failures of the same kind in a row end `forever`
OUT_OF_REACH_AFTER = 2  # the same if the goal of the node is unreachable
FAILURES_APART = 2.0  # failures of the same kind that follow each other faster count once [s]

_NUMBER = re.compile(r"\d+(\.\d+)?")


class Form(Enum):
    """Syntax of the value of a composite."""

    LIST = "nodes"
    CASES = "a value, and a node for each of its cases"
    EACH = "values, and a node for each of them"


@dataclass(frozen=True, kw_only=True)
class Option:
    """A parameter of a composite."""

    type: ValueType
    default: Plain
    description: str


class CompositeWord(Branch):
    """A branch whose key has one node or a list of nodes as its value.

    With options it may also be a mapping of those and `children`.
    """

    symbol: ClassVar[str]  # in pictures
    outcomes: ClassVar[Rule]  # order of its children, and its possible outcomes
    form: ClassVar[Form] = Form.LIST
    asks: ClassVar[bool] = False  # whether its children are conditions
    is_condition: ClassVar[bool] = False
    at_once: ClassVar[bool] = False  # whether several of its children run at the same time
    takes: ClassVar[str] = "one or more nodes"
    least: ClassVar[int] = 1
    most: ClassVar[int | None] = None  # numbers of children
    lone: ClassVar[bool] = False  # whether one child may stand without a list
    options: ClassVar[Mapping[str, Option]] = {}


class Sequence(CompositeWord):
    """Runs its children in order; fails when one fails, succeeds when all have."""

    key, symbol, counterpart = "sequence", "→", Counterpart("Sequence")
    outcomes = all_in_order
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


class Fallback(Sequence):
    """Tries its children in order; succeeds when one succeeds, fails when all have failed."""

    key, symbol, counterpart = "fallback", "?", Counterpart("Fallback")
    outcomes = first_success
    proceeds_on = Status.FAILURE


class Reactive(Branch):
    """Asks every child from the first again at every tick.

    A child that is not reached any more is halted. Only conditions stand before a last child that
    may be an action. While the answer of one is not known, the other conditions may decide, and an
    action is neither ticked nor halted; what stays not known fails.
    """

    proceeds_on: Status

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


class Parallel(CompositeWord):
    """Runs its children side by side until enough have succeeded or too many have failed.

    A child that has ended is not run again; those that still run at the end are halted. `policy` is
    how many have to succeed: `all`, `any`, or a number.
    """

    key, symbol, counterpart = "parallel", "‖", Counterpart("Parallel")
    outcomes, at_once = side_by_side, True
    options: ClassVar[Mapping[str, Option]] = {
        "policy": Option(
            type=ValueType(types=(int,), choices=("all", "any"), least=1),
            default="all",
            description="How many children have to succeed; it fails when that is out of reach.",
        )
    }

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


class Forever(CompositeWord):
    """Starts its child again after every failure; gives up when it always fails alike.

    Alike: the same node, the same message but for numbers, `GIVE_UP_AFTER` times in a row (twice if
    its goal is unreachable), and no object placed in between. An answer of a condition is no
    failure, and failures within `FAILURES_APART` count once, so that a task may wait. A child that
    fails at once again and again gets a pause between two starts. `placed` is the number of objects
    placed so far.
    """

    key, symbol = "forever", "∞"
    counterpart = Counterpart("RetryUntilSuccessful", fixed=(("num_attempts", "-1"),))
    outcomes, takes_time, needs = until_success, True, Need.FAILURE
    takes, most, lone = "one node", 1, True

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


class Until(CompositeWord):
    """Asks its first child; succeeds if that does, else runs the others in order and asks again.

    Fails when one of the others fails. Without others it waits.
    """

    key, symbol = "until", "↻"
    outcomes, takes_time = until_first_succeeds, True
    takes, lone = "a question, then the work to do, if any", True

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


class _Question(CompositeWord):
    """A condition of others."""

    is_condition = asks = True
    takes = "one or more conditions"


class AllOf(Reactive, _Question):
    """A condition: succeeds if all the conditions below it do; one that fails decides."""

    key, symbol, counterpart = "sequence", "∧", Counterpart("ReactiveSequence")
    outcomes, proceeds_on = all_in_order, Status.SUCCESS


class AnyOf(Reactive, _Question):
    """A condition: succeeds if one of the conditions below it does; it decides."""

    key, symbol, counterpart = "fallback", "∨", Counterpart("ReactiveFallback")
    outcomes, proceeds_on = first_success, Status.FAILURE


class Not(_Question):
    """A condition: succeeds if the condition below it fails; of not known, not known."""

    key, symbol, counterpart = "not", "¬", Counterpart("Inverter")
    outcomes, takes, most, lone = opposite, "one condition", 1, True

    def advance(self) -> Ticking:
        """Ask, and answer the opposite."""
        status = yield from self.run(self.children[0])
        self.feedback_message = f"not ({self.feedback_message})"
        return {Status.SUCCESS: Status.FAILURE, Status.FAILURE: Status.SUCCESS}.get(status, status)
