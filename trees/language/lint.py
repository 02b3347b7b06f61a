"""Warnings: what is allowed in a task file, but probably a mistake."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

from config import Diagnostics
from trees.language.ends import Ends, InOrder, Need, Outcome
from trees.language.flow import Fact
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode, nodes_below
from trees.language.vocabulary import COMPOSITES, MODIFIERS


def lint(root: Node, facts: Mapping[int, Fact], diagnostics: Diagnostics) -> None:
    """Warn of nodes that are never reached, conditions asked once, and words without effect.

    Args:
        root: the tree of one file.
        facts: what is known about its nodes.
        diagnostics: of the file.
    """
    for node in nodes_below(root):
        fact = facts[id(node)]
        if fact.before is None:
            continue
        if isinstance(node, CompositeNode):
            _warn_of_unreached(node, facts, diagnostics)
            _warn_of_order(node, diagnostics)
            word, child = COMPOSITES[node.key], node.children[0]
            if why := _needless(word.needs, child, facts[id(child)].ends):
                message = f"`{node.key}` has no effect on `{child.name}`: {why}"
                diagnostics.warning(node.location, message, "remove it")
        ends = fact.own
        for key, value in node.modifiers.items():
            if value is False:
                continue
            if why := _needless(MODIFIERS[key].needs, node, ends):
                message = f"`{key}` has no effect on `{node.name}`: {why}"
                diagnostics.warning(node.location, message, "remove it")
            ends = MODIFIERS[key].ends(ends, fact.before)


def _needless(need: Need, node: Node, ends: Ends) -> str | None:
    """Why a word has no effect on a node that can end in these ways; None if it has."""
    missing = {
        Need.SUCCESS: ends.success is None,
        Need.FAILURE: ends.failure is None,
        Need.TIME: not _runs(node),
        Need.NOTHING: False,
    }
    return need.value if missing[need] else None


def _warn_of_unreached(
    node: CompositeNode, facts: Mapping[int, Fact], diagnostics: Diagnostics
) -> None:
    """Of the first child that never starts."""
    for before, child in pairwise(node.children):
        if facts[id(child)].before is None:
            ends = facts[id(before)].ends
            never = "fails" if ends.success is not None else "succeeds"
            never = "ends" if ends.success is None and ends.failure is None else never
            message = f"`{child.name}` is never reached: `{before.name}` before it never {never}"
            diagnostics.warning(child.location, message, f"remove it, or change `{before.name}`")
            break


def _warn_of_order(node: CompositeNode, diagnostics: Diagnostics) -> None:
    """Of conditions that are asked too rarely, and actions that are started too often."""
    word = COMPOSITES[node.key]
    if word.ends == InOrder(Outcome.SUCCESS):
        (_warn_of_early_action if word.is_reactive else _warn_of_lone_guards)(node, diagnostics)


def _warn_of_lone_guards(node: CompositeNode, diagnostics: Diagnostics) -> None:
    """Of conditions that are asked once, before an action that they seem to guard."""
    guards: list[LeafNode] = []
    for child in node.children:
        if not isinstance(child, LeafNode) or not child.type.is_condition:
            break
        guards.append(child)
    action = next((child for child in node.children[len(guards) :] if _takes_time(child)), None)
    for guard in guards:
        if action is not None and not guard.modifiers and guard.name == guard.type.key:
            message = f"`{guard.name}` is asked once, and not again while `{action.name}` runs"
            hint = "write it as `while:` beside `sequence`, or give it a `name` if once is meant"
            diagnostics.warning(guard.location, message, hint)


def _warn_of_early_action(node: CompositeNode, diagnostics: Diagnostics) -> None:
    """Of an action that begins again at every tick, instead of leading to what follows it."""
    for child in node.children[:-1]:
        if _takes_time(child) and "once" not in child.modifiers:
            message = f"`{child.name}` begins again at every tick after its success"
            hint = "put it and what follows into a `sequence` below"
            diagnostics.warning(child.location, message, hint)
            break


def _takes_time(node: Node) -> bool:
    """Whether a node with its modifiers may run for more than a tick."""
    return any(MODIFIERS[key].takes_time for key in node.modifiers) or _runs(node)


def _runs(node: Node) -> bool:
    """Whether a node without its modifiers may run for more than a tick."""
    if isinstance(node, LeafNode):
        return node.type.takes_time
    if isinstance(node, SubtreeNode):
        return _takes_time(node.task.root)
    return COMPOSITES[node.key].takes_time or any(map(_takes_time, node.children))
