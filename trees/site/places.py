"""The places of a task, each with where it is defined and what it is for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from config import Location
from trees.language import LeafNode, NamedValue, SubtreeNode, Task, leaves_at, nodes_below


class Use(NamedTuple):
    """A place that a leaf is given."""

    path: Path
    """Of the file with the leaf."""
    leaf: LeafNode
    parameter: str
    value: NamedValue


class Definition(NamedTuple):
    """Where a file says what a place is."""

    path: Path
    location: Location


def uses(task: Task) -> Iterator[Use]:
    """Every place that a leaf of the task or of its subtrees is given and that is known by now."""
    for node in nodes_below(task.root):
        for leaf in leaves_at(node):
            for parameter, value in leaf.arguments.items():
                if isinstance(value, NamedValue):
                    yield Use(task.path, leaf, parameter, value)
        if isinstance(node, SubtreeNode):
            yield from uses(node.task)


def definitions(task: Task) -> Mapping[int, Definition]:
    """Where the places of a task and its subtrees are defined, by the `id` of the value."""
    found = {
        id(value): Definition(task.site.get(name, task.path), task.locations[name])
        for name, value in (*task.poses.items(), *task.regions.items())
    }
    for node in nodes_below(task.root):
        if isinstance(node, SubtreeNode):
            found |= definitions(node.task)
    return found
