"""Keys: where a leaf leaves a result for the nodes after it."""

from __future__ import annotations

from typing import Generic, TypeVar, cast

Value = TypeVar("Value")


class Key(Generic[Value]):
    """Where a leaf leaves what it found out, for the nodes after it.

    A leaf asks for one by a keyword-only parameter annotated `Key[int]`, a task file names it
    (`count: found`), and `$found` is then a value that later nodes may be given. A leaf that
    succeeds has written all its keys.

    Args:
        name: in the task file.
    """

    _NOTHING = object()

    def __init__(self, name: str) -> None:
        self.name = name
        self._value: object = self._NOTHING

    def write(self, value: Value) -> None:
        """Leave a value in place of the one before."""
        self._value = value

    @property
    def written(self) -> bool:
        """Whether there is a value to read."""
        return self._value is not self._NOTHING

    def read(self) -> Value:
        """The value that was written last.

        Raises:
            LookupError: nothing was; the leaf that should have is at fault.
        """
        if not self.written:
            raise LookupError(f"nothing was written to the key `{self.name}`")
        return cast(Value, self._value)
