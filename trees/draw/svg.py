"""A tree as an SVG picture: the root left, children right of their parent and one below another.

Leaves are stacked in the order of the file and a parent stands in the middle of its children, so no
two boxes touch and no two edges cross.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from html import escape

from trees.draw.box import Box

_COLOURS = {
    "composite": ("#e8eefc", "#4a6fc4"),
    "action": ("#e6f5ec", "#2f8f57"),
    "condition": ("#fdf3dc", "#c08a1e"),
    "subtree": ("#f1e8fa", "#8352b8"),
}
"""Fill and line, by category."""
_CHARACTER = 7.3  # breadth of a letter of the monospaced font at `_SIZE` [px]
_SIZE = 12
_LINE = 16.0
_PADDING = 9.0
_ACROSS, _DOWN = 44.0, 12.0  # gaps between columns and between boxes of a column [px]
_MARGIN = 16.0
_LONGEST = 46  # longer lines end in an ellipsis


@dataclass(frozen=True)
class _Placed:
    """A box and its position [px]."""

    box: Box
    lines: tuple[str, ...]
    depth: int
    top: float
    children: tuple[_Placed, ...]

    @property
    def height(self) -> float:
        return _height(self.lines)

    @property
    def middle(self) -> float:
        return self.top + self.height / 2.0

    @property
    def width(self) -> float:
        return _CHARACTER * max(map(len, self.lines)) + 2.0 * _PADDING

    def all(self) -> Iterator[_Placed]:
        """This one and all below it."""
        yield self
        for child in self.children:
            yield from child.all()


def svg(root: Box) -> str:
    """The picture of the tree below a box."""
    placed = _place(root, 0, _MARGIN)
    everything = list(placed.all())
    lefts = _columns(everything)
    width = max(lefts[node.depth] + node.width for node in everything) + _MARGIN
    height = max(node.top + node.height for node in everything) + _MARGIN
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" font-size="{_SIZE}" '
        'font-family="ui-monospace, SFMono-Regular, Menlo, Consolas, monospace">',
        f"<title>{_text(root.title)}</title>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
        *(_edge(node, child, lefts) for node in everything for child in node.children),
        *(part for node in everything for part in _drawn(node, lefts[node.depth])),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _place(box: Box, depth: int, top: float) -> _Placed:
    """The box and all below it, none above `top`."""
    children: list[_Placed] = []
    bottom = top
    for child in box.children:
        children.append(_place(child, depth + 1, bottom))
        bottom = max(node.top + node.height for node in children[-1].all()) + _DOWN
    kind = () if box.key == box.title else (box.key,)
    lines = tuple(
        _shortened(line)
        for line in (f"{box.symbol} {box.title}", *kind, *box.arguments, *box.modifiers)
    )
    if not children:
        return _Placed(box, lines, depth, top, ())
    wanted = (children[0].middle + children[-1].middle - _height(lines)) / 2.0
    if wanted < top:  # taller than what stands beside it: those move down instead
        children = [_moved(child, top - wanted) for child in children]
    return _Placed(box, lines, depth, max(wanted, top), tuple(children))


def _moved(node: _Placed, down: float) -> _Placed:
    children = tuple(_moved(child, down) for child in node.children)
    return replace(node, top=node.top + down, children=children)


def _height(lines: tuple[str, ...]) -> float:
    return _LINE * len(lines) + _PADDING


def _columns(everything: list[_Placed]) -> list[float]:
    """The left edge of each depth."""
    lefts = [_MARGIN]
    for depth in range(max(node.depth for node in everything)):
        widest = max(node.width for node in everything if node.depth == depth)
        lefts.append(lefts[-1] + widest + _ACROSS)
    return lefts


def _edge(parent: _Placed, child: _Placed, lefts: list[float]) -> str:
    x, y = lefts[parent.depth] + parent.width, parent.middle
    end_x, end_y = lefts[child.depth], child.middle
    half = (x + end_x) / 2.0
    return (
        f'<path d="M{x:.1f} {y:.1f} C{half:.1f} {y:.1f} {half:.1f} {end_y:.1f} '
        f'{end_x:.1f} {end_y:.1f}" fill="none" stroke="#9aa1ad" stroke-width="1.3"/>'
    )


def _drawn(node: _Placed, left: float) -> Iterator[str]:
    fill, line_colour = _COLOURS[node.box.category]
    yield (
        f'<rect x="{left:.1f}" y="{node.top:.1f}" width="{node.width:.1f}" '
        f'height="{node.height:.1f}" rx="5" fill="{fill}" stroke="{line_colour}"/>'
    )
    modifiers_from = len(node.lines) - len(node.box.modifiers)
    for number, line in enumerate(node.lines):
        y = node.top + _LINE * (number + 1) - 1.0
        style = ' font-weight="bold" fill="#1c1f26"' if number == 0 else ' fill="#525866"'
        if number >= modifiers_from > 0:
            style = ' font-style="italic" fill="#8a4b08"'
        yield f'<text x="{left + _PADDING:.1f}" y="{y:.1f}"{style}>{_text(line)}</text>'


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def _text(text: str) -> str:
    """The text as XML; what XML does not allow is left out."""
    return escape("".join(c for c in text if c.isprintable()))
