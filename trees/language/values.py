"""Conversion of values of a task file to the Python values that parameters expect, and hints."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from config import (
    Hint,
    Location,
    Plain,
    Rule,
    YamlScalar,
    YamlValue,
    describe,
    nearest,
    quoted,
    written,
)
from trees.language import rules
from trees.words import NAMED_TYPES, SEEN_TYPES, NamedValue, ValueType


@dataclass(frozen=True, kw_only=True)
class Reference:
    """A `$name` in the tree: a parameter, or a key."""

    location: Location
    name: str
    value: Plain | NamedValue = None  # None if it is known only while the task runs

    @property
    def origin(self) -> str:
        """The end of a message that quotes the value."""
        return f", the value of `${self.name}`"


@dataclass(frozen=True, kw_only=True)
class KeyRead:
    """A `$name` whose value is known only while the task runs."""

    location: Location
    name: str
    type: ValueType  # what is expected of it

    def __str__(self) -> str:
        return f"${self.name}"

    def fitted(self, value: object) -> object:
        """The value as the reader expects it: a whole number may stand for any number."""
        whole = type(value) is int and int not in self.type.types
        return float(value) if whole and isinstance(value, int) else value

    def check(self, name: str, value: object) -> None:
        """Check the bounds of a value that has become known.

        Raises ValueError: it is out of bounds; `name` is that of the parameter.
        """
        if isinstance(value, bool) or not isinstance(value, int | float):
            return
        if not self.type.within(value):
            raise ValueError(f"`{name}`: expected {self.type}, got {value} from `{self}`")


@dataclass(frozen=True, kw_only=True)
class KeyWrite:
    """The key that an output is written to."""

    location: Location
    name: str


Argument: TypeAlias = Plain | NamedValue | KeyRead  # what a parameter may be given


class MismatchError(Exception):
    """A value is not of the type expected."""

    def __init__(self, message: str, hint: str, rule: Rule = rules.VALUE) -> None:
        self.message, self.hint, self.rule = message, hint, rule
        super().__init__(f"{message}; {hint}")


def convert(
    value: YamlValue | Reference, expected: ValueType, named: Mapping[str, NamedValue]
) -> Argument:
    """A located value as the Python value that is expected.

    `named` are the poses, postures and regions that a name may stand for. Raises MismatchError: it
    is something else.
    """
    if isinstance(value, Reference):
        given = value.value
        if given is None:
            return KeyRead(location=value.location, name=value.name, type=expected)
        if isinstance(given, NamedValue):
            if isinstance(given, expected.named_types):
                return given
            raise _mismatch(expected, value)
    elif isinstance(value, YamlScalar):
        given = value.value
    else:
        hint = "write a single value"
        if expected.named_types:
            hint = "define it below `poses` or `regions`, and write its name here"
        raise MismatchError(f"expected {expected}, got {describe(value)}", hint)
    for choice in expected.choices:
        if given == choice and type(given) is type(choice):
            return choice
    if isinstance(given, str) and expected.named_types:
        found = named.get(given)
        if isinstance(found, expected.named_types):
            return found
        if str not in expected.types:
            raise _no_such_name(given, value, expected, named)
    if isinstance(given, int | float) and not isinstance(given, bool):
        return _number(value, given, expected)
    if type(given) in expected.types:
        return given
    raise _mismatch(expected, value)


def _number(value: YamlScalar | Reference, number: float, expected: ValueType) -> float:
    """An int or a float, as the type wants it."""
    is_type = type(number) in expected.types
    if not is_type and float not in expected.types:
        raise _mismatch(expected, value)
    if not math.isfinite(number):
        raise _mismatch(expected, value, "write a finite number")
    if not expected.within(number):
        raise _mismatch(expected, value)
    return number if is_type else float(number)


def _mismatch(
    expected: ValueType, value: YamlScalar | Reference, hint: str | None = None
) -> MismatchError:
    message = f"expected {expected}, got {described(value)}"
    if isinstance(text := value.value, str):
        hint = nearest(text, map(written, expected.choices)) or hint
        hint = hint or (expected.is_number and number_in(text, "", expected.within)) or None
    if hint is None and not SEEN_TYPES.keys().isdisjoint(expected.types):
        hint = "give `$` and the key of a `detect`, or the item of a `for_each` over it"
    return MismatchError(message, hint or f"write {expected}")


def described(value: YamlValue | Reference) -> str:
    """What a value is, for a person who should have written something else."""
    if not isinstance(value, Reference):
        return describe(value)
    if value.value is None:
        return f"`${value.name}`"
    if isinstance(value.value, NamedValue):
        return f"the {NAMED_TYPES[type(value.value)]} `{value.value.name}`{value.origin}"
    return describe(YamlScalar(location=value.location, value=value.value)) + value.origin


def _no_such_name(
    name: str, value: YamlValue | Reference, expected: ValueType, named: Mapping[str, NamedValue]
) -> MismatchError:
    fitting = [word for word, one in named.items() if isinstance(one, expected.named_types)]
    known = f"known: {quoted(sorted(fitting))}" if fitting else "the file defines none yet"
    if name in named:
        message = f"`{name}` is a {NAMED_TYPES[type(named[name])]}, expected {expected}"
        return MismatchError(message, known, rules.PLACE)
    types = " or ".join(NAMED_TYPES[one] for one in expected.named_types)
    origin = value.origin if isinstance(value, Reference) else ""
    near = nearest(name, fitting)
    hint = Hint(f"{near} ({known})", name, near.meant) if near else known
    return MismatchError(f"no {types} is called `{name}`{origin}", hint, rules.PLACE)


OTHER_UNITS: Mapping[str, tuple[tuple[str, float], ...]] = {
    "m": (("millimetres", 1e-3), ("centimetres", 1e-2)),
    "m/s": (("millimetres per second", 1e-3), ("centimetres per second", 1e-2)),
    "s": (("milliseconds", 1e-3),),
    "cm²": (("square millimetres", 1e-2),),
    "mm": (("metres", 1e3),),
    "%": (("a share", 1e2),),
}
"""In which a number may have been given instead, and what to multiply it by."""


def number_in(text: str, unit: str, fits: Callable[[float], bool]) -> Hint:
    """The hint for a number that was written as a text, perhaps with its unit; else empty."""
    units = "°|deg" if unit == "°" else re.escape(unit)
    number = re.fullmatch(rf"(-?\d+(?:[.,]\d+)?) ?(?:{units})?", text)
    plain = number[1].replace(",", ".") if number else ""
    if not plain or not fits(float(plain)):
        return Hint("")
    return Hint(f"did you mean {plain}?", text, plain)


_ROUND = math.pi / 12.0  # angles in radians are multiples of this ...
_CLOSE = 0.005  # ... rounded to about two digits [rad]


def meant(number: float, unit: str, fits: Callable[[float], bool]) -> Hint:
    """The hint for a number that is out of bounds; empty if no other unit explains it.

    `fits` tells whether a number is within the bounds.
    """
    likely = [
        (f"{number * factor:g}", name)
        for name, factor in OTHER_UNITS.get(unit, ())
        if (0.0 < number < 1.0 if factor > 1.0 else 10.0 <= abs(number) < math.inf)
        and fits(number * factor)
    ]
    # From a hundred on the smallest unit is far more likely.
    likely = likely[:1] if abs(number) >= 100.0 else likely
    ways = " or ".join(f"{other} (from {name})" for other, name in likely)
    other = likely[0][0] if len(likely) == 1 else ""
    return Hint(f"did you mean {ways}?" if likely else "", written(number), other)


def radians_for_degrees(number: float) -> Hint:
    """Message and hint, `; ` between them, about degrees that look like radians; else empty.

    They do if they are no whole number, and a round angle in radians.
    """
    if number == round(number, 1) or abs(number) > 2.0 * math.pi + _CLOSE:
        return Hint("")
    steps = round(number / _ROUND)
    if steps == 0 or abs(number - steps * _ROUND) > _CLOSE:
        return Hint("")
    angle = f"{math.degrees(steps * _ROUND):g}"
    text = f"{number:g}° looks like radians; did you mean {angle}? Else write {number:.1f}"
    return Hint(text, written(number), angle)
