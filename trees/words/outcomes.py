"""Outcomes of nodes, and the rules by which they follow from those of the nodes below.

A node starts with a set of keys that are certainly written, and can succeed or fail, each with such
a set, or do neither.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import NamedTuple, TypeAlias

Keys: TypeAlias = frozenset[str] | None
"""What is certain at a point: keys that are written, and what the hand is; None if the point is
never reached."""

FULL, EMPTY = "the hand is full", "the hand is empty"
UNUSED_HAND = "nothing taken is in the hand"  # of this task; what a person left there may be
JUST = "a leaf has just left the hand like this"  # nothing was lost since
HAND = frozenset({FULL, EMPTY, UNUSED_HAND, JUST})


class Outcomes(NamedTuple):
    """The keys that are certainly written after each outcome of a node."""

    success: Keys
    failure: Keys


class Outcome(Enum):
    """One outcome of a node."""

    SUCCESS = "succeed"
    FAILURE = "fail"

    def of(self, outcomes: Outcomes) -> Keys:
        """The keys after this outcome."""
        return outcomes.success if self is Outcome.SUCCESS else outcomes.failure

    @property
    def opposite(self) -> Outcome:
        """The other outcome."""
        return Outcome.FAILURE if self is Outcome.SUCCESS else Outcome.SUCCESS


def without_hand(known: Keys) -> Keys:
    """What is still certain where the hand may be anything."""
    return None if known is None else known - HAND


def either(*ways: Keys) -> Keys:
    """What is certainly written after one of several ways, some of them impossible."""
    possible = [way for way in ways if way is not None]
    return frozenset.intersection(*possible) if possible else None


Child: TypeAlias = Callable[[Keys], Outcomes]
"""Follows one child: from the keys when it starts to its outcomes."""


def rounds(child: Child, again: Outcome | None, before: Keys) -> Outcomes:
    """The outcomes of a child that starts anew after one of them: each round as the last left it.

    What is certain before a round repeats itself soon; without `again` there is one round.
    """
    starts: list[Keys] = []
    ends: list[Outcomes] = []
    while before not in starts and (before is not None or not starts):
        starts.append(before)
        ends.append(child(before))
        before = None if again is None else again.of(ends[-1])
    return Outcomes(either(*(one.success for one in ends)), either(*(one.failure for one in ends)))


Options: TypeAlias = Mapping[str, object]

Rule: TypeAlias = Callable[[Sequence[Child], Options, Keys], Outcomes]
"""(children, options of the composite, keys when it starts) to its outcomes."""

Change: TypeAlias = Callable[[Outcomes, Keys], Outcomes]
"""(outcomes of a node, what is certain when its modifier decides) to those with the modifier."""


def all_in_order(children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
    """Each child starts after the success of the one before; a failure ends all."""
    failures = []
    for child in children:
        before, failure = child(before)
        failures.append(failure)
    return Outcomes(before, either(*failures))


def first_success(children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
    """Each child starts after the failure of the one before; a success ends all."""
    successes = []
    for child in children:
        success, before = child(before)
        successes.append(success)
    return Outcomes(either(*successes), before)


def side_by_side(children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
    """All start at once: no child can rely on another."""
    outcomes = [child(before) for child in children]
    count, policy = len(outcomes), options.get("policy", "all")
    needed = {"all": count, "any": 1}.get(str(policy), policy)
    # A policy that is a parameter may be any number of children.
    least, most = (needed, needed) if isinstance(needed, int) else (1, count)
    successes = [one.success for one in outcomes if one.success is not None]
    if len(successes) == least:
        success: Keys = frozenset().union(*successes)
    else:
        success = either(*successes) if len(successes) > least else None
    can_fail = sum(one.failure is not None for one in outcomes) > count - most
    return Outcomes(success, before if can_fail else None)


def one_of(children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
    """Any one of the children runs; or none, if there are only `cases`."""
    outcomes = [child(before) for child in children]
    cases = options.get("cases")
    none = [before] if isinstance(cases, tuple) and len(cases) == len(children) else []
    success = either(*(one.success for one in outcomes))
    return Outcomes(success, either(*(one.failure for one in outcomes), *none))


def opposite(children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
    """Success and failure of the one child are swapped."""
    outcomes = children[0](before)
    return Outcomes(outcomes.failure, outcomes.success)


def until_success(children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
    """A failure of the one child starts it again, or ends it when it always fails alike."""
    return rounds(children[0], Outcome.FAILURE, before)


def until_first_succeeds(children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
    """A failure of the first child starts the others, in order; their success starts it again."""
    question, *work = children
    answers = []

    def one(before: Keys) -> Outcomes:
        answers.append(question(before))
        return all_in_order(work, {}, answers[-1].failure)

    worked = rounds(one, Outcome.SUCCESS, before)
    return Outcomes(either(*(answer.success for answer in answers)), worked.failure)


def each(children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
    """One copy for each value, in order; or one child for all of a list, which may be empty."""
    item = getattr(options.get("item"), "name", None)
    if not isinstance(item, str):
        return all_in_order(children, options, before)
    [child] = children
    start = None if before is None else before | {item}
    outcomes = rounds(child, Outcome.SUCCESS, start)
    return Outcomes(either(before, outcomes.success), outcomes.failure)


def as_the_node(node: Outcomes, early: Keys) -> Outcomes:
    """The modifier changes no outcome."""
    return node


def fails_early(node: Outcomes, early: Keys) -> Outcomes:
    """The modifier may fail without the node."""
    return Outcomes(node.success, either(node.failure, early))


def succeeds_early(node: Outcomes, early: Keys) -> Outcomes:
    """The modifier may succeed without the node."""
    return Outcomes(either(node.success, early), node.failure)


def always_succeeds(node: Outcomes, early: Keys) -> Outcomes:
    """Every end is a success."""
    return Outcomes(either(*node), None)


def always_fails(node: Outcomes, early: Keys) -> Outcomes:
    """Every end is a failure."""
    return Outcomes(None, either(*node))
