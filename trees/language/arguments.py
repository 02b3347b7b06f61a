"""Arguments of a leaf in a task file: values of its parameters, and the keys that it writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from behaviours import Key
from config import YamlEntry, YamlMap, YamlScalar, YamlValue, describe, quoted, suggest
from trees.language import aliases
from trees.language.aliases import renamed
from trees.language.leaf_type import ADD, LeafType
from trees.language.mappings import WORD
from trees.language.scope import Scope
from trees.language.syntax import LeafNode
from trees.language.units import meant, radians_for_degrees
from trees.language.value_types import NAMED_TYPES, ValueType
from trees.language.values import Argument, KeyRead, KeyWrite, MismatchError, convert, described
from trees.language.vocabulary import MODIFIERS, NAME

_ANYTHING = ValueType(types=(bool, int, float, str, *NAMED_TYPES))
"""What `set` may write."""
_NUMBER = ValueType(types=(int, float))
"""What `add` may add."""


def read_leaf(
    entry: YamlEntry, leaf: LeafType, beside: Mapping[str, YamlEntry], scope: Scope
) -> LeafNode:
    """A leaf and its arguments; invalid ones are noted and left out.

    Args:
        entry: the leaf's key and value.
        leaf: its type.
        beside: all entries of the item.
        scope: of the file.
    """
    node = LeafNode(location=entry.location, name=leaf.key, modifiers={}, type=leaf, arguments={})
    given = _below(entry, leaf, scope)
    if given is None:
        return node
    if leaf.names_keys:
        return _read_set(node, given, scope)
    names = {**leaf.parameters, **leaf.outputs}
    given = renamed(given, aliases.PARAMETERS, names, scope.diagnostics)
    # One that stands beside the leaf by mistake is noted there.
    for parameter in leaf.described:
        if parameter.required and parameter.name not in {*given, *beside}:
            about = f": {parameter.description}" if parameter.description else ""
            purpose = "a key for " if parameter.name in leaf.outputs else ""
            message = f"`{leaf.key}` lacks `{parameter.name}` ({purpose}{parameter.type}{about})"
            scope.diagnostics.error(entry.location, message, _usage(leaf, scope))
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
            scope.diagnostics.error(argument.location, message, _parameter_hint(key, leaf))
    if len(arguments) + len(outputs) == len(given):
        _validate(entry, leaf, arguments, scope)
    return replace(node, arguments=arguments, outputs=outputs)


def _validate(
    entry: YamlEntry, leaf: LeafType, arguments: Mapping[str, Argument], scope: Scope
) -> None:
    """Let the leaf check whether its arguments are compatible."""
    known: dict[str, object] = {
        name: Key(value.name) if isinstance(value, KeyRead) else value
        for name, value in arguments.items()
    }
    if leaf.validate is not None and (wrong := leaf.validate(known)):
        message, _, hint = wrong.partition("; ")
        scope.diagnostics.error(entry.location, f"`{leaf.key}` {message}", hint or "change it")


def read_argument(
    name: str,
    value: YamlValue,
    expected: ValueType,
    description: str,
    scope: Scope,
    unit: str = "",
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
        scope.mismatch(resolved, f"`{name}`{about}: {mismatch.message}", hint)
        return {}
    if unit == "°" and isinstance(argument, float) and (odd := radians_for_degrees(argument)):
        message, _, hint = odd.partition("; ")
        scope.diagnostics.error(value.location, f"`{name}`: {message}", hint)
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
    scope.diagnostics.error(value.location, message, _usage(leaf, scope))
    return None


def _read_set(node: LeafNode, given: Mapping[str, YamlEntry], scope: Scope) -> LeafNode:
    if not given:
        message, hint = f"`{node.name}` names no key", f"write `{node.name}: {{key: value}}`"
        scope.diagnostics.error(node.location, message, hint)
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
            scope.mismatch(resolved, message, hint)
        else:
            if write is not None:
                arguments[key], outputs[key] = value, write
    return replace(node, arguments=arguments, outputs=outputs)


def read_key_name(key: str, value: YamlValue, scope: Scope) -> KeyWrite | None:
    """The key that an output is written to; None and an error if it cannot be one."""
    name = value.value if isinstance(value, YamlScalar) else None
    if not isinstance(name, str) or not WORD.fullmatch(name):
        message = f"`{key}` names a key to write to, and cannot be {describe(value)}"
        hint = "write a word of letters, digits and `_`, without `$`"
        scope.diagnostics.error(value.location, message, hint)
        return None
    if name in scope.parameters:
        message = f"`{name}` is a parameter, and cannot be written to"
        scope.diagnostics.error(value.location, message, "choose another name for the key")
        return None
    return KeyWrite(location=value.location, name=name)


def _usage(leaf: LeafType, scope: Scope) -> str:
    """How the leaf is written with what it requires, and the names that fit."""
    if leaf.names_keys:
        return f"write `{leaf.key}: {{key: value}}`"
    required = [parameter for parameter in leaf.described if parameter.required]
    if not required:
        return f"write `{leaf.key}` alone, or its parameters by name"
    example = ", ".join(f"{parameter.name}: ..." for parameter in required)
    types = tuple(one for parameter in required for one in parameter.type.named_types)
    fitting = [name for name, value in scope.named.values.items() if isinstance(value, types)]
    known = f" (known: {quoted(sorted(fitting))})" if fitting else ""
    return f"write `{leaf.key}: {{{example}}}`{known}"


def _parameter_hint(key: str, leaf: LeafType) -> str:
    if key in MODIFIERS or key == NAME:
        return f"`{key}` belongs beside `{leaf.key}`, not below it"
    known = [parameter.name for parameter in leaf.described]
    return suggest(key, known) if known else "it takes none: remove it"
