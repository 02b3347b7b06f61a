"""Properties of a word of the language, a composite or a modifier, and the rules of outcomes.

A node starts with a set of keys that are certainly written, and can succeed or fail, each with such
a set, or do neither. The rules say how the outcomes of a node follow from those below it. The
checks of keys and reachability, the warnings, the schema, the pictures and the export derive from
the words.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from enum import Enum
from typing import Any, NamedTuple, TypeAlias

from py_trees.behaviour import Behaviour

from config import Plain
from trees.words.branch import Branch, Now
from trees.words.value_types import ValueType

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


class Source(Enum):
    """Source of an outcome of a modified node."""

    SUCCESS = "the node has succeeded"
    FAILURE = "the node has failed"
    EARLY = "the modifier decides without the node: only what was written before it counts"


class Need(Enum):
    """What a node must be able to do for a word around it to have an effect, else the reason."""

    SUCCESS = "it cannot succeed"
    FAILURE = "it cannot fail"
    TIME = "it ends at once"
    NOTHING = "it always has one"


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


@dataclass(frozen=True)
class InOrder:
    """Rule: each child starts after one outcome of the one before; the other outcome ends all."""

    goes_on: Outcome

    def __call__(self, children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
        """The outcomes of the composite."""
        stops = []
        for child in children:
            outcomes = child(before)
            stops.append(self.goes_on.opposite.of(outcomes))
            before = self.goes_on.of(outcomes)
        stop = either(*stops)
        is_sequence = self.goes_on is Outcome.SUCCESS
        return Outcomes(before, stop) if is_sequence else Outcomes(stop, before)


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
        return InOrder(Outcome.SUCCESS)(work, {}, answers[-1].failure)

    worked = rounds(one, Outcome.SUCCESS, before)
    return Outcomes(either(*(answer.success for answer in answers)), worked.failure)


def each(children: Sequence[Child], options: Options, before: Keys) -> Outcomes:
    """One copy for each value, in order; or one child for all of a list, which may be empty."""
    item = getattr(options.get("item"), "name", None)
    if not isinstance(item, str):
        return InOrder(Outcome.SUCCESS)(children, options, before)
    [child] = children
    start = None if before is None else before | {item}
    outcomes = rounds(child, Outcome.SUCCESS, start)
    return Outcomes(either(before, outcomes.success), outcomes.failure)


@dataclass(frozen=True, kw_only=True)
class Option:
    """A parameter of a composite."""

    type: ValueType
    default: Plain
    description: str


@dataclass(frozen=True)
class Counterpart:
    """The equivalent node of BehaviorTree.CPP 4."""

    tag: str
    port: str = ""  # the attribute that takes the word's value; empty if it has none
    scale: int = 1  # the attribute is the value times this, a whole number
    fixed: tuple[tuple[str, str], ...] = ()  # constant attributes


@dataclass(frozen=True)
class Word:
    """A composite or modifier."""

    node: type[Branch]  # what it is built into; the first line of its docstring describes the word
    counterpart: Counterpart | None
    """Of BehaviorTree.CPP; None if it has none, and the export declares a node of this key."""
    _: KW_ONLY
    takes_time: bool = False  # whether it may run for more than a tick by itself
    needs: Need = Need.NOTHING  # what the node below has to be able to do

    @property
    def description(self) -> str:
        """In a line."""
        return (self.node.__doc__ or "").splitlines()[0]


class Form(Enum):
    """Syntax of the value of a composite."""

    LIST = "nodes"
    CASES = "a value, and a node for each of its cases"
    EACH = "values, and a node for each of them"


@dataclass(frozen=True)
class CompositeWord(Word):
    """A key whose value is one node or a list of nodes.

    With options it may also be a mapping of those and `children`.
    """

    symbol: str  # in pictures
    outcomes: Rule  # order of its children, and its possible outcomes
    _: KW_ONLY
    form: Form = Form.LIST
    asks: bool = False  # whether its children are conditions
    at_once: bool = False  # whether several of its children run at the same time
    is_reactive: bool = False  # whether every tick begins at its first child
    children: str = "one or more nodes"  # description of its children
    least: int = 1
    most: int | None = None  # numbers of children; a single one may stand without a list
    options: Mapping[str, Option] = field(default_factory=dict)

    @property
    def is_condition(self) -> bool:
        """Whether it is a condition itself."""
        return self.asks and not self.takes_time


@dataclass(frozen=True)
class ModifierWord(Word):
    """A key that stands beside a node and wraps it."""

    type: ValueType | None  # of its value; None is a condition, written as a node
    wrap: Callable[[Behaviour, Any, Now], Behaviour]
    """(node, value or built condition, clock) to the wrapped node."""
    _: KW_ONLY
    succeeds: tuple[Source, ...] = (Source.SUCCESS,)  # of its success; empty if it never does
    fails: tuple[Source, ...] = (Source.FAILURE,)  # sources of its failure; empty if it never fails
    runs_on: Outcome | None = None
    """The outcome of its condition with which the node runs; None if it has no condition."""
    again: Outcome | None = None  # after which the node starts anew

    def outcomes(self, outcomes: Outcomes, early: Keys) -> Outcomes:
        """The outcomes of a node with this modifier.

        `outcomes` are those of the node without it, `early` is what is certain when the modifier
        decides.
        """
        ways = {
            Source.SUCCESS: outcomes.success,
            Source.FAILURE: outcomes.failure,
            Source.EARLY: early,
        }
        return Outcomes(
            either(*(ways[source] for source in self.succeeds)),
            either(*(ways[source] for source in self.fails)),
        )
