"""Leaves that the language itself makes for keys: `set`, and leaves that read keys."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from behaviours.leaf import LeafCrashedError
from behaviours.names import Key

Supply = Callable[[], object]
"""Gives a value when it is asked."""


class Set(Behaviour):
    """Writes values to keys.

    Args:
        name: the node's name in the tree.
        values: what is written to each key.
    """

    key = "set"

    def __init__(self, name: str, values: Mapping[Key[object], Supply]) -> None:
        super().__init__(name)
        self._values = values

    def update(self) -> Status:
        """One tick.

        Raises:
            LeafCrashedError: a key that is copied was not written; its writer is at fault.
        """
        try:
            for key, supply in self._values.items():
                key.write(supply())
        except LookupError as error:
            raise LeafCrashedError(self.name, error) from error
        written = (f"{key.name} = {key.read()}" for key in self._values)
        self.feedback_message = ", ".join(written)
        return Status.SUCCESS


class LateLeaf(Behaviour):
    """A leaf that is made anew at every start, with what its keys hold then.

    To the tree it is the leaf: it has its name and key, its status and its message.

    Args:
        name: the node's name in the tree.
        key: of the leaf.
        make: makes the leaf; a ValueError is a failure of the node.
    """

    def __init__(self, name: str, key: str, make: Callable[[], Behaviour]) -> None:
        super().__init__(name)
        self.key = key
        self._make = make
        self._leaf: Behaviour | None = None

    def initialise(self) -> None:
        """Make the leaf.

        Raises:
            LeafCrashedError: its constructor raised anything but a ValueError.
        """
        self._leaf = None
        try:
            self._leaf = self._make()
        except ValueError as error:
            self.feedback_message = f"refuses its parameters: {error}"
        except Exception as error:
            raise LeafCrashedError(self.name, error) from error

    def update(self) -> Status:
        """One tick of the leaf."""
        if self._leaf is None:
            return Status.FAILURE
        self._leaf.tick_once()
        self.feedback_message = self._leaf.feedback_message
        return self._leaf.status

    def terminate(self, new_status: Status) -> None:
        """Halt the leaf if it is running."""
        if self._leaf is not None and self._leaf.status is Status.RUNNING:
            self._leaf.stop(new_status)
