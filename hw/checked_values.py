"""The door for what comes from outside: each value is checked once, and what is wrong is named.

A check returns the value, or raises `RefusedError` with the field, its value and why; who takes
messages or readings skips those that are refused, and tells of them.
"""

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np

from config.arrays import Array
from hw.robot import HardwareError

_MOST = 1e6  # no length, angle or speed of a robot is larger [m, rad, m/s, rad/s]
_ROUNDING = 1e-6  # of covariances, relative to their largest element
_SHOWN = 40  # longest value that is shown [characters]


class RefusedError(HardwareError):
    """A message or reading that cannot be used."""

    def __init__(self, field: str, value: object, why: str) -> None:
        shown = str(value)
        self.field, self.why = field, why
        self.value = shown if len(shown) <= _SHOWN else f"{shown[:_SHOWN]}..."
        super().__init__(f"{field} = {self.value}: {why}")


def number(value: Any, field: str, least: float = -_MOST, most: float = _MOST) -> float:
    """A finite number within bounds."""
    if not isfinite(value):
        raise RefusedError(field, value, "no finite number")
    if not least <= value <= most:
        raise RefusedError(field, f"{value:g}", f"not between {least:g} and {most:g}")
    return float(value)


def numbers(values: Any, names: Sequence[str], field: str, most: float = _MOST) -> Array:
    """(n,) finite numbers, one for each name."""
    found: Array = np.array(values, dtype=np.float64)
    if found.shape != (len(names),):
        raise RefusedError(field, f"{found.size} values", f"not {len(names)}")
    if not np.abs(found).max() <= most:  # NaN is not
        for name, value in zip(names, found.tolist(), strict=True):
            number(value, f"{field}[{name}]", -most, most)
    return found


def covariance(matrix: Any, field: str) -> Array:
    """A covariance (3, 3): finite, symmetric, positive semidefinite; zero is exact."""
    found: Array = np.array(matrix, dtype=np.float64)
    if found.shape != (3, 3):
        raise RefusedError(field, f"an array {found.shape}", "not (3, 3)")
    for row, column in np.ndindex(found.shape):
        number(found[row, column], f"{field}[{row}, {column}]", -(_MOST**2), _MOST**2)
    largest = float(np.abs(found).max())
    if np.abs(found - found.T).max() > _ROUNDING * largest:
        raise RefusedError(field, found.tolist(), "not symmetric")
    if (least := float(np.linalg.eigvalsh(found)[0])) < -_ROUNDING * largest:
        raise RefusedError(field, f"{least:g} as an eigenvalue", "a variance cannot be negative")
    return found
