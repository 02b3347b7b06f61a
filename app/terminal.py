"""Terminal output without control sequences of foreign text, and waiting for Ctrl-C."""

import os
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment


def visible(text: str) -> str:
    r"""The text with control and invisible characters as escapes, for example `\x1b`.

    Line ends and tabs stay; halves of surrogate pairs, which cannot be encoded, are escaped too.
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
    """Console that prints text literally and makes it `visible`."""

    def __init__(self, *, stderr: bool = False, **more: Any) -> None:
        super().__init__(stderr=stderr, markup=False, highlight=False, emoji=False, **more)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """The segments of a renderable, with visible text."""
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable():
                yield segment
            else:
                yield Segment(visible(segment.text), segment.style)

    def on_broken_pipe(self) -> None:
        """Be silent when nobody reads; `rich` would end the process."""
        os.dup2(os.open(os.devnull, os.O_WRONLY), self.file.fileno())
        self.quiet = True

    def say(self, text: str) -> None:
        """Print text without breaking its lines."""
        self.print(text, soft_wrap=True)


_PERIOD = 0.5  # longest time until an interrupt is noticed [s]


@contextmanager
def until_interrupted() -> Iterator[None]:
    """Run the body of the context, then wait for Ctrl-C, which may come at any time.

    `signal.pause` and waiting without a limit miss a signal that another thread receives or that
    comes just before the call.
    """
    try:
        yield
        while True:
            time.sleep(_PERIOD)
    except KeyboardInterrupt:
        pass
