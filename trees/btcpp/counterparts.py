"""The nodes of BehaviorTree.CPP that stand for words of the language, and their attributes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from trees.btcpp.ports import pointer
from trees.language import COMPOSITES, MODIFIERS, Counterpart, KeyRead

MAIN = "Main"
"""The tree that runs the exported task with its default parameters."""

SUBTREE = "SubTree"
SCRIPT = "Script"
"""Writes keys: the language's `set`."""

PARALLEL = "Parallel"
"""The one node whose attributes count its children; see `parallel_counts`."""

SWITCHES = range(2, 7)
"""How many cases a `Switch` of BehaviorTree.CPP may have."""

VALUE = "value"
"""The port of an exported modifier that BehaviorTree.CPP does not have."""

TAGS: Mapping[str, str] = {
    word.node.key: word.counterpart.tag
    for word in (*COMPOSITES.values(), *MODIFIERS.values())
    if word.counterpart is not None
}
"""Tags by the key of a built node."""

_SWITCH_TAGS = {f"Switch{number}" for number in SWITCHES} | {"AlwaysFailure"}

TAKEN = frozenset({MAIN, SCRIPT, SUBTREE, *TAGS.values(), *COMPOSITES, *MODIFIERS, *_SWITCH_TAGS})
"""Names in the XML that neither a task nor a leaf can have."""

RESERVED_PORTS = frozenset({"ID", "name"})
"""Attributes with a meaning of their own, besides those that begin with `_`."""


def standard_attributes(counterpart: Counterpart, value: object) -> dict[str, str] | None:
    """The attributes of the counterpart of a modifier; None if it cannot take the value."""
    if not counterpart.port:
        return dict(counterpart.fixed)
    if isinstance(value, KeyRead) and counterpart.scale == 1:
        return {counterpart.port: pointer(value.name)}
    if isinstance(value, int | float):
        whole = round(value * counterpart.scale)
        if whole / counterpart.scale == value:
            return {counterpart.port: str(whole)}
    return None


def switch_attributes(variable: str, cases: Sequence[str]) -> dict[str, str]:
    """The attributes of a `Switch2` to `Switch6`; its last child is the default."""
    numbered = {f"case_{place}": case for place, case in enumerate(cases, 1)}
    return {"variable": variable} | numbered


def parallel_counts(policy: object, children: int) -> dict[str, str]:
    """The attributes of a `Parallel` for a policy of `parallel`."""
    if policy == "all":
        return {"success_count": "-1", "failure_count": "1"}
    if policy == "any":
        return {"success_count": "1", "failure_count": "-1"}
    return {"success_count": str(policy), "failure_count": str(children - int(str(policy)) + 1)}
