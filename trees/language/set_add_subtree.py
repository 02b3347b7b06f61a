"""The nodes `set`, `add` and `subtree`, and leaves with late arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from behaviours import Key, LeafCrashedError
from trees.language.branch import Branch, Ticking

Supply = Callable[[], object]
"""Returns a value when it is called."""


class Set(Behaviour):
    """Writes values to keys.

    Args:
        name: the node's name in the tree.
        values: for each key.
    """

    key = "set"

    def __init__(self, name: str, values: Mapping[Key[object], Supply]) -> None:
        super().__init__(name)
        self._values = values

    def update(self) -> Status:
        """One tick.

        Raises:
            LeafCrashedError: a key was read that was not written.
        """
        _write(self.name, {key: self._new(key, one) for key, one in self._values.items()})
        self.feedback_message = ", ".join(f"{key.name} = {key.read()}" for key in self._values)
        return Status.SUCCESS

    def _new(self, key: Key[object], supply: Supply) -> Supply:
        return supply


class Add(Set):
    """Adds numbers to keys."""

    key = "add"

    def _new(self, key: Key[object], supply: Supply) -> Supply:
        return partial(_sum, key, supply)


def _sum(key: Key[object], supply: Supply) -> object:
    before, more = key.read(), supply()
    assert isinstance(before, int | float)
    assert isinstance(more, int | float)
    return before + more


class Subtree(Branch):
    """Runs the tree of another file, whose keys are its own.

    Args:
        name: the node's name in the tree.
        child: the root of the other tree.
        inputs: its keys that get a value at every start.
        outputs: the keys around it that get the values of its own when it succeeds.
    """

    key = "subtree"

    def __init__(
        self,
        name: str,
        child: Behaviour,
        *,
        inputs: Mapping[Key[object], Supply],
        outputs: Mapping[Key[object], Key[object]],
    ) -> None:
        super().__init__(name, [child])
        self._inputs = inputs
        self._outputs = outputs

    def restart(self) -> None:
        """Write its inputs."""
        _write(self.name, self._inputs)

    def advance(self) -> Ticking:
        """Tick it; a success writes its outputs."""
        status = yield from self.run(self.children[0])
        if status is Status.SUCCESS:
            _write(self.name, {outer: inner.read for outer, inner in self._outputs.items()})
        return status


class LateLeaf(Behaviour):
    """A leaf that is made at every start, with the present values of its keys.

    It has the leaf's name, key, status and message.

    Args:
        name: the node's name in the tree.
        key: of the leaf.
        is_condition: whether the leaf is one.
        make: makes the leaf; a ValueError is a failure of the node.
    """

    def __init__(
        self, name: str, key: str, is_condition: bool, make: Callable[[], Behaviour]
    ) -> None:
        super().__init__(name)
        self.key = key
        self.is_condition = is_condition
        self._make = make
        self._leaf: Behaviour | None = None

    @property
    def phase(self) -> str:
        """That of the leaf."""
        return str(getattr(self._leaf, "phase", ""))

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


def _write(node: str, values: Mapping[Key[object], Supply]) -> None:
    """Write values to keys; reading a key that was not written raises LeafCrashedError."""
    try:
        for key, supply in values.items():
            key.write(supply())
    except LookupError as error:
        raise LeafCrashedError(node, error) from error
