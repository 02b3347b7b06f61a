"""Warnings about what is probably a mistake, and the error of two movers at the same time."""

from collections.abc import Container, Mapping
from itertools import pairwise

from config import Diagnostics
from trees.language import rules
from trees.language.flow import Fact, FlowResult
from trees.language.hand_warnings import check_hand
from trees.language.syntax import (
    CompositeNode,
    LeafNode,
    Node,
    SubtreeNode,
    all_leaves,
    hand_leaves,
    is_condition,
    nodes_below,
)
from trees.language.values import KeyRead
from trees.words import MODIFIERS, Need, Outcomes, all_in_order, first_success


def lint(root: Node, flow: FlowResult, diagnostics: Diagnostics, is_first: bool) -> bool:
    """Check a tree for what is allowed, but probably not meant.

    Only the first file of a task is judged as a whole. Returns whether there is no error.
    """
    facts, sound = flow.facts, True
    beside = {
        id(below)
        for node in nodes_below(root)
        if isinstance(node, CompositeNode) and node.word.at_once
        for below in nodes_below(node)
    }
    """Nodes beside others that run at the same time."""
    for node in nodes_below(root):
        fact = facts[id(node)]
        if not fact.reached:
            continue
        if isinstance(node, CompositeNode):
            _warn_of_unreached(node, facts, diagnostics)
            _warn_of_lone_guards(node, diagnostics)
            word, child = node.word, node.children[0]
            if why := _needless(word.needs, child, facts[id(child)].outcomes):
                message = f"`{node.key}` has no effect on `{child.name}`: {why}"
                diagnostics.warning(rules.NO_EFFECT, node.location, message, "remove it")
            sound &= not _note_movers(node, diagnostics)
            _warn_of_endless(node, facts, diagnostics)
            if id(node) not in beside:
                _warn_of_same_answer(node, facts, diagnostics)
        _warn_of_modifiers(node, fact, diagnostics)
    return check_hand(root, flow, diagnostics, is_first) and sound


def _warn_of_modifiers(node: Node, fact: Fact, diagnostics: Diagnostics) -> None:
    inner = fact.layers[""]
    for key, value in node.modifiers.items():
        if why := _needless(MODIFIERS[key].of(value).needs, node, inner):
            message = f"`{key}` has no effect on `{node.name}`: {why}"
            diagnostics.warning(rules.NO_EFFECT, node.location, message, "remove it")
        inner = fact.layers[key]
    if "retry" in node.modifiers and "while" in node.modifiers:
        message = f"`while` ends all attempts of `{node.name}`: what it stops is not tried again"
        hint = "put it on a node below the `retry`; if it is meant, on a `sequence` around"
        diagnostics.warning(rules.ENDS_RETRIES, node.location, message, hint)
    limit, least = node.modifiers.get("timeout_s"), _lasts(node)
    if isinstance(limit, float | int) and least > limit:
        message = f"`{node.name}` takes {least:g} s, and its `timeout_s` is {limit:g}"
        hint = f"give it more than {least:g} s, or what waits in it less"
        diagnostics.warning(rules.TOO_SHORT, node.location, message, hint)


def _lasts(node: Node) -> float:
    """The least time in which a node without its modifiers succeeds [s]."""
    if isinstance(node, LeafNode):
        given = node.arguments.get(node.type.lasts)
        return float(given) if isinstance(given, float | int) else 0.0
    if isinstance(node, SubtreeNode):
        return _lasts_with_modifiers(node.task.root)
    each, word = [_lasts_with_modifiers(child) for child in node.children], node.word
    if word.takes_time or node.item is not None:
        return each[0] if node.item is None else 0.0
    if word.at_once:
        return max(each) if node.options.get("policy", "all") == "all" else min(each)
    is_any = word.outcomes is first_success or bool(node.cases)
    return min(each) if is_any else sum(each)


def _lasts_with_modifiers(node: Node) -> float:
    times = node.modifiers.get("repeat")
    return _lasts(node) * times if isinstance(times, int) else _lasts(node)


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
        # That a condition is sure of the hand is no reason not to ask.
        if not facts[id(child)].reached and not is_condition(before):
            outcomes = facts[id(before)].outcomes
            never = "fails" if outcomes.success is not None else "succeeds"
            never = "ends" if outcomes.success is None and outcomes.failure is None else never
            message = f"`{child.name}` is never reached: `{before.name}` before it never {never}"
            hint = f"remove it, or change `{before.name}`"
            diagnostics.warning(rules.UNREACHED, child.location, message, hint)
            break


def _warn_of_lone_guards(node: CompositeNode, diagnostics: Diagnostics) -> None:
    """Of conditions that are asked once, before an action that they seem to guard."""
    guards: list[LeafNode] = []
    is_sequence = node.word.outcomes is all_in_order
    for child in node.children if is_sequence else ():
        if not isinstance(child, LeafNode) or not child.type.is_condition:
            break
        guards.append(child)
    action = next((child for child in node.children[len(guards) :] if _takes_time(child)), None)
    for guard in guards:
        if action is not None and not guard.modifiers and guard.name == guard.type.key:
            message = f"`{guard.name}` is asked once, and not again while `{action.name}` runs"
            hint = "write it as `while:` beside `sequence`, or give it a `name` if once is meant"
            diagnostics.warning(rules.ASKED_ONCE, guard.location, message, hint)


def _takes_time(node: Node) -> bool:
    """Whether a node with its modifiers may run for more than a tick."""
    return any(MODIFIERS[key].takes_time for key in node.modifiers) or _runs(node)


def _runs(node: Node) -> bool:
    """Whether a node without its modifiers may run for more than a tick."""
    if isinstance(node, LeafNode):
        return node.type.takes_time
    if isinstance(node, SubtreeNode):
        return _takes_time(node.task.root)
    return node.word.takes_time or any(map(_takes_time, node.children))


def _note_movers(node: CompositeNode, diagnostics: Diagnostics) -> bool:
    """Whether two children that run at the same time can move the robot, which is an error."""
    if not node.word.at_once:
        return False
    firsts = [
        next((leaf for leaf in all_leaves(child) if leaf.type.moves), None)
        for child in node.children
    ]
    movers = [(child, leaf) for child, leaf in zip(node.children, firsts, strict=True) if leaf]
    for child, leaf in movers[1:]:
        other = movers[0][1]
        message = f"`{other.name}` and `{leaf.name}` would both move the robot at the same time"
        hint = "let one run after the other, in a `sequence`"
        diagnostics.error(rules.MOVERS, child.location, message, hint)
    return len(movers) > 1


def _warn_of_endless(
    node: CompositeNode, facts: Mapping[int, Fact], diagnostics: Diagnostics
) -> None:
    """Of a loop around a child that never succeeds."""
    child = node.children[0]
    if node.word.takes_time and facts[id(child)].outcomes.success is None:
        message = f"`{node.key}` cannot succeed: `{child.name}` never does"
        hint = "put something that can succeed first, or a `timeout_s` beside it"
        if "timeout_s" not in node.modifiers:
            diagnostics.warning(rules.ENDLESS, node.location, message, hint)


def _warn_of_same_answer(
    node: CompositeNode, facts: Mapping[int, Fact], diagnostics: Diagnostics
) -> None:
    """Of a loop that asks for what nothing in it changes."""
    question = node.children[0]
    if node.key != "until" or None in facts[id(question)].outcomes:
        return
    below = [one for one in nodes_below(node) if not isinstance(one, CompositeNode)]
    changed = {write.name for one in below for write in one.outputs.values()}
    changed |= {"hand"} if any(hand_leaves(node)) else set()
    if "timeout_s" not in node.modifiers and not _may_become(question, True, changed):
        message = f"`{node.key}` never ends if it begins: nothing in it changes what is asked"
        hint = "put what changes the answer below it, or a `timeout_s` beside it"
        diagnostics.warning(rules.ENDLESS, node.location, message, hint)


def _may_become(node: Node, true: bool, changed: Container[str]) -> bool:
    """Whether a node may answer otherwise later, with these keys changed, and perhaps the hand."""
    if isinstance(node, CompositeNode):
        true = true != (node.key == "not")
        return any(_may_become(child, true, changed) for child in node.children)
    if isinstance(node, SubtreeNode) or node.modifiers:
        return True
    if node.type.is_condition and node.type.hand_before:  # a person may take it out of the hand
        return not true or "hand" in changed
    keys = [value.name for value in node.arguments.values() if isinstance(value, KeyRead)]
    return node.type.needs_robot or any(key in changed for key in keys)
