"""A run as a `.btlog`, which Groot2 replays: the tree, then every change of a node's status.

The layout is that of BehaviorTree.CPP 4's `FileLogger2`: a magic text, a version, the length of the
tree's XML and the XML itself, the time of the first record, and 9 bytes a change (time since then
in 6, the node's number in 2, its status in 1), all little-endian.
"""

import struct
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree

from py_trees.common import Status

from trees.btcpp.ports import TAGS
from trees.language import COMPOSITES, TreeNode

MAGIC = b"BTCPP4-FileLogger2"
VERSION = 1

STATUS_CODES = {Status.INVALID: 0, Status.RUNNING: 1, Status.SUCCESS: 2, Status.FAILURE: 3}


class BtLog:
    """The log of one run, piece by piece; `nodes` of the built tree are in preorder."""

    def __init__(self, nodes: Sequence[TreeNode]) -> None:
        self._nodes = [entry.node for entry in nodes]
        self._before = [Status.INVALID] * len(self._nodes)
        named = [(n.node.name, str(getattr(n.node, "key", "")), n.depth) for n in nodes]
        xml = tree_xml("Main", named).encode()
        began = struct.pack("<q", 0)  # a session's clock begins at 0
        self.head = MAGIC + struct.pack("<Bi", VERSION, len(xml)) + xml + began
        """What the file begins with."""

    def changes(self, stamp: float) -> bytes:
        """What the file goes on with: statuses changed since the last call; `stamp` in s."""
        records = []
        for number, node in enumerate(self._nodes):
            if node.status is not self._before[number]:
                self._before[number] = node.status
                records.append(
                    round(1e6 * stamp).to_bytes(6, "little")
                    + struct.pack("<HB", number + 1, STATUS_CODES[node.status])
                )
        return b"".join(records)


def tree_xml(task: str, nodes: Iterable[tuple[str, str, int]]) -> str:
    """A built tree as Groot2 draws it: each node with its number, counted from 1 in preorder.

    `nodes` are name, key and depth of each.
    """
    root = ElementTree.Element("root", BTCPP_format="4", main_tree_to_execute=task)
    above = [ElementTree.SubElement(root, "BehaviorTree", ID=task, _fullpath="")]
    drawn: list[tuple[str, ElementTree.Element]] = []
    for number, (name, key, depth) in enumerate(nodes, start=1):
        del above[depth + 1 :]
        about = {"name": _printable(name), "_uid": str(number)}
        above.append(ElementTree.SubElement(above[-1], TAGS.get(key, key or "node"), about))
        drawn.append((key, above[-1]))
    models = ElementTree.SubElement(root, "TreeNodesModel")
    for category, tag in sorted({(_category(key, len(node)), node.tag) for key, node in drawn}):
        ElementTree.SubElement(models, category, ID=tag)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode")


def _category(key: str, children: int) -> str:
    if children > 1 or (key in COMPOSITES and COMPOSITES[key].most != 1):
        return "Control"
    return "Decorator" if children else "Action"


def _printable(text: str) -> str:
    """The text without what XML does not allow."""
    return "".join(letter if letter.isprintable() else " " for letter in text)
