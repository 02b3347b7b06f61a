"""Warnings about the hand: what is grasped, held and let go in an order that can do something."""

from collections.abc import Sequence
from dataclasses import dataclass
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
from trees.words import COMPOSITES, EMPTY, FULL, UNUSED_HAND, InOrder, Outcome


def check_hand(root: Node, flow: FlowResult, diagnostics: Diagnostics, is_first: bool) -> bool:
    """Whether every leaf may have in the hand what it needs; warns of what is odd.

    Only the first file of a task is judged as a whole.
    """
    leaves = [
        (leaf, node)
        for node in nodes_below(root)
        if not isinstance(node, CompositeNode)
        for leaf in all_leaves(node)
    ]
    judge = _Judge(root=root, flow=flow, diagnostics=diagnostics, leaves=leaves)
    sound = all([judge.leaf(leaf, node) for leaf, node in judge.leaves])
    for node in nodes_below(root):
        judge.conditions(node)
    if is_first:
        judge.end()
        judge.forced()
    return sound


@dataclass(frozen=True, kw_only=True)
class _Judge:
    """What the flow through a file says of its leaves and conditions."""

    root: Node
    flow: FlowResult
    diagnostics: Diagnostics
    leaves: Sequence[tuple[LeafNode, Node]]
    """Each leaf in order, and the node of this file that it is or that includes its file."""

    def since(self, at: Node) -> str:
        """Which leaf before a node has made the hand what it is."""
        before = list(takewhile(lambda one: one[1] is not at, self.leaves))
        made = [one for one in before if one[0].type.hand_after and not one[0].type.is_condition]
        if not made:
            return ""
        leaf, node = made[-1]
        return f": `{leaf.name}` on line {node.location.line} has left it so"

    def leaf(self, leaf: LeafNode, node: Node) -> bool:
        """Whether a leaf can do something with the hand as it is."""
        ways = self.flow.facts[id(leaf)].ways if id(leaf) in self.flow.facts else ()
        needs, warn = leaf.type.hand_before, self.diagnostics.warning
        if leaf.type.is_condition or not needs:
            return True
        if needs == "empty" and any(FULL in way for way in ways):
            message = f"`{leaf.name}` begins with a full hand{self.since(node)}"
            hint = "let go before it, by `place`, `hand_over` or `open_gripper`"
            warn(rules.HAND, node.location, message, hint)
        if needs == "empty" or not any(UNUSED_HAND in way for way in ways):
            return True
        if any(EMPTY in way for way in ways):
            message = f"`{leaf.name}` has nothing in the hand here{self.since(node)}"
            hint = f"put a `grasp` before `{leaf.name}`, or remove what has emptied the hand"
            if all(EMPTY in way for way in ways):
                self.diagnostics.error(rules.HAND, node.location, message, hint)
                return False
        elif any(one.type.hand_before == "empty" for one in all_leaves(self.root)):
            message = f"`{leaf.name}` comes when nothing has been taken"
            hint = "put it behind `grasp`, or ask `holding_object` if the hand may be full before"
        else:
            return True
        parents = (one for one in nodes_below(self.root) if node in getattr(one, "children", ()))
        parent = next(parents, None)
        if isinstance(parent, CompositeNode) and _goes_on(parent) is Outcome.FAILURE:
            why = f"a child of `{parent.key}` starts only when those before it have failed"
            hint = f"{why}: put what follows each other into a `sequence`"
        warn(rules.HAND, node.location, message, hint)
        return True

    def conditions(self, node: Node) -> None:
        """Of those that never hold where they have to, and those that a leaf below ends."""
        asked: list[tuple[str, Node]] = []
        guard = node.modifiers.get("while")
        if isinstance(guard, LeafNode | CompositeNode):
            asked.append(("while", guard))
        if isinstance(node, CompositeNode):
            all_asked = node.children if _goes_on(node) is Outcome.SUCCESS else ()
            question = node.children[:1] if COMPOSITES[node.key].takes_time else ()
            asked += [(node.key, one) for one in (*all_asked, *question) if is_condition(one)]
        for word, condition in asked:
            fact = self.flow.facts[id(condition)]
            if not fact.reached:
                continue
            if fact.outcomes.success is None and "force_failure" not in condition.modifiers:
                message = f"`{condition.name}` never holds here{self.since(node)}"
                hint = "ask it before that, or let `grasp` or `receive` come between"
                self.diagnostics.warning(rules.HAND, condition.location, message, hint)
            elif leaf := self.flow.ends.get(id(condition)):
                message = (
                    f"`{word}` asks `{condition.name}` at every tick, and `{leaf.name}` ends that: "
                    "what it has done counts as a failure"
                )
                hint = f"let `{word}` guard only what comes before `{leaf.name}`"
                self.diagnostics.warning(rules.HAND, condition.location, message, hint)

    def end(self) -> None:
        """Of a task that carries something, succeeds, and still has it in the hand."""
        types = {leaf.type.key: leaf.type for leaf, _ in self.leaves}.values()
        puts = any(one.hand_before == "full" and one.hand_after == "empty" for one in types)
        carries = any(
            any(FULL in way for way in self.flow.facts[id(leaf)].ways)
            and any(isinstance(leaf.arguments.get(name), MapPlace) for name in leaf.type.goes_to)
            for leaf, _ in self.leaves
            if id(leaf) in self.flow.facts
        )
        took = [(leaf, node) for leaf, node in self.leaves if leaf.type.hand_before == "empty"]
        if FULL not in (self.flow.outcomes.success or ()) or not took or not (carries or puts):
            return
        leaf, node = took[-1]
        if leaf.name == leaf.type.key:
            message = f"the task succeeds with what `{leaf.name}` has taken still in the hand"
            hint = "end it with `place` or `hand_over`; if it is to keep it, give this a `name`"
            self.diagnostics.warning(rules.HAND, node.location, message, hint)

    def forced(self) -> None:
        """Of a task whose work cannot fail, as all of it is below one `force_success`."""
        forced = [one for one in nodes_below(self.root) if one.modifiers.get("force_success")]
        if len(forced) != 1 or not any(leaf.type.moves for leaf in all_leaves(forced[0])):
            return
        below = set(map(id, all_leaves(forced[0])))
        if any(id(leaf) not in below and leaf.type.can_fail for leaf, _ in self.leaves):
            return
        message = f"the task succeeds whatever happens: all that can fail is in `{forced[0].name}`"
        hint = "put `force_success` only beside what may fail without harm"
        self.diagnostics.warning(rules.FORCED, forced[0].location, message, hint)


def _goes_on(node: CompositeNode) -> Outcome | None:
    """The outcome of a child after which the next one starts, where they are no conditions."""
    rule = COMPOSITES[node.key].outcomes
    return rule.goes_on if isinstance(rule, InOrder) and not COMPOSITES[node.key].asks else None
