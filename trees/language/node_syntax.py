"""Syntax of the composites `switch` and `for_each`."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeAlias

from config import (
    Plain,
    YamlEntry,
    YamlList,
    YamlMap,
    YamlScalar,
    YamlValue,
    describe,
    suggest,
    written,
)
from trees.language import rules
from trees.language.documents import TaskParameter
from trees.language.mappings import WORD, fields
from trees.language.scope import Scope, read_argument, read_key_name
from trees.language.syntax import CompositeNode, Node
from trees.language.values import KeyRead, Reference
from trees.words import SEEN_LIST, Form, NamedValue, ValueType, is_case, type_of

Read: TypeAlias = Callable[[YamlValue, Scope], Node | None]  # reads a node

_MOST = 100  # values of one `for_each`
_COPIES = 1000  # of nodes for values, in a whole task
_PLAIN = ValueType(types=(bool, int, float, str))


def read_switch(entry: YamlEntry, scope: Scope, read: Read) -> Node | None:
    """A node for each case of a value, and perhaps one for all others."""
    required, diagnostics = ("value", "cases"), scope.diagnostics
    entries = fields(entry.value, "`switch`", diagnostics, required=required, optional=("else",))
    if entries is None:
        return None
    given = read_argument("value", entries["value"].value, _PLAIN, "", scope)
    cases = entries["cases"].value
    if isinstance(cases, YamlMap) and not cases.entries and diagnostics.fatal:
        return None  # its keys are no words
    if not isinstance(cases, YamlMap) or not cases.entries:
        what = "empty" if isinstance(cases, YamlMap) else describe(cases)
        message = f"`cases` is a mapping of values to nodes, not {what}"
        scope.error(rules.VALUE, cases.location, message, "write `left: {node: ...}` below it")
        return None
    _check_choices(entries["value"].value, cases, scope)
    nodes = [read(case.value, scope) for case in cases.entries.values()]
    other = read(entries["else"].value, scope) if "else" in entries else None
    children = [*nodes, *([other] if "else" in entries else [])]
    value = given.get("value")
    if value is None or isinstance(value, NamedValue) or None in children:
        return None
    known = tuple(child for child in children if child is not None)
    return _made("switch", entry, known, options={"value": value}, cases=tuple(cases.entries))


def _made(key: str, entry: YamlEntry, children: tuple[Node, ...], **more: Any) -> CompositeNode:
    return CompositeNode(location=entry.location, name=key, key=key, children=children, **more)


def _check_choices(value: YamlValue, cases: YamlMap, scope: Scope) -> None:
    """A case that the value can never have is an error."""
    text = value.value if isinstance(value, YamlScalar) else None
    parameter = scope.parameters.get(text[1:]) if isinstance(text, str) else None
    choices = parameter.type.choices if parameter and parameter.type else ()
    for case, entry in cases.entries.items():
        if choices and not any(is_case(choice, case) for choice in choices):
            message = f"`{text}` is never `{case}`"
            hint = suggest(case, [written(choice) for choice in choices])
            scope.error(rules.KEY_TYPE, entry.location, message, hint)


def read_for_each(entry: YamlEntry, scope: Scope, read: Read) -> Node | None:
    """A copy of a node for each value, in order."""
    required, diagnostics = ("item", "in", "do"), scope.diagnostics
    entries = fields(entry.value, "`for_each`", diagnostics, required=required)
    if entries is None:
        return None
    item = read_key_name("item", entries["item"].value, scope)
    listed = _listed(entries["in"].value, scope)
    if item is not None and listed is not None:
        child = read(entries["do"].value, scope)
        return child and _made("for_each", entry, (child,), options={"in": listed}, item=item)
    values = _values(entries["in"].value, scope)
    if item is None or not values:
        return None
    children, used = [], set()
    for value in values:
        if next(scope.copies) == _COPIES:
            message = f"the task has more than {_COPIES} nodes for values of `for_each`"
            diagnostics.error(rules.SIZE, entry.location, message, "make it smaller")
        bound = TaskParameter(location=item.location, type=type_of(value), value=value)
        inner = replace(
            scope, parameters={**scope.parameters, item.name: bound}, used_parameters=set()
        )
        child = read(entries["do"].value, inner)
        used |= inner.used_parameters
        if child is None:
            return None  # the other copies have the same mistakes
        shown = value.name if isinstance(value, NamedValue) else written(value)
        children.append(replace(child, name=f"{child.name} {shown.replace('/', ' ')}"))
    if item.name not in used:
        message = f"the item `{item.name}` is never used"
        hint = f"write `${item.name}` below `do`, or `repeat` instead"
        diagnostics.warning(rules.UNUSED, item.location, message, hint)
    scope.used_parameters.update(used - {item.name})
    return _made("for_each", entry, tuple(children))


def _listed(value: YamlValue, scope: Scope) -> KeyRead | None:
    """The key of a list that is known only while the task runs; None if it is something else."""
    text = value.value if isinstance(value, YamlScalar) else None
    if not isinstance(text, str) or not text.startswith("$"):
        return None
    name = text[1:]
    if name in scope.parameters or not WORD.fullmatch(name):
        return None
    return KeyRead(location=value.location, name=name, type=SEEN_LIST)


def _values(listed: YamlValue, scope: Scope) -> list[Plain | NamedValue]:
    """What stands after `in`: all of one kind; empty, and an error, if they cannot be used."""
    text = listed.value if isinstance(listed, YamlScalar) else None
    if isinstance(text, str) and (path := scope.named.paths.get(text)):
        points = tuple(YamlScalar(location=listed.location, value=point) for point in path)
        listed = YamlList(location=listed.location, items=points)
    if not isinstance(listed, YamlList) or not 0 < len(listed.items) <= _MOST:
        message = (
            f"`in` is a list of 1 to {_MOST} names or values, a path, or the key of a list of "
            f"detected objects, not {describe(listed)}"
        )
        if isinstance(listed, YamlList):
            message = f"`in` has {len(listed.items)} values, and 1 to {_MOST} are possible"
        is_word = isinstance(text, str) and WORD.fullmatch(text)
        hint = f"write `${text}` if that is its key, else " if is_word else "write "
        scope.error(rules.VALUE, listed.location, message, f"{hint}`in: [left, right]`")
        return []
    values: list[Plain | NamedValue] = []
    for one in listed.items:
        resolved = scope.resolve(one)
        value = resolved.value if isinstance(resolved, YamlScalar | Reference) else None
        if isinstance(value, str):
            value = scope.named.values.get(value, value)
        if value is None or isinstance(value, KeyRead):
            if resolved is not None and not scope.named.is_faulty(value):
                message = f"`in` needs values that are known before the run, not {describe(one)}"
                scope.error(rules.VALUE, one.location, message, "write a name or a value")
            return []
        scope.use(value)
        values.append(value)
        first, this = type_of(values[0]), type_of(value)
        if not (first.takes(this) or this.takes(first)):
            message = f"`in` has values of several kinds: {first}, and here {this}"
            hint = suggest(str(getattr(value, "name", value)), scope.named.locations)
            scope.error(rules.VALUE, one.location, message, hint)
            return []
    return values


FORMS: Mapping[Form, Callable[[YamlEntry, Scope, Read], Node | None]] = {
    Form.CASES: read_switch,
    Form.EACH: read_for_each,
}
"""What reads a composite that has a form of its own."""
