"""Composites that a value decides about: one case of several, or a node for each of several."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from config import parse_scalar
from trees.language.branch import Branch, Ticking
from trees.language.composites import Sequence


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
