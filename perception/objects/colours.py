"""Names of colours, by hue, saturation and value.

Light moves objects across the limits: a name is only as good as the light is white.
"""

from colorsys import rgb_to_hsv
from typing import Literal, TypeAlias, get_args

ColourName: TypeAlias = Literal[
    "red", "orange", "yellow", "green", "blue", "purple", "pink", "brown", "white", "grey", "black"
]
COLOURS: tuple[ColourName, ...] = get_args(ColourName)

BLACK = 0.2  # darker than this value is black
GREY = 0.17  # less saturated than this is grey, or white ...
WHITE = 0.85  # ... from this value on
BROWN = 0.5  # orange or yellow of less saturation times value than this is brown
PINK = 0.5  # red of less saturation than this is pink, if its value is at least ...
LIGHT = 0.7  # ... this
HUES: tuple[tuple[float, ColourName], ...] = (
    (13.0, "red"),
    (42.0, "orange"),
    (70.0, "yellow"),
    (175.0, "green"),
    (255.0, "blue"),
    (300.0, "purple"),
    (335.0, "pink"),
    (360.0, "red"),
)
"""Largest hue of each name [deg]."""


_RING: tuple[ColourName, ...] = ("red", "orange", "yellow", "green", "blue", "purple", "pink")


def differ(one: ColourName, other: ColourName) -> bool:
    """Whether no light makes one colour seem the other: they are far apart on the ring of hues."""
    if one not in _RING or other not in _RING:
        return False
    apart = abs(_RING.index(one) - _RING.index(other))
    return min(apart, len(_RING) - apart) >= 3


def colour_name(red: float, green: float, blue: float) -> ColourName:
    """The name of a colour; red, green and blue are of 255."""
    hue, saturation, value = rgb_to_hsv(red / 255.0, green / 255.0, blue / 255.0)
    if value < BLACK:
        return "black"
    if saturation < GREY:
        return "white" if value >= WHITE else "grey"
    name = next(name for end, name in HUES if 360.0 * hue <= end)
    if name in ("orange", "yellow") and saturation * value < BROWN:
        return "brown"
    if name == "red" and saturation < PINK and value >= LIGHT:
        return "pink"
    return name
