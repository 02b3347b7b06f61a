"""What the nodes of a file may refer to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from trees.language.diagnostics import Diagnostics
from trees.language.named_poses import Places
from trees.language.parameters import TaskParameter
from trees.language.registry import LeafType
from trees.language.source import Entry
from trees.language.syntax import SubtreeNode
from trees.language.value_types import Named
from trees.language.values import Given, KeyRead

Include: TypeAlias = "Callable[[Entry, Scope], SubtreeNode | None]"
"""Reads the node below `subtree:`."""


@dataclass(frozen=True, kw_only=True)
class Scope:
    """Names that mean something in a file, and where its diagnostics go."""

    leaves: Mapping[str, LeafType]
    parameters: Mapping[str, TaskParameter]
    places: Places
    diagnostics: Diagnostics
    include: Include
    level: int = 0
    """How many nodes and modifiers are above, those of including files counted."""
    used: set[str] = field(default_factory=set)
    """Receives the names of the poses and regions that the tree refers to."""

    def below(self, levels: int) -> Scope:
        """The scope so many levels further down."""
        return replace(self, level=self.level + levels)

    def use(self, value: object) -> None:
        """Note that a pose or region is referred to."""
        if isinstance(value, Named):
            self.used.add(value.name)

    def known(self, value: Given) -> Given:
        """The value; None if it is that of a parameter without one."""
        parameter = self.parameters.get(value.name) if isinstance(value, KeyRead) else None
        return None if parameter is not None and parameter.is_open else value
