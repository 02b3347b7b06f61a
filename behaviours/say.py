"""Tell people something."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Leaf

_BLANK = "{value}"


class Say(Leaf):
    """Tell the people around something; it stands in the summary of the run.

    Args:
        text: what to say; `{value}` in it stands for the value.
        value: for example a key, as in `value: $count`.
    """

    key: ClassVar[str] = "say"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        text: str,
        value: str | int | float | bool | None = None,
    ) -> None:
        super().__init__(name, context)
        if (value is not None) != (_BLANK in text):
            raise ValueError(f"write {_BLANK} where the value belongs in the text, and give both")
        self._text = text.replace(_BLANK, f"{value:g}" if isinstance(value, float) else f"{value}")

    def update(self) -> Status:
        """One tick."""
        self.context.log.say(self.context.clock.now(), self._text)
        return self.success(self._text)
