"""What the robot itself has set down, as far as it knows its shape."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from robots import Box, Geom, half_extents

_MOST_HALF = 0.08
"""What is set down counts this far along the pads at most: nobody has measured it, and more would
keep the camera off the next place [m]."""
_NEAR = 0.03
"""Fingers that close this near to it may move it [m]."""


class SetDown:
    """Remembers what was let go at a place, until the fingers close there again."""

    def __init__(self) -> None:
        self.shapes: tuple[Geom, ...] = ()
        """In the world; the same object as long as nothing has changed."""

    def add(self, held: Sequence[Geom], wTe: SE3) -> None:
        """What the hand held at a pose stands there now.

        Args:
            held: its shapes in e.
            wTe: of the end effector.
        """
        self.shapes += tuple(_shorter(one).moved(wTe) for one in held)

    def grasp(self, point: npt.NDArray[np.float64]) -> None:
        """The fingers close at a point (3,) in the world: what is there may be moved."""
        left = tuple(one for one in self.shapes if not _is_at(one, point))
        if len(left) < len(self.shapes):
            self.shapes = left

    def forget(self) -> None:
        """Nothing is where it was."""
        self.shapes = ()


def _shorter(held: Geom) -> Geom:
    """Its box, no longer along the pads than what counts."""
    x, y, z = half_extents(held.shape)
    return Geom(Box((min(x, _MOST_HALF), y, z)), held.pose, "what was set down")


def _is_at(one: Geom, point: npt.NDArray[np.float64]) -> bool:
    local = np.abs(one.pose.actInv(point)) - half_extents(one.shape)
    return bool(local.max() <= _NEAR)
