"""Scope of a file, the names that its nodes may refer to; and arguments of leaves in it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TypeAlias

from behaviours import Key
from config import (
    Diagnostics,
    Hint,
    Location,
    Rule,
    YamlEntry,
    YamlMap,
    YamlScalar,
    YamlValue,
    describe,
    parted,
    written,
)
from trees.language import rules
from trees.language.documents import TaskParameter
from trees.language.leaf_type import ADD, LeafType
from trees.language.mappings import WORD, likely, parameter_hint, usage
from trees.language.named_poses import NamedValues
from trees.language.registry import Installed
from trees.language.syntax import LeafNode, SubtreeNode
from trees.language.values import (
    Argument,
    KeyRead,
    KeyWrite,
    MismatchError,
    Reference,
    convert,
    described,
    meant,
    number_in,
    radians_for_degrees,
)
from trees.words import NAMED_TYPES, NamedValue, ValueType

Include: TypeAlias = "Callable[[YamlEntry, Scope], SubtreeNode | None]"
"""Reads the node below `subtree:`."""


@dataclass(frozen=True, kw_only=True)
class Scope:
    """The names of a file, and its diagnostics."""

    known: Installed
    parameters: Mapping[str, TaskParameter]
    named: NamedValues
    diagnostics: Diagnostics
    include: Include
    level: int = 0  # how many nodes and modifiers are above, those of including files counted
    copies: count[int] = field(default_factory=count)  # counts the nodes that `for_each` makes
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
            hint = "write `$` and its name: nothing is computed in a task"
            self.error(rules.REFERENCE, value.location, message, hint)
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

    def if_known(self, value: Argument) -> Argument:
        """The value; None if it is that of a parameter without one."""
        parameter = self.parameters.get(value.name) if isinstance(value, KeyRead) else None
        return None if parameter is not None and parameter.is_open else value

    def error(self, rule: Rule, location: Location, message: str, hint: str) -> None:
        """Note an error in the file."""
        self.diagnostics.error(rule, location, message, hint)

    def mismatch(self, rule: Rule, value: YamlValue | Reference, message: str, hint: str) -> None:
        """Note a value that does not fit, unless it names a pose with an error of its own."""
        name = getattr(value, "value", None)
        if isinstance(name, str) and name in self.named.locations:
            self.used_values.add(name)
            if self.named.is_faulty(name):
                return
        self.error(rule, value.location, message, hint)


_ANYTHING = ValueType(types=(bool, int, float, str, *NAMED_TYPES))  # what `set` may write
_NUMBER = ValueType(types=(int, float))  # what `add` may add


def read_leaf(
    entry: YamlEntry, leaf: LeafType, beside: Mapping[str, YamlEntry], scope: Scope
) -> LeafNode:
    """A leaf and its arguments; invalid ones are noted and left out.

    `beside` are all entries of the item.
    """
    node = LeafNode(location=entry.location, name=leaf.key, type=leaf, arguments={})
    given = _below(entry, leaf, scope)
    if given is None:
        return node
    if leaf.names_keys:
        return _read_set(node, given, scope)
    # One that stands beside the leaf by mistake is noted there.
    for parameter in leaf.described:
        if parameter.required and parameter.name not in {*given, *beside}:
            about = f": {parameter.description}" if parameter.description else ""
            purpose = "a key for " if parameter.name in leaf.outputs else ""
            message = f"`{leaf.key}` lacks `{parameter.name}` ({purpose}{parameter.type}{about})"
            scope.error(rules.MISSING_KEY, entry.location, message, usage(leaf, scope.named.values))
    arguments: dict[str, Argument] = {}
    outputs: dict[str, KeyWrite] = {}
    for key, argument in given.items():
        if key in leaf.outputs:
            name = read_key_name(key, argument.value, scope)
            if name is not None:
                outputs[key] = name
        elif key in leaf.parameters:
            parameter = leaf.parameters[key]
            arguments |= read_argument(
                key, argument.value, parameter.type, parameter.description, scope, parameter.unit
            )
        else:
            message = f"`{leaf.key}` has no parameter `{key}`"
            hint = parameter_hint(key, _place(argument.value, scope), leaf, given)
            scope.error(rules.UNKNOWN_KEY, argument.location, message, hint)
    if leaf.validate is not None and len(arguments) + len(outputs) == len(given):
        reads = [(name, one) for name, one in arguments.items() if isinstance(one, KeyRead)]
        late: dict[str, object] = {name: Key(one.name) for name, one in reads}
        if wrong := leaf.validate({**arguments, **late}):
            what, hint = parted(wrong)
            message, hint = f"`{leaf.key}` {what}", hint or "change it"
            scope.error(rules.ARGUMENTS, entry.location, message, hint)
    return replace(node, arguments=arguments, outputs=outputs)


def read_argument(
    name: str, value: YamlValue, expected: ValueType, description: str, scope: Scope, unit: str = ""
) -> dict[str, Argument]:
    """The argument for a parameter, by its name; empty, and an error, if it does not fit.

    A number in another unit does not fit.
    """
    resolved = scope.resolve(value)
    if resolved is None:
        return {}
    try:
        argument = convert(resolved, expected, scope.named.values)
    except MismatchError as mismatch:
        about = f" ({description})" if description else ""
        given = getattr(resolved, "value", None)
        number = given if isinstance(given, float | int) and not isinstance(given, bool) else 0.0
        hint = meant(number, unit, expected.within) or mismatch.hint
        if isinstance(given, str) and given in scope.parameters:
            hint = Hint(f"write `${given}`", given, f"${given}")
        elif given in scope.named.paths:
            hint = Hint(f"`{given}` is a path: give `for_each` that `in:`, and its item here")
        elif isinstance(given, str) and expected.is_number:
            hint = number_in(given, unit, expected.within) or hint
        scope.mismatch(mismatch.rule, resolved, f"`{name}`{about}: {mismatch.message}", hint)
        return {}
    if unit == "°" and isinstance(argument, float) and (odd := radians_for_degrees(argument)):
        message, hint = parted(odd)
        scope.error(rules.VALUE, value.location, f"`{name}`: {message}", hint)
        return {}
    scope.use(argument)
    return {name: argument}


def _below(entry: YamlEntry, leaf: LeafType, scope: Scope) -> Mapping[str, YamlEntry] | None:
    """What stands below a leaf's key; None and an error if it cannot be parameters."""
    value = entry.value
    if isinstance(value, YamlScalar) and value.value is None:
        return {}
    if isinstance(value, YamlMap):
        return value.entries
    message = f"`{leaf.key}` takes a mapping of parameters, not {describe(value)}"
    hint = usage(leaf, scope.named.values)
    if isinstance(value, YamlScalar) and not isinstance(value.value, bool):
        if len(meant_for := likely(_place(value, scope), leaf, ())) == 1:
            text = written(value.value)
            inner = text if WORD.fullmatch(text.lstrip("$")) else json.dumps(value.value)
            hint = Hint(hint, text, f"{{{meant_for[0]}: {inner}}}")
    elif isinstance(value, YamlScalar) and not leaf.described:
        hint = Hint(hint, written(value.value), "{}")
    scope.error(rules.VALUE, value.location, message, hint)
    return None


def _read_set(node: LeafNode, given: Mapping[str, YamlEntry], scope: Scope) -> LeafNode:
    if not given:
        message, hint = f"`{node.name}` names no key", f"write `{node.name}: {{key: value}}`"
        scope.error(rules.VALUE, node.location, message, hint)
    arguments: dict[str, Argument] = {}
    outputs: dict[str, KeyWrite] = {}
    for key, argument in given.items():
        write = read_key_name(node.name, YamlScalar(location=argument.location, value=key), scope)
        resolved = scope.resolve(argument.value)
        if resolved is None:
            continue
        try:
            value = convert(resolved, _NUMBER if node.type is ADD else _ANYTHING, {})
        except MismatchError as mismatch:
            verb = "add" if node.type is ADD else "write"
            message = f"`{node.name}` cannot {verb} {described(resolved)}"
            hint = "give a number, a text, `true`, `false`, a parameter or a key"
            hint = mismatch.hint if node.type is ADD else hint
            scope.mismatch(mismatch.rule, resolved, message, hint)
        else:
            if write is not None:
                arguments[key], outputs[key] = value, write
    return replace(node, arguments=arguments, outputs=outputs)


def read_key_name(key: str, value: YamlValue, scope: Scope) -> KeyWrite | None:
    """The key that an output is written to; None and an error if it cannot be one."""
    name = value.value if isinstance(value, YamlScalar) else None
    if not isinstance(name, str) or not WORD.fullmatch(name):
        message = f"`{key}` names a key to write to, and cannot be {describe(value)}"
        plain = (name, name[1:]) if isinstance(name, str) and name.startswith("$") else ()
        hint = Hint("write a word of letters, digits and `_`, without `$`", *plain)
        scope.error(rules.NAMING, value.location, message, hint)
        return None
    if name in scope.parameters:
        message = f"`{name}` is a parameter, and cannot be written to"
        scope.error(rules.NAMING, value.location, message, "choose another name for the key")
        return None
    return KeyWrite(location=value.location, name=name)


def _place(value: YamlValue, scope: Scope) -> NamedValue | None:
    """The place that a value names."""
    return scope.named.values.get(str(scope.text(value)))
