"""Warnings: what a task file may say, and hardly means.

They follow from how every node can end. A leaf can end both ways; `set` cannot fail; the others as
their children and modifiers let them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from trees.language.diagnostics import Diagnostics, Location
from trees.language.registry import SET
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode

Warn: TypeAlias = Callable[[Location, str, str], None]
"""(place, what is odd, how to fix it)."""


class Ends(NamedTuple):
    """How a node can end."""

    success: bool
    failure: bool


def lint(root: Node, diagnostics: Diagnostics) -> None:
    """Warn of nodes that are never reached, guards asked once, and modifiers without effect."""
    _ends(root, diagnostics.warning)


def _ends(node: Node, warn: Warn) -> Ends:
    """How a node with its modifiers can end; warns of what it meets on the way."""
    if isinstance(node, CompositeNode):
        ends = _COMPOSITES[node.key](node, warn)
    elif isinstance(node, SubtreeNode):
        # What is odd in the other file is said there.
        ends = _ends(node.task.root, lambda place, what, hint: None)
    else:
        ends = Ends(success=True, failure=node.type is not SET)
    for key, value in node.modifiers.items():
        if value is not False:
            if key in _NEEDLESS and (why := _NEEDLESS[key](node, ends)):
                warn(node.place, f"`{key}` has no effect on `{node.name}`: {why}", "remove it")
            if key in _MODIFIERS:
                ends = _MODIFIERS[key](ends)
    return ends


def _chain(nodes: Sequence[Node], warn: Warn, *, on_success: bool) -> list[Ends]:
    """The ends of nodes that follow each other, as far as they are reached.

    Args:
        nodes: in their order.
        warn: told of the first that is never reached.
        on_success: whether a success leads to the next one, else a failure does.
    """
    ends: list[Ends] = []
    for node in nodes:
        if ends and not (ends[-1].success if on_success else ends[-1].failure):
            before = nodes[len(ends) - 1].name
            never = ("succeeds" if on_success else "fails") if any(ends[-1]) else "ends"
            what = f"`{node.name}` is never reached: `{before}` before it never {never}"
            warn(node.place, what, f"remove it, or fix `{before}`")
            break
        ends.append(_ends(node, warn))
    return ends


def _sequence(node: CompositeNode, warn: Warn) -> Ends:
    _GUARDING[node.key](node, warn)
    ends = _chain(node.children, warn, on_success=True)
    return Ends(
        success=len(ends) == len(node.children) and ends[-1].success,
        failure=any(end.failure for end in ends),
    )


def _fallback(node: CompositeNode, warn: Warn) -> Ends:
    ends = _chain(node.children, warn, on_success=False)
    return Ends(
        success=any(end.success for end in ends),
        failure=len(ends) == len(node.children) and ends[-1].failure,
    )


def _parallel(node: CompositeNode, warn: Warn) -> Ends:
    ends = [_ends(child, warn) for child in node.children]
    policy, count = node.options.get("policy", "all"), len(ends)
    needed = policy if isinstance(policy, int) else 1 if policy == "any" else count
    return Ends(
        sum(end.success for end in ends) >= needed,
        sum(end.failure for end in ends) > count - needed,
    )


def _forever(node: CompositeNode, warn: Warn) -> Ends:
    [child] = node.children
    ends = _ends(child, warn)
    if not ends.failure:
        what = f"`forever` starts again after a failure, and `{child.name}` cannot fail"
        warn(node.place, what, "remove it, or use `repeat` for more rounds")
    return Ends(success=ends.success, failure=False)


def _until(node: CompositeNode, warn: Warn) -> Ends:
    question, *work = node.children
    asked = _ends(question, warn)
    if not asked.failure:
        what = f"`{work[0].name}` is never reached: the question `{question.name}` never fails"
        warn(work[0].place, what, "remove it, or ask something else")
        return asked
    done = _chain(work, warn, on_success=True)
    return Ends(asked.success, any(end.failure for end in done))


_COMPOSITES: Mapping[str, Callable[[CompositeNode, Warn], Ends]] = {
    "sequence": _sequence,
    "reactive_sequence": _sequence,
    "fallback": _fallback,
    "reactive_fallback": _fallback,
    "parallel": _parallel,
    "forever": _forever,
    "until": _until,
}


_MODIFIERS: Mapping[str, Callable[[Ends], Ends]] = {
    "timeout_s": lambda ends: Ends(ends.success, True),
    "invert": lambda ends: Ends(ends.failure, ends.success),
    "cooldown_s": lambda ends: Ends(ends.success, True),
    "unless": lambda ends: Ends(True, ends.failure),
    "while": lambda ends: Ends(ends.success, True),
    "force_success": lambda ends: Ends(any(ends), False),
    "force_failure": lambda ends: Ends(False, any(ends)),
}
"""How a node with a modifier can end; the others change nothing."""

_NEEDLESS: Mapping[str, Callable[[Node, Ends], str | None]] = {
    "timeout_s": lambda node, ends: None if _runs(node) else "it ends at once",
    "retry": lambda node, ends: None if ends.failure else "it cannot fail",
    "force_success": lambda node, ends: None if ends.failure else "it cannot fail",
    "force_failure": lambda node, ends: None if ends.success else "it cannot succeed",
}
"""Why a modifier has no effect on a node that can end so; None if it has."""


def _warn_of_lone_guards(node: CompositeNode, warn: Warn) -> None:
    """Of conditions that are asked once, before an action that they seem to guard."""
    guards: list[LeafNode] = []
    for child in node.children:
        if not isinstance(child, LeafNode) or not child.type.is_condition:
            break
        guards.append(child)
    action = next((child for child in node.children[len(guards) :] if _takes_time(child)), None)
    for guard in guards:
        if action is not None and not guard.modifiers and guard.name == guard.type.key:
            what = f"`{guard.name}` is asked once, and not again while `{action.name}` runs"
            hint = "write it as `while:` beside `sequence`, or give it a `name` if once is meant"
            warn(guard.place, what, hint)


def _warn_of_early_action(node: CompositeNode, warn: Warn) -> None:
    """Of an action that begins again at every tick, instead of leading to what follows it."""
    for child in node.children[:-1]:
        if _takes_time(child) and "once" not in child.modifiers:
            what = f"`{child.name}` begins again at every tick after its success"
            warn(child.place, what, "put it and what follows into a `sequence` below")
            break


_GUARDING: Mapping[str, Callable[[CompositeNode, Warn], None]] = {
    "sequence": _warn_of_lone_guards,
    "reactive_sequence": _warn_of_early_action,
}


def _takes_time(node: Node) -> bool:
    """Whether a node with its modifiers may run for more than a tick."""
    waits = ("delay_s", "retry", "repeat")
    return any(key in node.modifiers for key in waits) or _runs(node)


def _runs(node: Node) -> bool:
    """Whether a node without its modifiers may run for more than a tick."""
    if isinstance(node, LeafNode):
        return not node.type.is_condition and node.type is not SET
    if isinstance(node, SubtreeNode):
        return _takes_time(node.task.root)
    return node.key in ("forever", "until") or any(map(_takes_time, node.children))
