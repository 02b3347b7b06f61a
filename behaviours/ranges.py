"""Numbers within bounds, for the parameters of leaves: a task file that gives others is refused."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, TypeAlias


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """What a number annotated with it may be, as in `Annotated[float, Bounds(least=0.0)]`."""

    above: float | None = None
    """It is greater than this."""
    least: float | None = None
    """It is not less than this."""
    most: float | None = None
    """It is not more than this."""


Positive: TypeAlias = Annotated[float, Bounds(above=0.0)]
NotNegative: TypeAlias = Annotated[float, Bounds(least=0.0)]
Percent: TypeAlias = Annotated[float, Bounds(least=0.0, most=100.0)]
Count: TypeAlias = Annotated[int, Bounds(least=1)]
