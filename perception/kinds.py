"""The kinds of things that this installation can recognise."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from perception.objects import ColourFrame
from perception.recogniser import Known, Recogniser, RecogniserError, installed, labelled
from perception.seen_object import SeenObjects
from perception.shape_kinds import ShapeKinds

SHAPE_KINDS = ShapeKinds.kinds
"""What the shipped recogniser tells."""
SHIPPED: Mapping[str, Recogniser] = {"shapes": ShapeKinds()}


@cache
def known_kinds(wanted: str) -> Known:
    """What is known, found out once in a process.

    Packages are imported only if the shipped recognisers do not know the kind.

    Args:
        wanted: a kind.
    """
    return installed(SHIPPED, wanted)


def with_kinds(frame: ColourFrame, objects: SeenObjects, kind: str) -> SeenObjects:
    """The objects with their kinds, by the recogniser of one kind.

    Args:
        frame: that shows them.
        objects: told apart.
        kind: whose recogniser is asked.

    Raises:
        RecogniserError: there is none, or it does not do what it should.
    """
    known = known_kinds(kind)
    if kind not in known.recognisers:
        raise RecogniserError(f"no recogniser knows the kind `{kind}`")
    return labelled(frame, objects, *known.recognisers[kind])
