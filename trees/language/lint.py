"""Warnings about what is probably a mistake, and the error of two movers at the same time."""

from collections.abc import Iterator, Mapping
from itertools import pairwise

from config import Diagnostics
from trees.language import rules
from trees.language.flow import Fact
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode, nodes_below
from trees.words import COMPOSITES, MODIFIERS, InOrder, Need, Outcome, Outcomes


def lint(root: Node, facts: Mapping[int, Fact], diagnostics: Diagnostics) -> bool:
    """Check a tree for what is allowed, but probably not meant.

    Returns whether there is no error.
    """
    sound = True
    for node in nodes_below(root):
        fact = facts[id(node)]
        if fact.before is None:
            continue
        if isinstance(node, CompositeNode):
            _warn_of_unreached(node, facts, diagnostics)
            _warn_of_order(node, diagnostics)
            word, child = COMPOSITES[node.key], node.children[0]
            if why := _needless(word.needs, child, facts[id(child)].outcomes):
                message = f"`{node.key}` has no effect on `{child.name}`: {why}"
                diagnostics.warning(rules.NO_EFFECT, node.location, message, "remove it")
            sound &= not _note_movers(node, diagnostics)
            _warn_of_endless(node, facts, diagnostics)
        outcomes = fact.own
        for key, value in node.modifiers.items():
            if value is False:
                continue
            if why := _needless(MODIFIERS[key].needs, node, outcomes):
                message = f"`{key}` has no effect on `{node.name}`: {why}"
                diagnostics.warning(rules.NO_EFFECT, node.location, message, "remove it")
            outcomes = MODIFIERS[key].outcomes(outcomes, fact.before)
        if "retry" in node.modifiers and "while" in node.modifiers:
            message = (
                f"`while` ends all attempts of `{node.name}`: what it stops is not tried again"
            )
            hint = "put it on a node below the `retry`; if it is meant, on a `sequence` around"
            diagnostics.warning(rules.ENDS_RETRIES, node.location, message, hint)
    return sound


def _needless(need: Need, node: Node, outcomes: Outcomes) -> str | None:
    """Why a word has no effect on a node with these outcomes; None if it has."""
    missing = {
        Need.SUCCESS: outcomes.success is None,
        Need.FAILURE: outcomes.failure is None,
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
            outcomes = facts[id(before)].outcomes
            never = "fails" if outcomes.success is not None else "succeeds"
            never = "ends" if outcomes.success is None and outcomes.failure is None else never
            message = f"`{child.name}` is never reached: `{before.name}` before it never {never}"
            diagnostics.warning(
                rules.UNREACHED, child.location, message, f"remove it, or change `{before.name}`"
            )
            break


def _warn_of_order(node: CompositeNode, diagnostics: Diagnostics) -> None:
    """Of conditions that are asked too rarely, and actions that are started too often."""
    word = COMPOSITES[node.key]
    if word.outcomes == InOrder(Outcome.SUCCESS):
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
            diagnostics.warning(rules.ASKED_ONCE, guard.location, message, hint)


def _warn_of_early_action(node: CompositeNode, diagnostics: Diagnostics) -> None:
    """Of an action that begins again at every tick, instead of leading to what follows it."""
    for child in node.children[:-1]:
        if _takes_time(child) and "once" not in child.modifiers:
            message = f"`{child.name}` begins again at every tick after its success"
            hint = "put it and what follows into a `sequence` below"
            diagnostics.warning(rules.STARTS_AGAIN, child.location, message, hint)
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


def _note_movers(node: CompositeNode, diagnostics: Diagnostics) -> bool:
    """Whether two children that run at the same time can move the robot, which is an error."""
    if not COMPOSITES[node.key].at_once:
        return False
    firsts = [next(_movers(child), None) for child in node.children]
    movers = [(child, leaf) for child, leaf in zip(node.children, firsts, strict=True) if leaf]
    for child, leaf in movers[1:]:
        other = movers[0][1]
        message = f"`{other.name}` and `{leaf.name}` would both move the robot at the same time"
        hint = "let one run after the other, in a `sequence`"
        diagnostics.error(rules.MOVERS, child.location, message, hint)
    return len(movers) > 1


def _movers(node: Node) -> Iterator[LeafNode]:
    """The leaves at and below a node that may move the robot, those of other files included."""
    for one in nodes_below(node):
        if isinstance(one, SubtreeNode):
            yield from _movers(one.task.root)
        elif isinstance(one, LeafNode) and one.type.moves:
            yield one


def _warn_of_endless(
    node: CompositeNode, facts: Mapping[int, Fact], diagnostics: Diagnostics
) -> None:
    """Of a loop around a child that never succeeds."""
    child = node.children[0]
    if COMPOSITES[node.key].takes_time and facts[id(child)].outcomes.success is None:
        message = f"`{node.key}` cannot succeed: `{child.name}` never does"
        hint = "put something that can succeed first, or a `timeout_s` beside it"
        if "timeout_s" not in node.modifiers:
            diagnostics.warning(rules.ENDLESS, node.location, message, hint)
