"""Faults of the camera."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from hw.faults.effect import Effect
from hw.state import DepthArray, DepthFrame, Paint


class FramesLost(Effect):
    """There is no frame."""

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        """None."""
        return None


class FramesLate(Effect):
    """Frames arrive late, with the stamps of when they were captured.

    Args:
        delay: from the capture to the arrival [s].
    """

    def __init__(self, delay: float) -> None:
        self._delay = delay
        self._under_way: deque[DepthFrame] = deque()

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        """The newest one that has arrived; the oldest known until one has."""
        if frame is not None and (not self._under_way or frame is not self._under_way[-1]):
            self._under_way.append(frame)
        arrived = self.site.now - self._delay + 1e-9
        while len(self._under_way) > 1 and self._under_way[1].stamp <= arrived:
            self._under_way.popleft()
        return self._under_way[0] if self._under_way else None


class FramesFrozen(Effect):
    """The camera delivers one and the same frame."""

    _first: DepthFrame | None = None

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        """The first frame."""
        self._first = self._first or frame
        return self._first


class _Repainted(Effect):
    """Every new frame is changed once."""

    _seen: DepthFrame | None = None
    _shown: DepthFrame | None = None

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        """The changed frame, one object for each frame of the camera."""
        if frame is not self._seen:
            self._seen = frame
            self._shown = frame and replace(
                frame, depth=self.repaint(frame.depth), paint=self.recolour(frame.paint)
            )
        return self._shown

    def repaint(self, depth: DepthArray) -> DepthArray:
        """The picture instead of a picture."""
        raise NotImplementedError

    def recolour(self, paint: Paint | None) -> Paint | None:
        """The colours instead of those of a picture: the same, unless a subclass says otherwise."""
        return paint


class PictureFrozen(_Repainted):
    """The picture stands still; stamps and places of the camera are fresh."""

    _first: DepthArray | None = None
    _first_paint: Paint | None = None

    def repaint(self, depth: DepthArray) -> DepthArray:
        """The first picture."""
        if self._first is None:
            self._first = depth
        return self._first

    def recolour(self, paint: Paint | None) -> Paint | None:
        """Those of the first picture."""
        self._first_paint = self._first_paint or paint
        return self._first_paint


class FramesInMillimetres(_Repainted):
    """Depth has another unit than it should have."""

    def repaint(self, depth: DepthArray) -> DepthArray:
        """The picture, a thousand times as far."""
        return depth * np.float32(1000.0)


class FramesTransposed(_Repainted):
    """Rows and columns are exchanged, and the intrinsics stay."""

    def repaint(self, depth: DepthArray) -> DepthArray:
        """The picture as (W, H)."""
        return np.ascontiguousarray(depth.T)


class FramesFilled(_Repainted):
    """Pixels have one value, all of them or a random share.

    Args:
        value: 0 as of a dark camera, NaN as of one that measures nothing [m].
        share: of the pixels.
    """

    def __init__(self, value: float, share: float = 1.0) -> None:
        self._value, self._share = value, share

    def repaint(self, depth: DepthArray) -> DepthArray:
        """The picture with the value in it."""
        hit = self.site.rng.random(depth.shape) < self._share
        return np.where(hit, np.float32(self._value), depth)
