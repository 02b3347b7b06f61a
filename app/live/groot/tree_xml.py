"""The XML of a tree for Groot2: nodes numbered in preorder, and their models."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple
from xml.etree import ElementTree

from app.live.nodes import NodeInfo
from trees.btcpp import TAGS
from trees.language import COMPOSITES


class _Model(NamedTuple):
    category: str
    name: str


def tree_xml(task: str, tree: Sequence[NodeInfo]) -> str:
    """The XML of the tree of a task; `tree` has its nodes in preorder."""
    root = ElementTree.Element("root", BTCPP_format="4", main_tree_to_execute=task)
    ancestors = [ElementTree.SubElement(root, "BehaviorTree", ID=task, _fullpath="")]
    models = set()
    for index, node in enumerate(tree):
        del ancestors[node.depth + 1 :]
        children = len(_children(tree, index))
        model = _model(node.kind, children)
        models.add(model)
        element = ElementTree.SubElement(
            ancestors[-1], model.name, name=node.name, _uid=str(index + 1)
        )
        ancestors.append(element)
    listed = ElementTree.SubElement(root, "TreeNodesModel")
    for model in sorted(models):
        ElementTree.SubElement(listed, model.category, ID=model.name)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode")


def _model(kind: str, children: int) -> _Model:
    """The model of a node: BehaviorTree.CPP's name for it where it has one."""
    word = COMPOSITES.get(kind)
    is_control = children > 1 or (word is not None and word.most != 1)
    category = "Control" if is_control else "Decorator" if children else "Action"
    return _Model(category, TAGS.get(kind, kind or "node"))


def _children(tree: Sequence[NodeInfo], index: int) -> Sequence[NodeInfo]:
    below = []
    for node in tree[index + 1 :]:
        if node.depth <= tree[index].depth:
            break
        if node.depth == tree[index].depth + 1:
            below.append(node)
    return below
