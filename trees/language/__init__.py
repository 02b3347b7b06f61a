"""The tree language: task files in YAML, checked completely, built into py_trees behaviours.

`load` reads a file into a `Task` or raises every diagnostic in it at once, each with line, column
and how to fix it; `build` makes the tree. Leaves are classes with typed constructors (see
`registry`), the other words of the language are listed in `vocabulary`.
"""

from trees.language.build import build
from trees.language.diagnostics import Diagnostic, Location, Severity, TaskFileError
from trees.language.load import check, load
from trees.language.registry import LeafError, LeafType, describe_leaves, known_leaves
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode, Task
from trees.language.tree_nodes import TreeNode, nodes_in_order
from trees.language.vocabulary import COMPOSITES, MODIFIERS

__all__ = [
    "COMPOSITES",
    "MODIFIERS",
    "CompositeNode",
    "Diagnostic",
    "LeafError",
    "LeafNode",
    "LeafType",
    "Location",
    "Node",
    "Severity",
    "SubtreeNode",
    "Task",
    "TaskFileError",
    "TreeNode",
    "build",
    "check",
    "describe_leaves",
    "known_leaves",
    "load",
    "nodes_in_order",
]
