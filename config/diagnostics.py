"""User errors, and diagnostics of files: location, message and hint."""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from os.path import relpath
from pathlib import Path
from typing import ClassVar
from unicodedata import category

from config.yaml_rules import Rule


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


def extra(name: str) -> str:
    """The command that installs an extra of ours where this program runs."""
    python = min(sys.executable, relpath(sys.executable), key=len)
    return f'{python} -m pip install "frankie-task[{name}]"'


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
    *(("large", "small"), ("larg", "smallest"), ("tall", "small"), ("high", "low")),
    *(("long", "short"), ("wide", "narrow"), ("thick", "thin"), ("near", "far")),
    *(("first", "last"), ("start", "stop"), ("inside", "outside"), ("full", "empty")),
    *(("fast", "slow"), ("push", "pull"), ("give", "take"), ("pick", "place")),
)
_DENYING = ("un", "dis", "not_", "no_")
_UNITS = ("s", "m", "mm", "deg", "percent", "cm2")  # with which names of parameters end
_LIKE, _LIKE_PART = 0.8, 0.75  # least likeness of two words with a slip, and of their parts


def _are_opposite(one: str, other: str) -> bool:
    """Whether two words differ in a part that means the opposite, however near they look."""
    short, long = sorted((one.lower(), other.lower()), key=len)
    return long in {f"{no}{short}" for no in _DENYING} or any(
        {(a in word) - (b in word) for word in (short, long)} == {1, -1} for a, b in _OPPOSITES
    )


def _parts(word: str) -> list[str]:
    """The parts of a word as `shelf_2`, without case, plural and unit."""
    parts = re.findall(r"[a-z]+|[^a-z_ -]+", word.lower())
    parts = parts[:-1] if len(parts) > 1 and parts[-1] in _UNITS else parts
    return [re.sub(r"(?<=\w\w\w)(?<!s)s$", "", re.sub(r"ies$", "y", one)) for one in parts]


def _alike(one: str, other: str, least: float) -> bool:
    like = difflib.SequenceMatcher(None, one, other).ratio()
    return like >= least or sorted(one) == sorted(other)  # as of two exchanged letters


def _is_spelling(one: str, other: str) -> bool:
    """Whether two words are one, in another way of writing or with slips within long parts."""
    a, b = _parts(one), _parts(other)
    return "".join(a) == "".join(b) or (
        [x if x.isdigit() else x[0] for x in a] == [y if y.isdigit() else y[0] for y in b]
        and all(x == y or _alike(x, y, _LIKE_PART) for x, y in zip(a, b, strict=True))
        and _alike("".join(a), "".join(b), _LIKE)
    )


def nearest(word: str, known: Iterable[str]) -> Hint:
    """Asks whether the nearest known word was meant; empty if none is near.

    It is certain only where no other word differs as little: a word that means something else, as
    near as it looks, is not put in its place.
    """
    likely = sorted(one for one in known if not _are_opposite(one, word))
    same = [one for one in likely if _is_spelling(one, word)]
    close = same or difflib.get_close_matches(word, likely, n=1)
    text = f"did you mean `{close[0]}`?" if close else ""
    return Hint(text, word, close[0] if len(same) == 1 else "")


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
