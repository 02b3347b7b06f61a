"""Flow through a tree: the outcomes of each node, the keys that are written then, and the hand.

Each key is of one type, and is certainly written before it is read: by `set`, or by a leaf or a
subtree that has succeeded. Of a node that has failed, only what it writes on every way to its
failure counts. What the hand is follows in the same way from what each leaf makes of it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple

from config import Diagnostics, Location, suggest
from trees.language import rules
from trees.language.documents import TaskOutput, TaskParameter
from trees.language.leaf_type import ADD, SET
from trees.language.syntax import (
    CompositeNode,
    LeafNode,
    Node,
    SubtreeNode,
    hand_leaves,
    nodes_below,
)
from trees.language.values import Argument, KeyRead, KeyWrite
from trees.words import (
    EMPTY,
    FULL,
    HAND,
    JUST,
    MODIFIERS,
    SEEN_ONE,
    UNUSED_HAND,
    Keys,
    Outcome,
    Outcomes,
    ValueType,
    either,
    rounds,
    type_of,
    without_hand,
)

_ANY_NUMBER = ValueType(types=(int, float))


class Fact(NamedTuple):
    """What is known about a node; a loop comes to it in several ways."""

    reached: bool  # whether it is ever ticked, with its modifiers
    ways: tuple[frozenset[str], ...]  # what is certain when it starts without them, on each
    layers: Mapping[str, Outcomes]
    """How it can end with its modifiers up to each, innermost first; `` is the node without any."""

    @property
    def outcomes(self) -> Outcomes:
        """How it can end."""
        return list(self.layers.values())[-1]


@dataclass(frozen=True, kw_only=True)
class FlowResult:
    """What is known about the tree of one file."""

    outcomes: Outcomes
    outputs: Mapping[str, TaskOutput]  # with their types
    facts: Mapping[int, Fact]  # by `id` of the node, those of other files among them
    ends: Mapping[int, LeafNode]
    """By `id` of a condition that is asked again and again, the leaf after which it never holds."""


def check_flow(
    root: Node,
    parameters: Mapping[str, TaskParameter],
    outputs: Mapping[str, TaskOutput],
    diagnostics: Diagnostics,
    is_first: bool,
) -> FlowResult | None:
    """Note every key that is read without having been written, or as another type.

    Parameters without a value are there from the beginning, like keys; `outputs` have to be written
    when the tree succeeds. In the first file nothing was taken when it begins. Returns None if
    there is an error.
    """
    late = {
        name: parameter.type
        for name, parameter in parameters.items()
        if parameter.is_late and parameter.type is not None
    }
    flow = _Flow(root=root, parameters=parameters, diagnostics=diagnostics, types=dict(late))
    outcomes = flow.follow(root, frozenset(late) | {UNUSED_HAND} if is_first else frozenset(late))
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
    return FlowResult(outcomes=outcomes, outputs=typed, facts=flow.facts, ends=flow.ends)


@dataclass(frozen=True, kw_only=True)
class _Flow:
    """Follows the tree of one file."""

    root: Node
    parameters: Mapping[str, TaskParameter]
    diagnostics: Diagnostics
    types: dict[str, ValueType]  # of the keys met so far
    writes: dict[str, Location] = field(default_factory=dict)  # where each key is first written
    read: set[str] = field(default_factory=set)
    facts: dict[int, Fact] = field(default_factory=dict)
    ends: dict[int, LeafNode] = field(default_factory=dict)
    followed: dict[tuple[int, Keys], Outcomes] = field(default_factory=dict)

    def follow(self, node: Node, before: Keys) -> Outcomes:
        """How a node can end that starts when this is certain."""
        if (id(node), before) not in self.followed:
            keys = ["", *node.modifiers]
            self.followed[id(node), before] = self._layer(node, keys, before)
            fact = self.facts[id(node)]
            self.facts[id(node)] = fact._replace(reached=fact.reached or before is not None)
        return self.followed[id(node), before]

    def _layer(self, node: Node, keys: Sequence[str], before: Keys) -> Outcomes:
        """How a node can end with these of its modifiers, innermost first."""
        *inner, key = keys
        if not key:
            outcomes = self._alone(node, before)
        else:
            value = node.modifiers[key]
            word = MODIFIERS[key].of(value)
            start = before
            early = without_hand(before) if any(hand_leaves(node)) else before
            if word.runs_on is not None and isinstance(value, LeafNode | CompositeNode):
                start = word.runs_on.of(self.follow(value, before))
                early = word.runs_on.opposite.of(self.follow(value, early))
                if word.runs_on is Outcome.SUCCESS:
                    self._note_end(value, node, start)
            again = None if value == 1 else word.again
            ends = rounds(partial(self._layer, node, inner), again, start)
            outcomes = word.outcomes(ends, early)
        fact = self.facts.get(id(node), Fact(False, (), {}))
        ways = fact.ways if key or before is None else (*fact.ways, before)
        known = fact.layers.get(key, outcomes)
        merged = Outcomes(*(either(*one) for one in zip(known, outcomes, strict=True)))
        self.facts[id(node)] = fact._replace(ways=ways, layers={**fact.layers, key: merged})
        return outcomes

    def _note_end(self, condition: Node, node: Node, before: Keys) -> None:
        """Of a condition that is asked while a node runs: the leaf below after which it fails."""
        for leaf in hand_leaves(node) if before is not None else ():
            after = self._ends(leaf, without_hand(before)).success
            if after is not None and self.follow(condition, after | {JUST}).success is None:
                self.ends.setdefault(id(condition), leaf)

    def _alone(self, node: Node, before: Keys) -> Outcomes:
        """How a node can end without its modifiers."""
        if isinstance(node, SubtreeNode):
            return self._subtree(node, before)
        if isinstance(node, LeafNode):
            return self._leaf(node, before)
        word = node.word
        children = [partial(self.follow, child) for child in node.children]
        for option in node.options.values():
            self._read(option, before)
        if node.item is not None:
            self._write(node.item, SEEN_ONE)
        options = {**node.options, "cases": node.cases, "item": node.item}
        if not word.at_once or not any(hand_leaves(node)):
            return word.outcomes(children, options, before)
        # What one child does to the hand, the others meet.
        return Outcomes(*map(without_hand, word.outcomes(children, options, without_hand(before))))

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
        return self._ends(node, before)

    def _ends(self, node: LeafNode, before: Keys) -> Outcomes:
        """The outcomes of a leaf, by what it writes and what becomes of the hand."""
        leaf, success, failure = node.type, _with(before, node.outputs), before
        if before is not None and leaf.hand_after:
            known = before - HAND
            nothing = before & {UNUSED_HAND}
            made = {FULL} if leaf.hand_after == "full" else {EMPTY, UNUSED_HAND}
            success = known | made
            if leaf.is_condition:
                failure = None if {FULL, JUST} <= before else known | {EMPTY, UNUSED_HAND}
            elif leaf.hand_after == "full" and not (leaf.hand_before == "empty" and FULL in before):
                failure = known | {UNUSED_HAND}
            else:
                failure = known | nothing
            if leaf.hand_before == "full" and EMPTY in before:
                success, failure = None, before
        return Outcomes(success, failure if leaf.can_fail else None)

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
        inside = _Flow(
            root=node.task.root,
            parameters=node.task.parameters,
            diagnostics=Diagnostics(node.task.path),  # all but the hand was told of that file
            types={},
            facts=self.facts,
            ends=self.ends,
        )
        hand = inside.follow(node.task.root, None if before is None else before & HAND)
        written = Outcomes(_with(before, node.outputs), before)
        possible = zip(node.task.outcomes, written, hand, strict=True)
        return Outcomes(
            *(
                None if one is None or keys is None or after is None else keys - HAND | after & HAND
                for one, keys, after in possible
            )
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
            for node in nodes_below(self.root):
                written = () if isinstance(node, CompositeNode) else node.outputs.values()
                if name in [write.name for write in written]:
                    hint = f"move it behind `{node.name}` on line {node.location.line}"
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
