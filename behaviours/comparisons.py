"""Questions about values: what earlier nodes found out, or what a task was told."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Condition


class Equals(Condition):
    """Succeeds if a value is another value.

    Args:
        value: for example a key, as in `value: $side`.
        to: what it has to be.
    """

    key: ClassVar[str] = "equals"
    needs_robot: ClassVar[bool] = False
    alike: ClassVar[tuple[str, ...]] = ("value", "to")

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        value: bool | int | float | str,
        to: bool | int | float | str,
    ) -> None:
        super().__init__(name, context)
        self._value = value
        self._to = to

    def update(self) -> Status:
        """One tick."""
        # True is not 1 in a task file.
        if self._value == self._to and isinstance(self._value, bool) is isinstance(self._to, bool):
            return self.success(f"it is {self._to}")
        return self.failure(f"it is {self._value}, not {self._to}")


class AtLeast(Condition):
    """Succeeds if a number is not smaller than another one.

    Args:
        value: for example a key, as in `value: $count`.
        least: the smallest number that will do.
    """

    key: ClassVar[str] = "at_least"
    needs_robot: ClassVar[bool] = False

    def __init__(self, name: str, context: Context, *, value: float, least: float) -> None:
        super().__init__(name, context)
        self._value = value
        self._least = least

    def update(self) -> Status:
        """One tick."""
        text = f"{self._value:g} of at least {self._least:g}"
        return self.success(text) if self._value >= self._least else self.failure(text)
