"""The words of the language: composites and modifiers, each with what it takes and makes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from py_trees.behaviour import Behaviour

from trees.language import composites, modifiers
from trees.language.branch import Branch
from trees.language.modifiers import Now
from trees.language.value_types import Plain, ValueType


@dataclass(frozen=True, kw_only=True)
class Option:
    """What may be said about a composite besides its children."""

    type: ValueType
    default: Plain
    description: str


@dataclass(frozen=True, kw_only=True)
class CompositeWord:
    """A key whose value is one node or a list of nodes.

    With options it may also be a mapping of those and `children`.
    """

    node: type[Branch]
    least: int = 1
    """How many children it needs."""
    only_child: bool = False
    """Whether it takes a single child, which may then stand without a list."""
    children: str = "one or more nodes"
    """What its children are."""
    options: Mapping[str, Option] = field(default_factory=dict)

    @property
    def description(self) -> str:
        """What it does, in a line."""
        return (self.node.__doc__ or "").splitlines()[0]


@dataclass(frozen=True, kw_only=True)
class ModifierWord:
    """A key that stands beside a node and wraps it."""

    type: ValueType | None
    """What it takes; None is a condition, written as a node."""
    wrap: Callable[[Behaviour, Any, Now], Behaviour]
    """(node, value or built condition, clock) to the wrapped node."""
    description: str

    @property
    def is_guard(self) -> bool:
        """Whether its value is a condition."""
        return self.type is None


_SECONDS = ValueType(kinds=(float,), above=0.0)
_COUNT = ValueType(kinds=(int,), least=1)
_FLAG = ValueType(kinds=(bool,))

CHILDREN = "children"
"""The key of the children where a composite has options."""

COMPOSITES: Mapping[str, CompositeWord] = {
    word.node.key: word
    for word in (
        CompositeWord(node=composites.Sequence),
        CompositeWord(node=composites.Fallback),
        CompositeWord(node=composites.ReactiveSequence),
        CompositeWord(node=composites.ReactiveFallback),
        CompositeWord(
            node=composites.Parallel,
            options={
                "policy": Option(
                    type=ValueType(kinds=(int,), choices=("all", "any"), least=1),
                    default="all",
                    description="How many children have to succeed; it fails when so many cannot.",
                )
            },
        ),
        CompositeWord(node=composites.Forever, only_child=True, children="one node"),
        CompositeWord(node=composites.Until, least=2, children="a question, then the work to do"),
    )
}


def _flag(make: Callable[[Behaviour], Branch]) -> Callable[[Behaviour, bool, Now], Behaviour]:
    """A modifier that is there or not."""
    return lambda node, wanted, now: make(node) if wanted else node


MODIFIERS: Mapping[str, ModifierWord] = {
    "timeout_s": ModifierWord(
        type=_SECONDS,
        wrap=lambda node, seconds, now: modifiers.Timeout(node, seconds, now),
        description="Fails the node when it still runs after this time, in each attempt anew.",
    ),
    "delay_s": ModifierWord(
        type=_SECONDS,
        wrap=lambda node, seconds, now: modifiers.Delay(node, seconds, now),
        description="Waits so long before each attempt; the timeout does not count it.",
    ),
    "invert": ModifierWord(
        type=_FLAG,
        wrap=_flag(modifiers.Invert),
        description="Swaps success and failure.",
    ),
    "retry": ModifierWord(
        type=_COUNT,
        wrap=lambda node, attempts, now: modifiers.Retry(node, attempts),
        description="How often the node is attempted at most, until it succeeds.",
    ),
    "repeat": ModifierWord(
        type=_COUNT,
        wrap=lambda node, rounds, now: modifiers.Repeat(node, rounds),
        description="How often the node has to succeed, one time after the other.",
    ),
    "once": ModifierWord(
        type=_FLAG,
        wrap=_flag(modifiers.Once),
        description="Runs the node to an end a single time, and answers with that outcome after.",
    ),
    "cooldown_s": ModifierWord(
        type=_SECONDS,
        wrap=lambda node, seconds, now: modifiers.Cooldown(node, seconds, now),
        description="Fails at once when started again sooner than this after the last end or halt.",
    ),
    "unless": ModifierWord(
        type=None,
        wrap=lambda node, condition, now: modifiers.Unless(condition, node),
        description="Asks a condition at every tick; when it holds, halts the node and succeeds.",
    ),
    "while": ModifierWord(
        type=None,
        wrap=lambda node, condition, now: modifiers.While(condition, node),
        description="Asks a condition at every tick; when it is lost, halts the node and fails.",
    ),
    "force_success": ModifierWord(
        type=_FLAG,
        wrap=_flag(modifiers.ForceSuccess),
        description="Succeeds however the node ends.",
    ),
    "force_failure": ModifierWord(
        type=_FLAG,
        wrap=_flag(modifiers.ForceFailure),
        description="Fails however the node ends.",
    ),
}
"""Innermost first: this order holds whatever the order in the file."""

NAME = "name"
"""The key that names a node."""

SUBTREE = "subtree"
"""The key of a node that stands for the tree of another file."""

RESERVED = frozenset({NAME, SUBTREE, *COMPOSITES, *MODIFIERS})
"""Words that no leaf may take as its key."""
