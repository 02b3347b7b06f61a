"""Scope of a file: the names that its nodes may refer to."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TypeAlias

from config import Diagnostics, YamlEntry, YamlScalar, YamlValue, suggest
from trees.language.leaf_type import LeafType
from trees.language.mappings import WORD
from trees.language.named_poses import NamedValues
from trees.language.parameters import TaskParameter
from trees.language.syntax import SubtreeNode
from trees.language.value_types import NamedValue
from trees.language.values import Argument, KeyRead, Reference

Include: TypeAlias = "Callable[[YamlEntry, Scope], SubtreeNode | None]"
"""Reads the node below `subtree:`."""


def _meant(text: str) -> str:
    """The hint about a `$` that no name alone follows."""
    if braced := re.fullmatch(r"\$\{\s*(\w+)\s*\}", text):
        return f"write `${braced[1]}`"
    if re.match(r"\$\w+\s*[-+*/%<>=!]", text):
        return "nothing is computed in a task: count with `add`, compare with `at_least`, `equals`"
    return "write `$` and its name"


@dataclass(frozen=True, kw_only=True)
class Scope:
    """The names of a file, and its diagnostics."""

    leaves: Mapping[str, LeafType]
    parameters: Mapping[str, TaskParameter]
    named: NamedValues
    diagnostics: Diagnostics
    include: Include
    fetch: Callable[[str | None], None] = lambda name: None
    """Imports what packages offer by a name, or all, into `leaves` and `problems`."""
    problems: Mapping[str, str] = field(default_factory=dict)
    """Of leaves that cannot be used, by their names."""
    level: int = 0
    """How many nodes and modifiers are above, those of including files counted."""
    copies: count[int] = field(default_factory=count)
    """Counts the nodes that `for_each` makes."""
    used_parameters: set[str] = field(default_factory=set)
    """Receives the names of the parameters that the tree refers to."""
    used_values: set[str] = field(default_factory=set)
    """Receives the names of the poses and regions that the tree refers to."""

    def below(self, levels: int) -> Scope:
        """The scope this number of levels further down."""
        return replace(self, level=self.level + levels)

    def resolve(self, value: YamlValue) -> YamlValue | Reference | None:
        """The value, or what its `$name` refers to; None if there is an error."""
        text = value.value if isinstance(value, YamlScalar) else None
        if not isinstance(text, str) or not text.startswith("$"):
            return value
        name = text[1:]
        parameter = self.parameters.get(name)
        if parameter is None and not WORD.fullmatch(name):
            message = f"`{text}` begins with `$` and is neither a parameter nor a key"
            self.diagnostics.error(value.location, message, _meant(text))
            return None
        if parameter is None:
            return Reference(location=value.location, name=name)
        self.used_parameters.add(name)
        if parameter.type is None:
            return None
        known = None if isinstance(parameter.value, KeyRead) else parameter.value
        return Reference(location=value.location, name=name, value=known)

    def text(self, value: YamlValue) -> object:
        """The value of a scalar; None for others, and if it is known only during the run."""
        resolved = self.resolve(value)
        return resolved.value if isinstance(resolved, YamlScalar | Reference) else None

    def use(self, value: object) -> None:
        """Note that a pose or region is referred to."""
        if isinstance(value, NamedValue):
            self.used_values.add(value.name)

    def known(self, value: Argument) -> Argument:
        """The value; None if it is that of a parameter without one."""
        parameter = self.parameters.get(value.name) if isinstance(value, KeyRead) else None
        return None if parameter is not None and parameter.is_open else value

    def unknown_parameter(self, name: str) -> tuple[str, str]:
        """Message and hint about a `$name` that has to be a parameter and is none."""
        hint = suggest(name, self.parameters) if self.parameters else "define it under `params:`"
        return f"the task has no parameter `{name}`", hint

    def mismatch(self, value: YamlValue | Reference, message: str, hint: str) -> None:
        """Note a value that does not fit, unless it names a pose with an error of its own."""
        name = getattr(value, "value", None)
        if isinstance(name, str) and name in self.named.locations:
            self.used_values.add(name)
            if self.named.is_faulty(name):
                return
        self.diagnostics.error(value.location, message, hint)
