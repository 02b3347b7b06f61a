"""Nodes on values: `switch`, `for_each`, `set`, `add`, `subtree`, leaves with late arguments."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import cast

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from behaviours import Key, LeafCrashedError
from config import parse_scalar
from trees.words.branch import Branch, Ticking
from trees.words.composites import CompositeWord, Form, Sequence
from trees.words.outcomes import each, one_of

Supply = Callable[[], object]  # returns a value when it is called


def is_case(value: object, case: str) -> bool:
    """Whether a value is the one that a file writes like this; true is not 1."""
    if isinstance(value, str):
        return value == case
    read = parse_scalar(case)
    return value == read and isinstance(value, bool) is isinstance(read, bool)


class Switch(CompositeWord):
    """Runs the child that stands for a value; fails if none does and there is no `else`.

    The children stand for the `cases`, as a file writes them, and one more for `else`; `value`
    decides when it starts.
    """

    key, symbol, outcomes, form = "switch", "⎇", one_of, Form.CASES
    takes = "a `value`, `cases`, and perhaps `else`"

    def __init__(
        self, name: str, children: Iterable[Behaviour], value: Supply, cases: tuple[str, ...]
    ) -> None:
        super().__init__(name, children)
        self._value, self._cases = value, cases

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

    key, symbol, outcomes, form = "for_each", "∀", each, Form.EACH
    takes = "an `item`, values or a path `in`, and what to `do`"


class ForEachOf(Branch):
    """Runs its child for each value of a list, which is read when it starts.

    The key `item` has the value whose turn it is.
    """

    key = "for_each"

    def __init__(
        self, name: str, children: Iterable[Behaviour], *, values: Supply, item: Key[object]
    ) -> None:
        super().__init__(name, children)
        self._read, self._item = values, item

    def restart(self) -> None:
        """Read the list and begin with its first value.

        Raises LeafCrashedError: it was not written; its writer is at fault.
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


class Set(Behaviour):
    """Writes values to keys."""

    key = "set"

    def __init__(self, name: str, values: Mapping[Key[object], Supply]) -> None:
        super().__init__(name)
        self._values = values

    def update(self) -> Status:
        """One tick. Raises LeafCrashedError: a key was read that was not written."""
        _write(self.name, {key: self._new(key, one) for key, one in self._values.items()})
        self.feedback_message = ", ".join(f"{key.name} = {key.read()}" for key in self._values)
        return Status.SUCCESS

    def _new(self, key: Key[object], supply: Supply) -> Supply:
        return supply


class Add(Set):
    """Adds numbers to keys."""

    key = "add"

    def _new(self, key: Key[object], supply: Supply) -> Supply:
        return lambda: cast(float, key.read()) + cast(float, supply())


class Subtree(Branch):
    """Runs the tree of another file, whose keys are its own.

    `inputs` are its keys that get a value at every start, `outputs` the keys around it that get the
    values of its own when it succeeds.
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
        self._inputs, self._outputs = inputs, outputs

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

    It has the leaf's name, key, status and message; a ValueError of `make` is a failure of the
    node.
    """

    def __init__(
        self, name: str, key: str, is_condition: bool, make: Callable[[], Behaviour]
    ) -> None:
        super().__init__(name)
        self.key, self.is_condition, self._make = key, is_condition, make
        self._leaf: Behaviour | None = None

    @property
    def phase(self) -> str:
        """That of the leaf."""
        return str(getattr(self._leaf, "phase", ""))

    @property
    def overdue(self) -> bool:
        """That of the leaf, if it is a condition."""
        return bool(getattr(self._leaf, "overdue", False))

    def initialise(self) -> None:
        """Make the leaf.

        Raises LeafCrashedError: its constructor raised anything but a ValueError.
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
