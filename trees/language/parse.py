"""Syntax of the section `tree`: from located values to checked nodes.

Reading goes on after an error, so that one pass finds them all; an invalid node is None.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import TypeAlias

from config import (
    Hint,
    Location,
    Plain,
    YamlEntry,
    YamlList,
    YamlMap,
    YamlScalar,
    YamlValue,
    describe,
    quoted,
    suggest,
)
from trees.language import rules
from trees.language.mappings import FORMER_WORDS, called, counted_hint, fields
from trees.language.node_syntax import FORMS
from trees.language.scope import Scope, read_argument, read_leaf
from trees.language.syntax import CompositeNode, LeafNode, Modifiers, Node, is_condition
from trees.language.values import KeyRead
from trees.words import (
    ASKING,
    CHILDREN,
    COMPOSITES,
    MODIFIERS,
    NAME,
    SUBTREE,
    CompositeWord,
    Form,
    NamedValue,
    ValueType,
)

_Given: TypeAlias = Plain | KeyRead | LeafNode | CompositeNode  # what a modifier may be given

_OF_CONDITIONS = (*(key for key, word in COMPOSITES.items() if word.is_condition), *ASKING)

_WORDS = frozenset({*COMPOSITES, SUBTREE, *MODIFIERS, NAME})

MAX_LEVELS = 100
"""Of nodes and modifiers one inside the other, over all files: a tick goes through all of them."""


def read_node(value: YamlValue, scope: Scope) -> Node | None:
    """A node of the tree: a mapping with one node key, or the bare key of a leaf."""
    location = value.location
    if isinstance(value, YamlScalar) and isinstance(value.value, str):
        nothing = YamlScalar(location=location, value=None)
        entries: Mapping[str, YamlEntry] = {
            value.value: YamlEntry(location=location, value=nothing)
        }
    elif isinstance(value, YamlMap):
        entries = value.entries
    else:
        hint = "write `sequence:` above a list, and `node: {...}` for a single node"
        scope.error(rules.ONE_NODE, location, f"expected a node, got {describe(value)}", hint)
        return None
    key = _node_key(location, entries, scope)
    modifiers = _read_modifiers(entries, scope)
    name = _read_name(entries, scope)
    if key is None:
        return None
    below = scope.below(1 + len(modifiers))
    if below.level > MAX_LEVELS:
        message = f"the tree is more than {MAX_LEVELS} levels deep here, modifiers counted"
        scope.error(rules.SIZE, location, message, "make it flatter")
        return None
    node = _read_core(key, entries, below)
    return node and replace(node, name=name or node.name, modifiers=modifiers)


def _read_core(key: str, entries: Mapping[str, YamlEntry], scope: Scope) -> Node | None:
    """The node without what stands beside its key."""
    entry = entries[key]
    if key == SUBTREE:
        return scope.include(entry, scope)
    if key in scope.known.leaves:
        return read_leaf(entry, scope.known.leaves[key], entries, scope)
    word = COMPOSITES[key]
    if word.form is not Form.LIST:
        return FORMS[word.form](entry, scope, read_node)
    items, options = _read_options(entry, word, scope)
    children = _read_children(items, entry.location, word, scope)
    policy, count = options.get("policy"), len(items.items) if isinstance(items, YamlList) else 0
    if isinstance(policy, int) and 0 < count < policy:
        message = f"`policy` wants {policy} children to succeed, and there are {count}"
        scope.error(rules.ARGUMENTS, entry.location, message, f"write at most {count}, or `all`")
    at = entry.location
    return CompositeNode(location=at, name=key, key=key, children=children, options=options)


def _node_key(location: Location, entries: Mapping[str, YamlEntry], scope: Scope) -> str | None:
    """The one key that says what the node is; notes every key that does not belong here."""
    for key in entries:
        if key not in _WORDS and key not in scope.known.leaves:
            scope.known.fetch(key)
    if any(key not in _WORDS and key not in scope.known.leaves for key in entries):
        scope.known.fetch(None)  # an entry point may have another name than its leaf
    nodes = (*COMPOSITES, SUBTREE, *scope.known.leaves)
    keys = [key for key in entries if key in nodes]
    unknown = [key for key in entries if key not in (*nodes, *MODIFIERS, NAME)]
    for key in unknown:
        if key in scope.known.problems:
            message, _, hint = scope.known.problems[key].rpartition("; ")
        elif key in FORMER_WORDS:
            message, hint = _former(key, entries[key].value, scope)
        elif not keys:
            message, hint = f"unknown node `{key}`", called(key, nodes)
        elif keys[0] in scope.known.leaves and key in scope.known.leaves[keys[0]].parameters:
            message = f"`{key}` stands beside `{keys[0]}`, and is a parameter of it"
            hint = f"indent it below `{keys[0]}:`"
        else:
            message = f"unknown key `{key}` beside `{keys[0]}`"
            hint = called(key, (*MODIFIERS, NAME))
        rule = rules.ONE_NODE if keys else rules.UNKNOWN_NODE
        scope.error(rule, entries[key].location, message, hint)
    if len(keys) > 1:
        message = f"two nodes in one item: `{keys[0]}` and `{keys[1]}`"
        hint = "begin each with its own `- ` in the list of a composite"
        scope.error(rules.ONE_NODE, entries[keys[1]].location, message, hint)
    if not keys and not unknown:
        words = quoted(entries)
        hint = f"write {words} into the item of its node: remove the `- ` of the line below"
        message = f"this item has no node, only {words}" if words else "this item has no node"
        scope.error(rules.ONE_NODE, location, message, hint if words else "write one, or remove it")
    return keys[0] if len(keys) == 1 else None


def _former(key: str, value: YamlValue, scope: Scope) -> tuple[str, Hint]:
    """Message and hint about a word that was removed; certain where it only asks conditions."""
    text, word = FORMER_WORDS[key]
    items = value.items if isinstance(value, YamlList) else (value,)
    below = [one for item in items for one in getattr(item, "entries", [scope.text(item)])]
    leaves = {one: leaf.is_condition for one, leaf in scope.known.leaves.items()}
    asks = bool(below) and all(one in _OF_CONDITIONS or leaves.get(one) for one in below)
    return f"`{key}` is not a word any more", Hint(f"write {text}", key, word if asks else "")


def _read_name(entries: Mapping[str, YamlEntry], scope: Scope) -> str | None:
    if NAME not in entries:
        return None
    value = entries[NAME].value
    name = scope.text(value)
    if isinstance(name, str) and name.strip() and name.isprintable() and "/" not in name:
        return name
    hint = "write a line of text without `/`"
    scope.error(rules.VALUE, value.location, f"`name` cannot be {describe(value)}", hint)
    return None


def _read_modifiers(entries: Mapping[str, YamlEntry], scope: Scope) -> Modifiers:
    modifiers: dict[str, _Given] = {}
    for key, word in MODIFIERS.items():
        if key in entries:
            value = entries[key].value
            if word.type is None:
                given: _Given = _read_condition(key, value, scope)
            else:
                given = _read_fixed(key, value, word.type, scope)
            if given is not None:
                modifiers[key] = given
    return modifiers


def _read_fixed(key: str, value: YamlValue, expected: ValueType, scope: Scope) -> Plain | KeyRead:
    """A value that has to be known before the run; None and an error if it is not.

    A parameter without a value stays a `KeyRead`.
    """
    unit = "s" if key.endswith("_s") else ""
    given = read_argument(key, value, expected, "", scope, unit).get(key)
    assert not isinstance(given, NamedValue)
    if not isinstance(given, KeyRead):
        return given
    parameter = scope.parameters.get(given.name)
    if parameter is None:
        message, known = f"the task has no parameter `{given.name}`", scope.parameters
        hint = suggest(given.name, known) if known else "define it under `params:`"
    elif parameter.value is not None:
        message = f"`{key}` is fixed before the run, and `{given}` is given a key"
        hint = "give the parameter a value"
    elif parameter.type is not None and not expected.takes(parameter.type):
        message = f"`{key}`: expected {expected}, got `{given}`, which is {parameter.type}"
        hint = "give the parameter another type"
    else:
        return given
    scope.error(rules.REFERENCE, value.location, message, hint)
    return None


def _read_condition(key: str, value: YamlValue, scope: Scope) -> LeafNode | CompositeNode | None:
    """What `while`, `unless` and `not` ask."""
    if isinstance(value, YamlList):
        message = f"`{key}` asks one condition, not a list"
        hint = f"write `{key}: {{sequence: [...]}}`, or `fallback`"
        scope.error(rules.CONDITION, value.location, message, hint)
        return None
    node = read_node(value, scope)
    odd = None if node is None else _odd_condition(node)
    if odd is None:
        return node if isinstance(node, LeafNode | CompositeNode) else None
    if is_condition(odd):
        message = f"the condition of `{key}` takes no modifiers"
        hint = "remove them; `not` asks for the opposite"
    else:
        conditions = sorted(leaf.key for leaf in scope.known.leaves.values() if leaf.is_condition)
        message = f"`{key}` asks a condition, and `{_key(odd)}` is not one"
        hint = f"write one of {quoted([*conditions, *_OF_CONDITIONS])}"
        if isinstance(odd, LeafNode) and odd.type.counts:
            hint = counted_hint(odd.type.counts)
    scope.error(rules.CONDITION, odd.location, message, hint)
    return None


def _odd_condition(node: Node) -> Node | None:
    """The first node that keeps a node from being a condition; None if it is one."""
    if isinstance(node, CompositeNode) and node.key in ASKING and not node.modifiers:
        return next((odd for one in node.children if (odd := _odd_condition(one))), None)
    return None if is_condition(node) and not node.modifiers else node


def _key(node: Node) -> str:
    if isinstance(node, LeafNode):
        return node.type.key
    return node.key if isinstance(node, CompositeNode) else SUBTREE


def _read_options(
    entry: YamlEntry, word: type[CompositeWord], scope: Scope
) -> tuple[YamlValue | None, dict[str, Plain | KeyRead]]:
    """The value that holds the children, and the options if the composite has any."""
    value = entry.value
    keys = {CHILDREN, *word.options} if word.options else set()
    if not isinstance(value, YamlMap) or keys.isdisjoint(value.entries):
        return value, {}
    entries = fields(
        value,
        f"`{word.key}`",
        scope.diagnostics,
        required=(CHILDREN,),
        optional=tuple(word.options),
    )
    if entries is None:
        return None, {}
    options = {
        key: _read_fixed(key, entries[key].value, option.type, scope)
        for key, option in word.options.items()
        if key in entries
    }
    return entries[CHILDREN].value, options


def _read_children(
    value: YamlValue | None, location: Location, word: type[CompositeWord], scope: Scope
) -> tuple[Node, ...]:
    key = word.key
    if value is None:
        return ()
    is_bare = isinstance(value, YamlScalar) and isinstance(value.value, str)
    if word.lone and (is_bare or isinstance(value, YamlMap)):
        value = YamlList(location=value.location, items=(value,))
    if isinstance(value, YamlScalar) and value.value is None:
        value = YamlList(location=location, items=())
    if not isinstance(value, YamlList):
        message = f"the children of `{key}` are a list, not {describe(value)}"
        scope.error(rules.CHILDREN, value.location, message, "begin each child with `- `")
        if isinstance(value, YamlMap):
            read_node(value, scope)
        return ()
    count = len(value.items)
    if count == 0:
        hint = "add a node below it, or remove it"
        scope.error(rules.CHILDREN, location, f"`{key}` is empty", hint)
    elif count < word.least:
        message = f"`{key}` needs at least {word.least} children, got {count}"
        scope.error(rules.CHILDREN, location, message, f"give it {word.takes}")
    elif word.most is not None and count > word.most:
        message = f"`{key}` takes {word.takes}, got {count}"
        scope.error(rules.CHILDREN, location, message, "put them in a `sequence:` below it")
    read = partial(_read_condition, key) if word.asks else read_node
    children = [read(item, scope) for item in value.items]
    return tuple(child for child in children if child is not None)
