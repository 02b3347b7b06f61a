"""Content of the picture of a task: a box per node, with name, arguments and modifiers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple

from config import written
from trees.language import (
    COMPOSITES,
    SUBTREE,
    Argument,
    CompositeNode,
    KeyRead,
    KeyWrite,
    LeafNode,
    Node,
)


class Category(Enum):
    """What a node is; each has a colour."""

    COMPOSITE = "composite"
    ACTION = "action"
    CONDITION = "condition"
    SUBTREE = "subtree"


class Colour(NamedTuple):
    """How a box is painted."""

    fill: str
    line: str


COLOURS: Mapping[Category, Colour] = MappingProxyType(
    {
        Category.COMPOSITE: Colour("#e8eefc", "#4a6fc4"),
        Category.ACTION: Colour("#e6f5ec", "#2f8f57"),
        Category.CONDITION: Colour("#fdf3dc", "#c08a1e"),
        Category.SUBTREE: Colour("#f1e8fa", "#8352b8"),
    }
)

_SYMBOLS: Mapping[Category, str] = MappingProxyType(
    {Category.ACTION: "•", Category.CONDITION: "○", Category.SUBTREE: "▣"}
)


@dataclass(frozen=True, kw_only=True)
class Box:
    """One node as it is drawn."""

    category: Category
    key: str
    """The node's key in the task file."""
    title: str
    """Its name, which is its key unless the file says otherwise."""
    symbol: str
    arguments: tuple[str, ...]
    modifiers: tuple[str, ...]
    """Innermost first."""
    children: tuple[Box, ...] = ()


def boxes(node: Node) -> Box:
    """The box of a node and of everything below it, the trees of other files included."""
    modifiers = tuple(
        key if value is True else _pair(key, value) for key, value in node.modifiers.items()
    )
    if isinstance(node, LeafNode):
        category = Category.CONDITION if node.type.is_condition else Category.ACTION
        key = node.type.key
        children: tuple[Box, ...] = ()
        outputs = {} if node.type.names_keys else node.outputs  # its arguments are its outputs
        arguments = [*_pairs(node.arguments), *_written_keys(outputs)]
    elif isinstance(node, CompositeNode):
        category = Category.CONDITION if COMPOSITES[node.key].asks else Category.COMPOSITE
        key = node.key
        children = tuple(boxes(child) for child in node.children)
        arguments = [*_pairs(node.options)]
        arguments += [f"cases: {', '.join(node.cases)}"] if node.cases else []
    else:
        category, key = Category.SUBTREE, SUBTREE
        children = (boxes(node.task.root),)
        arguments = [node.file, *_pairs(node.arguments), *_written_keys(node.outputs)]
    symbol = COMPOSITES[key].symbol if key in COMPOSITES else _SYMBOLS[category]
    return Box(
        category=category,
        key=key,
        title=node.name,
        symbol=symbol,
        arguments=tuple(arguments),
        modifiers=modifiers,
        children=children,
    )


def _pairs(values: Mapping[str, Argument]) -> Iterable[str]:
    return (_pair(key, value) for key, value in values.items())


def _pair(key: str, value: object) -> str:
    return f"{key}: {_short(value)}"


def _written_keys(outputs: Mapping[str, KeyWrite]) -> Iterable[str]:
    return (f"{output} → ${key.name}" for output, key in outputs.items())


def _short(value: object) -> str:
    """A value as the task file has it, in short."""
    if isinstance(value, CompositeNode):
        return f"{value.key}({', '.join(map(_short, value.children))})"
    if isinstance(value, LeafNode):
        arguments = ", ".join(_pairs(value.arguments))
        return f"{value.type.key} {arguments}".strip()
    if value is None or isinstance(value, bool | int | float | str):
        return written(value)
    return str(value) if isinstance(value, KeyRead) else str(getattr(value, "name", value))
