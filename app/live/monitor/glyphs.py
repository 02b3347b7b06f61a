"""Colours and characters of the drawings.

The viewer's font is Inter. Without a window the viewer crashes on a character that the font lacks,
so all foreign text (names, messages) passes `printable` first.
"""

from app.live.nodes import Look

Colour = tuple[int, int, int]

LOOK_COLOUR: dict[Look, Colour] = {
    Look.RUNNING: (52, 120, 230),
    Look.SUCCESS: (38, 140, 64),
    Look.NOT_YET: (184, 120, 16),
    Look.FAILURE: (214, 58, 48),
    Look.IDLE: (72, 77, 86),
}
KIND_GLYPH = {
    "sequence": "→",
    "fallback": "?",
    "parallel": "‖",
    "forever": "↻",
    "until": "↻",
    "retry": "↻",
    "repeat": "↻",
    "not": "¬",
    "timeout": "◇",
}
"""Marks of composites and modifiers; leaves have none."""

MISSING = "□"

SYMBOLS = frozenset("→⇒↻↺↔◇◆○●□■△▲▶▷✔✓✗×·•‖⚠★¬°±…–—“”‘’²³½≤≥≠≈∞√∑ΩµÅ€")
LETTERS = (
    (0x20, 0x7E),
    (0xC0, 0x148),
    (0x14A, 0x17E),
    (0x391, 0x3A1),
    (0x3A3, 0x3CE),
    (0x410, 0x44F),
)
"""Ranges of code points that the font contains completely: Latin, Greek and Cyrillic."""


def printable(text: str) -> str:
    """The text on one line, in characters that the viewer can draw."""
    line = " ".join(text.split())
    return "".join(
        character
        if character in SYMBOLS or any(low <= ord(character) <= high for low, high in LETTERS)
        else MISSING
        for character in line
    )
