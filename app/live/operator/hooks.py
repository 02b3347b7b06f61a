"""Breakpoints: a node that stands before another one and can pause the run or answer in its place.

A `Hook` takes the place of a node in its parent and has the node as its only child. With nothing to
do it is transparent: same status, same message, same name. Viewers are given the nodes as they were
before the hooks came in, so nobody sees them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import Enum

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from config import UserError, quoted, suggest
from trees.language import Branch, Ticking, TreeNode


class UnknownNodeError(UserError):
    """No node of the tree goes by this name; the text suggests one."""


class Side(Enum):
    """Where a hook acts."""

    BEFORE = 0
    """When the node is entered; it has not done anything yet."""
    AFTER = 1
    """When the node has ended."""


@dataclass(frozen=True, kw_only=True)
class Act:
    """What a hook does on one side of its node."""

    instead: Status | None = None
    """The node's outcome, without asking the node; None pauses the run."""
    once: bool = False
    """Only the first time."""


Reached = Callable[["Hook", Side, Act], None]


class Hook(Branch):
    """Stands before a node.

    `acts` may be changed from any thread. A pause ends with the next tick of the tree, that is,
    when the run goes on or a step is made; `answer` then replaces what the node says.

    Args:
        node: the node; the hook takes its place in its parent.
        reached: told when an act comes to pass, on the thread of the loop.
    """

    def __init__(self, node: Behaviour, reached: Reached) -> None:
        parent, node.parent = node.parent, None
        super().__init__(node.name, [node])
        # A branch that is called as its key speaks without its name; a leaf always with it.
        self.key = str(getattr(node, "key", "")) if isinstance(node, Branch) else "hook"  # type: ignore[misc]
        self.node = node
        self.acts: dict[Side, Act] = {}
        self.answer: Status | None = None
        self._reached = reached
        self._waiting: Side | None = None
        self._ended = Status.INVALID
        if parent is not None:
            parent.children[parent.children.index(node)] = self
            self.parent = parent

    @property
    def waiting(self) -> bool:
        """Whether the run is paused here."""
        return self._waiting is not None and self.status is Status.RUNNING

    def restart(self) -> None:
        """Nothing is waited for yet, and nothing answered."""
        self._waiting, self.answer = None, None

    def advance(self) -> Ticking:
        """Tick the node, unless there is something to do before or after it."""
        if self._waiting is None and self.node.status is not Status.RUNNING:
            outcome = self._act(Side.BEFORE)
            if outcome is not None:
                return outcome
        elif self._waiting is not None:
            waited, self._waiting = self._waiting, None
            answer, self.answer = self.answer, None
            if answer is not None:
                self.feedback_message = f"{answer.value.lower()} chosen by a person"
                return answer
            if waited is Side.AFTER:
                return self._ended
        self._ended = yield from self.run(self.node)
        self.feedback_message = self.node.feedback_message
        if self._ended is Status.RUNNING:
            return self._ended
        outcome = self._act(Side.AFTER)
        return self._ended if outcome is None else outcome

    def _act(self, side: Side) -> Status | None:
        """What comes of reaching this side of the node; None goes on."""
        act = self.acts.get(side)
        if act is None:
            return None
        if act.once:
            self.acts.pop(side, None)
        if act.instead is not None:
            self.feedback_message = f"{act.instead.value.lower()} put in its place"
        else:
            self._waiting = side
            self.feedback_message = f"paused {side.name.lower()} it"
        self._reached(self, side, act)
        return act.instead or Status.RUNNING


def matching(nodes: Sequence[TreeNode], wanted: str) -> list[Behaviour]:
    """The nodes that a person means: by name, by key in the task file, or by path.

    Raises:
        UnknownNodeError: there is none.
    """
    found = [place.node for place in nodes if wanted in _names(place)]
    if found:
        return found
    known = sorted({name for place in nodes for name in _names(place)[:2] if name})
    hint = f"{suggest(wanted, known)} The tree has {quoted(known)}"
    raise UnknownNodeError(f"--break {wanted}: no node has this name; {hint}")


def insert_hooks(
    root: Behaviour, nodes: Iterable[Behaviour], reached: Reached
) -> tuple[Behaviour, list[Hook]]:
    """Put a hook before each of the nodes of a tree.

    Returns:
        The new root, and the hooks in the order of the nodes.
    """
    hooks = [Hook(node, reached) for node in nodes]
    top = next((hook for hook in hooks if hook.node is root), root)
    return top, hooks


def _names(place: TreeNode) -> Sequence[str]:
    return place.node.name, str(getattr(place.node, "key", "")), place.path
