"""What a task file may give as the value of a parameter, and how it becomes a Python value.

A type is read from an annotation: numbers, text, truth values, `Literal` choices, the named things
of `behaviours.names`, `None`, and unions of those.
"""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias, Union, get_args, get_origin

from behaviours.names import BasePose, Posture, Region, ToolPose
from trees.language.mistakes import quoted, suggestion
from trees.language.source import Items, Plain, Scalar, Value

Named: TypeAlias = ToolPose | BasePose | Posture | Region

NAMED_KINDS: Mapping[type, str] = {
    ToolPose: "tool pose",
    BasePose: "base pose",
    Posture: "posture",
    Region: "region",
}
_PLAIN_KINDS: Mapping[type, str] = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "text",
    types.NoneType: "null",
}


class MismatchError(Exception):
    """A value is not of the type expected.

    Args:
        what: what is wrong.
        mend: how to mend it.
    """

    def __init__(self, what: str, mend: str) -> None:
        self.what, self.mend = what, mend
        super().__init__(f"{what}; {mend}")


@dataclass(frozen=True, kw_only=True)
class ValueType:
    """A union of kinds of values; its text says what is expected."""

    kinds: tuple[type, ...]
    choices: tuple[Plain, ...] = ()

    def __str__(self) -> str:
        kinds = [_PLAIN_KINDS.get(kind) or f"a {NAMED_KINDS[kind]}" for kind in self.kinds]
        choices = [f"`{_written(choice)}`" for choice in self.choices]
        return " or ".join([*choices, *kinds])

    @property
    def named_kinds(self) -> tuple[type, ...]:
        """Those of its kinds that are given by name."""
        return tuple(kind for kind in self.kinds if kind in NAMED_KINDS)


def read_annotation(annotation: object) -> ValueType:
    """The type that an annotation stands for.

    Raises:
        TypeError: a task file cannot give such a value.
    """
    kinds: list[type] = []
    choices: list[Plain] = []
    is_union = get_origin(annotation) in (Union, types.UnionType)
    for part in get_args(annotation) if is_union else (annotation,):
        kind = types.NoneType if part is None else part
        if get_origin(part) is Literal:
            choices.extend(get_args(part))
        elif isinstance(kind, type) and (kind in _PLAIN_KINDS or kind in NAMED_KINDS):
            kinds.append(kind)
        else:
            raise TypeError(f"a task file cannot give a value of type {annotation!r}")
    return ValueType(kinds=tuple(kinds), choices=tuple(choices))


def type_of(value: Plain) -> ValueType:
    """The type of a plain value."""
    return ValueType(kinds=(type(value),))


def convert(value: Value, expected: ValueType, named: Mapping[str, Named]) -> Plain | Named:
    """A located value as the Python value that is expected.

    Args:
        value: from the file.
        expected: its type.
        named: the poses, postures and regions that a name may stand for.

    Raises:
        MismatchError: it is something else.
    """
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
    if float in expected.kinds and isinstance(given, int | float) and not isinstance(given, bool):
        if math.isfinite(given):
            return given if type(given) in expected.kinds else float(given)
        raise MismatchError(f"expected {expected}, got {describe(value)}", "write a finite number")
    if type(given) in expected.kinds:
        return given
    raise MismatchError(f"expected {expected}, got {describe(value)}", f"write {expected}")


def describe(value: Value) -> str:
    """What a value is, for a person who expected something else."""
    if isinstance(value, Items):
        return "a list"
    if not isinstance(value, Scalar):
        return "a mapping"
    kind = {str: "the text ", int: "the number ", float: "the number "}.get(type(value.value), "")
    origin = f", the value of `${value.parameter}`" if value.parameter else ""
    return f"{kind}`{_written(value.value)}`{origin}"


def _written(value: Plain) -> str:
    """A value as YAML writes it."""
    special = {None: "null", True: "true", False: "false"}
    if value is None or isinstance(value, bool):
        return special[value]
    return f"{value:g}" if isinstance(value, float) else str(value)


def _no_such_name(
    value: Scalar, name: str, expected: ValueType, named: Mapping[str, Named]
) -> MismatchError:
    fitting = [word for word, thing in named.items() if isinstance(thing, expected.named_kinds)]
    kinds = " or ".join(NAMED_KINDS[kind] for kind in expected.named_kinds)
    known = f"known: {quoted(sorted(fitting))}" if fitting else "the file defines none yet"
    if name in named:
        what = f"`{name}` is a {NAMED_KINDS[type(named[name])]}, expected {expected}"
        return MismatchError(what, known)
    near = suggestion(name, fitting)
    mend = f"{near} ({known})" if near.startswith("did you mean") else known
    origin = f", the value of `${value.parameter}`" if value.parameter else ""
    return MismatchError(f"no {kinds} is called `{name}`{origin}", mend)
