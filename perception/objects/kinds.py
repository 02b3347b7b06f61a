"""The kinds of things that this installation can recognise."""

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

SHAPE_CLASSES = ShapeClasses.kinds
"""What the shipped recogniser tells."""
SHIPPED: Mapping[str, Recogniser] = {"shapes": ShapeClasses()}


@cache
def known_classes(wanted: str) -> KnownClasses:
    """What is known, found out once in a process.

    Packages are imported only if the shipped recognisers do not know the kind.

    Args:
        wanted: a kind.
    """
    return installed(SHIPPED, wanted)


def with_classes(frame: ColourFrame, objects: DetectedObjects, kind: str) -> DetectedObjects:
    """The objects with their kinds, by the recogniser of one kind.

    Args:
        frame: that shows them.
        objects: told apart.
        kind: whose recogniser is asked.

    Raises:
        RecogniserError: there is none, or it does not do what it should.
    """
    known = known_classes(kind)
    if kind not in known.recognisers:
        raise RecogniserError(f"no recogniser knows the kind `{kind}`")
    return labelled(frame, objects, *known.recognisers[kind])
