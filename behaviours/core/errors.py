"""Errors in the code of a leaf; apart from `leaf`, as `check` imports them without numpy."""


class LeafCrashedError(Exception):
    """A leaf raised an exception: an error in its code, not in the task.

    Args:
        leaf: name of the node.
        error: what it raised.
    """

    def __init__(self, leaf: str, error: BaseException) -> None:
        super().__init__(f"{type(error).__name__}: {error}")
        self.leaf = leaf


class TwoGoalsError(Exception):
    """Two leaves that run at the same time have set a goal in one tick."""
