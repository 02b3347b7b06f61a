"""What is known about a word of the language.

The checks of keys and reachability, the warnings, the schema, the pictures and the export derive
from it. Every field is required, so that no word can be added that one of them does not know.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

from py_trees.behaviour import Behaviour

from config import Plain
from trees.language.branch import Branch, Now
from trees.language.ends import Ends, Keys, Need, Outcome, Rule, Source, ends_from
from trees.language.least_times import TimeRule, TimesRule
from trees.language.value_types import ValueType


@dataclass(frozen=True, kw_only=True)
class Option:
    """What a composite takes besides its children."""

    type: ValueType
    default: Plain
    description: str


@dataclass(frozen=True)
class Counterpart:
    """The node of BehaviorTree.CPP 4 that does what a word does."""

    tag: str
    port: str = ""
    """The attribute that takes the word's value; empty if it has none."""
    scale: int = 1
    """The attribute is the value times this, a whole number."""
    fixed: tuple[tuple[str, str], ...] = ()
    """Attributes that it always has."""


@dataclass(frozen=True, kw_only=True)
class Word:
    """A composite or modifier."""

    node: type[Branch]
    """What it is built into; the first line of its docstring describes the word."""
    takes_time: bool
    """Whether it may run for more than a tick although no leaf below it does."""
    needs: Need
    """What the node below has to be able to do."""
    counterpart: Counterpart | None
    """Of BehaviorTree.CPP; None if it has none, and the export declares a node of this key."""

    @property
    def description(self) -> str:
        """What it does, in a line."""
        return (self.node.__doc__ or "").splitlines()[0]


class Form(Enum):
    """What stands below a composite."""

    LIST = "nodes"
    CASES = "a value, and a node for each of its cases"
    EACH = "values, and a node for each of them"


@dataclass(frozen=True, kw_only=True)
class CompositeWord(Word):
    """A key whose value is one node or a list of nodes.

    With options it may also be a mapping of those and `children`.
    """

    form: Form
    """What stands below it."""
    asks: bool
    """Whether its children are conditions; it is one itself then."""
    at_once: bool
    """Whether several of its children run at the same time."""
    lasts: TimesRule
    """How long it takes at least until it succeeds."""
    ends: Rule
    """How its children follow each other, and how it can end."""
    is_reactive: bool
    """Whether it asks its children from the first again at every tick."""
    children: str
    """What its children are."""
    least: int
    """How many children it needs."""
    most: int | None
    """How many it takes; a single one may stand without a list."""
    options: Mapping[str, Option]
    symbol: str
    """In pictures."""


@dataclass(frozen=True, kw_only=True)
class ModifierWord(Word):
    """A key that stands beside a node and wraps it."""

    type: ValueType | None
    """What it takes; None is a condition, written as a node."""
    wrap: Callable[[Behaviour, Any, Now], Behaviour]
    """(node, value or built condition, clock) to the wrapped node."""
    lasts: TimeRule
    """How long the node with it takes at least until it succeeds."""
    succeeds: tuple[Source, ...]
    """Where its success comes from; nowhere, if it never succeeds."""
    fails: tuple[Source, ...]
    """Where its failure comes from; nowhere, if it never fails."""
    runs_on: Outcome | None
    """The outcome of its condition with which the node runs; None if it has no condition."""

    def ends(self, ends: Ends, before: Keys) -> Ends:
        """How a node with this modifier can end.

        Args:
            ends: of the node without it.
            before: what is written when it starts.
        """
        return ends_from(ends, before, self.succeeds, self.fails)
