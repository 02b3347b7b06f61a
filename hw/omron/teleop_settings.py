"""Decoding of the section "Teleop settings" of the base (5MTX), as on a reference server."""

from collections.abc import Iterator
from dataclasses import replace
from math import radians

from hw.omron.packet import Fields, LayoutError
from hw.omron.site import Site

SECTIONS = "getConfigBySectionsV4"  # its argument: priority of parameters, 9 for all
TELEOP = "Teleop settings"  # the section with the full-scale values of `ratioDrive`
TIMEOUT = "Timeout"  # without a `ratioDrive` for so long the base stops [s]; 0: never
Values = dict[str, float | str]

_SPEEDS = {"FullThrottleForwards": "forward", "FullThrottleBackwards": "reverse"}
_TURNS = {
    "RotAtStopped": "turn",
    "RotAtFullForwards": "turn_at_forward",
    "RotAtFullBackwards": "turn_at_reverse",
}
_ZONES = {"TransDeadZone": "dead_translation", "RotDeadZone": "dead_rotation"}


def read_section(fields: Fields) -> tuple[str, Values]:
    """Name and values of a section."""
    if fields.raw(1) != b"S":
        raise LayoutError("no section of a configuration")
    name = fields.text()
    fields.text()  # comment
    fields.text()  # category
    fields.integer("H")
    return name, dict(_parameters(fields, count=None))


def site_of(values: Values, default: Site) -> Site:
    """The site of the section `TELEOP`; values that are missing or 0 are those of the default."""
    numbers = {name: one for name, one in values.items() if isinstance(one, float)}
    given = {field: numbers[name] for name, field in _ZONES.items() if name in numbers}
    given |= {field: numbers[name] / 1000.0 for name, field in _SPEEDS.items() if numbers.get(name)}
    given |= {field: radians(numbers[name]) for name, field in _TURNS.items() if numbers.get(name)}
    return replace(default, **given)


def _parameters(fields: Fields, count: int | None) -> Iterator[tuple[str, float | str]]:
    """`count` parameters, or all to the end; those of lists are named LIST/NAME."""
    while fields.remaining if count is None else count:
        if fields.raw(1) != b"P":
            raise LayoutError("no parameter of a configuration")
        name = fields.text()
        fields.text()  # description
        fields.integer("b")  # priority
        match fields.raw(1):
            case b"b":
                yield name, float(fields.integer("b"))
            case b"i":
                yield name, float(fields.integers("iii")[0])
            case b"d":
                yield name, fields.number()
                fields.number()
                fields.number()
                fields.integer("i")
            case b"s":
                yield name, fields.text()
            case b"l":
                inner = _parameters(fields, fields.integer("i"))
                yield from ((f"{name}/{key}", value) for key, value in inner)
            case b".":
                pass
            case kind:
                raise LayoutError(f"a parameter of type {kind!r}")
        fields.text()  # display hint
        fields.text()  # extra
        fields.integers("bB")  # restart level, whether it is written to files
        fields.text()  # path of its parent
        count = None if count is None else count - 1
