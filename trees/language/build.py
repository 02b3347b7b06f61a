"""From what a task file says to behaviours that can be ticked."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from py_trees.behaviour import Behaviour

from trees.language.mistakes import Mistake, TaskFileError
from trees.language.syntax import CompositeNode, LeafNode, Node
from trees.language.vocabulary import COMPOSITES, MODIFIERS

if TYPE_CHECKING:
    from behaviours.context import Context


def build(node: Node, context: Context, path: Path) -> Behaviour:
    """The behaviours of a node and of everything below it.

    Args:
        node: a checked node.
        context: what all leaves share; its clock is the time of every modifier.
        path: the file, for messages.

    Raises:
        TaskFileError: a leaf refused its arguments with a ValueError.
    """
    if isinstance(node, CompositeNode):
        children = [build(child, context, path) for child in node.children]
        behaviour: Behaviour = COMPOSITES[node.key].node(node.name, children)
    else:
        behaviour = _leaf(node, context, path)
    for key, word in MODIFIERS.items():
        if key in node.modifiers:
            behaviour = word.wrap(behaviour, node.modifiers[key], context.clock.now)
    return behaviour


def _leaf(node: LeafNode, context: Context, path: Path) -> Behaviour:
    try:
        return node.type.behaviour(node.name, context, **node.arguments)
    except ValueError as error:
        what = f"`{node.type.key}` refuses its parameters: {error}"
        mistake = Mistake(path=path, place=node.place, what=what, mend="change them")
        raise TaskFileError([mistake]) from error
