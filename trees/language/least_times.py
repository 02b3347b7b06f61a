"""How long a node takes at least until it succeeds, by the times of the nodes below it.

These are the rules; they are assigned to the words in `composite_words` and `modifier_words`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

TimesRule: TypeAlias = Callable[[Sequence[float], Mapping[str, object]], float]
"""(least times of the children [s], options of the composite) to its own [s]."""

TimeRule: TypeAlias = Callable[[float, object], float]
"""(least time of the node [s], value of the modifier) to that of both [s]."""


def in_order(children: Sequence[float], options: Mapping[str, object]) -> float:
    """All, one after the other."""
    return sum(children)


def quickest(children: Sequence[float], options: Mapping[str, object]) -> float:
    """One of them, and nobody knows which."""
    return min(children)


def first(children: Sequence[float], options: Mapping[str, object]) -> float:
    """The first of them."""
    return children[0]


def nothing_sure(children: Sequence[float], options: Mapping[str, object]) -> float:
    """It may have begun before."""
    return 0.0


def for_each(children: Sequence[float], options: Mapping[str, object]) -> float:
    """All of them in order; a list that is known only during the run may be empty."""
    return 0.0 if options else sum(children)


def enough(children: Sequence[float], options: Mapping[str, object]) -> float:
    """As many side by side as the policy wants."""
    policy = options.get("policy", "all")
    needed = {"all": len(children), "any": 1}.get(str(policy), policy)
    return sorted(children)[needed - 1] if isinstance(needed, int) else min(children)


def unchanged(node: float, value: object) -> float:
    """As long as the node."""
    return node


def nothing(node: float, value: object) -> float:
    """It may succeed at once."""
    return 0.0


def longer(node: float, value: object) -> float:
    """So many seconds longer."""
    return node + value if isinstance(value, int | float) else node


def times(node: float, value: object) -> float:
    """So many times as long."""
    return node * value if isinstance(value, int) else node
