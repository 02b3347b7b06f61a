"""Ways of real machines that public trackers report, and what emulators call them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from config import UserError, suggest


@dataclass(frozen=True)
class Reported:
    """What a machine was reported to do, and who says so."""

    what: str
    source: str


class NotReportedError(UserError):
    """No way of this name is known."""


def chosen(names: Sequence[str], table: Mapping[str, Reported], part: str) -> frozenset[str]:
    """The names, as a set; each may hold several with commas between them.

    Raises:
        NotReportedError: the table of the part has no such name.
    """
    flat = [name.strip() for text in names for name in text.split(",") if name.strip()]
    for name in flat:
        if name not in table:
            raise NotReportedError(
                f"the emulated {part} has no way called `{name}`; {suggest(name, table)}"
            )
    return frozenset(flat)
