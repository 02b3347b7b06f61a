"""Strict YAML: a small, safe part of YAML 1.2 in which every value knows its place.

Scalars follow the YAML 1.2 core schema (`no` is text, `1e-3` a number). Anchors, aliases, tags,
repeated keys and further documents are diagnostics; size and depth are bounded.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import yaml

from trees.language.diagnostics import Diagnostics, Location
from trees.language.value_types import Named, Plain

MAX_BYTES = 64_000
"""A task of a thousand nodes is smaller, and is read within a second."""
MAX_DEPTH = 64


@dataclass(frozen=True, kw_only=True)
class Scalar:
    """A single value."""

    place: Location
    value: Plain
    parameter: str | None = None
    """The task parameter that gave the value, if one did."""

    @property
    def is_noted(self) -> bool:
        """Whether it hangs on a parameter without a value, which is noted as a diagnostic."""
        return self.parameter is not None and self.value is None


@dataclass(frozen=True, kw_only=True)
class Reference:
    """What stands for a `$name` that is not plain."""

    place: Location
    name: str
    value: Named | None = None
    """The pose or region; None if it is known only while the task runs."""


@dataclass(frozen=True, kw_only=True)
class Items:
    """A list."""

    place: Location
    items: tuple[Value, ...]


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One key of a mapping and its value."""

    place: Location
    value: Value


@dataclass(frozen=True, kw_only=True)
class Table:
    """A mapping; its keys are text."""

    place: Location
    entries: Mapping[str, Entry]


Value: TypeAlias = Scalar | Reference | Items | Table

# A decimal of more than 18 digits is a float: no use needs it whole, and it stays cheap to read.
_SCALARS: tuple[tuple[re.Pattern[str], Callable[[str], Plain]], ...] = (
    (re.compile(r"null|Null|NULL|~|"), lambda text: None),
    (re.compile(r"true|True|TRUE"), lambda text: True),
    (re.compile(r"false|False|FALSE"), lambda text: False),
    (re.compile(r"[-+]?[0-9]{1,18}"), int),
    (re.compile(r"0o[0-7]{1,18}"), lambda text: int(text, 8)),
    (re.compile(r"0x[0-9a-fA-F]{1,15}"), lambda text: int(text, 16)),
    (re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"), float),
    (re.compile(r"[-+]?(\.inf|\.Inf|\.INF)"), lambda text: float(text.replace(".", ""))),
    (re.compile(r"\.nan|\.NaN|\.NAN"), lambda text: float("nan")),
)

_YAML_HINTS = {
    r"'\t'": "indent with spaces, not with tabs",
    "mapping values are not allowed": "check the indentation, and quote text that contains `: `",
    "expected <block end>": "line the item up with the others of its list or mapping",
    "it nests deeper": "split it, or check that every bracket is closed",
    "unexpected end of stream": "close the quote or bracket that is still open",
}


def plain(text: str) -> Plain:
    """What an unquoted YAML 1.2 core scalar means."""
    for pattern, convert in _SCALARS:
        if pattern.fullmatch(text):
            return convert(text)
    return text


def read_text(path: Path, diagnostics: Diagnostics) -> str | None:
    """The text of a task file, or None and a diagnostic."""
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        diagnostics.error(None, "there is no such file", "check the path")
        return None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        diagnostics.error(None, f"the file cannot be read ({reason})", "name a readable file")
        return None
    if len(data) > MAX_BYTES:
        diagnostics.error(
            None,
            f"the file is larger than {MAX_BYTES // 1000} kB",
            "split the task into subtrees",
        )
        return None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line_start = before.rfind(b"\n") + 1
        column = len(before[line_start:].decode("utf-8", errors="replace")) + 1
        diagnostics.error(
            Location(line=before.count(b"\n") + 1, column=column),
            f"byte 0x{data[error.start]:02x} is not UTF-8 text",
            "save the file as UTF-8",
        )
        return None


def compose(text: str, diagnostics: Diagnostics) -> Value | None:
    """The one document in `text`, or None and a diagnostic if it is empty or not YAML."""
    try:
        loader = yaml.SafeLoader(text)
        return _Composer(_events(loader), diagnostics).document()
    except yaml.reader.ReaderError as error:
        before = text[: int(error.position)]
        place = Location(line=before.count("\n") + 1, column=len(before) - before.rfind("\n"))
        what = f"character {chr(error.character)!r} may not stand in YAML"
        diagnostics.error(place, what, "remove it, or write it as an escape in double quotes")
    except yaml.MarkedYAMLError as error:
        problem = error.problem or "it ends too early"
        hint = next(
            (hint for part, hint in _YAML_HINTS.items() if part in problem),
            "check the indentation and the quotes here and on the line above",
        )
        diagnostics.error(
            _place(error.problem_mark or error.context_mark), f"this is not YAML: {problem}", hint
        )
    except (ValueError, OverflowError):
        # The scanner converts escapes and version numbers without checking their range.
        what = "this is not YAML: a number or an escape is out of range"
        diagnostics.error(_place(loader.get_mark()), what, "correct it or write it as plain text")
    return None


def _events(loader: yaml.SafeLoader) -> Iterator[yaml.Event]:
    while loader.check_event():
        yield loader.get_event()  # type: ignore[no-untyped-call]


def _place(mark: Any) -> Location:
    return Location(line=mark.line + 1, column=mark.column + 1)


class _Composer:
    """Turns parser events into located values."""

    def __init__(self, events: Iterator[yaml.Event], diagnostics: Diagnostics) -> None:
        self._events = events
        self._mistakes = diagnostics

    def document(self) -> Value | None:
        documents: list[Value] = []
        for event in self._events:
            if isinstance(event, yaml.DocumentStartEvent):
                if documents:
                    what = "a second document starts here"
                    self._mistakes.error(_place(event.start_mark), what, "keep one task a file")
                    break
                documents.append(self._value(next(self._events), 1))
        if documents:
            return documents[0]
        hint = "write at least `task:` and `tree:`"
        self._mistakes.error(Location(line=1, column=1), "the file is empty", hint)
        return None

    def _value(self, event: yaml.Event, depth: int) -> Value:
        place = _place(event.start_mark)
        if depth > MAX_DEPTH:
            raise yaml.MarkedYAMLError(
                problem=f"it nests deeper than {MAX_DEPTH} levels",
                problem_mark=event.start_mark,  # type: ignore[arg-type]
            )
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
            self._mistakes.error(
                place, "anchors and aliases are not part of a task file", "write the value out"
            )
        if tag := getattr(event, "tag", None):
            what = f"the tag {tag!r} is not part of a task file"
            self._mistakes.error(place, what, "remove it")
        if isinstance(event, yaml.SequenceStartEvent):
            return Items(place=place, items=tuple(self._items(depth)))
        if isinstance(event, yaml.MappingStartEvent):
            return Table(place=place, entries=self._entries(depth))
        if isinstance(event, yaml.ScalarEvent):
            is_plain = event.style is None
            return Scalar(place=place, value=plain(event.value) if is_plain else event.value)
        return Scalar(place=place, value=None)

    def _items(self, depth: int) -> Iterator[Value]:
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            yield self._value(event, depth + 1)

    def _entries(self, depth: int) -> dict[str, Entry]:
        entries: dict[str, Entry] = {}
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            key = self._value(event, depth + 1)
            value = self._value(next(self._events), depth + 1)
            if not isinstance(key, Scalar) or not isinstance(key.value, str):
                self._mistakes.error(key.place, "this key is not a word", "give it a name")
            elif key.value in entries:
                first = entries[key.value].place.line
                what = f"the key `{key.value}` appears twice, first on line {first}"
                self._mistakes.error(key.place, what, "keep one of them")
            else:
                entries[key.value] = Entry(place=key.place, value=value)
        return entries
