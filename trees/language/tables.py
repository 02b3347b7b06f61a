"""Reading mappings: which keys may stand there, and what is said about the others."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping

from config import quoted, suggest
from trees.language.diagnostics import Diagnostics, Location
from trees.language.source import Entry, Scalar, Table, Value
from trees.language.values import describe

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
"""What a parameter, pose, region or task may be called."""


def fields(
    value: Value,
    what: str,
    diagnostics: Diagnostics,
    *,
    required: Collection[str] = (),
    optional: Collection[str] = (),
) -> Mapping[str, Entry] | None:
    """The entries of a mapping whose keys are fixed; None and diagnostics if they do not fit.

    Args:
        value: the mapping.
        what: what it describes, for messages.
        diagnostics: where they are noted.
        required: keys that must be there.
        optional: keys that may.
    """
    if not isinstance(value, Table):
        hint = f"write {quoted(required or optional)} with their values below it"
        diagnostics.error(value.place, f"{what} is a mapping, not {describe(value)}", hint)
        return None
    known = (*required, *optional)
    unknown = [key for key in value.entries if key not in known]
    for key in unknown:
        hint = suggest(key, known)
        diagnostics.error(value.entries[key].place, f"{what} has no key `{key}`", hint)
    missing = [key for key in required if key not in value.entries]
    if missing:
        diagnostics.error(value.place, f"{what} lacks {quoted(missing)}", f"add {quoted(missing)}")
    return None if missing else value.entries


def named_entries(
    entry: Entry | None, section: str, diagnostics: Diagnostics
) -> Iterator[tuple[str, Location, Value]]:
    """Name, place and value of each entry of a section of the file; an empty one has none."""
    if entry is None or (isinstance(entry.value, Scalar) and entry.value.value is None):
        return
    if not isinstance(entry.value, Table):
        what = f"`{section}` is a mapping of names, not {describe(entry.value)}"
        diagnostics.error(entry.value.place, what, f"indent `name: ...` below `{section}:`")
        return
    for name, named in entry.value.entries.items():
        if WORD.fullmatch(name):
            yield name, named.place, named.value
        else:
            hint = "use letters, digits and `_`, and begin with a letter"
            diagnostics.error(named.place, f"`{name}` cannot be a name in `{section}`", hint)
