"""Detected objects: choice among them by criteria and order, and their detection in frames."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from behaviours.core.context import Context
from behaviours.core.parameter_types import Region
from behaviours.views.survey import SMALLEST, glance, region_map, unseen
from config.arrays import Array, Mask
from hw import DepthFrame
from perception import (
    ColourName,
    DetectedObject,
    DetectedObjects,
    RecogniserError,
    consensus,
    segment_objects,
    with_classes,
)

Choose: TypeAlias = Literal["best", "largest", "smallest", "nearest"]

_LOW = 0.016  # height of an object of which noise may show parts alone [m]
_FRAMES = 3  # of which a majority must show an object
_BESIDE = 0.03  # an object nearer to another one blocks a finger [m]
_SHARE = 0.25  # of the area of the most blocking neighbour, from which others block too

_ORDERS: Mapping[str, Callable[[DetectedObject, Array], float]] = {
    "largest": lambda one, base: -one.area,
    "smallest": lambda one, base: one.area,
    "nearest": lambda one, base: float(np.linalg.norm((one.position - base)[:2])),
}
"""Costs, of which the first object has the least; `base` is (3,), the base in odometry."""


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
            base: (3,) the robot's base in odometry [m].
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
    others: tuple[DetectedObject, ...] = ()
    """What else was seen, which the fingers must leave."""

    @property
    def floor(self) -> float:
        """Height of the surface below them, in odometry [m]."""
        return self.objects[0].floor

    def locate(self) -> Callable[[], Chosen]:
        """Itself: it does not follow the map."""
        return lambda: self

    def contains(self, points: Array) -> Mask:
        """Which of (N, 3) points in odometry [m] belong to one of them, or are right beside it."""
        inside: Mask = np.any([one.contains(points) for one in self.objects], axis=0)
        return inside

    def owns(self, centres: Array, contacts: Array, pads: Array) -> Mask:
        """Which grasps are on one of them, and close on nothing else; see `ObjectRegion`."""
        ends = pads.reshape(-1, 3)
        beside = np.any([other.contains(ends) for other in self.others], axis=0)
        owned = np.zeros(len(centres), dtype=np.bool_)
        for one in self.objects:
            on = one.contains(contacts.reshape(-1, 3)).reshape(-1, 2).all(axis=1)
            alone = ~(beside & ~one.covers(ends)).reshape(-1, 4).any(axis=1)
            owned |= on & alone & one.covers(centres)
        return owned


def neighbours(one: DetectedObject, objects: Sequence[DetectedObject]) -> list[DetectedObject]:
    """Those that block fingers beside an object."""
    others = [it for it in objects if it is not one]
    areas = [it.footprint.area_near(one.footprint, _BESIDE) for it in others]
    most = max(areas, default=0.0)
    return [
        it for area, it in zip(areas, others, strict=True) if area > 0.0 and area >= _SHARE * most
    ]


class ObjectDetection:
    """Detects objects in the frames of successive ticks.

    Args:
        context: shared by the leaves.
        region: whose floor the objects stand on.
        choice: criteria, which say what has to be known of the objects.
    """

    def __init__(self, context: Context, region: Region, choice: Choice) -> None:
        self._context, self._region, self._choice = context, region, choice
        self.hides = False
        """Whether what stood there hid a part that could hold another one of the narrowest that
        are chosen, as `unseen` saw last."""
        self.begin()

    def begin(self, since: float = -np.inf) -> None:
        """Start again, with frames from session time `since` [s] on."""
        self._since = since
        self._frames: deque[DepthFrame] = deque(maxlen=_FRAMES)
        self._objects: deque[DetectedObjects] = deque(maxlen=_FRAMES)

    def unseen(self, found: DetectedObjects) -> str:
        """What the frames show beside these objects, or do not show; empty if nothing matters."""
        seen = region_map(self._context, self._region, *self._frames)
        untold = [one.centre for one in seen.segments(SMALLEST, beside=found)]
        if len(found) > len(seen.segments(SMALLEST)):  # parts of one, where noise makes gaps
            untold += [one.position for one in found if one.size[2] < _LOW]
        for x, y, _ in untold:
            return f"what stands at {x:.2f}, {y:.2f} is too low to be told apart"
        narrowest = self._choice.narrowest
        self.hides = bool(unseen(seen, self._region, SMALLEST, whole=True, narrowest=narrowest))
        return unseen(seen, self._region, SMALLEST)

    def update(self) -> DetectedObjects | str | None:
        """Take the frame that is new in this tick, if it is valid.

        Returns:
            The objects; None until there are enough frames; or why detection is impossible.
        """
        vision = self._context.vision
        frame = vision.new_frame()
        stale = frame is None or frame.stamp < self._since
        if frame is None or stale or vision.blindness(self._context.state.stamp):
            return None
        with vision.timed():
            seen = _segmented(self._context, frame, self._region, self._choice)
            if isinstance(seen, str):
                return seen
            self._objects.append(seen)
            self._frames.append(frame)
            if len(self._objects) < _FRAMES:
                return None
            return _with_kinds(frame, consensus(self._objects), self._choice)


def detect_once(
    context: Context, frame: DepthFrame, region: Region, choice: Choice
) -> DetectedObjects | str:
    """The objects in one frame; or why detection is impossible."""
    seen = _segmented(context, frame, region, choice)
    return seen if isinstance(seen, str) else _with_kinds(frame, seen, choice)


def _segmented(
    context: Context, frame: DepthFrame, region: Region, choice: Choice
) -> DetectedObjects | str:
    if choice.colour is not None and frame.colour is None:
        return "the camera of this robot sees no colours"
    shown = glance(context, region, frame)
    seen = segment_objects(frame, region.at(shown.oTr), shown.floor)
    return "no depth was measured" if seen is None else seen


def _with_kinds(
    frame: DepthFrame, objects: DetectedObjects, choice: Choice
) -> DetectedObjects | str:
    try:
        return objects if choice.kind is None else with_classes(frame, objects, choice.kind)
    except RecogniserError as error:
        return str(error)
