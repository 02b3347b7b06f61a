"""Keys: each is of one type, and is written before it is read.

The check follows the tree as it may run. A key counts as written at a node if it is on every way
there: by `set`, or by a leaf or a subtree that has succeeded. Of a node that failed on the way
nothing counts that it does not write on every way to its failure. Keys are never unwritten.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from config import suggest
from trees.language.diagnostics import Diagnostics, Location
from trees.language.parameters import TaskParameter
from trees.language.registry import SET
from trees.language.syntax import CompositeNode, LeafNode, Node, SubtreeNode, TaskOutput
from trees.language.value_types import ValueType, type_of
from trees.language.values import Given, KeyRead, KeyWrite


class Written(NamedTuple):
    """The keys that are certainly written when a node has ended."""

    success: frozenset[str]
    failure: frozenset[str]


def check_keys(
    root: Node,
    parameters: Mapping[str, TaskParameter],
    outputs: Mapping[str, TaskOutput],
    diagnostics: Diagnostics,
) -> dict[str, TaskOutput] | None:
    """Note every key that is read without having been written, or as what it is not.

    Args:
        root: the tree of one file.
        parameters: those without a value are there from the beginning, like keys.
        outputs: keys that have to be written when the tree succeeds.
        diagnostics: of the file.

    Returns:
        The outputs with their types; None if there is a diagnostic.
    """
    late = {
        name: parameter.type
        for name, parameter in parameters.items()
        if parameter.is_late and parameter.type is not None
    }
    flow = _Flow(parameters=parameters, diagnostics=diagnostics, types=dict(late))
    written = flow.after(root, frozenset(late))
    for name, output in outputs.items():
        flow.read.add(name)
        if name not in flow.types:
            what = f"nothing in the tree writes the output `{name}`"
            diagnostics.error(output.place, what, suggest(name, flow.writes))
        elif name not in written.success:
            what = f"the tree can succeed without having written the output `{name}`"
            diagnostics.error(output.place, what, f"begin it with `set: {{{name}: ...}}`")
    for name, place in flow.writes.items():
        if name not in flow.read:
            what = f"the key `{name}` is never read"
            diagnostics.warning(place, what, f"write `${name}` somewhere, or remove it")
    if diagnostics.fatal:
        return None
    return {name: replace(output, type=flow.types.get(name)) for name, output in outputs.items()}


@dataclass(frozen=True, kw_only=True)
class _Flow:
    """Follows the tree of one file."""

    parameters: Mapping[str, TaskParameter]
    diagnostics: Diagnostics
    types: dict[str, ValueType]
    """Of the keys met so far."""
    writes: dict[str, Location] = field(default_factory=dict)
    """Where each key is first written."""
    read: set[str] = field(default_factory=set)

    def after(self, node: Node, before: frozenset[str]) -> Written:
        """What is written after a node that starts when `before` is."""
        start = before
        for key in ("while", "unless"):
            guard = node.modifiers.get(key)
            if isinstance(guard, LeafNode):
                asked = self.after(guard, start)
                start = asked.success if key == "while" else asked.failure
        if isinstance(node, CompositeNode):
            written = _COMPOSITES[node.key](self, node, start)
        elif isinstance(node, SubtreeNode):
            written = self._subtree(node, start)
        else:
            written = self._leaf(node, start)
        for key, value in node.modifiers.items():
            if value is not False and key in _MODIFIERS:
                written = _MODIFIERS[key](written, before)
        return written

    def sequence(self, node: CompositeNode, before: frozenset[str]) -> Written:
        """Each child starts when the one before has succeeded."""
        failures = []
        for child in node.children:
            before, failure = self.after(child, before)
            failures.append(failure)
        return Written(before, frozenset.intersection(*failures))

    def fallback(self, node: CompositeNode, before: frozenset[str]) -> Written:
        """Each child starts when the one before has failed."""
        successes = []
        for child in node.children:
            success, before = self.after(child, before)
            successes.append(success)
        return Written(frozenset.intersection(*successes), before)

    def parallel(self, node: CompositeNode, before: frozenset[str]) -> Written:
        """No child can count on another."""
        successes = [self.after(child, before).success for child in node.children]
        everyone = node.options.get("policy", "all") in ("all", len(node.children))
        together = frozenset.union if everyone else frozenset.intersection
        return Written(together(*successes), before)

    def _leaf(self, node: LeafNode, before: frozenset[str]) -> Written:
        for value in node.arguments.values():
            self._read(value, before)
        for name, write in node.outputs.items():
            if node.type is SET:
                written = self._type_of(node.arguments[name])
            else:
                written = node.type.outputs[name].type
            self._write(write, written)
        names = frozenset(write.name for write in node.outputs.values())
        return Written(before | names, before)

    def _subtree(self, node: SubtreeNode, before: frozenset[str]) -> Written:
        for value in node.arguments.values():
            self._read(value, before)
        for name, write in node.outputs.items():
            self._write(write, node.task.outputs[name].type)
        names = frozenset(write.name for write in node.outputs.values())
        return Written(before | names, before)

    def _type_of(self, value: Given) -> ValueType | None:
        if isinstance(value, KeyRead):
            return self.types.get(value.name)
        return type_of(value)

    def _write(self, write: KeyWrite, written: ValueType | None) -> None:
        first = self.writes.setdefault(write.name, write.place)
        if written is None:
            return
        known = self.types.setdefault(write.name, written)
        if known != written:
            what = f"`{write.name}` takes {written} here, and {known} on line {first.line}"
            self.diagnostics.error(write.place, what, "write it under another name")

    def _read(self, value: Given, before: frozenset[str]) -> None:
        if not isinstance(value, KeyRead):
            return
        name = value.name
        self.read.add(name)
        if name not in self.types:
            if name in self.writes:
                return
            what = f"`{value}` is neither a parameter nor a key that is written before"
            hint = suggest(name, {*self.parameters, *self.types})
            self.diagnostics.error(value.place, what, hint)
        elif name not in before:
            what = f"`{value}` is not written on every way here"
            line = self.writes[name].line
            hint = f"let line {line} succeed before, or begin with `set: {{{name}: ...}}`"
            self.diagnostics.error(value.place, what, hint)
        elif not value.type.takes(self.types[name]):
            what = f"expected {value.type}, got `{value}`, which is {self.types[name]}"
            self.diagnostics.error(value.place, what, f"give {value.type}")


def _forever(flow: _Flow, node: CompositeNode, before: frozenset[str]) -> Written:
    return Written(flow.after(node.children[0], before).success, before)


def _until(flow: _Flow, node: CompositeNode, before: frozenset[str]) -> Written:
    question, *work = node.children
    asked = flow.after(question, before)
    worked = flow.sequence(replace(node, children=tuple(work)), asked.failure)
    return Written(asked.success, worked.failure)


_COMPOSITES: Mapping[str, Callable[[_Flow, CompositeNode, frozenset[str]], Written]] = {
    "sequence": _Flow.sequence,
    "reactive_sequence": _Flow.sequence,
    "fallback": _Flow.fallback,
    "reactive_fallback": _Flow.fallback,
    "parallel": _Flow.parallel,
    "forever": _forever,
    "until": _until,
}


def _failing_early(written: Written, before: frozenset[str]) -> Written:
    return Written(written.success, before)


def _succeeding_early(written: Written, before: frozenset[str]) -> Written:
    return Written(before, written.failure)


def _either(written: Written, before: frozenset[str]) -> Written:
    both = written.success & written.failure
    return Written(both, both)


_MODIFIERS: Mapping[str, Callable[[Written, frozenset[str]], Written]] = {
    "timeout_s": _failing_early,
    "invert": lambda written, before: Written(written.failure, written.success),
    "cooldown_s": _failing_early,
    "while": _failing_early,
    "unless": _succeeding_early,
    "force_success": _either,
    "force_failure": _either,
}
"""What a modifier changes; the others change nothing."""
