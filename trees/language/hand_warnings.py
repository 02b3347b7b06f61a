"""Warnings about the hand: what is grasped, held and let go in an order that can do something."""

from collections.abc import Iterator, Sequence
from itertools import takewhile

from behaviours import MapPlace
from config import Diagnostics
from trees.language import rules
from trees.language.flow import FlowResult
from trees.language.syntax import (
    CompositeNode,
    LeafNode,
    Node,
    all_leaves,
    is_condition,
    nodes_below,
)
from trees.words import COMPOSITES, EMPTY, FULL, UNUSED_HAND, all_in_order, first_success


def check_hand(root: Node, flow: FlowResult, diagnostics: Diagnostics, is_first: bool) -> bool:
    """Whether every leaf may have in the hand what it needs; warns of what is odd.

    Only the first file of a task is judged as a whole.
    """
    nodes = [one for one in nodes_below(root) if not isinstance(one, CompositeNode)]
    leaves = [(leaf, node) for node in nodes for leaf in all_leaves(node)]
    sound = True
    for leaf, node in leaves:
        if told := _what_is_odd(leaf, node, root, flow):
            ways, message, hint = flow.facts[id(leaf)].ways, *told
            if leaf.type.hand_before == "full" and all(EMPTY in way for way in ways):
                diagnostics.error(rules.HAND, node.location, message, hint)
                sound = False
            else:
                diagnostics.warning(rules.HAND, node.location, message, hint)
    for one in nodes_below(root):
        for word, condition in _asked(one):
            fact, ends = flow.facts[id(condition)], flow.ends.get(id(condition))
            if not fact.reached:
                continue
            if fact.outcomes.success is None and "force_failure" not in condition.modifiers:
                at = one if word == "while" else condition
                message = f"`{condition.name}` never holds here{_since(at, root)}"
                hint = "ask it before that, or let `grasp` or `receive` come between"
                diagnostics.warning(rules.HAND, condition.location, message, hint)
            elif ends:
                message = f"`{word}` asks `{condition.name}` at every tick, and `{ends.name}` ends"
                message += " that: what it has done counts as a failure"
                hint = f"let `{word}` guard only what comes before `{ends.name}`"
                diagnostics.warning(rules.HAND, condition.location, message, hint)
    if is_first:
        _warn_of_end(leaves, flow, diagnostics)
        _warn_of_forced(root, diagnostics)
    return sound


def _what_is_odd(
    leaf: LeafNode, node: Node, root: Node, flow: FlowResult
) -> tuple[str, str] | None:
    """Message and hint about a leaf, which the node is or includes, if the hand is not for it."""
    ways = flow.facts[id(leaf)].ways if id(leaf) in flow.facts else ()
    needs = "" if leaf.type.is_condition else leaf.type.hand_before
    if needs == "empty" and any(FULL in way for way in ways):
        hint = "let go before it, by `place`, `hand_over` or `open_gripper`"
        return f"`{leaf.name}` begins with a full hand{_since(node, root)}", hint
    if needs != "full" or not any(UNUSED_HAND in way for way in ways):
        return None
    if any(EMPTY in way for way in ways):
        message = f"`{leaf.name}` has nothing in the hand here{_since(node, root)}"
        hint = f"put a `grasp` before `{leaf.name}`, or remove what has emptied the hand"
    elif any(one.type.hand_before == "empty" for one in all_leaves(root)):
        message = f"`{leaf.name}` comes when nothing has been taken"
        hint = "put it behind `grasp`, or ask `holding_object` if the hand may be full before"
    else:
        return None
    parents = (one for one in nodes_below(root) if isinstance(one, CompositeNode))
    parent = next((one for one in parents if node in one.children), None)
    if parent and COMPOSITES[parent.key].outcomes is first_success:
        hint = f"a child of `{parent.key}` starts only when those before it have failed: "
        hint += "put what follows each other into a `sequence`"
    return message, hint


def _since(at: Node, root: Node) -> str:
    """Which leaf before a node has made the hand what it is."""
    before = takewhile(lambda node: node is not at, nodes_below(root))
    made = [
        (leaf.name, node.location.line)
        for node in before
        if not isinstance(node, CompositeNode)
        for leaf in all_leaves(node)
        if leaf.type.hand_after and not leaf.type.is_condition
    ]
    return ": `{}` on line {} has left it so".format(*made[-1]) if made else ""


def _asked(node: Node) -> Iterator[tuple[str, Node]]:
    """The conditions that have to hold for a node to succeed, and the word that asks each."""
    guard = node.modifiers.get("while")
    if isinstance(guard, LeafNode | CompositeNode):
        yield "while", guard
    word = COMPOSITES[node.key] if isinstance(node, CompositeNode) else None
    if isinstance(node, CompositeNode) and word and (word.takes_time or not word.asks):
        is_sequence = word.outcomes is all_in_order
        for child in node.children if is_sequence else node.children[: word.takes_time]:
            if is_condition(child):
                yield node.key, child


def _warn_of_end(
    leaves: Sequence[tuple[LeafNode, Node]], flow: FlowResult, diagnostics: Diagnostics
) -> None:
    """Of a task that carries something, or puts it down before, and ends with it in the hand."""
    taking = [one for one in leaves if one[0].type.hand_before == "empty"]
    leaf, node = taking[-1] if taking else leaves[-1]
    if leaf.name != leaf.type.key or FULL not in (flow.outcomes.success or ()):
        return
    for other, _ in leaves:
        says, given = other.type, (other.arguments.get(name) for name in other.type.goes_to)
        puts = says.hand_before == "full" and says.hand_after == "empty"
        ways = flow.facts[id(other)].ways if id(other) in flow.facts else ()
        carries = any(FULL in way for way in ways) and any(isinstance(x, MapPlace) for x in given)
        if puts or carries:
            message = f"the task succeeds with what `{leaf.name}` has taken still in the hand"
            hint = "end it with `place` or `hand_over`; if it is to keep it, give this a `name`"
            diagnostics.warning(rules.HAND, node.location, message, hint)
            return


def _warn_of_forced(root: Node, diagnostics: Diagnostics) -> None:
    """Of a task whose work cannot fail, as all of it is below one `force_success`."""
    forced = [one for one in nodes_below(root) if one.modifiers.get("force_success")]
    below = list(all_leaves(forced[0])) if len(forced) == 1 else []
    others = [one for one in all_leaves(root) if one not in below and not _prepares(one)]
    if any(leaf.type.moves for leaf in below) and not others:
        message = f"the task succeeds whatever happens: all its work is in `{forced[0].name}`"
        hint = "put `force_success` only beside what may fail without harm"
        diagnostics.warning(rules.FORCED, forced[0].location, message, hint)


def _prepares(leaf: LeafNode) -> bool:
    """Whether a leaf does no work of its own: it cannot fail, folds the arm or opens the hand."""
    says = leaf.type
    return not says.can_fail or says.key == "open_gripper" or says.base_rests
