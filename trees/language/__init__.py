"""The tree language: task files in YAML, checked completely, built into py_trees behaviours.

`load` reads a file into a `Task` or raises every mistake in it at once, each with line, column
and how to mend it; `build` makes the tree. Leaves are classes with typed constructors (see
`registry`), the other words of the language are listed in `vocabulary`.
"""

from trees.language.build import build
from trees.language.load import check, load
from trees.language.mistakes import Mistake, Place, Severity, TaskFileError
from trees.language.registry import LeafError, LeafType, describe_leaves, known_leaves
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode, Task
from trees.language.vocabulary import COMPOSITES, MODIFIERS
from trees.language.walk import PlacedNode, nodes_in_order

__all__ = [
    "COMPOSITES",
    "MODIFIERS",
    "CompositeNode",
    "LeafError",
    "LeafNode",
    "LeafType",
    "Mistake",
    "Node",
    "Place",
    "PlacedNode",
    "Severity",
    "SubtreeNode",
    "Task",
    "TaskFileError",
    "build",
    "check",
    "describe_leaves",
    "known_leaves",
    "load",
    "nodes_in_order",
]
