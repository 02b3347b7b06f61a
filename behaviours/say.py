"""Tell people something."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import ClassVar

from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Leaf

_BLANK = "{value}"
_ANY_BLANK = re.compile(r"\{\w*\}")


class Say(Leaf):
    """Tell the people around something; it stands in the summary of the run.

    Args:
        text: what to say; `{value}` in it stands for the value.
        value: for example a key, as in `value: $count`.
    """

    key: ClassVar[str] = "say"
    needs_robot: ClassVar[bool] = False
    moves: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        text: str,
        value: str | int | float | bool | None = None,
    ) -> None:
        super().__init__(name, context)
        if wrong := self.misfit({"text": text, "value": value}):
            raise ValueError(wrong)
        self._text = text.replace(_BLANK, f"{value:g}" if isinstance(value, float) else f"{value}")

    @classmethod
    def misfit(cls, arguments: Mapping[str, object]) -> str:
        """A blank has a value, and a value its blank; there are no other blanks."""
        text, value = arguments.get("text"), arguments.get("value")
        if not isinstance(text, str):
            return ""
        if odd := [blank for blank in _ANY_BLANK.findall(text) if blank != _BLANK]:
            return f"`{odd[0]}` in the text is filled by nothing; write {_BLANK} and give `value`"
        if (value is not None) != (_BLANK in text):
            return f"has only one of {_BLANK} and `value`; write {_BLANK} where the value belongs"
        return ""

    def update(self) -> Status:
        """One tick."""
        self.context.log.say(self.context.clock.now(), self._text)
        return self.success(self._text)
