"""What is drawn of a task: a box a node, with its name, its arguments and its modifiers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple

from trees.language.registry import SET
from trees.language.syntax import CompositeNode, LeafNode, Node
from trees.language.value_types import written
from trees.language.values import Given, KeyRead, KeyWrite
from trees.language.vocabulary import SUBTREE


class Kind(Enum):
    """What a node is, told apart by colour."""

    COMPOSITE = "composite"
    ACTION = "action"
    CONDITION = "condition"
    SUBTREE = "subtree"


class Colour(NamedTuple):
    """How a box is painted."""

    fill: str
    line: str


COLOURS: Mapping[Kind, Colour] = MappingProxyType(
    {
        Kind.COMPOSITE: Colour("#e8eefc", "#4a6fc4"),
        Kind.ACTION: Colour("#e6f5ec", "#2f8f57"),
        Kind.CONDITION: Colour("#fdf3dc", "#c08a1e"),
        Kind.SUBTREE: Colour("#f1e8fa", "#8352b8"),
    }
)

_SYMBOLS: Mapping[str, str] = MappingProxyType(
    {
        "sequence": "→",
        "reactive_sequence": "⇉",
        "fallback": "?",
        "reactive_fallback": "⁇",
        "parallel": "‖",
        "forever": "∞",
        "until": "↻",
    }
)
_SYMBOL_OF_KIND: Mapping[Kind, str] = MappingProxyType(
    {Kind.COMPOSITE: "◇", Kind.ACTION: "•", Kind.CONDITION: "○", Kind.SUBTREE: "▣"}
)


@dataclass(frozen=True, kw_only=True)
class Box:
    """One node as it is drawn."""

    kind: Kind
    kind_name: str
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
        kind = Kind.CONDITION if node.type.is_condition else Kind.ACTION
        key = node.type.key
        children: tuple[Box, ...] = ()
        outputs = {} if node.type is SET else node.outputs  # its arguments are its outputs
        arguments = [*_pairs(node.arguments), *_written_keys(outputs)]
    elif isinstance(node, CompositeNode):
        kind, key = Kind.COMPOSITE, node.key
        children = tuple(boxes(child) for child in node.children)
        arguments = [*_pairs(node.options)]
    else:
        kind, key = Kind.SUBTREE, SUBTREE
        children = (boxes(node.task.root),)
        arguments = [node.file, *_pairs(node.arguments), *_written_keys(node.outputs)]
    return Box(
        kind=kind,
        kind_name=key,
        title=node.name,
        symbol=_SYMBOLS.get(key, _SYMBOL_OF_KIND[kind]),
        arguments=tuple(arguments),
        modifiers=modifiers,
        children=children,
    )


def _pairs(values: Mapping[str, Given]) -> Iterable[str]:
    return (_pair(key, value) for key, value in values.items())


def _pair(key: str, value: object) -> str:
    return f"{key}: {_said(value)}"


def _written_keys(outputs: Mapping[str, KeyWrite]) -> Iterable[str]:
    return (f"{output} → ${key.name}" for output, key in outputs.items())


def _said(value: object) -> str:
    """A value as the task file has it, in short."""
    if isinstance(value, LeafNode):
        arguments = ", ".join(_pairs(value.arguments))
        return f"{value.type.key} {arguments}".strip()
    if value is None or isinstance(value, bool | int | float | str):
        return written(value)
    return str(value) if isinstance(value, KeyRead) else str(getattr(value, "name", value))
