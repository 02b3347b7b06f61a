"""What reaches the terminal: text, and never a control sequence that came with it."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment


def visible(text: str) -> str:
    r"""The text with every character that is none on a screen as an escape, as `\x1b`.

    Line ends and tabs stay. Control characters, invisible and bidirectional marks, and halves of
    surrogate pairs, which no terminal can encode, are written out.
    """
    if text.isprintable():
        return text
    return "".join(
        letter
        if letter.isprintable() or letter in "\n\t"
        else letter.encode("unicode_escape").decode("ascii")
        for letter in text
    )


class Terminal(Console):
    """The one way to print. Text is taken literally, and is made `visible`.

    Args:
        stderr: write to standard error.
        more: for the console of `rich`.
    """

    def __init__(self, *, stderr: bool = False, **more: Any) -> None:
        super().__init__(stderr=stderr, markup=False, highlight=False, emoji=False, **more)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """The segments of something to print, with visible text."""
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable():
                yield segment
            else:
                yield Segment(visible(segment.text), segment.style)

    def on_broken_pipe(self) -> None:
        """Nobody reads any more: be silent. `rich` would end the process with a code of its own."""
        os.dup2(os.open(os.devnull, os.O_WRONLY), self.file.fileno())
        self.quiet = True

    def say(self, text: str) -> None:
        """Print text as it is, without breaking its lines."""
        self.print(text, soft_wrap=True)
