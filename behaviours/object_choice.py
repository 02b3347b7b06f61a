"""Choice among detected objects, by criteria and order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from controller import Array
from perception import ColourName, DetectedObject

Choose: TypeAlias = Literal["best", "largest", "smallest", "nearest"]

_BESIDE = 0.03  # an object nearer to another one blocks a finger [m]
_SHARE = 0.25  # of the area of the most blocking neighbour, from which others block too

_ORDERS: Mapping[str, Callable[[DetectedObject, Array], float]] = {
    "largest": lambda one, base: -one.area,
    "smallest": lambda one, base: one.area,
    "nearest": lambda one, base: float(np.linalg.norm((one.position - base)[:2])),
}
"""Costs, of which the first object has the least; `base` is (3,), the base in the world."""


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Criteria of an object, and the order of those that meet them."""

    choose: Choose = "best"
    """`best` leaves it to the grasps."""
    kind: str | None = None
    """As a recogniser names it."""
    colour: ColourName | None = None
    narrowest: float = 0.0
    """Minimum of the shorter edge, seen from above [m]."""
    widest: float = np.inf
    """Maximum of it [m]."""

    @classmethod
    def of(
        cls,
        choose: Choose,
        kind: str | None,
        colour: ColourName | None,
        min_width_mm: float | None,
        max_width_mm: float | None,
    ) -> Choice:
        """From the parameters of a leaf."""
        return cls(
            choose=choose,
            kind=kind,
            colour=colour,
            narrowest=0.0 if min_width_mm is None else min_width_mm / 1000.0,
            widest=np.inf if max_width_mm is None else max_width_mm / 1000.0,
        )

    @property
    def is_free(self) -> bool:
        """Whether it takes any object, so that they need not be told apart."""
        return self == Choice()

    def fitting(self, objects: Sequence[DetectedObject], base: Array) -> list[DetectedObject]:
        """The objects that meet the criteria, in order.

        Args:
            objects: all that were detected.
            base: (3,) the robot's base in the world [m].
        """
        fitting = [
            one
            for one in objects
            if self.narrowest <= one.width <= self.widest
            and self.colour in (None, one.colour)
            and self.kind in (None, one.kind)
        ]
        order = _ORDERS.get(self.choose)
        return fitting if order is None else sorted(fitting, key=lambda one: order(one, base))

    def __str__(self) -> str:
        """For messages: `a red object of at least 30 mm`."""
        what = " ".join(word for word in (self.colour, self.kind or "object") if word)
        article = "an" if what[0] in "aeiou" else "a"
        least = f"at least {1000 * self.narrowest:g} mm" if self.narrowest else ""
        most = f"at most {1000 * self.widest:g} mm" if self.widest < np.inf else ""
        width = " and ".join(bound for bound in (least, most) if bound)
        return f"{article} {what}" + (f" of {width}" if width else "")


@dataclass(frozen=True, kw_only=True, eq=False)
class Chosen:
    """A workspace that has only the grasps on certain objects."""

    objects: tuple[DetectedObject, ...]
    """At least one."""

    @property
    def floor(self) -> float:
        """Height of the surface below them, in the world [m]."""
        return self.objects[0].floor

    def contains(self, points: Array) -> npt.NDArray[np.bool_]:
        """Which of (N, 3) points of the world [m] belong to one of them, or are right beside it."""
        inside: npt.NDArray[np.bool_] = np.any(
            [one.contains(points) for one in self.objects], axis=0
        )
        return inside

    def owns(self, centres: Array, contacts: Array) -> npt.NDArray[np.bool_]:
        """Which grasps are on one of them, and close on nothing else.

        Args:
            centres: (N, 3) in the world [m].
            contacts: (N, 2, 3) of both fingers, in the world [m].
        """
        owned = np.zeros(len(centres), dtype=np.bool_)
        for one in self.objects:
            on = one.contains(contacts.reshape(-1, 3)).reshape(-1, 2).all(axis=1)
            owned |= on & one.footprint.holds(centres[:, 0], centres[:, 1])
        return owned


def neighbours(one: DetectedObject, objects: Sequence[DetectedObject]) -> list[DetectedObject]:
    """Those that block fingers beside an object."""
    others = [it for it in objects if it is not one]
    areas = [it.footprint.area_near(one.footprint, _BESIDE) for it in others]
    most = max(areas, default=0.0)
    return [
        it for area, it in zip(areas, others, strict=True) if area > 0.0 and area >= _SHARE * most
    ]
