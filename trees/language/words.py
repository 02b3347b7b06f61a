"""Properties of a word of the language: a composite or a modifier.

The checks of keys and reachability, the warnings, the schema, the pictures and the export derive
from them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from py_trees.behaviour import Behaviour

from config import Plain
from trees.language.branch import Branch, Now
from trees.language.durations import DurationRule, DurationsRule, quickest, unchanged
from trees.language.outcomes import Keys, Need, Outcome, Outcomes, Rule, Source, outcomes_from
from trees.language.value_types import ValueType


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
    port: str = ""
    """The attribute that takes the word's value; empty if it has none."""
    scale: int = 1
    """The attribute is the value times this, a whole number."""
    fixed: tuple[tuple[str, str], ...] = ()
    """Constant attributes."""


@dataclass(frozen=True, kw_only=True)
class Word:
    """A composite or modifier."""

    node: type[Branch]
    """What it is built into; the first line of its docstring describes the word."""
    takes_time: bool = False
    """Whether it may run for more than a tick although no leaf below it does."""
    needs: Need = Need.NOTHING
    """What the node below has to be able to do."""
    counterpart: Counterpart | None
    """Of BehaviorTree.CPP; None if it has none, and the export declares a node of this key."""

    @property
    def description(self) -> str:
        """In a line."""
        return (self.node.__doc__ or "").splitlines()[0]


class Form(Enum):
    """Syntax of the value of a composite."""

    LIST = "nodes"
    CASES = "a value, and a node for each of its cases"
    EACH = "values, and a node for each of them"


@dataclass(frozen=True, kw_only=True)
class CompositeWord(Word):
    """A key whose value is one node or a list of nodes.

    With options it may also be a mapping of those and `children`.
    """

    form: Form = Form.LIST
    asks: bool = False
    """Whether its children are conditions; it is a condition then."""
    at_once: bool = False
    """Whether several of its children run at the same time."""
    duration: DurationsRule = quickest
    """Minimum duration until it succeeds."""
    outcomes: Rule
    """Order of its children, and its possible outcomes."""
    is_reactive: bool = False
    """Whether every tick begins at its first child."""
    children: str = "one or more nodes"
    """Description of its children."""
    least: int = 1
    most: int | None = None
    """Numbers of children; a single one may stand without a list."""
    options: Mapping[str, Option] = field(default_factory=dict)
    symbol: str
    """In pictures."""


@dataclass(frozen=True, kw_only=True)
class ModifierWord(Word):
    """A key that stands beside a node and wraps it."""

    type: ValueType | None = None
    """Of its value; None is a condition, written as a node."""
    wrap: Callable[[Behaviour, Any, Now], Behaviour]
    """(node, value or built condition, clock) to the wrapped node."""
    duration: DurationRule = unchanged
    """Minimum duration of the node with it until it succeeds."""
    succeeds: tuple[Source, ...] = (Source.SUCCESS,)
    """Sources of its success; empty if it never succeeds."""
    fails: tuple[Source, ...] = (Source.FAILURE,)
    """Sources of its failure; empty if it never fails."""
    runs_on: Outcome | None = None
    """The outcome of its condition with which the node runs; None if it has no condition."""

    def outcomes(self, outcomes: Outcomes, before: Keys) -> Outcomes:
        """The outcomes of a node with this modifier.

        Args:
            outcomes: of the node without it.
            before: the keys that are written when it starts.
        """
        return outcomes_from(outcomes, before, self.succeeds, self.fails)
