"""A tree as indented text, one node a line, and as a Mermaid flowchart."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from trees.draw.box import COLOURS, Box


def text(root: Box) -> str:
    """The tree below a box; every line ends in a line break."""
    return "".join(f"{line}\n" for line in _text_lines(root, "", ""))


def mermaid(root: Box) -> str:
    """The flowchart of the tree below a box."""
    styles = [
        f"  classDef {category.value} fill:{colour.fill},stroke:{colour.line},color:#1c1f26"
        for category, colour in COLOURS.items()
    ]
    numbers = (f"n{number}" for number in count())
    lines = ["flowchart TD", *_mermaid_lines(root, numbers), *styles]
    return "\n".join(lines) + "\n"


def _text_lines(box: Box, first: str, later: str) -> Iterator[str]:
    """The lines of a box after the prefix `first`, and of those below it after `later`."""
    kind = "" if box.key == box.title else f" ({box.key})"
    details = "".join(f"  {detail}" for detail in box.arguments)
    modifiers = "".join(f"  [{modifier}]" for modifier in box.modifiers)
    yield f"{first}{box.symbol} {box.title}{kind}{details}{modifiers}"
    for position, child in enumerate(box.children, start=1):
        is_last = position == len(box.children)
        yield from _text_lines(
            child, later + ("└─ " if is_last else "├─ "), later + ("   " if is_last else "│  ")
        )


def _mermaid_lines(box: Box, names: Iterator[str]) -> Iterator[str]:
    name = next(names)
    kind = [] if box.key == box.title else [box.key]
    label = "<br/>".join(
        _escaped(line)
        for line in (f"{box.symbol} {box.title}", *kind, *box.arguments, *box.modifiers)
    )
    yield f'  {name}["{label}"]:::{box.category.value}'
    for child in box.children:
        below = list(_mermaid_lines(child, names))
        yield f"  {name} --> {below[0].split('[')[0].strip()}"
        yield from below


def _escaped(text: str) -> str:
    """Everything but letters, digits and harmless marks as Mermaid's character codes."""
    return "".join(c if c.isalnum() or c in " _-.,:/()" else f"#{ord(c)};" for c in text)
