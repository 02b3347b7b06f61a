"""Strict YAML: a safe subset of YAML 1.2 whose values have locations.

Scalars follow the YAML 1.2 core schema (`no` is text, `1e-3` a number). Anchors, aliases, tags,
repeated keys and further documents are errors; size and depth are bounded.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import yaml

from config.diagnostics import Diagnostics, Hint, Location
from config.yaml_rules import FILE, SYNTAX

MAX_BYTES = 256_000  # a task of a thousand nodes is smaller, and a robot with two arms
MAX_DEPTH = 64

Plain: TypeAlias = bool | int | float | str | None  # the value of a YAML scalar


@dataclass(frozen=True, kw_only=True)
class YamlScalar:
    """A single value."""

    location: Location
    value: Plain


@dataclass(frozen=True, kw_only=True)
class YamlList:
    """A sequence of values."""

    location: Location
    items: tuple[YamlValue, ...]


@dataclass(frozen=True, kw_only=True)
class YamlEntry:
    """One key of a mapping and its value."""

    location: Location  # of the key
    value: YamlValue


@dataclass(frozen=True, kw_only=True)
class YamlMap:
    """A mapping; its keys are text."""

    location: Location
    entries: Mapping[str, YamlEntry]


YamlValue: TypeAlias = YamlScalar | YamlList | YamlMap

# A decimal of more than 18 digits is a float.
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
    "'`'": "remove the ``` of Markdown around the file; text that begins with ` is quoted",
    "unknown escape": "write `/` in paths; in double quotes a backslash is written twice",
    "could not find expected ':'": "a key beside others ends in `:`, as `open_gripper:`",
    "got ':'": "quote text that contains `: `, or close the bracket before it",
    "mapping values are not allowed": "check the indentation, and quote text that contains `: `",
    "expected <block end>": "line the item up with the others of its list or mapping",
    "it nests deeper": "split it, or check that every bracket is closed",
    "unexpected end of stream": "close the quote or bracket that is still open",
}


def parse_scalar(text: str) -> Plain:
    """The value of an unquoted YAML 1.2 core scalar."""
    for pattern, convert in _SCALARS:
        if pattern.fullmatch(text):
            return convert(text)
    return text


def written(value: Plain) -> str:
    """A value as YAML writes it."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return f"{value:g}" if isinstance(value, float) else str(value)


def describe(value: YamlValue) -> str:
    """A value in messages."""
    if isinstance(value, YamlList):
        return "a list"
    if isinstance(value, YamlMap):
        return "a mapping"
    types = {str: "the text ", int: "the number ", float: "the number "}
    return f"{types.get(type(value.value), '')}`{written(value.value)}`"


def content(value: YamlValue) -> Any:
    """The value as Python lists, dicts and scalars, without locations."""
    if isinstance(value, YamlList):
        return [content(item) for item in value.items]
    if isinstance(value, YamlMap):
        return {key: content(entry.value) for key, entry in value.entries.items()}
    return value.value


def texts(value: YamlValue) -> Iterator[tuple[str, Location]]:
    """Every scalar in a value that is text, and where it stands."""
    if isinstance(value, YamlMap):
        for entry in value.entries.values():
            yield from texts(entry.value)
    elif isinstance(value, YamlList):
        for item in value.items:
            yield from texts(item)
    elif isinstance(value.value, str):
        yield value.value, value.location


def read_yaml(diagnostics: Diagnostics) -> tuple[str, YamlValue] | None:
    """Text and content of the file of the diagnostics; None after an error in them."""
    text = diagnostics.text
    text = _read_text(diagnostics.path, diagnostics) if text is None else text
    document = None if text is None else parse_yaml(text, diagnostics)
    return None if text is None or document is None else (text, document)


def _read_text(path: Path, diagnostics: Diagnostics) -> str | None:
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        diagnostics.error(FILE, None, "there is no such file", "check the path")
        return None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        diagnostics.error(FILE, None, f"the file cannot be read ({reason})", "name a readable file")
        return None
    if len(data) > MAX_BYTES:
        message = f"the file is larger than {MAX_BYTES // 1000} kB"
        diagnostics.error(FILE, None, message, "split it into smaller files")
        return None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line_start = before.rfind(b"\n") + 1
        column = len(before[line_start:].decode("utf-8", errors="replace")) + 1
        diagnostics.error(
            FILE,
            Location(line=before.count(b"\n") + 1, column=column),
            f"the file cannot be read: byte 0x{data[error.start]:02x} is not UTF-8 text",
            "save it as UTF-8",
        )
        return None


def parse_yaml(text: str, diagnostics: Diagnostics) -> YamlValue | None:
    """The document in `text`; None after an error in the diagnostics."""
    if text.lstrip().startswith("<"):
        hint = "write YAML: `frankie-task export` writes XML, and nothing reads it"
        diagnostics.error(SYNTAX, Location(line=1, column=1), "this is XML", hint)
        return None
    if (faultless := _read_by_libyaml(text)) is not None:
        return faultless
    try:
        loader = yaml.SafeLoader(text)
        return _Composer(_events(loader), diagnostics).document()
    except yaml.reader.ReaderError as error:
        before = text[: int(error.position)]
        location = Location(line=before.count("\n") + 1, column=len(before) - before.rfind("\n"))
        message = f"this is not YAML: character {chr(error.character)!r} is not allowed"
        hint = "remove it, or write it as an escape in double quotes"
        diagnostics.error(SYNTAX, location, message, hint)
    except yaml.MarkedYAMLError as error:
        problem = error.problem or "it ends too early"
        hint = next(
            (hint for part, hint in _YAML_HINTS.items() if part in problem),
            "check the indentation and the quotes here and on the line above",
        )
        location = _location(error.problem_mark or error.context_mark)
        if problem.startswith("expected ','") and (comment := _comment_before(text, location)):
            location, hint = comment, "what follows ` #` is a comment: put the text in quotes"
        diagnostics.error(SYNTAX, location, f"this is not YAML: {problem}", hint)
    except (ValueError, OverflowError):
        # The scanner converts escapes and version numbers without checking their range.
        message = "this is not YAML: a number or an escape is out of range"
        diagnostics.error(
            SYNTAX, _location(loader.get_mark()), message, "correct it or write it as plain text"
        )
    return None


def _comment_before(text: str, location: Location) -> Location | None:
    """Where ` #` cuts off the line before a location, or its own."""
    for number in (location.line, location.line - 1):
        line = text.splitlines()[number - 1 : number] if number > 0 else []
        for one in line:
            if (at := one.find(" #")) > 0 and one[:at].count("{") + one[:at].count("["):
                return Location(line=number, column=at + 2)
    return None


def _read_by_libyaml(text: str) -> YamlValue | None:
    """The document by libyaml, five times faster than in Python.

    None if it has mistakes, which Python words better, or tabs, which only libyaml accepts; or if
    there is no libyaml.
    """
    if not yaml.__with_libyaml__ or "\t" in text:
        return None
    mistakes = Diagnostics(Path())
    try:
        document = _Composer(_events(yaml.CSafeLoader(text)), mistakes).document()
    except (yaml.YAMLError, ValueError, OverflowError):
        return None
    return None if mistakes.fatal else document


def _events(loader: Any) -> Iterator[yaml.Event]:
    while loader.check_event():
        yield loader.get_event()


def _location(mark: Any) -> Location:
    return Location(line=mark.line + 1, column=mark.column + 1)


class _Composer:
    """Turns parser events into located values."""

    def __init__(self, events: Iterator[yaml.Event], diagnostics: Diagnostics) -> None:
        self._events = events
        self._diagnostics = diagnostics

    def document(self) -> YamlValue | None:
        documents: list[YamlValue] = []
        for event in self._events:
            if isinstance(event, yaml.DocumentStartEvent):
                if documents:
                    location = _location(event.start_mark)
                    message = "a second document starts here"
                    self._diagnostics.error(FILE, location, message, "keep one document per file")
                    break
                documents.append(self._value(next(self._events), 1))
        if documents:
            return documents[0]
        start = Location(line=1, column=1)
        self._diagnostics.error(FILE, start, "the file is empty", "write its keys and their values")
        return None

    def _value(self, event: yaml.Event, depth: int) -> YamlValue:
        location = _location(event.start_mark)
        if depth > MAX_DEPTH:
            raise yaml.MarkedYAMLError(
                problem=f"it nests deeper than {MAX_DEPTH} levels",
                problem_mark=event.start_mark,  # type: ignore[arg-type]
            )
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
            message = "anchors and aliases are not supported"
            self._diagnostics.error(SYNTAX, location, message, "write the value out")
        if tag := getattr(event, "tag", None):
            message = f"the tag {tag!r} is not supported"
            self._diagnostics.error(SYNTAX, location, message, "remove it")
        if isinstance(event, yaml.SequenceStartEvent):
            return YamlList(location=location, items=tuple(self._items(depth)))
        if isinstance(event, yaml.MappingStartEvent):
            return YamlMap(location=location, entries=self._entries(depth))
        if isinstance(event, yaml.ScalarEvent):
            value = event.value if event.style else parse_scalar(event.value)
            return YamlScalar(location=location, value=value)
        return YamlScalar(location=location, value=None)

    def _items(self, depth: int) -> Iterator[YamlValue]:
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            yield self._value(event, depth + 1)

    def _entries(self, depth: int) -> dict[str, YamlEntry]:
        entries: dict[str, YamlEntry] = {}
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            key = self._value(event, depth + 1)
            value = self._value(next(self._events), depth + 1)
            if not isinstance(key, YamlScalar) or not isinstance(key.value, str):
                plain = written(key.value) if isinstance(key, YamlScalar) else ""
                quotes = f'"{plain}"' if plain else ""
                hint = Hint("give it a name, or write it in quotes", plain, quotes)
                if isinstance(value, YamlScalar) and value.value is None and entries:
                    hint = Hint("a decimal has a point, as 1.5; else write it in quotes")
                self._diagnostics.error(SYNTAX, key.location, "this key is not a word", hint)
            elif key.value in entries:
                first = entries[key.value].location.line
                message = f"the key `{key.value}` appears twice, first on line {first}"
                self._diagnostics.error(SYNTAX, key.location, message, "keep one of them")
            else:
                entries[key.value] = YamlEntry(location=key.location, value=value)
        return entries
