"""Which objects were brought somewhere, as the contacts of a simulated world tell."""

from __future__ import annotations

from collections.abc import Mapping

from hw import Truth

_NOWHERE = ("", "hand", "floor")


def supports(truth: Truth | None) -> Mapping[str, str]:
    """What carries each object, by its name; nothing where nobody knows the world."""
    return truth.supports() if truth else {}


def brought(before: Mapping[str, str], after: Mapping[str, str]) -> int:
    """How many objects stand on some other furniture than before, and not on the floor.

    Args:
        before: what carried each object.
        after: what carries it now.
    """
    return sum(after[name] not in (*_NOWHERE, before[name]) for name in before)
