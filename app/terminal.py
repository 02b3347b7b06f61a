"""What reaches the terminal: text, and never a control sequence that came with it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

if TYPE_CHECKING:
    from rich.live import Live


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
    """The one way to print. Text is taken literally, and is made `visible`."""

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


class Loading:
    """What is being loaded, from the first moment on; use it in a `with` statement.

    In a terminal a line that lives, and is gone when all is loaded; elsewhere nothing.

    Args:
        title: what it is loaded for; empty says nothing at all.
        terminal: where to write; standard error by default.
    """

    def __init__(self, title: str = "", terminal: Terminal | None = None) -> None:
        self._title = title
        terminal = terminal or Terminal(stderr=True)
        self._live: Live | None = None
        if title and terminal.is_terminal:
            from rich.live import Live

            self._live = Live(console=terminal, refresh_per_second=10, transient=True)

    def __enter__(self) -> Loading:
        with suppress(OSError):  # nobody reads
            if self._live is not None:
                self._live.start()
                self("the software")
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def __call__(self, what: str) -> None:
        """Show what is being loaded."""
        if self._live is not None:
            from rich.spinner import Spinner

            text = visible(f"{self._title}  loading {what} ...")
            self._live.update(Spinner("dots", text=text, style="cyan"), refresh=True)

    @contextmanager
    def ended(self) -> Iterator[None]:
        """All is loaded."""
        self._end()
        yield

    def _end(self) -> None:
        if self._live is not None:
            with suppress(OSError):  # the terminal is gone
                self._live.stop()
