"""Settings that refuse numbers which make no sense, by name and where they are made."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, ClassVar


class Checked:
    """Base of frozen dataclasses of settings: no number is NaN or negative.

    A subclass names in `POSITIVE` those that may not be zero either.

    Raises:
        ValueError: names the setting and says what it must be.
    """

    POSITIVE: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        settings: Any = self
        for name in (field.name for field in fields(settings)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            if name in self.POSITIVE and not value > 0.0:
                raise ValueError(f"{self._named(name)} must be a number above 0, got {value}")
            if not value >= 0.0:
                raise ValueError(f"{self._named(name)} must be at least 0, got {value}")

    def _named(self, name: str) -> str:
        return f"`{name}` of {type(self).__name__}"
