"""What is written well and cannot be meant: movers side by side, short times, endless rounds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from config import Diagnostics
from trees.language.flow import Fact
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode, nodes_below
from trees.language.vocabulary import COMPOSITES, MODIFIERS


def check_meaning(root: Node, facts: Mapping[int, Fact], diagnostics: Diagnostics) -> bool:
    """Note what cannot be meant; only two movers at the same time are an error.

    Args:
        root: the tree of one file.
        facts: what is known about its nodes.
        diagnostics: of the file.

    Returns:
        Whether there is no error.
    """
    sound = True
    for node in nodes_below(root):
        if facts[id(node)].before is None:
            continue
        if isinstance(node, CompositeNode):
            sound &= not _note_movers(node, diagnostics)
            _warn_of_endless(node, facts, diagnostics)
        _warn_of_lost_retry(node, diagnostics)
        _warn_of_short_times(node, diagnostics)
    return sound


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
        diagnostics.error(child.location, message, hint)
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
    """Of rounds that begin again although nothing in them can ever end them well."""
    child = node.children[0]
    if COMPOSITES[node.key].takes_time and facts[id(child)].ends.success is None:
        message = f"`{node.key}` cannot succeed: `{child.name}` never does"
        hint = "put something that can succeed first, or a `timeout_s` beside it"
        if "timeout_s" not in node.modifiers:
            diagnostics.warning(node.location, message, hint)


def _warn_of_lost_retry(node: Node, diagnostics: Diagnostics) -> None:
    """Of attempts that end with the first failure of a guard."""
    if "retry" in node.modifiers and "while" in node.modifiers:
        message = f"`while` ends all attempts of `{node.name}`: what it stops is not tried again"
        hint = "put it on a node below the `retry`; if it is meant, on a `sequence` around"
        diagnostics.warning(node.location, message, hint)


def _warn_of_short_times(node: Node, diagnostics: Diagnostics) -> None:
    """Of a timeout that is over before the node can have succeeded."""
    least = _least_time_inside(node)
    for key, value in node.modifiers.items():
        if key == "timeout_s" and isinstance(value, int | float) and least >= value:
            message = f"`timeout_s: {value:g}` is over before `{node.name}` can succeed"
            hint = f"it waits for {least:g} s; give it more time"
            diagnostics.warning(node.location, message, hint)
        least = MODIFIERS[key].lasts(least, value)


def _least_time(node: Node) -> float:
    """How long a node with its modifiers takes at least until it succeeds [s]."""
    least = _least_time_inside(node)
    for key, value in node.modifiers.items():
        least = MODIFIERS[key].lasts(least, value)
    return least


def _least_time_inside(node: Node) -> float:
    """The same without its modifiers [s]."""
    if isinstance(node, SubtreeNode):
        return _least_time(node.task.root)
    if isinstance(node, CompositeNode):
        times = [_least_time(child) for child in node.children]
        return COMPOSITES[node.key].lasts(times, node.options)
    seconds = node.arguments.get(node.type.duration)
    return seconds if isinstance(seconds, int | float) else 0.0
