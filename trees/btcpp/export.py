"""A task as XML for BehaviorTree.CPP 4, which Groot2 opens.

Each task file becomes a tree of the XML, its parameters, poses and regions the ports of that tree,
with their defaults: `$attempts` and a named pose are then both entries of the tree's blackboard.
The tree `Main` runs the task with these defaults. Leaves keep their keys; the models of everything
that BehaviorTree.CPP does not bring along stand at the end.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from trees.btcpp.places import place_text
from trees.btcpp.ports import literal, pointed_at, pointer, port_type, survives
from trees.btcpp.words import (
    ANY_TYPE,
    GUARD,
    MAIN,
    PARALLEL,
    RESERVED_PORTS,
    SCRIPT,
    STANDARD_COMPOSITES,
    STANDARD_MODIFIERS,
    STANDARD_TAGS,
    SUBTREE,
    VALUE,
    parallel_counts,
)
from trees.language import Task, TaskFileError
from trees.language.diagnostics import Diagnostics, Location
from trees.language.parameters import TaskParameter
from trees.language.registry import SET, LeafType
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode
from trees.language.value_types import Named, ValueType
from trees.language.values import KeyRead
from trees.language.vocabulary import COMPOSITES, MODIFIERS

_TAKEN = frozenset({MAIN, SCRIPT, SUBTREE, *STANDARD_TAGS.values(), *COMPOSITES, *MODIFIERS})
"""What neither a task nor a leaf may be called in the XML."""


def export_xml(task: Task) -> str:
    """The XML of a task and of the files that it includes.

    Args:
        task: loaded with open parameters, so that `$name` is still there.

    Raises:
        TaskFileError: something in it has no counterpart in the XML.
    """
    export = _Export()
    required = [name for name, given in task.parameters.items() if given.default is None]
    main = Element("BehaviorTree", ID=MAIN)
    SubElement(main, SUBTREE, {"ID": task.name} | {name: pointer(name) for name in required})
    export.add(task)
    root = Element("root", BTCPP_format="4", main_tree_to_execute=MAIN)
    root.append(main)
    root.extend(export.trees.values())
    models = SubElement(root, "TreeNodesModel")
    models.extend(model for _, model in sorted(export.models.items()))
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


class _Export:
    """Collects the trees of the XML and the models of their nodes."""

    def __init__(self) -> None:
        self.trees: dict[Path, Element] = {}
        self.models: dict[str, Element] = {}

    def add(self, task: Task) -> None:
        """Add a task file, unless it is there already."""
        if task.path in self.trees:
            return
        diagnostics = Diagnostics(task.path)
        start = Location(line=1, column=1)
        others = {tree.get("ID") for tree in self.trees.values()}
        if task.name in _TAKEN or task.name in others or task.name in self.models:
            what = f"the name `{task.name}` of the task is taken in the exported file"
            diagnostics.error(start, what, "give the task another name")
        tree = self.trees[task.path] = Element("BehaviorTree", ID=task.name)
        for key, text in (("_description", task.description), ("_scene", task.scene)):
            if text:
                tree.set(key, text)
        self._add_ports(task, diagnostics)
        _Writer(task=task, export=self, diagnostics=diagnostics).node(task.root, tree)
        if diagnostics.fatal:
            raise TaskFileError(diagnostics.in_order())

    def _add_ports(self, task: Task, diagnostics: Diagnostics) -> None:
        model = self.models[task.name] = Element(SUBTREE, ID=task.name)
        for name, parameter in task.parameters.items():
            assert parameter.type is not None
            model.append(_parameter_port(name, parameter, parameter.type))
            for choice in parameter.type.choices:
                if not survives(choice, None) or ";" in literal(choice):
                    what = f"the choice `{choice}` of `{name}` would be read as something else"
                    diagnostics.error(parameter.place, what, "write it in another way")
        for name, place in (*task.poses.items(), *task.regions.items()):
            kind = port_type(ValueType(kinds=(type(place),)))
            port = SubElement(model, "input_port", name=name, type=kind)
            port.set("default", place_text(place))
        for name, output in task.outputs.items():
            port = SubElement(model, "output_port", name=name, type=ANY_TYPE)
            port.text = output.description or None
        names = [port.get("name") for port in model]
        for name in sorted({str(name) for name in names if names.count(name) > 1}):
            what = f"`{name}` is the name of two things, and they become ports of one tree"
            diagnostics.error(Location(line=1, column=1), what, "rename one of them")

    def add_leaf(self, leaf: LeafType) -> None:
        """Add the model of a leaf."""
        if leaf.key in self.models:
            return
        model = Element("Condition" if leaf.is_condition else "Action", ID=leaf.key)
        for parameter in leaf.parameters.values():
            port = SubElement(model, "input_port", name=parameter.name)
            port.set("type", port_type(parameter.type))
            default = "" if parameter.default is None else parameter.default
            if isinstance(default, bool | int | float | str) and not parameter.required:
                port.set("default", literal(default))
            port.text = parameter.description or None
        for output in leaf.outputs.values():
            port = SubElement(model, "output_port", name=output.name, type=port_type(output.type))
            port.text = output.description or None
        self.models[leaf.key] = model

    def add_word(self, category: str, key: str, ports: Mapping[str, ValueType]) -> None:
        """Add the model of a word that BehaviorTree.CPP does not have."""
        model = self.models[key] = Element(category, ID=key)
        for name, kind in ports.items():
            SubElement(model, "input_port", name=name, type=port_type(kind))


class _Writer:
    """Writes the nodes of one task file.

    Args:
        task: the file.
        export: receives what the nodes need.
        diagnostics: receives what has no counterpart.
    """

    def __init__(self, *, task: Task, export: _Export, diagnostics: Diagnostics) -> None:
        self._task = task
        self._export = export
        self._mistakes = diagnostics

    def node(self, node: Node, above: Element) -> None:
        """Write a node, its modifiers around it, below an element."""
        for key, value in reversed(list(node.modifiers.items())):
            above = self._modifier(key, value, node, above)
        if isinstance(node, CompositeNode):
            self._composite(node, above)
        elif isinstance(node, SubtreeNode):
            self._subtree(node, above)
        else:
            self._leaf(node, above)

    def _modifier(self, key: str, value: object, node: Node, above: Element) -> Element:
        """The element of a modifier; if it is switched off, the one above."""
        if value is False:
            return above
        standard = STANDARD_MODIFIERS.get(key)
        if isinstance(value, LeafNode):
            if standard is None:
                self._export.add_word("Control", key, {})
            guard = SubElement(above, standard.tag if standard else key, {GUARD: key})
            self.node(value, guard)
            return guard
        if standard is not None and not standard.port:
            return SubElement(above, standard.tag, dict(standard.fixed))
        if standard is not None and isinstance(value, KeyRead) and standard.scale == 1:
            return SubElement(above, standard.tag, {standard.port: pointer(value.name)})
        if standard is not None and isinstance(value, int | float):
            whole = round(value * standard.scale)
            if whole / standard.scale == value:
                return SubElement(above, standard.tag, {standard.port: str(whole)})
        kind = MODIFIERS[key].type
        self._export.add_word("Decorator", key, {} if kind is None else {VALUE: kind})
        text = self._text(value, kind, node.place, key)
        return SubElement(above, key, {VALUE: text})

    def _composite(self, node: CompositeNode, above: Element) -> None:
        standard = STANDARD_COMPOSITES.get(node.key)
        options = COMPOSITES[node.key].options
        given = {key: node.options.get(key, option.default) for key, option in options.items()}
        if standard is None:
            self._export.add_word(
                "Control", node.key, {key: option.type for key, option in options.items()}
            )
            attributes = {
                key: self._text(value, options[key].type, node.place, key)
                for key, value in given.items()
            }
        elif standard.tag == PARALLEL and isinstance(given["policy"], KeyRead):
            what = "`policy` decides two attributes of the XML, and none can be told by a parameter"
            self._mistakes.error(node.place, what, "write it out")
            attributes = {}
        elif standard.tag == PARALLEL:
            attributes = parallel_counts(given["policy"], len(node.children))
        else:
            attributes = dict(standard.fixed)
        element = SubElement(above, standard.tag if standard else node.key)
        self._name(node, node.key, element)
        element.attrib.update(attributes)
        for child in node.children:
            self.node(child, element)

    def _leaf(self, node: LeafNode, above: Element) -> None:
        if node.type is SET:
            element = SubElement(above, SCRIPT)
            self._name(node, SET.key, element)
            element.set("code", self._script(node))
            return
        self._export.add_leaf(node.type)
        if self._export.models[node.type.key].tag == SUBTREE:
            what = f"the name `{node.type.key}` is taken by a task in the exported file"
            self._mistakes.error(node.place, what, "give the task another name")
        if node.type.key in _TAKEN or any(key in RESERVED_PORTS for key in node.type.parameters):
            what = (
                f"BehaviorTree.CPP has its own meaning for the key or a port of `{node.type.key}`"
            )
            self._mistakes.error(node.place, what, "rename it in the leaf's class")
        element = SubElement(above, node.type.key)
        self._name(node, node.type.key, element)
        for name, value in node.arguments.items():
            kind = node.type.parameters[name].type
            element.set(name, self._text(value, kind, node.place, name))
        for name, key in node.outputs.items():
            element.set(name, self._pointer(key.name, node.place))

    def _script(self, node: LeafNode) -> str:
        """The assignments of a `set`."""
        parts = []
        for key, value in node.arguments.items():
            text = self._text(value, None, node.place, key)
            if value is None or "'" in text:
                what = f"`{key}`: a script cannot write {text}"
                self._mistakes.error(node.place, what, "write another value")
            is_word = isinstance(value, bool | int | float)
            self._pointer(key, node.place)
            parts.append(f"{key} := {pointed_at(text) or (text if is_word else repr(text))}")
        return "; ".join(parts)

    def _subtree(self, node: SubtreeNode, above: Element) -> None:
        self._export.add(node.task)
        element = SubElement(above, SUBTREE, ID=node.task.name)
        self._name(node, node.task.name, element)
        for name, value in node.arguments.items():
            kind = node.task.parameters[name].type
            element.set(name, self._text(value, kind, node.place, name))
        for name, key in node.outputs.items():
            element.set(name, self._pointer(key.name, node.place))

    def _name(self, node: Node, unnamed: str, element: Element) -> None:
        """Name the element, if the node has a name of its own."""
        if node.name != unnamed:
            element.set("name", node.name)

    def _pointer(self, name: str, place: Location) -> str:
        """The attribute that stands for a parameter or key."""
        if name in self._task.poses or name in self._task.regions:
            what = f"`{name}` is a key and a pose or region, which share one blackboard in the XML"
            self._mistakes.error(place, what, "rename one of them")
        return pointer(name)

    def _text(self, value: object, kind: ValueType | None, place: Location, about: str) -> str:
        """A value as the text of an attribute."""
        if isinstance(value, KeyRead):
            return self._pointer(value.name, place)
        if isinstance(value, Named):
            defined = value.name in self._task.poses or value.name in self._task.regions
            return pointer(value.name) if defined else value.name
        assert value is None or isinstance(value, bool | int | float | str)
        if not survives(value, kind):
            what = f"`{about}`: BehaviorTree.CPP would read {literal(value)!r} as something else"
            self._mistakes.error(place, what, "write it in another way")
        return literal(value)


def _parameter_port(name: str, parameter: TaskParameter, expected: ValueType) -> Element:
    port = Element("input_port", name=name, type=port_type(expected))
    if parameter.default is not None:
        port.set("default", literal(parameter.default.value))
    bounds = {"_min": expected.least, "_max": expected.most}
    for key, bound in bounds.items():
        if bound is not None:
            port.set(key, f"{bound:.15g}")
    if expected.choices:
        port.set("_choices", ";".join(literal(choice) for choice in expected.choices))
    port.text = parameter.description or None
    return port
