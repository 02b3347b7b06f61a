"""Hints for numbers in the wrong unit: millimetres for metres, radians for degrees."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import degrees, inf, pi

_SMALLER_UNITS: Mapping[str, tuple[tuple[str, float], ...]] = {
    "m": (("millimetres", 1e-3), ("centimetres", 1e-2)),
    "m/s": (("millimetres per second", 1e-3), ("centimetres per second", 1e-2)),
    "s": (("milliseconds", 1e-3),),
    "cm²": (("square millimetres", 1e-2),),
}
"""In which a number may have been given instead, and what to multiply it by."""

_ROUND = pi / 12.0  # angles in radians are multiples of this ...
_CLOSE = 0.005  # ... rounded to about two digits [rad]


def meant(number: float, unit: str, fits: Callable[[float], bool]) -> str:
    """The hint for a number that is out of bounds; empty if no other unit explains it.

    Args:
        number: as it was given.
        unit: in which it was expected.
        fits: whether a number is within the bounds.
    """
    if unit == "mm" and 0.0 < number < 1.0 and fits(1000.0 * number):
        return f"did you mean {1000.0 * number:g} (from metres)?"
    if unit == "%" and 0.0 < number < 1.0 and fits(100.0 * number):
        return f"did you mean {100.0 * number:g} (from a share)?"
    if not 10.0 <= abs(number) < inf:
        return ""
    fitting = [
        f"{number * factor:g} (from {name})"
        for name, factor in _SMALLER_UNITS.get(unit, ())
        if fits(number * factor)
    ]
    # From a hundred on the smallest unit is far more likely.
    likely = fitting[:1] if abs(number) >= 100.0 else fitting
    return f"did you mean {' or '.join(likely)}?" if likely else ""


def radians_for_degrees(number: float) -> str:
    """Message and hint, `; ` between them, about degrees that look like radians; else empty.

    They do if they are no whole number, and a round angle in radians.
    """
    if number == round(number, 1) or abs(number) > 2.0 * pi + _CLOSE:
        return ""
    steps = round(number / _ROUND)
    if steps == 0 or abs(number - steps * _ROUND) > _CLOSE:
        return ""
    angle = degrees(steps * _ROUND)
    return f"{number:g}° looks like radians; did you mean {angle:g}? Else write {number:.1f}"
