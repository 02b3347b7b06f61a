"""A tree as a Mermaid flowchart, for Markdown pages that draw themselves."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from trees.draw.box import COLOURS, Box


def mermaid(root: Box) -> str:
    """The flowchart of the tree below a box."""
    styles = [
        f"  classDef {category.value} fill:{colour.fill},stroke:{colour.line},color:#1c1f26"
        for category, colour in COLOURS.items()
    ]
    lines = ["flowchart TD", *_lines(root, (f"n{number}" for number in count())), *styles]
    return "\n".join(lines) + "\n"


def _lines(box: Box, names: Iterator[str]) -> Iterator[str]:
    name = next(names)
    kind = [] if box.key == box.title else [box.key]
    label = "<br/>".join(
        _escaped(line)
        for line in (f"{box.symbol} {box.title}", *kind, *box.arguments, *box.modifiers)
    )
    yield f'  {name}["{label}"]:::{box.category.value}'
    for child in box.children:
        below = list(_lines(child, names))
        yield f"  {name} --> {below[0].split('[')[0].strip()}"
        yield from below


def _escaped(text: str) -> str:
    """Everything but letters, digits and harmless marks as Mermaid's character codes."""
    return "".join(c if c.isalnum() or c in " _-.,:/()" else f"#{ord(c)};" for c in text)
