"""How nodes can end, and which keys are certainly written then.

The check follows the tree as it may run. A node starts with a set of keys that are certainly
written, and can end in success or failure, each with such a set, or not at all. Keys are never
unwritten. What a composite or modifier makes of the ends of the nodes below it is given here, and
assigned to the words in `vocabulary`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, TypeAlias

Keys: TypeAlias = frozenset[str] | None
"""The keys that are certainly written at a point; None if the point is never reached."""


class Ends(NamedTuple):
    """The keys that are certainly written when a node has ended."""

    success: Keys
    failure: Keys


NEVER = Ends(None, None)
"""The ends of a node that is never reached, or runs for ever."""


class Outcome(Enum):
    """One way in which a node can end."""

    SUCCESS = "succeed"
    FAILURE = "fail"

    def of(self, ends: Ends) -> Keys:
        """The keys after this outcome."""
        return ends.success if self is Outcome.SUCCESS else ends.failure

    @property
    def opposite(self) -> Outcome:
        """The other outcome."""
        return Outcome.FAILURE if self is Outcome.SUCCESS else Outcome.SUCCESS


class Source(Enum):
    """Where an outcome of a modified node comes from."""

    SUCCESS = "the node has succeeded"
    FAILURE = "the node has failed"
    EARLY = "the modifier decides without the node: only what was written before it counts"


class Need(Enum):
    """What a node must be able to do for a word around it to have an effect, else the reason."""

    SUCCESS = "it cannot succeed"
    FAILURE = "it cannot fail"
    TIME = "it ends at once"
    NOTHING = "it always has one"


def either(*ways: Keys) -> Keys:
    """What is certainly written after one of several ways, of which some are impossible."""
    possible = [way for way in ways if way is not None]
    return frozenset.intersection(*possible) if possible else None


def ends_from(
    ends: Ends, before: Keys, success: Sequence[Source], failure: Sequence[Source]
) -> Ends:
    """The ends of a modified node, by the sources of its outcomes."""
    if before is None:
        return NEVER
    ways = {Source.SUCCESS: ends.success, Source.FAILURE: ends.failure, Source.EARLY: before}
    return Ends(
        either(*(ways[source] for source in success)), either(*(ways[source] for source in failure))
    )


Child: TypeAlias = Callable[[Keys], Ends]
"""Follows one child: from what is written when it starts to how it can end."""

Rule: TypeAlias = Callable[[Sequence[Child], Mapping[str, object], Keys], Ends]
"""(children, options of the composite, what is written when it starts) to how it can end."""


@dataclass(frozen=True)
class InOrder:
    """Each child starts when the one before has ended in one way; the other way ends them all.

    Args:
        goes_on: the way that leads to the next child.
    """

    goes_on: Outcome

    def __call__(
        self, children: Sequence[Child], options: Mapping[str, object], before: Keys
    ) -> Ends:
        """The ends of the composite."""
        stops = []
        for child in children:
            ends = child(before)
            stops.append(self.goes_on.opposite.of(ends))
            before = self.goes_on.of(ends)
        stop = either(*stops)
        is_sequence = self.goes_on is Outcome.SUCCESS
        return Ends(before, stop) if is_sequence else Ends(stop, before)


def side_by_side(children: Sequence[Child], options: Mapping[str, object], before: Keys) -> Ends:
    """All start at once: no child can count on another."""
    ends = [child(before) for child in children]
    count, policy = len(ends), options.get("policy", "all")
    needed = {"all": count, "any": 1}.get(str(policy), policy)
    # A policy that is a parameter may be any number of children.
    least, most = (needed, needed) if isinstance(needed, int) else (1, count)
    successes = [one.success for one in ends if one.success is not None]
    if len(successes) == least:
        success: Keys = frozenset().union(*successes)
    else:
        success = either(*successes) if len(successes) > least else None
    can_fail = sum(one.failure is not None for one in ends) > count - most
    return Ends(success, before if can_fail else None)


def one_of(children: Sequence[Child], options: Mapping[str, object], before: Keys) -> Ends:
    """One of the children runs, and nobody knows which; or none, if there are only `cases`."""
    ends = [child(before) for child in children]
    cases = options.get("cases")
    none = [before] if isinstance(cases, tuple) and len(cases) == len(children) else []
    success = either(*(one.success for one in ends))
    return Ends(success, either(*(one.failure for one in ends), *none))


def opposite(children: Sequence[Child], options: Mapping[str, object], before: Keys) -> Ends:
    """The one child succeeds, and it fails; and the other way round."""
    [child] = children
    ends = child(before)
    return Ends(ends.failure, ends.success)


def until_success(children: Sequence[Child], options: Mapping[str, object], before: Keys) -> Ends:
    """A failure of the one child starts it again, or ends it when it always fails alike."""
    [child] = children
    return child(before)


def until_first_succeeds(
    children: Sequence[Child], options: Mapping[str, object], before: Keys
) -> Ends:
    """A failure of the first child starts the others, in order; their success starts it again."""
    question, *work = children
    asked = question(before)
    return Ends(asked.success, InOrder(Outcome.SUCCESS)(work, {}, asked.failure).failure)


def each(children: Sequence[Child], options: Mapping[str, object], before: Keys) -> Ends:
    """One copy for each value, in order; or one child for all of a list, which may be empty."""
    item = getattr(options.get("item"), "name", None)
    if not isinstance(item, str):
        return InOrder(Outcome.SUCCESS)(children, options, before)
    [child] = children
    ends = child(None if before is None else before | {item})
    return Ends(before, ends.failure)
