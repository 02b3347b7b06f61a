"""A task file that has been read and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from py_trees.behaviour import Behaviour

from trees.language.build import LeafMaker, build_task, real_leaf
from trees.language.kinds import Named, ValueType
from trees.language.mistakes import Mistake, Place
from trees.language.parameters import TaskParameter
from trees.language.syntax import Node, SubtreeNode, nodes_below

if TYPE_CHECKING:
    from behaviours.context import Context


@dataclass(frozen=True, kw_only=True)
class TaskOutput:
    """A key that an including file may take over."""

    place: Place
    description: str
    type: ValueType | None = None
    """What the tree writes to it; None before the tree is read."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """A task file without mistakes."""

    name: str
    description: str
    path: Path
    text: str
    """The file as it was read."""
    scene: str
    """The simulated scene that it is written for; empty if any will do."""
    parameters: Mapping[str, TaskParameter]
    poses: Mapping[str, Named]
    """What the file defines: tool poses, base poses and postures."""
    regions: Mapping[str, Named]
    outputs: Mapping[str, TaskOutput]
    root: Node
    warnings: tuple[Mistake, ...] = ()
    """What is probably not meant, and does not keep the task from running."""

    @property
    def files(self) -> tuple[Path, ...]:
        """This file and those of its subtrees, each once."""
        inner = (node.task for node in nodes_below(self.root) if isinstance(node, SubtreeNode))
        paths = (self.path, *(path for task in inner for path in task.files))
        return tuple(dict.fromkeys(paths))

    def build(self, context: Context, make_leaf: LeafMaker = real_leaf) -> Behaviour:
        """A fresh tree, ready to tick, on the context's clock.

        Args:
            context: what all leaves share.
            make_leaf: makes a leaf from its node, the context and its arguments.

        Raises:
            TaskFileError: a leaf refused its parameters, or a parameter has no value.
        """
        return build_task(self, context, make_leaf)
