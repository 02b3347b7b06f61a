"""Content of the picture of a task, a box per node with name, arguments and modifiers; as text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

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

_SYMBOLS = {"action": "•", "condition": "○", "subtree": "▣"}


@dataclass(frozen=True, kw_only=True)
class Box:
    """One node as it is drawn."""

    category: str  # `composite`, `action`, `condition` or `subtree`
    key: str  # the node's key in the task file
    title: str  # its name, which is its key unless the file says otherwise
    symbol: str
    arguments: tuple[str, ...]
    modifiers: tuple[str, ...]  # innermost first
    children: tuple[Box, ...] = ()


def boxes(node: Node) -> Box:
    """The box of a node and of everything below it, the trees of other files included."""
    children: tuple[Box, ...] = ()
    if isinstance(node, LeafNode):
        category, key = "condition" if node.type.is_condition else "action", node.type.key
        outputs = {} if node.type.names_keys else node.outputs  # its arguments are its outputs
        arguments = [*_pairs(node.arguments), *_written_keys(outputs)]
    elif isinstance(node, CompositeNode):
        category, key = "condition" if COMPOSITES[node.key].asks else "composite", node.key
        children = tuple(boxes(child) for child in node.children)
        arguments = [*_pairs(node.options)]
        arguments += [f"cases: {', '.join(node.cases)}"] if node.cases else []
    else:
        category, key = "subtree", SUBTREE
        children = (boxes(node.task.root),)
        arguments = [node.file, *_pairs(node.arguments), *_written_keys(node.outputs)]
    return Box(
        category=category,
        key=key,
        title=node.name,
        symbol=COMPOSITES[key].symbol if key in COMPOSITES else _SYMBOLS[category],
        arguments=tuple(arguments),
        modifiers=tuple(
            key if value is True else f"{key}: {_short(value)}"
            for key, value in node.modifiers.items()
        ),
        children=children,
    )


def _pairs(values: Mapping[str, Argument]) -> Iterator[str]:
    return (f"{key}: {_short(value)}" for key, value in values.items())


def _written_keys(outputs: Mapping[str, KeyWrite]) -> Iterator[str]:
    return (f"{output} → ${key.name}" for output, key in outputs.items())


def _short(value: object) -> str:
    """A value as the task file has it, in short."""
    if isinstance(value, CompositeNode):
        return f"{value.key}({', '.join(map(_short, value.children))})"
    if isinstance(value, LeafNode):
        return f"{value.type.key} {', '.join(_pairs(value.arguments))}".strip()
    if value is None or isinstance(value, bool | int | float | str):
        return written(value)
    return str(value) if isinstance(value, KeyRead) else str(getattr(value, "name", value))


def text(root: Box) -> str:
    """The tree below a box, indented, one node a line; every line ends in a line break."""
    return "".join(f"{line}\n" for line in _lines(root, "", ""))


def _lines(box: Box, first: str, later: str) -> Iterator[str]:
    """The lines of a box after the prefix `first`, and of those below it after `later`."""
    kind = "" if box.key == box.title else f" ({box.key})"
    details = "".join(f"  {detail}" for detail in box.arguments)
    modifiers = "".join(f"  [{modifier}]" for modifier in box.modifiers)
    yield f"{first}{box.symbol} {box.title}{kind}{details}{modifiers}"
    for position, child in enumerate(box.children, start=1):
        is_last = position == len(box.children)
        branch, beside = ("└─ ", "   ") if is_last else ("├─ ", "│  ")
        yield from _lines(child, later + branch, later + beside)
