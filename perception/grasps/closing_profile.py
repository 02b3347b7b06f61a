"""Profile of a scene along lines in the closing direction: solid runs, free space and edges.

A line is sampled every `STEP` from -63 mm to 63 mm about the grasp centre, past an open finger.
"""

import numpy as np

from config.arrays import Array, Image, Mask

STEP = 0.0015  # between the samples of a line [m]
ALONG = np.arange(-42, 43, dtype=np.float32) * np.float32(STEP)
"""(S,) offsets of the samples along the closing direction [m]."""

_CENTRE = len(ALONG) // 2
_CONTACT_ZONE = 0.003  # edge points this near to the outermost one belong to the contact [m]


def runs(occupied: Mask) -> tuple[Array, Array, Mask]:
    """Ends of the solid run around the middle of each line [m], and whether there is one."""
    free, solid = ~occupied, occupied[..., _CENTRE]
    # Nothing free on a side of a solid middle is a run to the end.
    right, left = free[..., _CENTRE:].argmax(-1), free[..., _CENTRE::-1].argmax(-1)
    right[solid & (right == 0)] = left[solid & (left == 0)] = _CENTRE + 1
    return -(left - 0.5) * STEP, (right - 0.5) * STEP, solid


def free_distances(
    blocked: Mask, body_first: Array, body_last: Array, centre: Array
) -> tuple[Array, Array]:
    """Distances from the centre to the first obstacle beyond the body, to either side [m].

    `blocked` (N, along) is whether anything is in the way of the fingers; the ends of the body and
    the centre (N,) are along the closing direction [m].
    """
    beyond = np.where(blocked & (body_last[:, None] < ALONG), ALONG, np.inf).min(axis=1)
    before = np.where(blocked & (body_first[:, None] > ALONG), ALONG, -np.inf).max(axis=1)
    return beyond - 0.5 * STEP - centre, centre - before - 0.5 * STEP


def contact_edge(
    ends: Array, solid: Mask, outermost: Array, across: Image
) -> tuple[Array, Array, Array]:
    """Slope of a contact edge [rad], the number of lines it is on, its offset across [m]."""
    weight = (solid & (np.abs(ends - outermost[:, None]) < _CONTACT_ZONE)).astype(float)
    lines = weight.sum(axis=1)
    total = np.maximum(lines, 1.0)
    centre = (weight * across).sum(axis=1) / total
    mean = (weight * ends).sum(axis=1) / total
    spread = (weight * (across - centre[:, None]) ** 2).sum(axis=1)
    slope = (weight * (across - centre[:, None]) * (ends - mean[:, None])).sum(axis=1)
    slope = np.where(lines >= 2, slope / np.maximum(spread, 1e-9), 0.0)
    return np.arctan(slope), lines, centre


def flare(above: Mask, first: Array, last: Array) -> Array:
    """Excess of the body at the tips over its extent higher up, on the worse side [m]."""
    left, right, solid = runs(above)
    left = np.where(solid, left, np.inf).min(axis=1)
    right = np.where(solid, right, -np.inf).max(axis=1)
    some = solid.any(axis=1)
    excess = np.maximum(left - first, last - right)
    return np.where(some, excess, 1.0)
