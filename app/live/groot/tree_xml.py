"""The XML of a tree for Groot2: nodes numbered in preorder, and their models."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from xml.etree import ElementTree

from app.live.nodes import NodeInfo, parents
from trees.btcpp import TAGS
from trees.language import COMPOSITES


def tree_xml(task: str, tree: Sequence[NodeInfo]) -> str:
    """The XML of the tree of a task; `tree` has its nodes in preorder."""
    root = ElementTree.Element("root", BTCPP_format="4", main_tree_to_execute=task)
    top = ElementTree.SubElement(root, "BehaviorTree", ID=task, _fullpath="")
    above = parents(tree)
    children = Counter(above)
    elements: list[ElementTree.Element] = []
    models = set()
    for index, (node, parent) in enumerate(zip(tree, above, strict=True)):
        tag = TAGS.get(node.kind, node.kind or "node")
        models.add((_category(node.kind, children[index]), tag))
        place = top if parent is None else elements[parent]
        elements.append(ElementTree.SubElement(place, tag, name=node.name, _uid=str(index + 1)))
    listed = ElementTree.SubElement(root, "TreeNodesModel")
    for category, tag in sorted(models):
        ElementTree.SubElement(listed, category, ID=tag)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode")


def _category(kind: str, children: int) -> str:
    word = COMPOSITES.get(kind)
    if children > 1 or (word is not None and word.most != 1):
        return "Control"
    return "Decorator" if children else "Action"
