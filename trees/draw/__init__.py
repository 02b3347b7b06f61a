"""A task as a picture: indented text or SVG."""

from collections.abc import Callable, Mapping

from trees.draw.box import Box, boxes, text
from trees.draw.svg import svg

FORMATS: Mapping[str, Callable[[Box], str]] = {"text": text, "svg": svg}
"""What draws a box and all below it, by name."""
