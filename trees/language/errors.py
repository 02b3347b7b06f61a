"""Errors of people who write tasks and leaves."""

from __future__ import annotations

from collections.abc import Iterable

from config import Diagnostic, UserError


class TaskFileError(UserError):
    """A task file cannot be used.

    Args:
        diagnostics: everything that is wrong with it and its subtrees, in order.
    """

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(str(diagnostic) for diagnostic in self.diagnostics))


class LeafError(UserError):
    """A leaf class cannot be used in task files; the text says which and what to change."""
