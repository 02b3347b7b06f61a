"""XML of BehaviorTree.CPP 4 as task files: the part of it that the language has too.

What the language does not have (scripts that compute, `_skipIf` and its like, `Switch`, trees in
other files) is refused at its line and column. Each tree of the XML becomes a file; what the
language finds wrong in one is reported where it stands in the XML.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from trees.btcpp.elements import Element, read_elements
from trees.btcpp.ports import pointed_at, read_literal
from trees.btcpp.sections import Item, Located, Sections, read_sections
from trees.btcpp.words import (
    GUARD,
    MAIN,
    PARALLEL,
    SCRIPT,
    STANDARD_COMPOSITES,
    STANDARD_MODIFIERS,
    SUBTREE,
    VALUE,
    Standard,
    parallel_policy,
)
from trees.btcpp.writing import traced, yaml_text
from trees.language import TaskFileError, load
from trees.language.kinds import ValueType
from trees.language.mistakes import Mistakes, Place, suggestion
from trees.language.registry import SET, LeafType, describe_leaves, known_leaves
from trees.language.source import read_text
from trees.language.tables import WORD
from trees.language.vocabulary import CHILDREN, COMPOSITES, MODIFIERS, NAME
from trees.language.vocabulary import SUBTREE as SUBTREE_KEY

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


def import_xml(path: Path) -> dict[str, str]:
    """The task files that an XML file amounts to.

    Args:
        path: the XML file.

    Returns:
        Texts by file name, that of the main tree first.

    Raises:
        TaskFileError: with every part that has no counterpart, or if it is not XML.
        LeafError: a leaf class, not the file, is at fault.
    """
    mistakes = Mistakes(path)
    text = read_text(path, mistakes)
    root = None if text is None else read_elements(text, mistakes)
    files = {} if root is None else _files(root, describe_leaves(known_leaves()), mistakes)
    if mistakes.fatal:
        raise TaskFileError(mistakes.in_order())
    texts = {name: yaml_text(said) for name, said in files.items()}
    _check(texts, files, path)
    return texts


def _check(texts: Mapping[str, str], files: Mapping[str, Located], path: Path) -> None:
    """Let the language check the files; what it finds is told with the place in the XML."""
    with TemporaryDirectory() as folder:
        for name, text in texts.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        try:
            load(Path(folder) / next(iter(texts)), open_parameters=True)
        except TaskFileError as error:
            raise TaskFileError(
                replace(
                    mistake,
                    path=path,
                    place=traced(mistake.place, texts[mistake.path.name], files[mistake.path.name]),
                )
                for mistake in error.mistakes
            ) from None


def _files(root: Element, leaves: Mapping[str, LeafType], mistakes: Mistakes) -> dict[str, Located]:
    """What each task file says, by its name, that of the main tree first."""
    if root.tag != "root" or root.attributes.get("BTCPP_format") != "4":
        what = "this is not a tree of BehaviorTree.CPP 4"
        mistakes.error(root.place, what, 'the root is `<root BTCPP_format="4">`')
        return {}
    for child in root.children:
        if child.tag not in ("BehaviorTree", "TreeNodesModel"):
            what = f"`<{child.tag}>` has no counterpart"
            mistakes.error(child.place, what, "put all trees into one file, without others")
    trees = {tree.attributes.get("ID", ""): tree for tree in root.all("BehaviorTree")}
    models = {
        model.attributes.get("ID", ""): read_sections(model, mistakes)
        for all_models in root.all("TreeNodesModel")
        for model in all_models.all(SUBTREE)
    }
    main = root.attributes.get("main_tree_to_execute", next(iter(trees), ""))
    if main not in trees:
        what = f"there is no tree `{main}`"
        mistakes.error(root.place, what, suggestion(main, trees))
        return {}
    found = _Trees(trees=trees, models=models, leaves=leaves, mistakes=mistakes)
    found.add(_unwrapped(main, trees))
    return dict(reversed(found.files.items()))


def _unwrapped(main: str, trees: Mapping[str, Element]) -> str:
    """The tree that the main tree only passes its own entries to, else the main tree itself."""
    children = trees[main].children
    if main != MAIN or len(children) != 1 or children[0].tag != SUBTREE:
        return main
    ports = {key: text for key, text in children[0].attributes.items() if key != "ID"}
    inner = children[0].attributes.get("ID", "")
    passes_on = all(pointed_at(text) == key for key, text in ports.items())
    return inner if passes_on and inner in trees else main


@dataclass(frozen=True, kw_only=True, eq=False)
class _Trees:
    """Turns the trees that the main tree needs into files, inner ones first."""

    trees: Mapping[str, Element]
    models: Mapping[str, Sections]
    leaves: Mapping[str, LeafType]
    mistakes: Mistakes
    files: dict[str, Located] = field(default_factory=dict)
    under_way: list[str] = field(default_factory=list)

    def sections(self, name: str) -> Sections:
        """The ports of a tree."""
        return self.models.get(name, Sections())

    def add(self, name: str) -> None:
        """Add the file of a tree, and those of the trees that it needs."""
        tree = self.trees[name]
        if not WORD.fullmatch(name):
            mend = "use letters, digits and `_`, and begin with a letter"
            self.mistakes.error(tree.place, f"`{name}` cannot name a task", mend)
            return
        if len(tree.children) != 1:
            what = f"the tree `{name}` has {len(tree.children)} roots"
            self.mistakes.error(tree.place, what, "give it one")
            return
        self.under_way.append(name)
        sections = self.sections(name)
        said = {
            "task": name,
            "description": tree.attributes.get("_description"),
            "scene": tree.attributes.get("_scene"),
            "params": sections.params,
            "outputs": sections.outputs,
            "poses": sections.poses,
            "regions": sections.regions,
            "tree": _Nodes(trees=self, sections=sections).node(tree.children[0]),
        }
        self.under_way.pop()
        self.files[f"{name}.yaml"] = Located(
            tree.place, {key: value for key, value in said.items() if value}
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Nodes:
    """Turns the nodes of one tree into items of a task file."""

    trees: _Trees
    sections: Sections

    def node(self, element: Element) -> Item:
        """The item of an element and of all below it."""
        attributes = dict(element.attributes)
        tag = attributes.pop("ID", "") if element.tag in _EXPLICIT else element.tag
        for key in [key for key in attributes if key.startswith("_") and key != GUARD]:
            if attributes.pop(key) != "false" if key == "_autoremap" else key not in _NOTES:
                what = f"`{key}` has no counterpart"
                self._refuse(element, what, "say it by nodes, or leave it out")
            attributes.pop(key, None)
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
            said = {SET.key: self._script(attributes.get("code", ""), element)}
        elif tag == SUBTREE:
            said = {SUBTREE_KEY: self._subtree(attributes, element)}
        elif tag in self.trees.leaves and tag != SET.key:
            said = {tag: self._leaf(self.trees.leaves[tag], attributes, element)}
        else:
            known = (*_COMPOSITES, *_MODIFIERS, SCRIPT, SUBTREE, *self.trees.leaves)
            self._refuse(element, f"`{tag}` has no counterpart", suggestion(tag, known))
            said = {}
        return Item(element.place, said if name is None else {NAME: name, **said})

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
        value = self._value(text, MODIFIERS[key].type)
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
                said[key] = self._value(text, parameter.type if parameter else None, key)
        return Located(element.place, said) if said else None

    def _subtree(self, attributes: dict[str, str], element: Element) -> Located:
        name = attributes.pop("ID", "")
        if name not in self.trees.trees or name in self.trees.under_way:
            around = "goes round in a circle" if name in self.trees.trees else "is not in the file"
            known = [tree for tree in self.trees.trees if tree not in self.trees.under_way]
            self._refuse(element, f"the tree `{name}` {around}", suggestion(name, known))
            return Located(element.place, {})
        if f"{name}.yaml" not in self.trees.files:
            self.trees.add(name)
        ports = self.trees.sections(name)
        given = {}
        taken = {}
        for key, text in attributes.items():
            if key in ports.outputs:
                taken[key] = self._written_key(key, text, element)
            else:
                given[key] = self._value(text, ports.types.get(key), key)
        said = {"file": f"{name}.yaml", "with": given, "out": taken}
        return Located(element.place, {key: value for key, value in said.items() if value})

    def _script(self, code: str, element: Element) -> Located:
        """The keys that a script of nothing but assignments writes."""
        said: dict[str, object] = {}
        position = 0
        while match := _ASSIGNMENT.match(code, position):
            key, text = match.groups()
            position = match.end()
            is_name = WORD.fullmatch(text) and text not in ("true", "false")
            said[key] = (
                text[1:-1]
                if text.startswith("'")
                else self._value(f"{{{text}}}" if is_name else text, None)
            )
        if not said or code[position:].strip():
            what = "a script that does more than give values to keys has no counterpart"
            self._refuse(element, what, "write `key := value`, or a leaf of your own")
        return Located(element.place, said)

    def _value(self, text: str, expected: ValueType | None, port: str = "") -> object:
        """What an attribute says: a literal, `$name`, or the name of a pose or region."""
        name = port if text == "{=}" else pointed_at(text)
        if name is None:
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

    def _refuse(self, element: Element, what: str, mend: str) -> None:
        self.trees.mistakes.error(element.place, what, mend)


def _wrapped(key: str, value: object, inner: Item, place: Place) -> Item:
    """A node with a modifier around it, in the order of wrapping that the language has."""
    order = list(MODIFIERS)
    inside = [order.index(other) for other in inner if other in MODIFIERS]
    if all(order.index(key) > other for other in inside):
        return Item(inner.place, {key: value, **inner}, {**inner.modifiers, key: place})
    return Item(place, {key: value, "sequence": [inner]}, {key: place})
