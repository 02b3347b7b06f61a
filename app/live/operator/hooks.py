"""Hooks, as in BehaviorTree.CPP: pause the run before or after a node, or replace its outcome.

A `Hook` takes the place of a node in its parent and has the node as its only child. Without an
action it is transparent: same status, message and name. Viewers are built from the nodes before
hooks are inserted and do not show them.
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
    """No node of the tree has this name."""


class Side(Enum):
    """When a hook acts: when the node is entered, or when it has ended."""

    BEFORE = 0
    AFTER = 1


@dataclass(frozen=True, kw_only=True)
class HookAction:
    """Action of a hook on one side of its node."""

    replace_with: Status | None = None
    """Status returned instead of the node's; None pauses the run."""
    once: bool = False
    """Act the first time only."""


Reached = Callable[["Hook", Side, HookAction], None]


class Hook(Branch):
    """Wraps a node and takes its place in its parent.

    `actions` may be changed from any thread. A pause ends with the next tick of the tree, that is,
    on resume or step; `answer`, if it was set meanwhile, then replaces the node's status. `reached`
    is called when an action takes place, on the thread of the loop; `asks` makes the node wait for
    approval each time that it is entered.
    """

    def __init__(self, node: Behaviour, reached: Reached) -> None:
        parent, node.parent = node.parent, None
        super().__init__(node.name, [node])
        # Messages omit the name of a branch that is named as its key, but never that of a leaf.
        self.key = str(getattr(node, "key", "")) if isinstance(node, Branch) else "hook"  # type: ignore[misc]
        self.node = node
        self.actions: dict[Side, HookAction] = {}
        self.answer: Status | None = None
        self.asks = False
        self._forced: Status | None = None
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

    @property
    def chosen(self) -> Status | None:
        """The outcome that was chosen for the node, if any."""
        replaced = (action.replace_with for action in self.actions.copy().values())
        return self._forced or next(filter(None, replaced), None)

    def force(self, outcome: Status | None) -> None:
        """End the node with an outcome, now or as soon as it is entered; None revokes it."""
        self._forced = outcome

    def restart(self) -> None:
        """Forget a pause and its answer."""
        self._waiting, self.answer = None, None

    def advance(self) -> Ticking:
        """Tick the node, with the actions before and after it."""
        forced, self._forced = self._forced, None
        if forced is not None:
            return self._end_with(forced)
        if self._waiting is None and self.node.status is not Status.RUNNING:
            outcome = self._act(Side.BEFORE)
            if outcome is not None:
                return outcome
        elif self._waiting is not None:
            waited, self._waiting = self._waiting, None
            answer, self.answer = self.answer, None
            if answer is not None:
                self.feedback_message = f"{answer.value.lower()} chosen by a person"
                self.node.status = answer
                self.node.feedback_message = self.feedback_message
                return answer
            if waited is Side.AFTER:
                return self._ended
        self._ended = yield from self.run(self.node)
        self.feedback_message = self.node.feedback_message
        if self._ended is Status.RUNNING:
            return self._ended
        outcome = self._act(Side.AFTER)
        return self._ended if outcome is None else outcome

    def _end_with(self, outcome: Status) -> Status:
        self.restart()
        if self.node.status is Status.RUNNING:
            self.node.stop(Status.INVALID)
        self.node.status = outcome
        self.feedback_message = f"{outcome.value.lower()} forced by a person"
        self.node.feedback_message = self.feedback_message
        return outcome

    def _act(self, side: Side) -> Status | None:
        """Status to return at this side of the node; None to continue."""
        action = self.actions.get(side)
        if action is None and side is Side.BEFORE and self.asks:
            action = HookAction()
        if action is None:
            return None
        if action.once:
            self.actions.pop(side, None)
        if action.replace_with is not None:
            self.feedback_message = f"replaced with {action.replace_with.value.lower()}"
        else:
            self._waiting = side
            self.feedback_message = f"paused {side.name.lower()} this node"
        self._reached(self, side, action)
        return action.replace_with or Status.RUNNING


def matching(nodes: Sequence[TreeNode], wanted: str) -> list[Behaviour]:
    """The nodes with a name, a key in the task file, or a path.

    Raises:
        UnknownNodeError: there are none.
    """
    found = [node.node for node in nodes if wanted in _names(node)]
    if found:
        return found
    known = sorted({name for node in nodes for name in _names(node)[:2] if name})
    hint = f"{suggest(wanted, known)} The tree has {quoted(known)}"
    raise UnknownNodeError(f"--break {wanted}: no node has this name; {hint}")


def insert_hooks(
    root: Behaviour, nodes: Iterable[Behaviour], reached: Reached
) -> tuple[Behaviour, list[Hook]]:
    """Wrap some nodes of a tree in hooks; returns the new root and the hooks in order."""
    hooks = [Hook(node, reached) for node in nodes]
    top = next((hook for hook in hooks if hook.node is root), root)
    return top, hooks


def _names(node: TreeNode) -> Sequence[str]:
    return node.node.name, str(getattr(node.node, "key", "")), node.path
