"""Classes of objects that this installation can recognise."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from perception.frame import ColourFrame
from perception.objects.detected_object import DetectedObjects
from perception.objects.recogniser import (
    KnownClasses,
    Recogniser,
    RecogniserError,
    installed,
    labelled,
)
from perception.objects.shape_classes import ShapeClasses

SHIPPED: Mapping[str, Recogniser] = {"shapes": ShapeClasses()}


@cache
def known_classes(wanted: str) -> KnownClasses:
    """Known classes, found once in a process; see `installed`."""
    return installed(SHIPPED, wanted)


def with_classes(frame: ColourFrame, objects: DetectedObjects, kind: str) -> DetectedObjects:
    """The objects with their classes, by the recogniser of one class.

    Raises:
        RecogniserError: there is none, or it failed.
    """
    known = known_classes(kind)
    if kind not in known.recognisers:
        raise RecogniserError(f"no recogniser knows the kind `{kind}`")
    return labelled(frame, objects, *known.recognisers[kind])
