"""What every leaf of a task tree is, and how the tree language finds it."""

from __future__ import annotations

from typing import ClassVar

import py_trees
from py_trees.common import Status

from behaviours.context import Context


class Leaf(py_trees.behaviour.Behaviour):
    """A behaviour that sets goals and reads the state, and never commands motion itself.

    A subclass names itself by `key`, and declares what a task file may say about it as the
    keyword-only parameters of its constructor: their annotations are the types, their defaults
    the defaults, the `Args:` section of the constructor's class their descriptions.

    Args:
        name: the node's name in the tree.
        context: what all leaves of the tree share.
    """

    key: ClassVar[str]
    """The node's key in a task file, for example `navigate`."""

    def __init__(self, name: str, context: Context) -> None:
        super().__init__(name)
        self.context = context

    def running(self, message: str) -> Status:
        """Say what is under way."""
        self.feedback_message = message
        return Status.RUNNING

    def success(self, message: str) -> Status:
        """End well, saying how."""
        self.feedback_message = message
        return Status.SUCCESS

    def failure(self, reason: str) -> Status:
        """End badly, saying why."""
        self.feedback_message = reason
        return Status.FAILURE
