"""Warnings: what a task file may say, and hardly means."""

from __future__ import annotations

from trees.language.mistakes import Mistakes
from trees.language.syntax import Node


def lint(root: Node, mistakes: Mistakes) -> None:
    """Warn of nodes that are never reached, guards asked once, and modifiers without effect."""
