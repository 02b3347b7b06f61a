"""A task as a picture: indented text, SVG or a Mermaid flowchart."""

from collections.abc import Callable, Mapping

from trees.draw.box import Box, boxes
from trees.draw.formats import mermaid, text
from trees.draw.svg import svg

FORMATS: Mapping[str, Callable[[Box], str]] = {"text": text, "svg": svg, "mermaid": mermaid}
"""What draws a box and all below it, by name."""

__all__ = ["FORMATS", "Box", "boxes"]
