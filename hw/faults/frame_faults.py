"""Faults of the camera."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from functools import partial
from math import nan

import numpy as np

from hw.faults.effect import Effect, Injectable
from hw.state import DepthArray, DepthFrame, Paint

_FRAME_DELAY = 0.3  # [s]


class _FramesLost(Effect):
    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        return None


class _FramesLate(Effect):
    """Frames arrive late, with the stamps of their capture."""

    def __init__(self) -> None:
        self._queue: deque[DepthFrame] = deque()

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        if frame is not None and (not self._queue or frame is not self._queue[-1]):
            self._queue.append(frame)
        arrived = self.site.now - _FRAME_DELAY + 1e-9
        while len(self._queue) > 1 and self._queue[1].stamp <= arrived:
            self._queue.popleft()
        return self._queue[0] if self._queue else None


class _FramesFrozen(Effect):
    _first: DepthFrame | None = None

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        self._first = self._first or frame
        return self._first


class _Repainted(Effect):
    """Changes every new frame once: one object for each frame of the camera."""

    _seen: DepthFrame | None = None
    _shown: DepthFrame | None = None

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        if frame is not self._seen:
            self._seen = frame
            self._shown = frame and replace(
                frame, depth=self.repaint(frame.depth), paint=self.recolour(frame.paint)
            )
        return self._shown

    def repaint(self, depth: DepthArray) -> DepthArray:
        raise NotImplementedError

    def recolour(self, paint: Paint | None) -> Paint | None:
        return paint


class _PictureFrozen(_Repainted):
    """The image is frozen; stamps and camera poses are fresh."""

    _first: DepthArray | None = None
    _first_paint: Paint | None = None

    def repaint(self, depth: DepthArray) -> DepthArray:
        if self._first is None:
            self._first = depth
        return self._first

    def recolour(self, paint: Paint | None) -> Paint | None:
        self._first_paint = self._first_paint or paint
        return self._first_paint


class _FramesInMillimetres(_Repainted):
    def repaint(self, depth: DepthArray) -> DepthArray:
        return depth * np.float32(1000.0)


class _FramesTransposed(_Repainted):
    def repaint(self, depth: DepthArray) -> DepthArray:
        return np.ascontiguousarray(depth.T)


class _FramesFilled(_Repainted):
    """A random share of the pixels has one value."""

    def __init__(self, value: float, share: float = 1.0) -> None:
        self._value, self._share = value, share

    def repaint(self, depth: DepthArray) -> DepthArray:
        hit = self.site.rng.random(depth.shape) < self._share
        return np.where(hit, np.float32(self._value), depth)


FRAME_FAULTS = (
    Injectable("frames lost", _FramesLost, "no frame arrives"),
    Injectable("frames late", _FramesLate, "frames arrive 0.3 s late"),
    Injectable("frames frozen", _FramesFrozen, "one frame, again and again"),
    Injectable("picture frozen", _PictureFrozen, "one picture, with fresh stamps and camera poses"),
    Injectable("frames black", partial(_FramesFilled, 0.0), "every depth is 0"),
    Injectable("frames empty", partial(_FramesFilled, nan), "every depth is NaN"),
    Injectable(
        "frames sparse", partial(_FramesFilled, nan, 0.5), "every second depth, at random, is NaN"
    ),
    Injectable(
        "frames in millimetres",
        _FramesInMillimetres,
        "depth is in millimetres, and said to be in metres",
    ),
    Injectable("frames transposed", _FramesTransposed, "rows and columns are exchanged"),
)
