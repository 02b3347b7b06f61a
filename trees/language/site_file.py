"""The poses and regions of a site, in a file of their own, for every task that is done there."""

from __future__ import annotations

from config import Diagnostics, read_yaml
from trees.language.mappings import fields
from trees.language.named_poses import NamedValues, read_named_values

SITE_KEYS = ("description", "poses", "regions")
"""What may stand in such a file."""


def read_site(diagnostics: Diagnostics) -> NamedValues:
    """What the file defines that the diagnostics are about."""
    read = read_yaml(diagnostics)
    entries = read and fields(read[1], "the file of places", diagnostics, optional=SITE_KEYS)
    if not entries:
        return NamedValues()
    return read_named_values(entries.get("poses"), entries.get("regions"), diagnostics)
