"""The nodes of an XML tree as items of a task file."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from config import suggest
from trees.btcpp.elements import Element
from trees.btcpp.ports import pointed_at, read_literal
from trees.btcpp.sections import Item, Located, Sections
from trees.btcpp.words import (
    GUARD,
    PARALLEL,
    SCRIPT,
    STANDARD_COMPOSITES,
    STANDARD_MODIFIERS,
    SUBTREE,
    VALUE,
    Standard,
    parallel_policy,
)
from trees.language.diagnostics import Diagnostics, Location
from trees.language.registry import SET, LeafType
from trees.language.tables import WORD
from trees.language.value_types import ValueType
from trees.language.vocabulary import CHILDREN, COMPOSITES, MODIFIERS, NAME
from trees.language.vocabulary import SUBTREE as SUBTREE_KEY

Include: TypeAlias = Callable[[str, Element], Sections | None]
"""(name of a tree, the node that stands for it) to the ports of the tree; None if it is refused."""

_EXPLICIT = ("Action", "Condition", "Control", "Decorator")
"""`<Action ID="navigate"/>` is another way to write `<navigate/>`."""

_NOTES = frozenset({"_description", "_scene", "_fullpath", "_uid"})
"""Attributes that mean nothing to a tree."""

_FOREVER = STANDARD_COMPOSITES["forever"]
_COMPOSITES: Mapping[str, str] = {
    standard.tag: key for key, standard in STANDARD_COMPOSITES.items() if standard is not _FOREVER
}
_MODIFIERS: Mapping[str, str] = {
    standard.tag: key for key, standard in STANDARD_MODIFIERS.items() if not MODIFIERS[key].is_guard
}
_ASSIGNMENT = re.compile(r"\s*([A-Za-z_]\w*)\s*:=\s*('[^']*'|[^\s';]+)\s*(?:;|$)")


@dataclass(frozen=True, kw_only=True, eq=False)
class Nodes:
    """Turns the nodes of one tree into items of a task file."""

    sections: Sections
    """The ports of the tree."""
    leaves: Mapping[str, LeafType]
    diagnostics: Diagnostics
    include: Include

    def node(self, element: Element) -> Item:
        """The item of an element and of all below it."""
        attributes = self._ports(element)
        tag = attributes.pop("ID", "") if element.tag in _EXPLICIT else element.tag
        name = attributes.pop("name", None)
        guard = attributes.pop(GUARD, None)
        if guard is not None:
            return self._guard(guard, element)
        is_forever = attributes == _FOREVER.fixed and tag == _FOREVER.tag
        if tag in MODIFIERS or (tag in _MODIFIERS and not is_forever):
            return self._modifier(tag, attributes, element)
        if is_forever:
            said: dict[str, Any] = {"forever": self._only_child(element)}
        elif tag in _COMPOSITES or tag in COMPOSITES:
            said = self._composite(tag, attributes, element)
        elif tag == SCRIPT:
            said = {SET.key: self._script(attributes, element)}
        elif tag == SUBTREE:
            said = {SUBTREE_KEY: self._subtree(attributes, element)}
        elif tag in self.leaves and tag != SET.key:
            said = {tag: self._leaf(self.leaves[tag], attributes, element)}
        else:
            known = (*_COMPOSITES, *_MODIFIERS, SCRIPT, SUBTREE, *self.leaves)
            self._refuse(element, f"`{tag}` has no counterpart", suggest(tag, known))
            said = {}
        return Item(element.place, said if name is None else {NAME: name, **said})

    def _ports(self, element: Element) -> dict[str, str]:
        """Its attributes, without those that mean nothing to a tree."""
        ports = {}
        for key, text in element.attributes.items():
            if key == GUARD or not key.startswith("_"):
                ports[key] = text
            elif key not in _NOTES and (key, text) != ("_autoremap", "false"):
                what = f"`{key}` has no counterpart"
                self._refuse(element, what, "say it by nodes, or leave it out")
        return ports

    def _composite(self, tag: str, attributes: dict[str, str], element: Element) -> dict[str, Any]:
        key = _COMPOSITES.get(tag, tag)
        children = [self.node(child) for child in element.children]
        options = {
            option: read_literal(attributes.pop(option), known.type)
            for option, known in COMPOSITES[key].options.items()
            if tag != PARALLEL and option in attributes
        }
        if tag == PARALLEL:
            counts = (attributes.pop("success_count", "-1"), attributes.pop("failure_count", "1"))
            policy = parallel_policy(*counts, len(children))
            if policy is None:
                what = (
                    f"success_count {counts[0]} with failure_count {counts[1]} has no counterpart"
                )
                self._refuse(element, what, "let it fail when too few can succeed any more")
            options = {} if policy == "all" else {"policy": policy}
        self._no_more(attributes, element)
        if not options:
            return {key: children}
        return {key: Located(element.place, {**options, CHILDREN: children})}

    def _modifier(self, tag: str, attributes: dict[str, str], element: Element) -> Item:
        key = _MODIFIERS.get(tag, tag)
        standard = STANDARD_MODIFIERS[key] if tag in _MODIFIERS else Standard(tag=tag, port=VALUE)
        value: object = True
        if standard.port:
            value = self._modifier_value(key, standard, attributes, element)
        for fixed, wanted in standard.fixed.items():
            if attributes.pop(fixed, "") != wanted:
                what = f"`{tag}` has a counterpart only with `{fixed}` {wanted}"
                self._refuse(element, what, f'write {fixed}="{wanted}"')
        self._no_more(attributes, element)
        return _wrapped(key, value, self._only_child(element), element.place)

    def _modifier_value(
        self, key: str, standard: Standard, attributes: dict[str, str], element: Element
    ) -> object:
        if standard.port not in attributes:
            self._refuse(element, f"`{standard.tag}` lacks `{standard.port}`", "add it")
            return True
        text = attributes.pop(standard.port)
        value = self._value(text, MODIFIERS[key].type, element)
        if standard.scale == 1:
            return value
        if not isinstance(value, int):
            what = f"`{standard.port}`: {text} is not a whole number of milliseconds"
            self._refuse(element, what, "write one; an entry of the blackboard has no counterpart")
            return value
        return value / standard.scale

    def _guard(self, key: str, element: Element) -> Item:
        if len(element.children) != 2 or key not in MODIFIERS or not MODIFIERS[key].is_guard:
            what = f"a guard `{key}` of {len(element.children)} children has no counterpart"
            self._refuse(element, what, "give it a condition and the node that it guards")
            return Item(element.place, {})
        condition, guarded = (self.node(child) for child in element.children)
        return _wrapped(key, condition, guarded, element.place)

    def _only_child(self, element: Element) -> Item:
        if len(element.children) == 1:
            return self.node(element.children[0])
        what = f"`{element.tag}` has {len(element.children)} children"
        self._refuse(element, what, "give it one")
        return Item(element.place, {})

    def _leaf(
        self, leaf: LeafType, attributes: Mapping[str, str], element: Element
    ) -> Located | None:
        said: dict[str, object] = {}
        for key, text in attributes.items():
            if key in leaf.outputs:
                said[key] = self._written_key(key, text, element)
            else:
                parameter = leaf.parameters.get(key)
                said[key] = self._value(text, parameter.type if parameter else None, element, key)
        return Located(element.place, said) if said else None

    def _subtree(self, attributes: dict[str, str], element: Element) -> Located:
        name = attributes.pop("ID", "")
        ports = self.include(name, element)
        if ports is None:
            return Located(element.place, {})
        given = {}
        taken = {}
        for key, text in attributes.items():
            if key in ports.outputs:
                taken[key] = self._written_key(key, text, element)
            else:
                given[key] = self._value(text, ports.types.get(key), element, key)
        said = {"file": f"{name}.yaml", "with": given, "out": taken}
        return Located(element.place, {key: value for key, value in said.items() if value})

    def _script(self, attributes: dict[str, str], element: Element) -> Located:
        """The keys that a script of nothing but assignments writes."""
        code = attributes.pop("code", "")
        self._no_more(attributes, element)
        said: dict[str, object] = {}
        position = 0
        while match := _ASSIGNMENT.match(code, position):
            key, text = match.groups()
            position = match.end()
            is_name = WORD.fullmatch(text) and text not in ("true", "false")
            said[key] = (
                text[1:-1]
                if text.startswith("'")
                else self._value(f"{{{text}}}" if is_name else text, None, element)
            )
        if not said or code[position:].strip():
            what = "a script that does more than give values to keys has no counterpart"
            self._refuse(element, what, "write `key := value`, or a leaf of your own")
        return Located(element.place, said)

    def _value(
        self, text: str, expected: ValueType | None, element: Element, port: str = ""
    ) -> object:
        """What an attribute says: a literal, `$name`, or the name of a pose or region."""
        name = port if text == "{=}" else pointed_at(text)
        if name is None:
            if text.startswith("$"):
                what = f"the text {text!r} has no counterpart: `$` begins a reference in a task"
                self._refuse(element, what, "write it without")
            return read_literal(text, expected)
        return name if self.sections.is_place(name) else f"${name}"

    def _written_key(self, port: str, text: str, element: Element) -> str:
        name = port if text == "{=}" else pointed_at(text)
        if name is None:
            what = f"`{port}` writes to an entry of the blackboard, not to {text!r}"
            self._refuse(element, what, f'write {port}="{{name}}"')
        return name or port

    def _no_more(self, attributes: Mapping[str, str], element: Element) -> None:
        for key in attributes:
            self._refuse(element, f"`{element.tag}` has no `{key}`", "remove it")

    def _refuse(self, element: Element, what: str, hint: str) -> None:
        self.diagnostics.error(element.place, what, hint)


def _wrapped(key: str, value: object, inner: Item, place: Location) -> Item:
    """A node with a modifier around it, in the order of wrapping that the language has."""
    order = list(MODIFIERS)
    inside = [order.index(other) for other in inner if other in MODIFIERS]
    if all(order.index(key) > other for other in inside):
        return Item(inner.place, {key: value, **inner}, {**inner.modifiers, key: place})
    return Item(place, {key: value, "sequence": [inner]}, {key: place})
