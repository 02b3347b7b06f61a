"""Base class of composites and modifiers, and functions on built trees.

A child that returns INVALID has failed. A halt calls `terminate` of each running leaf once, and of
no other. The feedback message of a branch is that of the child that decides it, with the child's
name. An exception passes through; a halt then still reaches every leaf that was running.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite

if TYPE_CHECKING:
    from behaviours import Context, Intent
    from hw import TaskTime

Now = Callable[[], "TaskTime"]  # the time of the task

ROUNDING = 1e-9
"""Stamps are sums of periods: this keeps the number of ticks independent of their rounding [s]."""

_AT_ONCE = 0.5  # a node that fails within this time fails at once [s]
_PAUSE, _LONGEST_PAUSE = 0.1, 1.0  # before it starts again [s]

Ticking = Generator[Behaviour, None, Status]  # yields the nodes that it ticks and returns a status


@dataclass(frozen=True)
class Counterpart:
    """The equivalent node of BehaviorTree.CPP 4."""

    tag: str
    port: str = ""  # the attribute that takes the word's value; empty if it has none
    scale: int = 1  # the attribute is the value times this, a whole number
    fixed: tuple[tuple[str, str], ...] = ()  # constant attributes


class Need(Enum):
    """What a node must be able to do for a word around it to have an effect, else the reason."""

    SUCCESS = "it cannot succeed"
    FAILURE = "it cannot fail"
    TIME = "it ends at once"
    NOTHING = "it always has one"


class Branch(Composite):
    """A node with children; a subclass decides in `advance` which of them to tick.

    It has at least one child, in the order of the file; an unnamed one is named by its key.
    """

    key: ClassVar[str]
    description: ClassVar[str]  # the first line of its docstring
    counterpart: ClassVar[Counterpart | None] = None
    """Of BehaviorTree.CPP; None if it has none, and the export declares a node of this key."""
    takes_time: ClassVar[bool] = False  # whether it may run for more than a tick by itself
    needs: ClassVar[Need] = Need.NOTHING  # what the node below has to be able to do

    def __init_subclass__(cls) -> None:
        cls.description = (cls.__doc__ or "").partition("\n")[0]

    def __init__(self, name: str, children: Iterable[Behaviour]) -> None:
        super().__init__(name, list(children))

    @classmethod
    def from_context(cls, context: Context) -> Mapping[str, object]:
        """More options, which the context of the task has."""
        return {}

    def restart(self) -> None:
        """Called before the first tick of a new round."""

    @abstractmethod
    def advance(self) -> Ticking:
        """Tick the children that are due; returns the status of the branch."""

    def tick(self) -> Generator[Behaviour, None, None]:
        """Tick once; yields every node ticked, this one last."""
        if self.status is not Status.RUNNING:
            self.rewind()
            self.restart()
        status = yield from self.advance()
        if status is Status.RUNNING:
            self.status = status
        else:
            self.stop(status)
        yield self

    def run(self, child: Behaviour) -> Ticking:
        """Tick a child; returns its status, which is FAILURE if it is INVALID."""
        self.current_child = child
        yield from child.tick() if is_answer(self) else ticked(child)
        self.feedback_message = reason(child)
        return Status.FAILURE if child.status is Status.INVALID else child.status

    def rewind(self) -> None:
        """Bring all children to rest, ready for a new round."""
        self.current_child = None
        for child in self.children:
            halt(child)

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End with `new_status`: INVALID halts everything below, else only what still runs."""
        if new_status is Status.INVALID:
            self.rewind()
        for child in self.children:
            if child.status is Status.RUNNING:
                halt(child)
        self.status = new_status


class Again:
    """When a failed node starts again: at the next tick, unless it fails at once.

    From the second immediate failure in a row on it pauses first, from 0.1 s doubling up to 1 s. An
    answer of a condition is no failure: it may be asked at every tick.
    """

    def __init__(self, now: Now) -> None:
        self._now = now
        self._begun: TaskTime | None = None
        self._due: TaskTime | None = None
        self._in_a_row = 0

    def waits(self) -> bool:
        """Whether it does not start yet; asked at every tick before the node is run."""
        if self._begun is None:
            now = self._now()
            if self._due is not None and self._due - now > ROUNDING:
                return True
            self._begun = now
        return False

    def ended(self, failed: Behaviour | None) -> None:
        """The node has ended: it has failed because of a node below it, or succeeded (None)."""
        now, begun = self._now(), self._begun
        self._begun = None
        if failed is None or is_answer(failed) or (begun is not None and now - begun > _AT_ONCE):
            self._in_a_row, self._due = 0, None
            return
        self._in_a_row += 1
        if self._in_a_row > 1:
            self._due = now + min(_LONGEST_PAUSE, _PAUSE * 2.0 ** (self._in_a_row - 2))


def intent_of(root: Behaviour, context: Context) -> Intent | None:
    """Tick a tree once; returns what it wants of the coming period, None to come to rest."""
    for _ in ticked(root):
        pass
    return context.now.intent


def ticked(node: Behaviour) -> Iterator[Behaviour]:
    """Tick a node that no condition asks; yields every node ticked, this one last.

    A condition that has not known its answer for too long fails.
    """
    for each in node.tick():
        if each is node and _is_overdue(node):
            _give_up(node)
        yield each


def _is_overdue(node: Behaviour) -> bool:
    if not is_answer(node) or node.status is not Status.RUNNING:
        return False
    return bool(getattr(node, "overdue", False)) or any(map(_is_overdue, node.children))


def _give_up(node: Behaviour) -> None:
    for child in node.children:
        if child.status is Status.RUNNING:
            _give_up(child)
    node.stop(Status.FAILURE)


def is_answer(node: Behaviour) -> bool:
    """Whether it is a condition, whose failure is an answer."""
    return bool(getattr(node, "is_condition", False))


def is_unknown(node: Behaviour) -> bool:
    """Whether a failed node has failed as the answer of a condition was not known."""
    return bool(getattr(failed_node(node), "overdue", False))


def is_out_of_reach(node: Behaviour) -> bool:
    """Whether a node has failed because its goal cannot be reached: so it will again."""
    return bool(getattr(node, "out_of_reach", False))


def halt(node: Behaviour) -> None:
    """Bring a subtree to rest; every running leaf is stopped once, the others are only reset."""
    if node.children or node.status is Status.RUNNING:
        node.stop(Status.INVALID)
    else:
        node.status = Status.INVALID


def reason(node: Behaviour) -> str:
    """The message of a node, after its name if it is a leaf or has a name of its own."""
    message = str(node.feedback_message or node.status.value.lower())
    unnamed = isinstance(node, Branch) and node.name == node.key
    return message if unnamed else f"{node.name}: {message}"


def failed_node(root: Behaviour) -> Behaviour:
    """The deepest node that made a failed tree fail: down the last failed child of each node.

    Of a condition, down the last that was not known, if there is one.
    """
    node = root
    while failed := [child for child in node.children if child.status is Status.FAILURE]:
        unknown = [child for child in failed if is_answer(node) and is_unknown(child)]
        node = (unknown or failed)[-1]
    return node


class TreeNode(NamedTuple):
    """A node and where it is in its tree."""

    path: str  # names from the root down, joined by `/`; no other node of the tree has it
    node: Behaviour
    depth: int  # 0 for the root


def nodes_in_order(root: Behaviour) -> list[TreeNode]:
    """All nodes, parents before children and children in their order.

    Siblings of the same name are told apart by a number: `navigate`, `navigate 2`.
    """
    return list(_below(TreeNode(root.name, root, 0)))


def _below(parent: TreeNode) -> Iterator[TreeNode]:
    yield parent
    taken: set[str] = set()
    for child in parent.node.children:
        name, number = child.name, 1
        while name in taken:
            number += 1
            name = f"{child.name} {number}"
        taken.add(name)
        yield from _below(TreeNode(f"{parent.path}/{name}", child, parent.depth + 1))
