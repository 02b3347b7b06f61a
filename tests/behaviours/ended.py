"""What leaves say that have ended."""

from harness import Harness
from py_trees.common import Status

from behaviours import Leaf


def failure(harness: Harness, leaf: Leaf, seconds: float = 30.0) -> str:
    """What a leaf says that fails."""
    assert harness.run(leaf, seconds) is Status.FAILURE, leaf.feedback_message
    return leaf.feedback_message


def success(harness: Harness, leaf: Leaf, seconds: float = 30.0) -> str:
    """What a leaf says that succeeds."""
    assert harness.run(leaf, seconds) is Status.SUCCESS, leaf.feedback_message
    return leaf.feedback_message
