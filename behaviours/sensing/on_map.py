"""Places on the map what the robot remembers in the world."""

from collections.abc import Callable
from math import hypot
from typing import Generic, TypeVar

from pinocchio import SE3

from behaviours.sensing.localisation import Localiser

Thing = TypeVar("Thing")


class OnMap(Generic[Thing]):
    """Places on the map what the robot remembers in the world.

    Args:
        moved: (what, T) to what T moves it to.
        still: a smaller correction, at the robot, moves nothing on the map yet [m].
    """

    def __init__(self, moved: Callable[[Thing, SE3], Thing], *, still: float = 0.002) -> None:
        self._moved, self._still = moved, still
        self._placed: tuple[Thing, SE3, Thing] | None = None

    def __call__(self, thing: Thing, here: Localiser) -> Thing:
        """The same object until what is remembered changes or the map has moved noticeably."""
        if (mTw := here.mTw) is None or not thing:
            return thing
        if self._placed is not None and self._placed[0] is thing:
            base = here.mTb.translation
            shift = self._placed[1].act(mTw.actInv(base)) - base
            if hypot(*shift.tolist()) < self._still:
                return self._placed[2]
        self._placed = thing, mTw, self._moved(thing, mTw)
        return self._placed[2]
