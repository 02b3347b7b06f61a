"""Data flow of a tree: the outcomes of each node, and the keys that are written then.

Each key is of one type, and is certainly written before it is read: by `set`, or by a leaf or a
subtree that has succeeded. Of a node that has failed, only what it writes on every way to its
failure counts.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple

from config import Diagnostics, Location, suggest
from trees.language import rules
from trees.language.documents import TaskOutput, TaskParameter
from trees.language.leaf_type import ADD, SET
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode
from trees.language.values import Argument, KeyRead, KeyWrite
from trees.words import COMPOSITES, MODIFIERS, NEVER, SEEN_ONE, Keys, Outcomes, ValueType, type_of

_ANY_NUMBER = ValueType(types=(int, float))


class Fact(NamedTuple):
    """What is known about a node."""

    before: Keys  # the keys that are written when it starts; None if it is never reached
    own: Outcomes  # how it can end without its modifiers
    outcomes: Outcomes


@dataclass(frozen=True, kw_only=True)
class FlowResult:
    """What is known about the tree of one file."""

    outcomes: Outcomes
    outputs: Mapping[str, TaskOutput]  # with their types
    facts: Mapping[int, Fact]  # by `id` of the node


def check_flow(
    root: Node,
    parameters: Mapping[str, TaskParameter],
    outputs: Mapping[str, TaskOutput],
    diagnostics: Diagnostics,
) -> FlowResult | None:
    """Note every key that is read without having been written, or as another type.

    Parameters without a value are there from the beginning, like keys; `outputs` have to be written
    when the tree succeeds. Returns None if there is an error.
    """
    late = {
        name: parameter.type
        for name, parameter in parameters.items()
        if parameter.is_late and parameter.type is not None
    }
    flow = _Flow(parameters=parameters, diagnostics=diagnostics, types=dict(late))
    outcomes = flow.follow(root, frozenset(late))
    for name, output in outputs.items():
        flow.read.add(name)
        if name not in flow.types:
            message = f"nothing in the tree writes the output `{name}`"
            diagnostics.error(rules.UNWRITTEN, output.location, message, suggest(name, flow.writes))
        elif outcomes.success is not None and name not in outcomes.success:
            message = f"the tree can succeed without having written the output `{name}`"
            hint = f"begin it with `set: {{{name}: ...}}`"
            diagnostics.error(rules.UNWRITTEN, output.location, message, hint)
    for name, location in flow.writes.items():
        if name not in flow.read:
            hint = f"write `${name}` somewhere, or remove it"
            diagnostics.warning(rules.UNUSED, location, f"the key `{name}` is never read", hint)
    if diagnostics.fatal:
        return None
    typed = {name: replace(output, type=flow.types.get(name)) for name, output in outputs.items()}
    return FlowResult(outcomes=outcomes, outputs=typed, facts=flow.facts)


@dataclass(frozen=True, kw_only=True)
class _Flow:
    """Follows the tree of one file."""

    parameters: Mapping[str, TaskParameter]
    diagnostics: Diagnostics
    types: dict[str, ValueType]  # of the keys met so far
    writes: dict[str, Location] = field(default_factory=dict)  # where each key is first written
    read: set[str] = field(default_factory=set)
    facts: dict[int, Fact] = field(default_factory=dict)

    def follow(self, node: Node, before: Keys) -> Outcomes:
        """How a node can end that starts when the keys `before` are written."""
        start = before
        for key, value in reversed(list(node.modifiers.items())):
            runs_on = MODIFIERS[key].runs_on
            if runs_on is not None and isinstance(value, LeafNode | CompositeNode):
                start = runs_on.of(self.follow(value, start))
        if isinstance(node, CompositeNode):
            children = [partial(self.follow, child) for child in node.children]
            for option in node.options.values():
                self._read(option, start)
            if node.item is not None:
                self._write(node.item, SEEN_ONE)
            options = {**node.options, "cases": node.cases, "item": node.item}
            outcomes = COMPOSITES[node.key].outcomes(children, options, start)
        elif isinstance(node, SubtreeNode):
            outcomes = self._subtree(node, start)
        else:
            outcomes = self._leaf(node, start)
        own = outcomes if start is not None else NEVER
        outcomes = own
        for key, value in node.modifiers.items():
            if value is not False:
                outcomes = MODIFIERS[key].outcomes(outcomes, before)
        self.facts[id(node)] = Fact(before, own, outcomes)
        return outcomes

    def _leaf(self, node: LeafNode, before: Keys) -> Outcomes:
        for value in node.arguments.values():
            self._read(value, before)
        for name, write in node.outputs.items():
            if node.type is ADD:
                self._add(write, self._type_of(node.arguments[name]), before)
            elif node.type is SET:
                self._write(write, self._type_of(node.arguments[name]))
            else:
                self._write(write, node.type.outputs[name].type)
        self._compare(node)
        return Outcomes(_with(before, node.outputs), before if node.type.can_fail else None)

    def _add(self, write: KeyWrite, more: ValueType | None, before: Keys) -> None:
        """A number is added to a key that holds one."""
        known = self.types.get(write.name)
        wanted = ValueType(types=(int, float)) if known is None or known.is_number else known
        self._read(KeyRead(location=write.location, name=write.name, type=_ANY_NUMBER), before)
        if known is not None and more is not None and known.is_number and not wanted.takes(more):
            message = f"`{write.name}` holds {known}"
            self.diagnostics.error(rules.KEY_TYPE, write.location, message, "add a number")
        elif known == ValueType(types=(int,)) and more == ValueType(types=(float,)):
            message = f"`{write.name}` holds a whole number, and cannot take a fraction"
            hint = f"add a whole number, or begin with `set: {{{write.name}: 0.0}}`"
            self.diagnostics.error(rules.KEY_TYPE, write.location, message, hint)

    def _compare(self, node: LeafNode) -> None:
        """Values of different kinds are never equal."""
        kinds = [
            (name, kind)
            for name in node.type.comparable
            if name in node.arguments and (kind := _kind(self._type_of(node.arguments[name])))
        ]
        for (one, first), (other, second) in pairwise(kinds):
            if first.isdisjoint(second):
                what, with_what = (" or ".join(sorted(kinds)) for kinds in (first, second))
                message = (
                    f"`{node.type.key}` compares {what} (`{one}`) with {with_what} (`{other}`), "
                    "which are never equal"
                )
                hint = "give values of one kind, without quotes for a number"
                self.diagnostics.error(rules.KEY_TYPE, node.location, message, hint)

    def _subtree(self, node: SubtreeNode, before: Keys) -> Outcomes:
        for value in node.arguments.values():
            self._read(value, before)
        for name, write in node.outputs.items():
            self._write(write, node.task.outputs[name].type)
        can = node.task.outcomes
        return Outcomes(
            None if can.success is None else _with(before, node.outputs),
            None if can.failure is None else before,
        )

    def _type_of(self, value: Argument) -> ValueType | None:
        if isinstance(value, KeyRead):
            return self.types.get(value.name)
        return type_of(value)

    def _write(self, write: KeyWrite, written: ValueType | None) -> None:
        first = self.writes.setdefault(write.name, write.location)
        if written is None:
            return
        known = self.types.setdefault(write.name, written)
        if known != written:
            message = f"`{write.name}` takes {written} here, and {known} on line {first.line}"
            hint = "write it under another name"
            self.diagnostics.error(rules.KEY_TYPE, write.location, message, hint)

    def _read(self, value: Argument, before: Keys) -> None:
        if not isinstance(value, KeyRead):
            return
        name = value.name
        self.read.add(name)
        if name not in self.types:
            if name in self.writes:
                return
            message = f"`{value}` is neither a parameter nor a key that is written before"
            hint = suggest(name, {*self.parameters, *self.types})
            self.diagnostics.error(rules.UNWRITTEN, value.location, message, hint)
        elif before is not None and name not in before:
            message = f"`{value}` is not written on every way here"
            line = self.writes[name].line
            hint = f"let line {line} succeed before, or begin with `set: {{{name}: ...}}`"
            self.diagnostics.error(rules.UNWRITTEN, value.location, message, hint)
        elif not value.type.takes(self.types[name]):
            message = f"expected {value.type}, got `{value}`, which is {self.types[name]}"
            self.diagnostics.error(rules.KEY_TYPE, value.location, message, f"give {value.type}")


def _kind(expected: ValueType | None) -> frozenset[str]:
    """What kinds of values a type has; empty if it is not known."""
    if expected is None:
        return frozenset()
    types = {*expected.types, *(type(choice) for choice in expected.choices)}
    words = {bool: "a truth value", int: "a number", float: "a number", str: "a text"}
    return frozenset(words.get(one, "something else") for one in types)


def _with(before: Keys, outputs: Mapping[str, KeyWrite]) -> Keys:
    return None if before is None else before | {write.name for write in outputs.values()}
