"""Types of values in a task file.

A type is read from an annotation: numbers, text, truth values, `Literal` choices, poses, postures,
regions, `None`, and unions of those. Numbers may have `Bounds`.
"""

from __future__ import annotations

import types
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Annotated, Literal, TypeAlias, Union, get_args, get_origin

from behaviours import BasePose, Bounds, DetectedObject, DetectedObjects, Posture, Region, ToolPose
from config import Plain, written

NamedValue: TypeAlias = ToolPose | BasePose | Posture | Region
"""What the sections `poses` and `regions` define."""

NAMED_TYPES: Mapping[type, str] = {
    ToolPose: "tool pose",
    BasePose: "base pose",
    Posture: "posture",
    Region: "region",
}
SEEN_TYPES: Mapping[type, str] = {
    DetectedObject: "a detected object",
    DetectedObjects: "a list of detected objects",
}
"""Those whose values only leaves can make: a task file has them by their keys."""
_PLAIN_TYPES: Mapping[type, str] = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "text",
    types.NoneType: "null",
}
_TYPES = (*_PLAIN_TYPES, *NAMED_TYPES, *SEEN_TYPES)


@dataclass(frozen=True, kw_only=True)
class ValueType:
    """A union of types, numbers within bounds; its text says what is expected."""

    types: tuple[type, ...]
    choices: tuple[Plain, ...] = ()
    above: float | None = None  # numbers must be greater than this
    least: float | None = None
    most: float | None = None

    def __str__(self) -> str:
        names = [
            (_PLAIN_TYPES.get(one) or SEEN_TYPES.get(one) or f"a {NAMED_TYPES[one]}")
            + (self._bounds if one in (int, float) else "")
            for one in self.types
        ]
        return " or ".join([*(f"`{written(choice)}`" for choice in self.choices), *names])

    @property
    def _bounds(self) -> str:
        """Of its numbers, as the end of what is expected."""
        ends = (("at least", self.least), ("at most", self.most))
        bounds = " and ".join(f"{words} {bound:g}" for words, bound in ends if bound is not None)
        if self.above is None:
            return f" of {bounds}" if bounds else ""
        return f" greater than {self.above:g}" + (f" and {bounds}" if bounds else "")

    @property
    def named_types(self) -> tuple[type, ...]:
        """Those of its types that are given by name."""
        return tuple(one for one in self.types if one in NAMED_TYPES)

    @property
    def is_number(self) -> bool:
        """Whether numbers are among its values."""
        return not {int, float}.isdisjoint(self.types)

    @property
    def is_bounded(self) -> bool:
        """Whether it leaves out some numbers."""
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
        mine = {*self.types, *((int,) if float in self.types else ())}
        choices = (choice in self.choices or type(choice) in mine for choice in other.choices)
        return set(other.types) <= mine and all(choices)


def read_annotation(annotation: object) -> ValueType:
    """The type that an annotation stands for.

    Raises TypeError: a task file cannot give such a value.
    """
    found: list[type] = []
    choices: list[Plain] = []
    bounds = Bounds()
    is_union = get_origin(annotation) in (Union, types.UnionType)
    for part in get_args(annotation) if is_union else (annotation,):
        if get_origin(part) is Annotated:
            part, *notes = get_args(part)
            bounds = next((note for note in notes if isinstance(note, Bounds)), bounds)
        member = types.NoneType if part is None else part
        if get_origin(part) is Literal:
            choices.extend(get_args(part))
        elif isinstance(member, type) and member in _TYPES:
            found.append(member)
        else:
            raise TypeError(f"a task file cannot give a value of type {annotation!r}")
    return ValueType(types=tuple(found), choices=tuple(choices), **asdict(bounds))


def type_of(value: Plain | NamedValue) -> ValueType:
    """The type of a value."""
    return ValueType(types=(type(value),))


PARAMETER_TYPES: Mapping[str, ValueType] = {
    "bool": ValueType(types=(bool,)),
    "int": ValueType(types=(int,)),
    "float": ValueType(types=(float,)),
    "text": ValueType(types=(str,)),
    "pose": ValueType(types=(ToolPose, BasePose)),
    "tool_pose": ValueType(types=(ToolPose,)),
    "base_pose": ValueType(types=(BasePose,)),
    "posture": ValueType(types=(Posture,)),
    "region": ValueType(types=(Region,)),
    "object": ValueType(types=(DetectedObject,)),
}
"""What may stand after `type:` in the section `params`; a list of choices may too."""

SEEN_ONE = ValueType(types=(DetectedObject,))
SEEN_LIST = ValueType(types=(DetectedObjects,))
