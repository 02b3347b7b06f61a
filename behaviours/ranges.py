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
Count: TypeAlias = Annotated[int, Bounds(least=1, most=1000)]
Seconds: TypeAlias = Annotated[float, Bounds(above=0.0, most=86_400.0)]
"""A time to wait for something: at most a day [s]."""
Pause: TypeAlias = Annotated[float, Bounds(least=0.0, most=86_400.0)]
"""A time that may be none [s]."""
Distance: TypeAlias = Annotated[float, Bounds(above=0.0, most=2.0)]
"""Within reach of the arm [m]."""
Lift: TypeAlias = Annotated[float, Bounds(least=0.0, most=1.0)]
"""How far the hand goes up; may be none [m]."""
Speed: TypeAlias = Annotated[float, Bounds(least=0.01, most=2.0)]
"""Of the hand or the base [m/s]."""
Way: TypeAlias = Annotated[float, Bounds(least=-20.0, most=20.0)]
"""Of the base, forwards or backwards [m]."""
Turn: TypeAlias = Annotated[float, Bounds(least=-360.0, most=360.0)]
"""To the left or the right [deg]."""
Deviation: TypeAlias = Annotated[float, Bounds(least=0.0, most=180.0)]
"""How far something is turned away; may be none [deg]."""
Force: TypeAlias = Annotated[float, Bounds(least=1.0, most=140.0)]
"""Of the fingers; as much as a hand can press [N]."""
Area: TypeAlias = Annotated[float, Bounds(least=0.0, most=10_000.0)]
"""Of something that stands on a table [cm^2]."""
Millimetres: TypeAlias = Annotated[float, Bounds(least=1.0, most=500.0)]
"""Of something that stands on a table [mm]."""
Pitch: TypeAlias = Annotated[float, Bounds(least=0.02, most=2.0)]
"""Between things that stand side by side [m]."""
