"""What a task file says, checked and with every name and parameter resolved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from trees.language.mistakes import Place
from trees.language.registry import LeafType
from trees.language.source import Plain


@dataclass(frozen=True, kw_only=True)
class LeafNode:
    """A leaf and its arguments."""

    place: Place
    name: str
    modifiers: Mapping[str, Plain]
    """Values by key."""
    type: LeafType
    arguments: Mapping[str, object]
    """What the file gives; the leaf's own defaults are not filled in."""


@dataclass(frozen=True, kw_only=True)
class CompositeNode:
    """A composite and its children."""

    place: Place
    name: str
    modifiers: Mapping[str, Plain]
    """Values by key."""
    key: str
    children: tuple[Node, ...]


Node: TypeAlias = LeafNode | CompositeNode
