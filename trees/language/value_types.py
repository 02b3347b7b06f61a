"""The kinds of values that a task file can give.

A type is read from an annotation: numbers, text, truth values, `Literal` choices, the named things
of `behaviours.named`, `None`, and unions of those.
"""

from __future__ import annotations

import types
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias, Union, get_args, get_origin

from behaviours.named import BasePose, Posture, Region, ToolPose

Plain: TypeAlias = bool | int | float | str | None
"""What YAML itself can say."""

Named: TypeAlias = ToolPose | BasePose | Posture | Region
"""What the sections `poses` and `regions` define."""

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


@dataclass(frozen=True, kw_only=True)
class ValueType:
    """A union of kinds of values, numbers within bounds; its text says what is expected."""

    kinds: tuple[type, ...]
    choices: tuple[Plain, ...] = ()
    above: float | None = None
    """Numbers must be greater than this."""
    least: float | None = None
    most: float | None = None

    def __str__(self) -> str:
        kinds = [_PLAIN_KINDS.get(kind) or f"a {NAMED_KINDS[kind]}" for kind in self.kinds]
        choices = [f"`{written(choice)}`" for choice in self.choices]
        ends = (("at least", self.least), ("at most", self.most))
        said = " and ".join(f"{words} {bound:g}" for words, bound in ends if bound is not None)
        above = "" if self.above is None else f" greater than {self.above:g}"
        return " or ".join([*choices, *kinds]) + above + (f" of {said}" if said else "")

    @property
    def named_kinds(self) -> tuple[type, ...]:
        """Those of its kinds that are given by name."""
        return tuple(kind for kind in self.kinds if kind in NAMED_KINDS)

    @property
    def is_bounded(self) -> bool:
        """Whether not every number of its kind will do."""
        return (self.above, self.least, self.most) != (None, None, None)

    def within(self, number: float) -> bool:
        """Whether a number is inside the bounds."""
        return (
            (self.above is None or number > self.above)
            and (self.least is None or number >= self.least)
            and (self.most is None or number <= self.most)
        )

    def takes(self, other: ValueType) -> bool:
        """Whether the values of another type are of this type too, bounds aside."""
        kinds = {*self.kinds, *((int,) if float in self.kinds else ())}
        choices = (choice in self.choices or type(choice) in kinds for choice in other.choices)
        return set(other.kinds) <= kinds and all(choices)


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


def type_of(value: Plain | Named) -> ValueType:
    """The type of a value."""
    return ValueType(kinds=(type(value),))


PARAMETER_TYPES: Mapping[str, ValueType] = {
    "bool": ValueType(kinds=(bool,)),
    "int": ValueType(kinds=(int,)),
    "float": ValueType(kinds=(float,)),
    "text": ValueType(kinds=(str,)),
    "pose": ValueType(kinds=(ToolPose, BasePose)),
    "tool_pose": ValueType(kinds=(ToolPose,)),
    "base_pose": ValueType(kinds=(BasePose,)),
    "posture": ValueType(kinds=(Posture,)),
    "region": ValueType(kinds=(Region,)),
}
"""What may stand after `type:` in the section `params`; a list of choices may too."""


def written(value: Plain) -> str:
    """A value as YAML writes it."""
    special = {None: "null", True: "true", False: "false"}
    if value is None or isinstance(value, bool):
        return special[value]
    return f"{value:g}" if isinstance(value, float) else str(value)
