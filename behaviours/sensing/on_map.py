"""Places on the map what the robot remembers in the world."""

from collections.abc import Callable
from math import hypot
from typing import Generic, TypeVar

from pinocchio import SE3

from behaviours.sensing.localisation import Localiser

Thing = TypeVar("Thing")

_STILL = 0.002  # correction, at the robot, that moves nothing on the map yet [m]


class OnMap(Generic[Thing]):
    """Places on the map what the robot remembers in the world.

    Args:
        moved: (what, T) to what T moves it to.
    """

    def __init__(self, moved: Callable[[Thing, SE3], Thing]) -> None:
        self._moved = moved
        self._placed: tuple[Thing, SE3, Thing] | None = None

    def __call__(self, thing: Thing, here: Localiser) -> Thing:
        """The same object until what is remembered changes or the map has moved noticeably."""
        if (mTw := here.mTw) is None or not thing:
            return thing
        if self._placed is not None and self._placed[0] is thing:
            base = here.mTb.translation
            shift = self._placed[1].act(mTw.actInv(base)) - base
            if hypot(*shift.tolist()) < _STILL:
                return self._placed[2]
        self._placed = thing, mTw, self._moved(thing, mTw)
        return self._placed[2]
