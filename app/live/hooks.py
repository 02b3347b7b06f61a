"""Hooks: pause the run before a node, ask a person for approval, or force an outcome.

A `Hook` takes the place of a node in its parent and has the node as its only child. As long as
nobody wants anything it is transparent: same status, message and name. Viewers are built from the
nodes before hooks are inserted and do not show them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from config import UserError, quoted, suggest
from trees.language import Branch, Ticking, TreeNode, is_answer


class UnknownNodeError(UserError):
    """No node of the tree has this name."""


class Hook(Branch):
    """Wraps a node and takes its place in its parent.

    The public attributes may be set from any thread. A pause ends with the next tick of the tree,
    that is, on resume or step; `answer`, if it was set meanwhile, then replaces the node's status.
    `reached` is called when the run is to pause here, on the thread of the loop.
    """

    def __init__(self, node: Behaviour, reached: Callable[[Hook], None]) -> None:
        parent, node.parent = node.parent, None
        super().__init__(node.name, [node])
        # Messages omit the name of a branch that is named as its key, but never that of a leaf.
        self.key = str(getattr(node, "key", "")) if isinstance(node, Branch) else "hook"  # type: ignore[misc]
        self.node = node
        self.is_condition = is_answer(node)
        self.stops = False  # whether the run pauses before the node
        self.asks = False  # whether the node waits for approval each time that it is entered
        self.answer: Status | None = None
        self.forced: Status | None = None  # ends the node now, or as soon as it is entered
        self._reached = reached
        self._waiting = False
        if parent is not None:
            parent.children[parent.children.index(node)] = self
            self.parent = parent

    @property
    def waiting(self) -> bool:
        """Whether the run is paused here."""
        return self._waiting and self.status is Status.RUNNING

    def restart(self) -> None:
        """Forget a pause and its answer."""
        self._waiting, self.answer = False, None

    def advance(self) -> Ticking:
        """Tick the node, unless the run pauses before it or a person has chosen its outcome."""
        forced, self.forced = self.forced, None
        if forced is not None:
            return self._end_with(forced, "forced")
        if self._waiting:
            answer = self.answer
            self.restart()
            if answer is not None:
                return self._end_with(answer, "chosen")
        elif self.node.status is not Status.RUNNING and (self.stops or self.asks):
            self._waiting = True
            self.feedback_message = "paused before this node"
            self._reached(self)
            return Status.RUNNING
        status = yield from self.run(self.node)
        self.feedback_message = self.node.feedback_message
        return status

    def _end_with(self, outcome: Status, how: str) -> Status:
        self.restart()
        if self.node.status is Status.RUNNING:
            self.node.stop(Status.INVALID)
        self.node.status = outcome
        self.feedback_message = f"{outcome.value.lower()} {how} by a person"
        self.node.feedback_message = self.feedback_message
        return outcome


def matching(nodes: Sequence[TreeNode], wanted: str) -> list[Behaviour]:
    """The nodes with a name, a key in the task file, or a path.

    Raises UnknownNodeError: there are none.
    """
    found = [node.node for node in nodes if wanted in (*_names(node), node.path)]
    if found:
        return found
    known = sorted({name for node in nodes for name in _names(node) if name})
    hint = f"{suggest(wanted, known)} The tree has {quoted(known)}"
    raise UnknownNodeError(f"--break {wanted}: no node has this name; {hint}")


def _names(node: TreeNode) -> tuple[str, str]:
    return node.node.name, str(getattr(node.node, "key", ""))


def insert_hooks(
    root: Behaviour, nodes: Iterable[Behaviour], reached: Callable[[Hook], None]
) -> tuple[Behaviour, list[Hook]]:
    """Wrap some nodes of a tree in hooks; returns the new root and the hooks in order."""
    hooks = [Hook(node, reached) for node in nodes]
    return next((hook for hook in hooks if hook.node is root), root), hooks
