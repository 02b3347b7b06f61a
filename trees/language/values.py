"""From a value of a task file to the Python value that a parameter expects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from config import quoted, suggest
from trees.language.diagnostics import Location
from trees.language.source import Items, Reference, Scalar, Value
from trees.language.value_types import NAMED_KINDS, Named, Plain, ValueType, written


@dataclass(frozen=True, kw_only=True)
class KeyRead:
    """A `$name` whose value is known only while the task runs."""

    place: Location
    name: str
    type: ValueType
    """What is expected of it."""

    def __str__(self) -> str:
        return f"${self.name}"

    def fitted(self, value: object) -> object:
        """The value as the reader expects it: a whole number may stand for any number."""
        whole = type(value) is int and int not in self.type.kinds
        return float(value) if whole and isinstance(value, int) else value


@dataclass(frozen=True, kw_only=True)
class KeyWrite:
    """The key that an output is written to."""

    place: Location
    name: str


Given: TypeAlias = Plain | Named | KeyRead
"""What a parameter may be given."""


class MismatchError(Exception):
    """A value is not of the type expected.

    Args:
        what: what is wrong.
        hint: how to fix it.
    """

    def __init__(self, what: str, hint: str) -> None:
        self.what, self.hint = what, hint
        super().__init__(f"{what}; {hint}")


def convert(value: Value, expected: ValueType, named: Mapping[str, Named]) -> Given:
    """A located value as the Python value that is expected.

    Args:
        value: from the file.
        expected: its type.
        named: the poses, postures and regions that a name may stand for.

    Raises:
        MismatchError: it is something else.
    """
    if isinstance(value, Reference):
        return _referred(value, expected)
    if not isinstance(value, Scalar):
        raise MismatchError(f"expected {expected}, got {describe(value)}", "write a single value")
    given = value.value
    for choice in expected.choices:
        if given == choice and type(given) is type(choice):
            return choice
    if isinstance(given, str) and expected.named_kinds:
        found = named.get(given)
        if isinstance(found, expected.named_kinds):
            return found
        if str not in expected.kinds:
            raise _no_such_name(value, given, expected, named)
    if isinstance(given, int | float) and not isinstance(given, bool):
        return _number(value, given, expected)
    if type(given) in expected.kinds:
        return given
    raise MismatchError(f"expected {expected}, got {describe(value)}", f"write {expected}")


def _number(value: Scalar, number: float, expected: ValueType) -> float:
    """An int or a float, as the type wants it."""
    is_kind = type(number) in expected.kinds
    if not is_kind and float not in expected.kinds:
        raise MismatchError(f"expected {expected}, got {describe(value)}", f"write {expected}")
    if not math.isfinite(number):
        raise MismatchError(f"expected {expected}, got {describe(value)}", "write a finite number")
    if not expected.within(number):
        raise MismatchError(f"expected {expected}, got {describe(value)}", f"write {expected}")
    return number if is_kind else float(number)


def _referred(reference: Reference, expected: ValueType) -> Given:
    if reference.value is None:
        return KeyRead(place=reference.place, name=reference.name, type=expected)
    if isinstance(reference.value, expected.named_kinds):
        return reference.value
    raise MismatchError(f"expected {expected}, got {describe(reference)}", f"write {expected}")


def describe(value: Value) -> str:
    """What a value is, for a person who expected something else."""
    if isinstance(value, Items):
        return "a list"
    if isinstance(value, Reference):
        if value.value is None:
            return f"`${value.name}`"
        kind = NAMED_KINDS[type(value.value)]
        return f"the {kind} `{value.value.name}`, the value of `${value.name}`"
    if not isinstance(value, Scalar):
        return "a mapping"
    kind = {str: "the text ", int: "the number ", float: "the number "}.get(type(value.value), "")
    origin = f", the value of `${value.parameter}`" if value.parameter else ""
    return f"{kind}`{written(value.value)}`{origin}"


def _no_such_name(
    value: Scalar, name: str, expected: ValueType, named: Mapping[str, Named]
) -> MismatchError:
    fitting = [word for word, thing in named.items() if isinstance(thing, expected.named_kinds)]
    kinds = " or ".join(NAMED_KINDS[kind] for kind in expected.named_kinds)
    known = f"known: {quoted(sorted(fitting))}" if fitting else "the file defines none yet"
    if name in named:
        what = f"`{name}` is a {NAMED_KINDS[type(named[name])]}, expected {expected}"
        return MismatchError(what, known)
    near = suggest(name, fitting)
    hint = f"{near} ({known})" if near.startswith("did you mean") else known
    origin = f", the value of `${value.parameter}`" if value.parameter else ""
    return MismatchError(f"no {kinds} is called `{name}`{origin}", hint)
