"""Behaviour `say`."""

from typing import ClassVar

from py_trees.common import Status

from behaviours.core.arguments import PLACEHOLDER, validate_text
from behaviours.core.context import Context
from behaviours.core.leaf import Leaf


class Say(Leaf):
    """Tell the people around something; it stands in the summary of the run.

    Args:
        text: what to say; `{value}` in it stands for the value.
        value: for example a key, as in `value: $count`.
    """

    key: ClassVar[str] = "say"
    can_fail: ClassVar[bool] = False
    needs_robot: ClassVar[bool] = False
    moves: ClassVar[bool] = False
    validate = staticmethod(validate_text)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        text: str,
        value: str | int | float | bool | None = None,
    ) -> None:
        super().__init__(name, context)
        if wrong := self.validate({"text": text, "value": value}):
            raise ValueError(wrong)
        shown = f"{value:g}" if isinstance(value, float) else f"{value}"
        self._text = text.replace(PLACEHOLDER, shown)

    def update(self) -> Status:
        """One tick."""
        self.context.log.say(self.context.clock.now(), self._text)
        return self.success(self._text)
