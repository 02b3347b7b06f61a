"""The composites `switch` and `for_each`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, cast

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from behaviours import Key, LeafCrashedError
from config import parse_scalar
from trees.language.branch import Branch, Ticking
from trees.language.composites import Sequence

if TYPE_CHECKING:
    from behaviours import Context


def is_case(value: object, case: str) -> bool:
    """Whether a value is the one that a file writes like this; true is not 1."""
    if isinstance(value, str):
        return value == case
    read = parse_scalar(case)
    return value == read and isinstance(value, bool) is isinstance(read, bool)


class Switch(Branch):
    """Runs the child that stands for a value; fails if none does and there is no `else`.

    Args:
        name: the node's name in the tree.
        children: one for each case, and one more if there is an `else`.
        value: what decides, when it starts.
        cases: the values of the children, as a file writes them.
    """

    key = "switch"

    def __init__(
        self,
        name: str,
        children: Iterable[Behaviour],
        value: Callable[[], object],
        cases: tuple[str, ...],
    ) -> None:
        super().__init__(name, children)
        self._value = value
        self._cases = cases

    def restart(self) -> None:
        """Choose the child."""
        value = self._value()
        self._chosen = len(self._cases)
        for place, case in enumerate(self._cases):
            if is_case(value, case):
                self._chosen = place

    def advance(self) -> Ticking:
        """Tick the chosen child."""
        if self._chosen == len(self.children):
            self.feedback_message = f"no case for {self._value()}"
            return Status.FAILURE
        return (yield from self.run(self.children[self._chosen]))


class ForEach(Sequence):
    """Runs a node for each of several values, in order; fails when one fails."""

    key = "for_each"

    @classmethod
    def built(
        cls,
        name: str,
        children: Iterable[Behaviour],
        options: Mapping[str, object],
        context: Context,
    ) -> Branch:
        """One that has a copy for each value; or one child, if the values are those of a list."""
        return ForEachOf(name, children, **cast(Any, options)) if options else cls(name, children)


class ForEachOf(Branch):
    """Runs its child for each value of a list, which is read when it starts.

    Args:
        name: the node's name in the tree.
        children: one.
        values: the list.
        item: the key that has the value whose turn it is.
    """

    key = "for_each"

    def __init__(
        self,
        name: str,
        children: Iterable[Behaviour],
        *,
        values: Callable[[], object],
        item: Key[object],
    ) -> None:
        super().__init__(name, children)
        self._read = values
        self._item = item

    def restart(self) -> None:
        """Read the list and begin with its first value.

        Raises:
            LeafCrashedError: it was not written; its writer is at fault.
        """
        try:
            values = self._read()
        except LookupError as error:
            raise LeafCrashedError(self.name, error) from error
        assert isinstance(values, tuple)
        self._left = list(values)
        if self._left:
            self._item.write(self._left[0])

    def advance(self) -> Ticking:
        """Tick the child; the next value has its turn at the next tick."""
        if not self._left:
            self.feedback_message = "nothing is on the list"
            return Status.SUCCESS
        status = yield from self.run(self.children[0])
        if status is not Status.SUCCESS:
            return status
        del self._left[0]
        if not self._left:
            return Status.SUCCESS
        self.rewind()
        self._item.write(self._left[0])
        return Status.RUNNING
