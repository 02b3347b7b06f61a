"""User errors, and diagnostics of files: location, message and hint."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import ClassVar
from unicodedata import category

from config.rules import Rule


class UserError(Exception):
    """Input that cannot be used: a file, a name, an option, a missing extra.

    The text is what the user reads, without a traceback: what, where, and a hint. The command line
    exits with `exit_code`; nothing has moved by then.
    """

    exit_code: ClassVar[int] = 2


def quoted(words: Iterable[object]) -> str:
    """The words in backquotes, separated by commas."""
    return ", ".join(f"`{word}`" for word in words)


def counted(number: int, noun: str) -> str:
    """A number of things, as `1 object` and `2 objects`."""
    return f"{number} {noun}{'s' * (number != 1)}"


class Hint(str):
    """A hint; `meant` is what belongs in place of the text `given`, where that is certain."""

    given: str
    meant: str

    def __new__(cls, text: str, given: str = "", meant: str = "") -> Hint:
        """The hint as text."""
        self = super().__new__(cls, text)
        self.given, self.meant = given, meant
        return self


def parted(text: str) -> tuple[str, str]:
    """Message and hint of the text `message; hint`; of a `Hint` with what is meant."""
    message, _, hint = text.partition("; ")
    return message, Hint(hint, text.given, text.meant) if isinstance(text, Hint) else hint


def suggest(word: str, known: Iterable[str]) -> str:
    """The hint for an unknown word: the nearest known one, else all of them."""
    words = sorted(known)
    if meant := nearest(word, words):
        return meant
    return f"known: {quoted(words)}" if words else "remove it"


_OPPOSITES = (
    *(("open", "close"), ("forward", "backward"), ("left", "right"), ("min", "max")),
    *(("least", "most"), ("before", "after"), ("above", "below"), ("up", "down")),
)


def _are_opposite(one: str, other: str) -> bool:
    """Whether two words differ in a part that means the opposite, however near they look."""
    return any((a in one and b in other) or (b in one and a in other) for a, b in _OPPOSITES)


def nearest(word: str, known: Iterable[str]) -> Hint:
    """Asks whether the nearest known word was meant; empty if none is near."""
    likely = sorted(one for one in known if not _are_opposite(one, word))
    close = difflib.get_close_matches(word, likely, n=2)
    likeness = [difflib.SequenceMatcher(None, one, word).ratio() for one in close]
    is_certain = bool(close) and likeness.count(likeness[0]) == 1
    text = f"did you mean `{close[0]}`?" if close else ""
    return Hint(text, word, close[0] if is_certain else "")


@dataclass(frozen=True, kw_only=True, order=True)
class Location:
    """A position in a file, counted from 1 as editors do."""

    line: int
    column: int


class Severity(Enum):
    """Whether a file with this diagnostic can be used."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True)
class Diagnostic:
    """One problem in a file; its text is one line."""

    rule: Rule
    path: Path
    location: Location | None  # None when the whole file is meant, as for a missing one
    message: str
    hint: str  # how to fix it; a `Hint` if that is certain
    severity: Severity = Severity.ERROR

    def __str__(self) -> str:
        at = f":{self.location.line}:{self.location.column}" if self.location else ""
        warning = "warning: " if self.severity is Severity.WARNING else ""
        return f"{self.path}{at}: {warning}{_one_line(self.message)}; {_one_line(self.hint)}"


class TooManyErrorsError(Exception):
    """The limit of errors is reached."""


class Diagnostics:
    """Collects the diagnostics of a file and of its included files, up to a limit of errors."""

    def __init__(self, path: Path, limit: int | None = None, text: str | None = None) -> None:
        self.path = path
        self.text = text  # of the file, instead of what it contains
        self._limit = limit
        self._found: list[Diagnostic] = []

    def of(self, path: Path) -> Diagnostics:
        """The same collection for an included file."""
        other = Diagnostics(path, self._limit)
        other._found = self._found
        return other

    def error(self, rule: Rule, location: Location | None, message: str, hint: str) -> None:
        """Add an error, which makes the file unusable.

        Raises:
            TooManyErrorsError: the limit is reached.
        """
        self._found.append(Diagnostic(rule, self.path, location, message, hint))
        if self._limit is not None and len(self._found) >= self._limit:
            raise TooManyErrorsError

    def warning(self, rule: Rule, location: Location, message: str, hint: str) -> None:
        """Add a probable mistake."""
        severity = Severity.WARNING
        self._found.append(Diagnostic(rule, self.path, location, message, hint, severity))

    @property
    def fatal(self) -> bool:
        """Whether there is an error, in any of the files."""
        return any(diagnostic.severity is Severity.ERROR for diagnostic in self._found)

    def in_order(self) -> list[Diagnostic]:
        """All diagnostics once, those of this file first, in the order of each file."""
        return sorted(dict.fromkeys(self._found), key=self._position)

    def _position(self, diagnostic: Diagnostic) -> tuple[bool, Path, Location]:
        start = Location(line=0, column=0)
        return diagnostic.path != self.path, diagnostic.path, diagnostic.location or start


def _one_line(text: str) -> str:
    """Text that may quote a file, made safe and short for a terminal."""
    shown = (
        f"<U+{ord(letter):04X}>" if category(letter) in ("Zs", "Cf") and letter != " " else letter
        for letter in text
    )
    line = " ".join("".join(one if one.isprintable() else " " for one in shown).split())
    return line if len(line) <= 400 else f"{line[:399]}…"
