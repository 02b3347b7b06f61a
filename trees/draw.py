"""A task as indented text: a line per node with name, arguments and modifiers."""

from collections.abc import Iterator, Mapping

from config import written
from trees.language import Argument, CompositeNode, KeyRead, KeyWrite, LeafNode, Node

_ACTION, _CONDITION, _SUBTREE = "•", "○", "▣"


def tree_text(root: Node) -> str:
    """The tree below a node, those of other files included; every line ends in a line break."""
    return "".join(f"{line}\n" for line in _lines(root, "", ""))


def _lines(node: Node, first: str, later: str) -> Iterator[str]:
    """The line of a node after the prefix `first`, and those of its children after `later`."""
    children: tuple[Node, ...] = ()
    if isinstance(node, LeafNode):
        key, symbol = node.type.key, _CONDITION if node.type.is_condition else _ACTION
        outputs = {} if node.type.names_keys else node.outputs  # its arguments are its outputs
        details = [*_pairs(node.arguments), *_written_keys(outputs)]
    elif isinstance(node, CompositeNode):
        key, symbol, children = node.key, node.word.symbol, node.children
        cases = [f"cases: {', '.join(node.cases)}"] if node.cases else []
        details = [*_pairs(node.options), *cases]
    else:
        key, symbol, children = "subtree", _SUBTREE, (node.task.root,)
        details = [node.file, *_pairs(node.arguments), *_written_keys(node.outputs)]
    for word, value in node.modifiers.items():
        details.append(f"[{word}: {_short(value)}]")
    kind = "" if key == node.name else f" ({key})"
    yield "  ".join([f"{first}{symbol} {node.name}{kind}", *details])
    for child in children:
        branch, beside = ("└─ ", "   ") if child is children[-1] else ("├─ ", "│  ")
        yield from _lines(child, later + branch, later + beside)


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
