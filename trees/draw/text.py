"""A tree as indented text, one node a line."""

from __future__ import annotations

from collections.abc import Iterator

from trees.draw.box import Box


def text(root: Box) -> str:
    """The tree below a box; every line ends in a line break."""
    return "".join(f"{line}\n" for line in _lines(root, "", ""))


def _lines(box: Box, first: str, later: str) -> Iterator[str]:
    """The lines of a box and of all below it.

    Args:
        box: the box.
        first: the text before its own line.
        later: the text before the lines of its children.
    """
    kind = "" if box.key == box.title else f" ({box.key})"
    details = "".join(f"  {detail}" for detail in box.arguments)
    modifiers = "".join(f"  [{modifier}]" for modifier in box.modifiers)
    yield f"{first}{box.symbol} {box.title}{kind}{details}{modifiers}"
    for position, child in enumerate(box.children, start=1):
        is_last = position == len(box.children)
        yield from _lines(
            child, later + ("└─ " if is_last else "├─ "), later + ("   " if is_last else "│  ")
        )
