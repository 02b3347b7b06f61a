"""Errors that a person can fix, and the one way to suggest the word that was meant."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import ClassVar


class UserError(Exception):
    """Input that cannot be used: a file, a name, an option, a missing extra.

    The text is what the person reads, without a traceback: what is wrong, where, and a hint. The
    command line prints it and exits with `exit_code`; nothing has moved by then.
    """

    exit_code: ClassVar[int] = 2


def quoted(words: Iterable[object]) -> str:
    """The words in backquotes, separated by commas."""
    return ", ".join(f"`{word}`" for word in words)


def suggest(word: str, known: Iterable[str]) -> str:
    """The hint for an unknown word: the nearest known one, else all of them."""
    words = sorted(known)
    close = difflib.get_close_matches(word, words, n=1)
    if close:
        return f"did you mean `{close[0]}`?"
    return f"known: {quoted(words)}" if words else "remove it"
