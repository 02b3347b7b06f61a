"""The configuration that the base keeps, as packets tell it (5MTX): verified on a reference server.

A section a packet: its name, then parameters, each with a type, a value and words for people. An
empty packet ends it. On 6MTX bases this request is said to be gone.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import radians

from hw.omron.fields import Fields, LayoutError
from hw.omron.site import Site

SECTIONS = "getConfigBySectionsV4"
"""The request; its argument is the priority up to which parameters are told, 9 for all."""
TELEOP = "Teleop settings"
"""The section that says what `ratioDrive` means."""

TIMEOUT = "Timeout"
"""In that section: without a `ratioDrive` for this long the base stops by itself [s]; 0: never."""

Values = dict[str, float | str]


def read_section(fields: Fields) -> tuple[str, Values]:
    """Name and values of a section.

    Raises:
        LayoutError: it is none.
    """
    if fields.raw(1) != b"S":
        raise LayoutError("no section of a configuration")
    name = fields.text()
    fields.text()  # comment
    fields.text()  # category
    fields.integer("H")
    return name, dict(_parameters(fields, count=None))


def site_of(values: Values, told: Site) -> Site:
    """The site that a base keeps in its section `TELEOP` (mm/s and deg/s; units inferred).

    A value of 0 stands for one that depends on others, and one that is missing is not known: both
    are taken from what a person has told.
    """

    def speed(name: str, otherwise: float) -> float:
        value = values.get(name)
        return value / 1000.0 if isinstance(value, float) and value else otherwise

    def turn(name: str) -> float | None:
        value = values.get(name)
        return radians(value) if isinstance(value, float) and value else None

    def share(name: str, otherwise: float) -> float:
        value = values.get(name)
        return value if isinstance(value, float) else otherwise

    return Site(
        forward=speed("FullThrottleForwards", told.forward),
        reverse=speed("FullThrottleBackwards", told.reverse),
        turn=turn("RotAtStopped") or told.turn,
        turn_at_forward=turn("RotAtFullForwards") or told.turn_at_forward,
        turn_at_reverse=turn("RotAtFullBackwards") or told.turn_at_reverse,
        dead_translation=share("TransDeadZone", told.dead_translation),
        dead_rotation=share("RotDeadZone", told.dead_rotation),
        throttle=told.throttle,
    )


def _parameters(fields: Fields, count: int | None) -> Iterator[tuple[str, float | str]]:
    """As many parameters as told, or all to the end; those of lists have its name before theirs."""
    while fields.left if count is None else count:
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
