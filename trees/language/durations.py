"""Minimum durations of nodes until they succeed: the rules of composites and modifiers.

They are assigned to the words in `vocabulary`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

DurationsRule: TypeAlias = Callable[[Sequence[float], Mapping[str, object]], float]
"""(minimum durations of the children [s], options of the composite) to its own [s]."""

DurationRule: TypeAlias = Callable[[float, object], float]
"""(minimum duration of the node [s], value of the modifier) to that of both [s]."""


def in_order(children: Sequence[float], options: Mapping[str, object]) -> float:
    """All, one after the other."""
    return sum(children)


def quickest(children: Sequence[float], options: Mapping[str, object]) -> float:
    """Any one of them."""
    return min(children)


def first(children: Sequence[float], options: Mapping[str, object]) -> float:
    """The first of them."""
    return children[0]


def nothing_sure(children: Sequence[float], options: Mapping[str, object]) -> float:
    """None: it may have begun before."""
    return 0.0


def for_each(children: Sequence[float], options: Mapping[str, object]) -> float:
    """All of them in order; none for a list that is known only during the run."""
    return 0.0 if options else sum(children)


def enough(children: Sequence[float], options: Mapping[str, object]) -> float:
    """As many side by side as the policy wants."""
    policy = options.get("policy", "all")
    needed = {"all": len(children), "any": 1}.get(str(policy), policy)
    return sorted(children)[needed - 1] if isinstance(needed, int) else min(children)


def unchanged(node: float, value: object) -> float:
    """That of the node."""
    return node


def nothing(node: float, value: object) -> float:
    """None: it may succeed at once."""
    return 0.0


def longer(node: float, value: object) -> float:
    """Longer by the value [s]."""
    return node + value if isinstance(value, int | float) else node


def times(node: float, value: object) -> float:
    """A multiple."""
    return node * value if isinstance(value, int) else node
