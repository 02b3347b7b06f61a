"""Aliases: old words and parameters of the language, which still work and warn for one version."""

from __future__ import annotations

from collections.abc import Mapping

from config import Diagnostics, YamlEntry

WORDS: Mapping[str, str] = {}
"""New names of nodes and modifiers, by their old ones."""

PARAMETERS: Mapping[str, str] = {"onward": "next_goal"}
"""New names of the parameters of leaves, by their old ones."""


def renamed(
    entries: Mapping[str, YamlEntry],
    aliases: Mapping[str, str],
    known: Mapping[str, object],
    diagnostics: Diagnostics,
) -> dict[str, YamlEntry]:
    """The entries by their new names, in order, with a warning for each old one.

    Args:
        entries: of a mapping in a task file.
        aliases: new names by old ones.
        known: the names that the mapping may have; an alias is used only for one of them.
        diagnostics: receives the warnings.
    """
    result: dict[str, YamlEntry] = {}
    for key, entry in entries.items():
        new = aliases.get(key, key)
        if key in known or new not in known or new in entries:
            new = key
        if new != key:
            message = f"`{key}` is now called `{new}`"
            diagnostics.warning(entry.location, message, f"write `{new}`: `{key}` will be removed")
        result[new] = entry
    return result
