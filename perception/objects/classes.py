"""Classes of objects that this installation can recognise; a recogniser of simple bodies by shape.

The features are how much of its bounding rectangle an object fills, how much of it is near its top,
and the ratios of its edges and of its height.
"""

from collections.abc import Mapping
from dataclasses import astuple, dataclass
from functools import cache
from math import nan
from typing import ClassVar

import numpy as np

from config.arrays import Array
from perception.frame import ColourFrame
from perception.objects.detected_object import DetectedObject, DetectedObjects
from perception.objects.recogniser import (
    KnownClasses,
    Labelled,
    RecogniserError,
    installed,
    labelled,
)

TOP = 0.85  # share of an object's height above which is its top
LEAST = 0.15  # smallest score of an answer


@dataclass(frozen=True)
class Form:
    """Shape features of an object seen from above, without units; NaN is any."""

    fill: float  # its area, in that of the smallest rectangle around it
    top: float  # share of that area near its highest
    squareness: float  # shorter edge of the rectangle, in longer ones
    tallness: float  # its height, in shorter edges


KINDS: Mapping[str, Form] = {
    "box": Form(fill=0.92, top=0.87, squareness=nan, tallness=nan),
    "can": Form(fill=0.76, top=0.85, squareness=1.0, tallness=nan),
    "ball": Form(fill=0.76, top=0.54, squareness=1.0, tallness=1.0),
    "roll": Form(fill=0.88, top=0.65, squareness=nan, tallness=1.0),
}
"""Geometry says 1 and 1; 0.79 and 1; 0.79 and 0.51; 1 and 0.71; the noise of a camera takes off
from edges. A can stands; a roll is round and lies, a cylinder or a capsule.
"""

SPREAD = Form(fill=0.06, top=0.12, squareness=0.08, tallness=0.15)  # deviations of measurements


class ShapeClasses:
    """Names boxes, cans, balls and rolls by their depth."""

    kinds: ClassVar[tuple[str, ...]] = tuple(KINDS)

    def recognise(self, frame: ColourFrame, objects: DetectedObjects) -> list[Labelled]:
        """The label of each object that is like one of these bodies."""
        labels = []
        for one in objects:
            form = np.array(astuple(measured(frame, one)))
            scores = {kind: _score(form, kinds_form) for kind, kinds_form in KINDS.items()}
            kind = max(scores, key=lambda name: scores[name])
            if one.whole and scores[kind] >= LEAST:
                labels.append(Labelled(kind=kind, box=one.box, score=scores[kind]))
        return labels


def _score(form: Array, body: Form) -> float:
    """1 for the features of the body itself, less the more spreads they are away."""
    spreads = (form - np.array(astuple(body))) / np.array(astuple(SPREAD))
    return float(np.exp(-0.5 * np.nansum(spreads**2)))


def measured(frame: ColourFrame, one: DetectedObject) -> Form:
    """The form of an object in a frame."""
    left, above, right, below = one.box
    box = frame.cloud.part(slice(above, below + 1), slice(left, right + 1))
    points = box.every(1).points
    points = points[one.footprint.holds(points[:, 0], points[:, 1])]
    length, width, height = one.size
    return Form(
        fill=one.area / (length * width),
        top=float(np.mean(points[:, 2] - one.floor > TOP * height)) if len(points) else 0.0,
        squareness=width / length,
        tallness=height / width,
    )


@cache
def known_classes(wanted: str) -> KnownClasses:
    """Known classes, found once in a process; see `installed`."""
    return installed({"shapes": ShapeClasses()}, wanted)


def with_classes(frame: ColourFrame, objects: DetectedObjects, kind: str) -> DetectedObjects:
    """The objects with their classes, by the recogniser of one class.

    Raises:
        RecogniserError: there is none, or it failed.
    """
    known = known_classes(kind)
    if kind not in known.recognisers:
        raise RecogniserError(f"no recogniser knows the kind `{kind}`")
    return labelled(frame, objects, *known.recognisers[kind])
