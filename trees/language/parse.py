"""The section `tree`: located values in, checked nodes out.

Reading goes on after a mistake, so that one pass finds them all; a node that cannot be understood
is None.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from trees.language.mistakes import Mistakes, Place, quoted, suggestion
from trees.language.places import Places
from trees.language.registry import LeafType
from trees.language.source import Entry, Items, Plain, Scalar, Table, Value
from trees.language.syntax import CompositeNode, LeafNode, Node
from trees.language.values import MismatchError, convert, describe
from trees.language.vocabulary import COMPOSITES, MODIFIERS, NAME


@dataclass(frozen=True, kw_only=True)
class Scope:
    """What the nodes of a file may refer to, and where mistakes go."""

    leaves: Mapping[str, LeafType]
    places: Places
    mistakes: Mistakes
    used: set[str] = field(default_factory=set)
    """Receives the names of the poses and regions that the tree refers to."""


def read_node(value: Value, scope: Scope) -> Node | None:
    """A node of the tree: a mapping with one node key, or the bare key of a leaf."""
    if isinstance(value, Scalar) and isinstance(value.value, str):
        entries: Mapping[str, Entry] = {
            value.value: Entry(place=value.place, value=Scalar(place=value.place, value=None))
        }
    elif isinstance(value, Table):
        entries = value.entries
    else:
        mend = "write `sequence:` above a list, and `node: {...}` for a single node"
        scope.mistakes.error(value.place, f"expected a node, got {describe(value)}", mend)
        return None
    key = _node_key(value.place, entries, scope)
    modifiers = _read_modifiers(entries, scope)
    if key is None:
        return None
    name = _read_name(entries, key, scope.mistakes)
    entry = entries[key]
    if key in scope.leaves:
        leaf = scope.leaves[key]
        arguments = _read_arguments(entry, leaf, entries, scope)
        return LeafNode(
            place=entry.place, name=name, modifiers=modifiers, type=leaf, arguments=arguments
        )
    children = _read_children(entry, key, scope)
    return CompositeNode(
        place=entry.place, name=name, modifiers=modifiers, key=key, children=children
    )


def _node_key(place: Place, entries: Mapping[str, Entry], scope: Scope) -> str | None:
    """The one key that says what the node is; notes every key that has no business here."""
    nodes = (*COMPOSITES, *scope.leaves)
    keys = [key for key in entries if key in nodes]
    unknown = [key for key in entries if key not in (*nodes, *MODIFIERS, NAME)]
    for key in unknown:
        if not keys:
            what, mend = f"unknown node `{key}`", suggestion(key, nodes)
        elif keys[0] in scope.leaves and key in scope.leaves[keys[0]].parameters:
            what = f"`{key}` stands beside `{keys[0]}`, and is a parameter of it"
            mend = f"indent it below `{keys[0]}:`"
        else:
            what = f"unknown key `{key}` beside `{keys[0]}`"
            mend = suggestion(key, (*nodes, *MODIFIERS, NAME))
        scope.mistakes.error(entries[key].place, what, mend)
    if len(keys) > 1:
        what = f"two nodes in one item: `{keys[0]}` and `{keys[1]}`"
        mend = "begin each with its own `- ` in the list of a composite"
        scope.mistakes.error(entries[keys[1]].place, what, mend)
    if not keys and not unknown:
        mend = f"add a node key, for example {quoted(sorted(nodes)[:3])}"
        scope.mistakes.error(place, "this item says nothing to do", mend)
    return keys[0] if len(keys) == 1 else None


def _read_name(entries: Mapping[str, Entry], key: str, mistakes: Mistakes) -> str:
    if NAME not in entries:
        return key
    value = entries[NAME].value
    name = value.value if isinstance(value, Scalar) else None
    if isinstance(name, str) and name.strip() and name.isprintable() and "/" not in name:
        return name
    mend = "write a line of text without `/`"
    mistakes.error(value.place, f"`name` cannot be {describe(value)}", mend)
    return key


def _read_modifiers(entries: Mapping[str, Entry], scope: Scope) -> dict[str, Plain]:
    modifiers: dict[str, Plain] = {}
    for key, word in MODIFIERS.items():
        if key not in entries:
            continue
        value = entries[key].value
        try:
            given = convert(value, word.type, {})
            if not word.accepts(given):
                what = f"must be {word.rule}, got {describe(value)}"
                raise MismatchError(what, f"write one that is {word.rule}")
        except MismatchError as mismatch:
            _note_mismatch(value, f"`{key}`: {mismatch.what}", mismatch.mend, scope)
        else:
            assert given is None or isinstance(given, bool | int | float | str)
            modifiers[key] = given
    return modifiers


def _read_children(entry: Entry, key: str, scope: Scope) -> tuple[Node, ...]:
    word = COMPOSITES[key]
    value = entry.value
    if word.only_child and isinstance(value, Table):
        value = Items(place=value.place, items=(value,))
    if isinstance(value, Scalar) and value.value is None:
        value = Items(place=entry.place, items=())
    if not isinstance(value, Items):
        what = f"the children of `{key}` are a list, not {describe(value)}"
        scope.mistakes.error(value.place, what, "begin each child with `- `")
        if isinstance(value, Table):
            read_node(value, scope)
        return ()
    count = len(value.items)
    if count == 0:
        scope.mistakes.error(entry.place, f"`{key}` is empty", "add a node below it, or remove it")
    elif count < word.least:
        what = f"`{key}` needs at least {word.least} children, got {count}"
        scope.mistakes.error(entry.place, what, f"give it {word.children}")
    elif word.only_child and count > 1:
        what = f"`{key}` takes one child, got {count}"
        scope.mistakes.error(entry.place, what, "put them in a `sequence:` below it")
    children = [read_node(item, scope) for item in value.items]
    return tuple(child for child in children if child is not None)


def _read_arguments(
    entry: Entry, leaf: LeafType, beside: Mapping[str, Entry], scope: Scope
) -> dict[str, object]:
    value = entry.value
    if isinstance(value, Scalar) and value.value is None:
        given: Mapping[str, Entry] = {}
    elif isinstance(value, Table):
        given = value.entries
    else:
        what = f"`{leaf.key}` takes a mapping of parameters, not {describe(value)}"
        scope.mistakes.error(value.place, what, _usage(leaf, scope))
        return {}
    for parameter in leaf.parameters.values():
        # One that stands beside the leaf by mistake is noted there.
        if parameter.required and parameter.name not in {*given, *beside}:
            about = f": {parameter.description}" if parameter.description else ""
            what = f"`{leaf.key}` lacks `{parameter.name}` ({parameter.type}{about})"
            scope.mistakes.error(entry.place, what, _usage(leaf, scope))
    arguments: dict[str, object] = {}
    for key, argument in given.items():
        if key not in leaf.parameters:
            what = f"`{leaf.key}` has no parameter `{key}`"
            scope.mistakes.error(argument.place, what, _mend_parameter(key, leaf))
            continue
        parameter = leaf.parameters[key]
        try:
            converted = convert(argument.value, parameter.type, scope.places.named)
        except MismatchError as mismatch:
            about = f" ({parameter.description})" if parameter.description else ""
            what = f"`{key}`{about}: {mismatch.what}"
            _note_mismatch(argument.value, what, mismatch.mend, scope)
        else:
            scope.used.add(getattr(converted, "name", ""))
            arguments[key] = converted
    return arguments


def _note_mismatch(value: Value, what: str, mend: str, scope: Scope) -> None:
    """Note a value that does not fit, unless a mistake in its own definition is noted already."""
    if isinstance(value, Scalar):
        if value.is_noted:
            return
        name = value.value
        if isinstance(name, str) and name in scope.places.defined:
            scope.used.add(name)
            if name not in scope.places.named:
                return
    scope.mistakes.error(value.place, what, mend)


def _usage(leaf: LeafType, scope: Scope) -> str:
    """How the leaf is written with what it requires, and the names that would do."""
    required = [parameter for parameter in leaf.parameters.values() if parameter.required]
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
    return suggestion(key, leaf.parameters) if leaf.parameters else "it takes none: remove it"
