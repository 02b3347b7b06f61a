"""Faults of the camera, and disturbances of objects by people in a world that allows them."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import cos, nan, pi, sin

import numpy as np
from pinocchio import SE3

from extensions.faults.effects import Effect, Injectable, Site
from hw import DepthArray, DepthFrame, DisturbableWorld, RobotState

_FRAME_DELAY = 0.3  # [s]
_OUTSIDE = np.array([-8.0, -8.0, 0.5])  # where objects are taken [m]
_TURNED = 0.003  # by which fingers open around what is turned between them [m]
_DISTANCE = 0.1  # by which objects are pushed [m]
_TRIES = 24  # directions that are tried so that a pushed object stays on its support


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

    def __init__(self, repaint: Callable[[DepthArray], DepthArray] = lambda depth: depth) -> None:
        self._repaint = repaint

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        if frame is not self._seen:
            self._seen = frame
            self._shown = frame and self.changed(frame)
        return self._shown

    def changed(self, frame: DepthFrame) -> DepthFrame:
        return replace(frame, depth=self._repaint(frame.depth))


class _PictureFrozen(_Repainted):
    """The image is frozen; stamps and camera poses are fresh."""

    _first: DepthFrame | None = None

    def changed(self, frame: DepthFrame) -> DepthFrame:
        self._first = first = self._first or frame
        return replace(frame, depth=first.depth, paint=first.paint)


class _FramesFilled(_Repainted):
    """A random share of the pixels has one value."""

    def __init__(self, value: float, share: float = 1.0) -> None:
        super().__init__()
        self._value, self._share = value, share

    def changed(self, frame: DepthFrame) -> DepthFrame:
        hit = self.site.rng.random(frame.depth.shape) < self._share
        return replace(frame, depth=np.where(hit, np.float32(self._value), frame.depth))


class _ObjectFault(Effect):
    """Affects one random object that is not lost already."""

    def begin(self, site: Site) -> None:
        super().begin(site)
        if site.world is None:
            return
        supports = site.world.supports()
        candidates = [one for one in site.world.objects if supports[one.name] not in ("", "floor")]
        if candidates:
            chosen = candidates[int(site.rng.integers(len(candidates)))]
            self.disturb(site.world, chosen.name, chosen.pose, supports[chosen.name])

    def disturb(self, world: DisturbableWorld, name: str, wTs: SE3, support: str) -> None:
        raise NotImplementedError


class _ObjectMoved(_ObjectFault):
    """An object is pushed aside on its support; a held one slips out of the hand."""

    def disturb(self, world: DisturbableWorld, name: str, wTs: SE3, support: str) -> None:
        if support == "hand":
            world.put(name, wTs)
            return
        for _ in range(_TRIES):
            towards = self.site.rng.uniform(-pi, pi)
            aside = _DISTANCE * np.array([cos(towards), sin(towards), 0.0])
            world.put(name, SE3(wTs.rotation, wTs.translation + aside))
            if world.supports()[name] == support:
                return
        world.put(name, wTs)


class _ObjectTaken(_ObjectFault):
    """An object is taken away, and brought back to its place when the fault is cleared."""

    _taken: tuple[str, SE3] | None = None

    def disturb(self, world: DisturbableWorld, name: str, wTs: SE3, support: str) -> None:
        self._taken = name, self.site.homes[name] if support == "hand" else wTs
        world.put(name, SE3(wTs.rotation, _OUTSIDE))

    def end(self) -> None:
        if self._taken is not None and self.site.world is not None:
            self.site.world.put(*self._taken)


class _ObjectPulled(_ObjectFault):
    """A person pulls at the held object, which turns in the hand, until the fingers open."""

    _held: str | None = None

    def disturb(self, world: DisturbableWorld, name: str, wTs: SE3, support: str) -> None:
        held = [one for one, by in world.supports().items() if by == "hand"]
        self._held = held[0] if held else None

    def reading(self, state: RobotState) -> RobotState:
        if self._held is None:
            return state
        return replace(state, gripper_width=state.gripper_width + _TURNED)

    def grip(self, width: float) -> float:
        state, world = self.site.state, self.site.world
        if self._held is not None and world is not None and width > state.gripper_width:
            world.put(self._held, SE3(np.eye(3), _OUTSIDE))
            self._held = None
        return width


class _ObjectGiven(_ObjectFault):
    """A person holds an object between the fingers, until they have it."""

    def disturb(self, world: DisturbableWorld, name: str, wTs: SE3, support: str) -> None:
        if "hand" not in world.supports().values():
            world.give(name)


_ROWS: tuple[tuple[str, Callable[[], Effect], str], ...] = (
    ("frames lost", _FramesLost, "no frame arrives"),
    ("frames late", _FramesLate, "frames arrive 0.3 s late"),
    ("frames frozen", _FramesFrozen, "one frame, again and again"),
    ("picture frozen", _PictureFrozen, "one picture, with fresh stamps and camera poses"),
    ("frames black", partial(_FramesFilled, 0.0), "every depth is 0"),
    ("frames empty", partial(_FramesFilled, nan), "every depth is NaN"),
    ("frames sparse", partial(_FramesFilled, nan, 0.5), "every second depth, at random, is NaN"),
    (
        "frames in millimetres",
        partial(_Repainted, lambda depth: depth * np.float32(1000.0)),
        "depth is in millimetres, and said to be in metres",
    ),
    (
        "frames transposed",
        partial(_Repainted, lambda depth: np.ascontiguousarray(depth.T)),
        "rows and columns are exchanged",
    ),
)
_MOVED = "an object is pushed aside by 0.1 m; a held one is dropped"
_TAKEN = "an object is taken away, out of the hand too, until the fault is cleared"
_PULLED = "a person pulls at the held object, and has it once the fingers open"
_GIVEN = "an object is held between the fingers until they have it"
WORLD_FAULTS = (
    *(Injectable(*row) for row in _ROWS),
    Injectable("object moved", _ObjectMoved, _MOVED, of_world=True),
    Injectable("object taken", _ObjectTaken, _TAKEN, of_world=True),
    Injectable("object pulled", _ObjectPulled, _PULLED, of_world=True),
    Injectable("object given", _ObjectGiven, _GIVEN, of_world=True),
)
