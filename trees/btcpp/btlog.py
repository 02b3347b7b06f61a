"""A run as a `.btlog`, which Groot2 replays: the tree, then every change of a node's status.

The layout is that of BehaviorTree.CPP 4's `FileLogger2`: a magic text, a version, the length of the
tree's XML and the XML itself, the time of the first record, and 9 bytes a change (time since then
in 6, the node's number in 2, its status in 1), all little-endian.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from xml.etree import ElementTree

from py_trees.common import Status

from trees.btcpp.ports import TAGS
from trees.language import TreeNode

MAGIC = b"BTCPP4-FileLogger2"
VERSION = 1

_STATUS = {Status.INVALID: 0, Status.RUNNING: 1, Status.SUCCESS: 2, Status.FAILURE: 3}


class BtLog:
    """The log of one run, piece by piece.

    Args:
        nodes: of the built tree, in preorder.
    """

    def __init__(self, nodes: Sequence[TreeNode]) -> None:
        self._nodes = [entry.node for entry in nodes]
        self._before = [Status.INVALID] * len(self._nodes)
        xml = tree_xml(nodes).encode()
        began = struct.pack("<q", 0)  # a session's clock begins at 0
        self.head = MAGIC + struct.pack("<Bi", VERSION, len(xml)) + xml + began
        """What the file begins with."""

    def changes(self, stamp: float) -> bytes:
        """What the file goes on with: the statuses that have changed since the last call.

        Args:
            stamp: the session's time [s].
        """
        records = []
        for number, node in enumerate(self._nodes):
            if node.status is not self._before[number]:
                self._before[number] = node.status
                records.append(
                    round(1e6 * stamp).to_bytes(6, "little")
                    + struct.pack("<HB", number + 1, _STATUS[node.status])
                )
        return b"".join(records)


def tree_xml(nodes: Sequence[TreeNode]) -> str:
    """The built tree as Groot2 draws it: each node with its number, counted from 1 in preorder."""
    root = ElementTree.Element("root", BTCPP_format="4", main_tree_to_execute="Main")
    tree = ElementTree.SubElement(root, "BehaviorTree", ID="Main", _fullpath="")
    above = [tree]
    models: dict[str, str] = {}
    for number, entry in enumerate(nodes, start=1):
        node = entry.node
        key = str(getattr(node, "key", type(node).__name__))
        tag = TAGS.get(key, key)
        if tag == key:
            models[tag] = ("Action", "Decorator", "Control")[min(len(node.children), 2)]
        del above[entry.depth + 1 :]
        above.append(
            ElementTree.SubElement(above[-1], tag, name=_printable(node.name), _uid=str(number))
        )
    model = ElementTree.SubElement(root, "TreeNodesModel")
    for tag, category in sorted(models.items()):
        ElementTree.SubElement(model, category, ID=tag)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode")


def _printable(text: str) -> str:
    """The text without what XML does not allow."""
    return "".join(letter if letter.isprintable() else " " for letter in text)
