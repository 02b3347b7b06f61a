"""Diagnostics of a file that a person writes: where, what is wrong, and how to fix it.

All diagnostics of a file are collected in one pass, so that a person fixes them in one go.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from pathlib import Path


@dataclass(frozen=True, kw_only=True, order=True)
class Location:
    """A position in a file, counted from 1 as editors do."""

    line: int
    column: int


class Severity(Enum):
    """Whether a file with this diagnostic can be used."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, kw_only=True)
class Diagnostic:
    """One problem in a file; its text is one line."""

    path: Path
    location: Location | None
    """None when the whole file is meant, for example because it does not exist."""
    message: str
    hint: str
    """How to fix it."""
    severity: Severity = Severity.ERROR

    def __str__(self) -> str:
        at = f":{self.location.line}:{self.location.column}" if self.location else ""
        warning = "warning: " if self.severity is Severity.WARNING else ""
        return f"{self.path}{at}: {warning}{_one_line(self.message)}; {_one_line(self.hint)}"


class TooManyErrorsError(Exception):
    """The limit of errors is reached."""


class Diagnostics:
    """Collects the diagnostics of a file and of the files that it includes.

    Args:
        path: the file, as the person named it.
        limit: how many errors are enough; None is no limit.
    """

    def __init__(self, path: Path, limit: int | None = None) -> None:
        self.path = path
        self._limit = limit
        self._found: list[Diagnostic] = []

    def of(self, path: Path) -> Diagnostics:
        """The same collection, for the diagnostics of an included file."""
        other = Diagnostics(path, self._limit)
        other._found = self._found
        return other

    def error(self, location: Location | None, message: str, hint: str) -> None:
        """Add a problem because of which the file cannot be used.

        Raises:
            TooManyErrorsError: the limit is reached.
        """
        self._found.append(
            Diagnostic(path=self.path, location=location, message=message, hint=hint)
        )
        if self._limit is not None and len(self._found) >= self._limit:
            raise TooManyErrorsError

    def warning(self, location: Location, message: str, hint: str) -> None:
        """Add something that is probably a mistake."""
        self._found.append(
            Diagnostic(
                path=self.path,
                location=location,
                message=message,
                hint=hint,
                severity=Severity.WARNING,
            )
        )

    @property
    def fatal(self) -> bool:
        """Whether there is an error among them, in whichever file."""
        return any(diagnostic.severity is Severity.ERROR for diagnostic in self._found)

    def in_order(self) -> list[Diagnostic]:
        """All of them, each once: those of this file first, each file's in its order."""
        return sorted(dict.fromkeys(self._found), key=self._position)

    def _position(self, diagnostic: Diagnostic) -> tuple[bool, Path, Location]:
        start = Location(line=0, column=0)
        return diagnostic.path != self.path, diagnostic.path, diagnostic.location or start


def _one_line(text: str) -> str:
    """Text that may quote anything from a file, made safe and short enough for a terminal."""
    line = " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())
    return line if len(line) <= 400 else f"{line[:399]}…"
