"""A task as XML for BehaviorTree.CPP 4, which Groot2 opens.

Each task file becomes a tree of the XML, in one text or in a file of its own, with its parameters,
poses and regions as ports. The tree `Main` runs the task with their defaults. The models of nodes
that BehaviorTree.CPP lacks stand at the end.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from config import Diagnostics, Location
from trees.btcpp.counterparts import MAIN, SUBTREE, TAKEN
from trees.btcpp.ports import (
    ANY_TYPE,
    leaf_model,
    parameter_port,
    pointer,
    port_type,
    pose_text,
)
from trees.btcpp.writer import Writer
from trees.language import LeafType, Task, TaskFileError, ValueType


def export_xml(task: Task) -> str:
    """The XML of a task and of the files that it includes, in one text.

    Args:
        task: loaded with open parameters, so that `$name` is still there.

    Raises:
        TaskFileError: something in it has no counterpart in the XML.
    """
    export = _Export(task)
    root = _root(_main(task))
    root.extend(export.trees.values())
    return _text(root, export.models, export.models)


def export_files(task: Task) -> dict[Path, str]:
    """The XML of a task, and a file of XML for each file that it includes.

    Each includes those that it uses, so that each can be opened alone.

    Args:
        task: as for `export_xml`.

    Returns:
        The texts by where they belong, from the file of the task on, which comes first.

    Raises:
        TaskFileError: something in it has no counterpart in the XML.
    """
    export = _Export(task)
    home = task.path.resolve().parent
    texts: dict[Path, str] = {}
    for path, tree in export.trees.items():
        root = _root(*((_main(task),) if path == task.path else ()))
        for number, other in enumerate(sorted(export.included[path])):
            include = Element("include", path=_beside(other, path.resolve().parent).as_posix())
            root.insert(number, include)
        root.append(tree)
        place = _beside(path, home)
        if place in texts:
            diagnostics = Diagnostics(path)
            message = f"another file of the task becomes `{place}` too"
            diagnostics.error(Location(line=1, column=1), message, "rename one of them")
            raise TaskFileError(diagnostics.in_order())
        texts[place] = _text(root, export.models, export.used[path])
    return texts


def _beside(path: Path, folder: Path) -> Path:
    """The XML of a task file, relative to a folder."""
    return Path(os.path.relpath(path.resolve(), folder)).with_suffix(".xml")


def _main(task: Task) -> Element:
    """The tree that runs the task with its defaults."""
    required = [name for name, one in task.parameters.items() if one.default is None]
    main = Element("BehaviorTree", ID=MAIN)
    SubElement(main, SUBTREE, {"ID": task.name} | {name: pointer(name) for name in required})
    return main


def _root(*trees: Element) -> Element:
    root = Element("root", BTCPP_format="4")
    if trees:
        root.set("main_tree_to_execute", MAIN)
    root.extend(trees)
    return root


def _text(root: Element, models: Mapping[str, Element], used: Iterable[str]) -> str:
    SubElement(root, "TreeNodesModel").extend(models[key] for key in sorted(used))
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


class _Export:
    """Collects the trees of the XML and the models of their nodes."""

    def __init__(self, task: Task) -> None:
        self.trees: dict[Path, Element] = {}
        self.models: dict[str, Element] = {}
        self.used: dict[Path, set[str]] = {}
        """The models of the nodes that a file has, and of its tree."""
        self.included: dict[Path, set[Path]] = {}
        """The files that a file uses."""
        self.add(task)

    def add(self, task: Task) -> None:
        """Add a task file, unless it is there already."""
        if task.path in self.trees:
            return
        self.used[task.path], self.included[task.path] = {task.name}, set()
        diagnostics = Diagnostics(task.path)
        start = Location(line=1, column=1)
        others = {tree.get("ID") for tree in self.trees.values()}
        if task.name in TAKEN or task.name in others or task.name in self.models:
            message = f"the name `{task.name}` of the task is taken in the exported file"
            diagnostics.error(start, message, "give the task another name")
        tree = self.trees[task.path] = Element("BehaviorTree", ID=task.name)
        for key, text in (("_description", task.description), ("_scene", task.scene)):
            if text:
                tree.set(key, text)
        self._add_ports(task, diagnostics)
        Writer(task=task, export=self, diagnostics=diagnostics).node(task.root, tree)
        if diagnostics.fatal:
            raise TaskFileError(diagnostics.in_order())

    def _add_ports(self, task: Task, diagnostics: Diagnostics) -> None:
        model = self.models[task.name] = Element(SUBTREE, ID=task.name)
        for name, parameter in task.parameters.items():
            assert parameter.type is not None
            model.append(parameter_port(name, parameter, parameter.type))
        for name, value in (*task.poses.items(), *task.regions.items()):
            port = SubElement(model, "input_port", name=name)
            port.set("type", port_type(ValueType(types=(type(value),))))
            port.set("default", pose_text(value))
        for name, output in task.outputs.items():
            port = SubElement(model, "output_port", name=name, type=ANY_TYPE)
            port.text = output.description or None
        names = [port.get("name") for port in model]
        for name in sorted({str(name) for name in names if names.count(name) > 1}):
            message = f"`{name}` is defined twice, and both become ports of one tree"
            diagnostics.error(Location(line=1, column=1), message, "rename one of them")

    def add_subtree(self, task: Task, other: Task) -> None:
        """Add the file that a task includes."""
        self.add(other)
        self.included[task.path].add(other.path)

    def add_leaf(self, task: Task, leaf: LeafType) -> Element:
        """Add the model of a leaf that a task has; returns what has its name."""
        self.used[task.path].add(leaf.key)
        if leaf.key not in self.models:
            self.models[leaf.key] = leaf_model(leaf)
        return self.models[leaf.key]

    def add_word(self, task: Task, category: str, key: str, ports: Mapping[str, ValueType]) -> None:
        """Add the model of a word that BehaviorTree.CPP does not have, and a task has."""
        self.used[task.path].add(key)
        model = self.models[key] = Element(category, ID=key)
        for name, expected in ports.items():
            SubElement(model, "input_port", name=name, type=port_type(expected))
