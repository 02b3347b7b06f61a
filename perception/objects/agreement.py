"""What several looks at a region agree on: one frame alone may cut an object in two."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from perception.objects.detected_object import DetectedObject, DetectedObjects

SAME = 0.65
"""Two that share this much of what each of them covers are the same object; halves share less."""


def consensus(looks: Sequence[DetectedObjects]) -> DetectedObjects:
    """The objects that more than half of the looks show, from the left to the right of the image.

    Sizes and areas are medians; all else is as the newest look shows it.

    Args:
        looks: at the same region, the newest last.
    """
    groups: list[list[DetectedObject]] = []
    for one in (one for look in reversed(looks) for one in look):
        alike = (group for group in groups if group[0].footprint.shared(one.footprint) >= SAME)
        if (group := next(alike, None)) is None:
            groups.append([one])
        else:
            group.append(one)
    most = [_typical(group) for group in groups if 2 * len(group) > len(looks)]
    return DetectedObjects(sorted(most, key=lambda one: one.box))


def _typical(group: Sequence[DetectedObject]) -> DetectedObject:
    length, width, height = np.median([one.size for one in group], axis=0).tolist()
    return replace(
        group[0],
        size=(length, width, height),
        area=float(np.median([one.area for one in group])),
        colour=Counter(one.colour for one in group).most_common(1)[0][0],
    )
