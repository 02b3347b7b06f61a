"""Trees of the XML, one for each task file, and the models of their nodes."""

from collections.abc import Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from config import Diagnostics, Location, counted
from extensions.export.btcpp.counterparts import (
    ANY_TYPE,
    PARALLEL,
    RESERVED_PORTS,
    SCRIPT,
    SUBTREE,
    SWITCHES,
    TAKEN,
    VALUE,
    leaf_model,
    literal,
    parallel_counts,
    parameter_port,
    pointed_at,
    pointer,
    port_type,
    pose_text,
    standard_attributes,
    survives,
    switch_attributes,
)
from trees.language import (
    MODIFIERS,
    NO_COUNTERPART,
    SET,
    CompositeNode,
    KeyRead,
    LeafNode,
    LeafType,
    NamedValue,
    Node,
    SubtreeNode,
    Task,
    TaskFileError,
    ValueType,
)


class Export:
    """Collects the trees of the XML and the models of their nodes."""

    def __init__(self, task: Task) -> None:
        self.trees: dict[Path, Element] = {}
        self.models: dict[str, Element] = {}
        self.used: dict[Path, set[str]] = {}  # models of the nodes of a file, and of its tree
        self.included: dict[Path, set[Path]] = {}  # the files that a file uses
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
            diagnostics.error(NO_COUNTERPART, start, message, "give the task another name")
        tree = self.trees[task.path] = Element("BehaviorTree", ID=task.name)
        for key, text in (("_description", task.description), ("_scene", task.scene)):
            if text:
                tree.set(key, text)
        self._add_ports(task, diagnostics)
        _Writer(task, self, diagnostics).node(task.root, tree)
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
            diagnostics.error(
                NO_COUNTERPART, Location(line=1, column=1), message, "rename one of them"
            )

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


class _Writer:
    """Writes the nodes of one task file."""

    def __init__(self, task: Task, export: Export, diagnostics: Diagnostics) -> None:
        self._task, self._export, self._diagnostics = task, export, diagnostics

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
        """The element of a modifier."""
        word = MODIFIERS[key].of(value)
        counterpart = word.counterpart
        if isinstance(value, LeafNode | CompositeNode):
            if counterpart is None:
                self._export.add_word(self._task, "Control", key, {})
            guard = SubElement(above, counterpart.tag if counterpart else key)
            self.node(value, guard)
            return guard
        attributes = None if counterpart is None else standard_attributes(counterpart, value)
        if counterpart is not None and attributes is not None:
            return SubElement(above, counterpart.tag, attributes)
        self._export.add_word(
            self._task, "Decorator", key, {} if word.type is None else {VALUE: word.type}
        )
        text = self._text(value, word.type, node.location, key)
        return SubElement(above, key, {VALUE: text})

    def _switch(self, node: CompositeNode, above: Element) -> None:
        number = len(node.cases)
        if number not in SWITCHES:
            message = f"`switch` has {counted(number, 'case')}, and the XML has switches of 2 to 6"
            self._refuse(node.location, message, "split it, or make it a `fallback`")
        variable = self._text(node.options["value"], None, node.location, "value")
        element = SubElement(above, f"Switch{number}", switch_attributes(variable, node.cases))
        self._name(node, node.key, element)
        for child in node.children:
            self.node(child, element)
        if len(node.children) == number:
            SubElement(element, "AlwaysFailure")

    def _composite(self, node: CompositeNode, above: Element) -> None:
        if node.cases:
            self._switch(node, above)
            return
        if node.item is not None:
            message = "`for_each` over what is detected has no counterpart in the XML"
            self._refuse(node.location, message, "leave it out for the export")
            return
        counterpart, options = node.word.counterpart, node.word.options
        values = {key: node.options.get(key, option.default) for key, option in options.items()}
        if counterpart is None:
            self._export.add_word(
                self._task,
                "Control",
                node.key,
                {key: option.type for key, option in options.items()},
            )
            attributes = {
                key: self._text(value, options[key].type, node.location, key)
                for key, value in values.items()
            }
        elif counterpart.tag == PARALLEL and isinstance(values["policy"], KeyRead):
            message = "`policy` becomes two counts in the XML, and a parameter is only one"
            self._refuse(node.location, message, "write the policy out")
            attributes = {}
        elif counterpart.tag == PARALLEL:
            attributes = parallel_counts(values["policy"], len(node.children))
        else:
            attributes = dict(counterpart.fixed)
        element = SubElement(above, counterpart.tag if counterpart else node.key)
        self._name(node, node.key, element)
        element.attrib.update(attributes)
        for child in node.children:
            self.node(child, element)

    def _leaf(self, node: LeafNode, above: Element) -> None:
        if node.type.names_keys:
            element = SubElement(above, SCRIPT)
            self._name(node, node.type.key, element)
            element.set("code", self._script(node))
            return
        if self._export.add_leaf(self._task, node.type).tag == SUBTREE:
            message = f"the name `{node.type.key}` is taken by a task in the exported file"
            self._refuse(node.location, message, "give the task another name")
        if node.type.key in TAKEN or not RESERVED_PORTS.isdisjoint(node.type.parameters):
            message = f"the key or a parameter of `{node.type.key}` is taken in BehaviorTree.CPP"
            self._refuse(node.location, message, "rename it in the leaf's class")
        element = SubElement(above, node.type.key)
        self._name(node, node.type.key, element)
        for name, value in node.arguments.items():
            expected = node.type.parameters[name].type
            element.set(name, self._text(value, expected, node.location, name))
        for name, key in node.outputs.items():
            element.set(name, self._pointer(key.name, node.location))

    def _script(self, node: LeafNode) -> str:
        """The assignments of a `set` or an `add`."""
        parts = []
        for key, value in node.arguments.items():
            text = self._text(value, None, node.location, key)
            if value is None or "'" in text:
                message = f"`{key}`: a script cannot write {text}"
                self._refuse(node.location, message, "write another value")
            is_word = isinstance(value, bool | int | float)
            self._pointer(key, node.location)
            becomes = ":=" if node.type is SET else "+="
            parts.append(f"{key} {becomes} {pointed_at(text) or (text if is_word else repr(text))}")
        return "; ".join(parts)

    def _subtree(self, node: SubtreeNode, above: Element) -> None:
        self._export.add_subtree(self._task, node.task)
        element = SubElement(above, SUBTREE, ID=node.task.name)
        self._name(node, node.task.name, element)
        for name, value in node.arguments.items():
            expected = node.task.parameters[name].type
            element.set(name, self._text(value, expected, node.location, name))
        for name, key in node.outputs.items():
            element.set(name, self._pointer(key.name, node.location))

    def _refuse(self, location: Location, message: str, hint: str) -> None:
        self._diagnostics.error(NO_COUNTERPART, location, message, hint)

    def _name(self, node: Node, unnamed: str, element: Element) -> None:
        """Name the element, if the node has a name of its own."""
        if node.name != unnamed:
            element.set("name", node.name)

    def _pointer(self, name: str, location: Location) -> str:
        """The attribute that stands for a parameter or key."""
        if name in self._task.poses or name in self._task.regions:
            message = (
                f"`{name}` is a key and a pose or region, and the XML has one blackboard for both"
            )
            self._refuse(location, message, "rename one of them")
        return pointer(name)

    def _text(
        self, value: object, expected: ValueType | None, location: Location, about: str
    ) -> str:
        """A value as the text of an attribute."""
        if isinstance(value, KeyRead):
            return self._pointer(value.name, location)
        if isinstance(value, NamedValue):
            defined = value.name in self._task.poses or value.name in self._task.regions
            return pointer(value.name) if defined else value.name
        assert value is None or isinstance(value, bool | int | float | str)
        if not survives(value, expected):
            message = f"`{about}`: BehaviorTree.CPP would read {literal(value)!r} as something else"
            self._refuse(location, message, "write it in another way")
        return literal(value)
