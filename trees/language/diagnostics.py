"""Diagnostics in a task file: each says where it is, what is wrong and how to fix it.

All diagnostics of a file and its subtrees are collected in one pass, so that a person fixes them in
one go.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from config import UserError


@dataclass(frozen=True, kw_only=True, order=True)
class Location:
    """A position in a file, counted from 1 as editors do."""

    line: int
    column: int


class Severity(Enum):
    """Whether a diagnostic keeps the task from running."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, kw_only=True)
class Diagnostic:
    """One thing to fix in a task file."""

    path: Path
    place: Location | None
    """None when the whole file is meant, for example because it does not exist."""
    what: str
    hint: str
    severity: Severity = Severity.ERROR

    def __str__(self) -> str:
        where = f"{self.path}:{self.place.line}:{self.place.column}" if self.place else self.path
        warning = "warning: " if self.severity is Severity.WARNING else ""
        return f"{where}: {warning}{_one_line(self.what)}; {_one_line(self.hint)}"


class TaskFileError(UserError):
    """A task file cannot be used.

    Args:
        diagnostics: everything that is wrong with it and its subtrees, in order.
    """

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(str(diagnostic) for diagnostic in self.diagnostics))


class TooManyErrorsError(Exception):
    """As many errors are collected as were wanted."""


class Diagnostics:
    """Collects the diagnostics of one file.

    Args:
        path: the file, as the person named it.
        most: how many errors are enough; None is no limit.
    """

    def __init__(self, path: Path, most: int | None = None) -> None:
        self.path = path
        self._most = most
        self._found: list[Diagnostic] = []

    def of(self, path: Path) -> Diagnostics:
        """The same collection, for the diagnostics of another file of the task."""
        other = Diagnostics(path, self._most)
        other._found = self._found
        return other

    def error(self, place: Location | None, what: str, hint: str) -> None:
        """Note something that keeps the task from running.

        Raises:
            TooManyErrorsError: that are enough of them.
        """
        self._found.append(Diagnostic(path=self.path, place=place, what=what, hint=hint))
        if self._most is not None and len(self._found) >= self._most:
            raise TooManyErrorsError

    def warning(self, place: Location, what: str, hint: str) -> None:
        """Note something that is probably not meant."""
        self._found.append(
            Diagnostic(path=self.path, place=place, what=what, hint=hint, severity=Severity.WARNING)
        )

    @property
    def fatal(self) -> bool:
        """Whether there is an error among them, whichever file it is in."""
        return any(diagnostic.severity is Severity.ERROR for diagnostic in self._found)

    def in_order(self) -> list[Diagnostic]:
        """All of them, each once: those of this file first, each file's in its order."""
        return sorted(dict.fromkeys(self._found), key=self._position)

    def _position(self, diagnostic: Diagnostic) -> tuple[bool, Path, Location]:
        nowhere = Location(line=0, column=0)
        return diagnostic.path != self.path, diagnostic.path, diagnostic.place or nowhere


def _one_line(text: str) -> str:
    """Text that may quote anything from a file, made safe and short enough for a terminal."""
    line = " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())
    return line if len(line) <= 400 else f"{line[:399]}…"
