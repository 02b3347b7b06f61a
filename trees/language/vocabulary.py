"""The words of the language: composites and modifiers, each with what it takes and makes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour

from trees.language import composites, modifiers
from trees.language.branch import Branch
from trees.language.values import ValueType

Now = Callable[[], float]
"""The time on the session's clock [s]."""


@dataclass(frozen=True, kw_only=True)
class CompositeWord:
    """A key whose value is one node or a list of nodes."""

    node: type[Branch]
    least: int = 1
    """How many children it needs."""
    only_child: bool = False
    """Whether it takes a single child, which may then stand without a list."""
    children: str = "one or more nodes"
    """What its children are."""

    @property
    def description(self) -> str:
        """What it does, in a line."""
        return (self.node.__doc__ or "").splitlines()[0]


@dataclass(frozen=True, kw_only=True)
class ModifierWord:
    """A key that stands beside a node and wraps it."""

    type: ValueType
    wrap: Callable[[Behaviour, Any, Now], Behaviour]
    """(node, value, clock) to the wrapped node."""
    description: str
    accepts: Callable[[Any], bool] = lambda value: True
    rule: str = ""
    """What a value of the right type must be besides."""


_COUNT = ValueType(kinds=(int,))

COMPOSITES: Mapping[str, CompositeWord] = {
    word.node.key: word
    for word in (
        CompositeWord(node=composites.Sequence),
        CompositeWord(node=composites.Fallback),
        CompositeWord(node=composites.ReactiveSequence),
        CompositeWord(node=composites.ReactiveFallback),
        CompositeWord(node=composites.Parallel),
        CompositeWord(node=composites.Forever, only_child=True, children="one node"),
        CompositeWord(node=composites.Until, least=2, children="a question, then the work to do"),
    )
}

MODIFIERS: Mapping[str, ModifierWord] = {
    "timeout_s": ModifierWord(
        type=ValueType(kinds=(float,)),
        wrap=lambda node, seconds, now: modifiers.Timeout(node, seconds, now),
        description="Fails the node when it still runs after this time, in each attempt anew.",
        accepts=lambda seconds: seconds > 0.0,
        rule="greater than 0",
    ),
    "invert": ModifierWord(
        type=ValueType(kinds=(bool,)),
        wrap=lambda node, wanted, now: modifiers.Invert(node) if wanted else node,
        description="Swaps success and failure.",
    ),
    "retry": ModifierWord(
        type=_COUNT,
        wrap=lambda node, attempts, now: modifiers.Retry(node, attempts),
        description="How often the node is attempted at most, until it succeeds.",
        accepts=lambda attempts: attempts >= 1,
        rule="at least 1",
    ),
    "repeat": ModifierWord(
        type=_COUNT,
        wrap=lambda node, rounds, now: modifiers.Repeat(node, rounds),
        description="How often the node has to succeed, one time after the other.",
        accepts=lambda rounds: rounds >= 1,
        rule="at least 1",
    ),
}
"""Innermost first: this order holds whatever the order in the file."""

NAME = "name"
"""The key that names a node."""

RESERVED = frozenset({NAME, *COMPOSITES, *MODIFIERS})
"""Words that no leaf may take as its key."""
