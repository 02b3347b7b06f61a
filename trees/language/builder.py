"""Building of a checked task into a py_trees tree."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from py_trees.behaviour import Behaviour

from behaviours import Context, Key, MapPlace, Posture
from config import Diagnostic, Location
from trees.language import rules
from trees.language.leaf_type import ADD
from trees.language.named_poses import READY
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode, Task, TaskFileError
from trees.language.values import Argument, KeyRead
from trees.words import (
    MODIFIERS,
    Add,
    Branch,
    ForEachOf,
    LateLeaf,
    Set,
    Subtree,
    Supply,
)

LeafMaker: TypeAlias = Callable[[LeafNode, Context, Mapping[str, object]], Behaviour]
"""(node, context, arguments and keys by parameter) to the leaf."""


def real_leaf(node: LeafNode, context: Context, arguments: Mapping[str, object]) -> Behaviour:
    """The leaf of a node; `ready` becomes the posture of the robot's description.

    Poses and regions are on the map: the leaf has them where the map is.
    """
    fitted = dict(arguments)
    for name, value in arguments.items():
        if value is READY:
            fitted[name] = Posture(name=READY.name, q=context.robot.description.arm.ready)
        elif isinstance(value, Posture):
            fitted[name] = value.on(context.robot.description)
        elif isinstance(value, MapPlace):
            fitted[name] = context.on_map(value)
    return node.type.behaviour(node.name, context, **fitted)


def build(task: Task, context: Context, make_leaf: LeafMaker = real_leaf) -> Behaviour:
    """A fresh tree, ready to tick, on the context's clock.

    `make_leaf` makes a leaf from its node, the context and its arguments. Raises TaskFileError: a
    leaf refused its parameters, or a parameter has no value.
    """
    for name, parameter in task.parameters.items():
        if parameter.value is None:
            message = f"the parameter `{name}` has no value"
            raise _refused(task.path, parameter.location, message, "give it one")
    return _Builder(context=context, make_leaf=make_leaf, path=task.path).build(task.root)


def _refused(path: Path, location: Location, message: str, hint: str) -> TaskFileError:
    return TaskFileError([Diagnostic(rules.ARGUMENTS, path, location, message, hint)])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Builder:
    """Builds the nodes of one file; each subtree has a builder, and so keys, of its own."""

    context: Context
    make_leaf: LeafMaker
    path: Path  # the file, for messages
    keys: dict[str, Key[object]] = field(default_factory=dict)  # by their names in this file

    def build(self, node: Node) -> Behaviour:
        """The behaviours of a node and of everything below it."""
        if isinstance(node, CompositeNode):
            children = [self.build(child) for child in node.children]
            composite: type[Branch] = node.word
            options: dict[str, object] = dict(node.options)
            if node.cases:
                options = {"value": self._supply(node.options["value"]), "cases": node.cases}
            if node.item is not None:
                listed = self._supply(node.options["in"])
                options = {"values": listed, "item": self._key(node.item.name)}
                composite = ForEachOf
            more = composite.from_context(self.context)
            behaviour: Behaviour = composite(node.name, children, **options, **more)
        elif isinstance(node, SubtreeNode):
            behaviour = self._subtree(node)
        else:
            behaviour = self._leaf(node)
            behaviour.given = node.arguments  # type: ignore[attr-defined]  # for whoever draws it
        for key, value in node.modifiers.items():
            guard = value if isinstance(value, LeafNode | CompositeNode) else None
            made = self.build(guard) if guard is not None else value
            behaviour = MODIFIERS[key].of(made)(behaviour, made, self.context.clock.now)
        return behaviour

    def _subtree(self, node: SubtreeNode) -> Behaviour:
        inner = _Builder(context=self.context, make_leaf=self.make_leaf, path=node.task.path)
        return Subtree(
            node.name,
            inner.build(node.task.root),
            inputs={
                inner._key(name): self._supply(value)
                for name, value in node.arguments.items()
                if isinstance(value, KeyRead)
            },
            outputs={
                self._key(outer.name): inner._key(name) for name, outer in node.outputs.items()
            },
        )

    def _leaf(self, node: LeafNode) -> Behaviour:
        supplies = {name: self._supply(value) for name, value in node.arguments.items()}
        if node.type.names_keys:
            writes = {self._key(key): value for key, value in supplies.items()}
            return (Add if node.type is ADD else Set)(node.name, writes)
        outputs = {name: self._key(key.name) for name, key in node.outputs.items()}

        def make() -> Behaviour:
            arguments = {name: supply() for name, supply in supplies.items()}
            for name, value in node.arguments.items():
                if isinstance(value, KeyRead):
                    value.check(name, arguments[name])
            return self.make_leaf(node, self.context, {**arguments, **outputs})

        if any(isinstance(value, KeyRead) for value in node.arguments.values()):
            return LateLeaf(node.name, node.type.key, node.type.is_condition, make)
        try:
            return make()
        except ValueError as error:
            message = f"`{node.type.key}` refuses its parameters: {error}"
            raise _refused(self.path, node.location, message, "change them") from error
        except (Exception, SystemExit) as error:  # of a constructor that anybody may have written
            message = f"`{node.type.key}` cannot be made: {type(error).__name__}: {error}"
            hint = "correct the constructor of the leaf"
            raise _refused(self.path, node.location, message, hint) from error

    def _key(self, name: str) -> Key[object]:
        return self.keys.setdefault(name, Key(name))

    def _supply(self, value: Argument) -> Supply:
        """Returns the value, or that of its key at the time of the call."""
        if isinstance(value, KeyRead):
            key = self._key(value.name)
            return lambda: value.fitted(key.read())
        return lambda: value
