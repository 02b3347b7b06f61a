"""Reading mappings: known keys, and errors about unknown and missing ones."""

import re
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from config import (
    Diagnostics,
    Location,
    YamlEntry,
    YamlMap,
    YamlScalar,
    YamlValue,
    describe,
    quoted,
    suggest,
)
from trees.language import rules

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")  # names of parameters, keys, poses, regions, tasks

ABSENT: Any = None  # the default of a field that may be left out, but not be null

NAMING_HINT = "use letters, digits and `_`, and begin with a letter"


def fields(
    value: YamlValue,
    subject: str,
    diagnostics: Diagnostics,
    *,
    required: Collection[str] = (),
    optional: Collection[str] = (),
) -> Mapping[str, YamlEntry] | None:
    """The entries of a mapping with known keys; None and an error if one is missing.

    `subject` is what it describes, for messages.
    """
    if not isinstance(value, YamlMap):
        hint = f"write {quoted(required or optional)} with their values below it"
        diagnostics.error(
            rules.VALUE, value.location, f"{subject} is a mapping, not {describe(value)}", hint
        )
        return None
    known = (*required, *optional)
    for key in [key for key in value.entries if key not in known]:
        message = f"{subject} has no key `{key}`"
        at = value.entries[key].location
        diagnostics.error(rules.UNKNOWN_KEY, at, message, suggest(key, known))
    missing = [key for key in required if key not in value.entries]
    if missing:
        message = f"{subject} lacks {quoted(missing)}"
        diagnostics.error(rules.MISSING_KEY, value.location, message, f"add {quoted(missing)}")
    return None if missing else value.entries


def named_entries(
    entry: YamlEntry | None, section: str, diagnostics: Diagnostics
) -> Iterator[tuple[str, Location, YamlValue]]:
    """Name, location and value of each entry of a section; an empty section has none."""
    if entry is None or (isinstance(entry.value, YamlScalar) and entry.value.value is None):
        return
    if not isinstance(entry.value, YamlMap):
        message = f"`{section}` is a mapping of names, not {describe(entry.value)}"
        diagnostics.error(
            rules.VALUE, entry.value.location, message, f"indent `name: ...` below `{section}:`"
        )
        return
    for name, named in entry.value.entries.items():
        if WORD.fullmatch(name):
            yield name, named.location, named.value
        else:
            message = f"`{name}` cannot be a name in `{section}`"
            diagnostics.error(rules.NAMING, named.location, message, NAMING_HINT)
