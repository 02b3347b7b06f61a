"""A task as a picture: indented text for a terminal, SVG for people, Mermaid for documents.

`box` holds the content of a picture; `text`, `svg` and `mermaid` draw it.
"""

from collections.abc import Callable, Mapping

from trees.draw.box import Box, boxes
from trees.draw.mermaid import mermaid
from trees.draw.svg import svg
from trees.draw.text import text

FORMATS: Mapping[str, Callable[[Box], str]] = {"text": text, "svg": svg, "mermaid": mermaid}
"""What draws a box and all below it, by name."""

__all__ = ["FORMATS", "Box", "boxes"]
