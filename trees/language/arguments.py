"""What a task file says about a leaf: its parameters, and the keys that it writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from config import quoted, suggest
from trees.language.registry import SET, LeafType
from trees.language.scope import Scope
from trees.language.source import Entry, Scalar, Table, Value
from trees.language.syntax import LeafNode
from trees.language.tables import WORD
from trees.language.value_types import NAMED_KINDS, ValueType
from trees.language.values import Given, KeyWrite, MismatchError, convert, describe
from trees.language.vocabulary import MODIFIERS, NAME

_ANYTHING = ValueType(kinds=(bool, int, float, str, *NAMED_KINDS))
"""What `set` may write."""


def read_leaf(entry: Entry, leaf: LeafType, beside: Mapping[str, Entry], scope: Scope) -> LeafNode:
    """A leaf and its arguments; those that do not fit are noted and left out.

    Args:
        entry: the leaf's key and what is below it.
        leaf: its type.
        beside: all entries of the item.
        scope: what may be referred to.
    """
    node = LeafNode(place=entry.place, name=leaf.key, modifiers={}, type=leaf, arguments={})
    given = _below(entry, leaf, scope)
    if given is None:
        return node
    if leaf is SET:
        return _read_set(node, given, scope)
    # One that stands beside the leaf by diagnostic is noted there.
    for parameter in leaf.described:
        if parameter.required and parameter.name not in {*given, *beside}:
            about = f": {parameter.description}" if parameter.description else ""
            kind = "a key for " if parameter.name in leaf.outputs else ""
            what = f"`{leaf.key}` lacks `{parameter.name}` ({kind}{parameter.type}{about})"
            scope.diagnostics.error(entry.place, what, _usage(leaf, scope))
    arguments: dict[str, Given] = {}
    outputs: dict[str, KeyWrite] = {}
    for key, argument in given.items():
        if key in leaf.outputs:
            name = read_key_name(key, argument.value, scope)
            if name is not None:
                outputs[key] = name
        elif key in leaf.parameters:
            arguments |= _read_argument(key, argument.value, leaf, scope)
        else:
            what = f"`{leaf.key}` has no parameter `{key}`"
            scope.diagnostics.error(argument.place, what, _mend_parameter(key, leaf))
    return replace(node, arguments=arguments, outputs=outputs)


def _below(entry: Entry, leaf: LeafType, scope: Scope) -> Mapping[str, Entry] | None:
    """What stands below a leaf's key; None and a diagnostic if it cannot be parameters."""
    value = entry.value
    if isinstance(value, Scalar) and value.value is None:
        return {}
    if isinstance(value, Table):
        return value.entries
    what = f"`{leaf.key}` takes a mapping of parameters, not {describe(value)}"
    scope.diagnostics.error(value.place, what, _usage(leaf, scope))
    return None


def _read_argument(key: str, value: Value, leaf: LeafType, scope: Scope) -> dict[str, Given]:
    parameter = leaf.parameters[key]
    try:
        converted = convert(value, parameter.type, scope.places.named)
    except MismatchError as mismatch:
        about = f" ({parameter.description})" if parameter.description else ""
        note_mismatch(value, f"`{key}`{about}: {mismatch.what}", mismatch.hint, scope)
        return {}
    scope.use(converted)
    return {key: converted}


def _read_set(node: LeafNode, given: Mapping[str, Entry], scope: Scope) -> LeafNode:
    if not given:
        scope.diagnostics.error(node.place, "`set` sets nothing", "write `set: {key: value}`")
    arguments: dict[str, Given] = {}
    outputs: dict[str, KeyWrite] = {}
    for key, argument in given.items():
        write = read_key_name("set", Scalar(place=argument.place, value=key), scope)
        try:
            value = convert(argument.value, _ANYTHING, {})
        except MismatchError:
            what = f"`set` cannot write {describe(argument.value)}"
            hint = "give a number, a text, `true`, `false`, a parameter or a key"
            note_mismatch(argument.value, what, hint, scope)
        else:
            if write is not None:
                arguments[key], outputs[key] = value, write
    return replace(node, arguments=arguments, outputs=outputs)


def read_key_name(key: str, value: Value, scope: Scope) -> KeyWrite | None:
    """The key that an output is written to; None and a diagnostic if it cannot be one."""
    name = value.value if isinstance(value, Scalar) else None
    if not isinstance(name, str) or not WORD.fullmatch(name):
        what = f"`{key}` names a key to write to, and cannot be {describe(value)}"
        hint = "write a word of letters, digits and `_`, without `$`"
        note_mismatch(value, what, hint, scope)
        return None
    if name in scope.parameters:
        what = f"`{name}` is a parameter, and cannot be written to"
        scope.diagnostics.error(value.place, what, "choose another name for the key")
        return None
    return KeyWrite(place=value.place, name=name)


def note_mismatch(value: Value, what: str, hint: str, scope: Scope) -> None:
    """Note a value that does not fit, unless one in its own definition is noted already."""
    if isinstance(value, Scalar):
        if value.is_noted:
            return
        name = value.value
        if isinstance(name, str) and name in scope.places.defined:
            scope.used.add(name)
            if name not in scope.places.named:
                return
    scope.diagnostics.error(value.place, what, hint)


def _usage(leaf: LeafType, scope: Scope) -> str:
    """How the leaf is written with what it requires, and the names that would do."""
    if leaf is SET:
        return "write `set: {key: value}`"
    required = [parameter for parameter in leaf.described if parameter.required]
    if not required:
        return f"write `{leaf.key}` alone, or its parameters by name"
    written = ", ".join(f"{parameter.name}: ..." for parameter in required)
    kinds = tuple(kind for parameter in required for kind in parameter.type.named_kinds)
    fitting = [name for name, thing in scope.places.named.items() if isinstance(thing, kinds)]
    known = f" (known: {quoted(sorted(fitting))})" if fitting else ""
    return f"write `{leaf.key}: {{{written}}}`{known}"


def _mend_parameter(key: str, leaf: LeafType) -> str:
    if key in MODIFIERS or key == NAME:
        return f"`{key}` belongs beside `{leaf.key}`, not below it"
    known = [parameter.name for parameter in leaf.described]
    return suggest(key, known) if known else "it takes none: remove it"
