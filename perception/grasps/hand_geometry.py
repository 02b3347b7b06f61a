"""Dimensions of a gripper in the feasibility check, with safety margins."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cache
from math import ceil, floor
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Image
from robots import GripperDescription, half_extents

TIP_MARGIN = 0.0004  # added to the reach of the finger tips [m]
FINGER_MARGIN = 0.00005  # added to the thickness of the fingers [m]
FINGER_END_MARGIN = 0.002  # added to the fingers at their lower end [m]
PALM_ALLOWANCE = 0.0001  # subtracted from the reach of the palm [m]
PALM_MARGIN = 0.004  # added to the palm on all sides, for errors of the arm [m]
LINE_SPACING = 0.0035  # between the sampled lines, across the fingers [m]
PALM_SPACING = 0.016  # between the sampled points under the palm [m]


class Overhead(NamedTuple):
    """A part of the hand above the grasped object and its surroundings."""

    height: float  # above the grasp centre [m]
    along: Array  # (P,) offsets along the closing direction of points under it [m]
    across: Array  # (P,) offsets across [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class HandDimensions:
    """A parallel gripper, `along` the closing direction and `across` it."""

    opening: float  # between the pads when fully open [m]
    tip: float  # height of the grasp centre above the finger tips [m]
    palm: float  # height of the palm above the grasp centre [m]
    finger: float  # height above the grasp centre where `finger_thickness` begins [m]
    pad_thickness: float  # from the inner face of a pad outwards [m]
    finger_thickness: float  # from the inner face of a pad to the outer face [m]
    lines: Image  # (L,) offset across of each line, over the width of the fingers [m]
    pad_lines: slice  # those over the width of the pads
    overhead: tuple[Overhead, ...]  # the palm, and the camera on both sides


def hand_sizes(gripper: GripperDescription) -> dict[str, float]:
    """The lengths by which one hand differs from another, by name [m]."""
    sizes = asdict(hand_dimensions(gripper))
    return {name: size for name, size in sizes.items() if isinstance(size, float)}


@cache
def hand_dimensions(gripper: GripperDescription, margin: float = 0.0) -> HandDimensions:
    """The dimensions of a gripper, with a margin around its fingers [m]."""
    finger, pad = (half_extents(part.shape) for part in (gripper.finger, gripper.pad))
    overhead = tuple(_overhead(gripper))
    n_pad = floor(pad[0] / LINE_SPACING)
    n_finger = ceil((finger[0] + margin) / LINE_SPACING)
    millimetres = np.arange(-n_finger, n_finger + 1, dtype=np.float32) * np.float32(
        1e3 * LINE_SPACING
    )
    return HandDimensions(
        opening=gripper.opening,
        tip=_rounded(gripper.tip + TIP_MARGIN),
        palm=overhead[0].height,
        finger=_rounded(-gripper.finger.pose.translation[2] - finger[2] - FINGER_END_MARGIN),
        pad_thickness=_rounded(gripper.pad.pose.translation[1] + pad[1] + margin),
        finger_thickness=_rounded(
            gripper.finger.pose.translation[1] + finger[1] + FINGER_MARGIN + margin
        ),
        lines=millimetres * np.float32(1e-3),
        pad_lines=slice(n_finger - n_pad, n_finger + n_pad + 1),
        overhead=overhead,
    )


def _overhead(gripper: GripperDescription) -> Iterator[Overhead]:
    """The palm first."""
    for part in (gripper.palm, gripper.camera):
        if part is not None:
            aside, ahead, up = part.pose.translation
            across, along, high = half_extents(part.shape)
            sides = _points(across + PALM_MARGIN)
            sides = np.unique(np.concatenate([sides + aside, sides - aside]))
            grid = np.meshgrid(_points(along + abs(ahead) + PALM_MARGIN), sides)
            height = _rounded(-up - high + PALM_ALLOWANCE)
            yield Overhead(height, grid[0].ravel(), grid[1].ravel())


def _points(half: float) -> Array:
    """(P,) points that cover a length of twice `half` [m]."""
    last = _rounded(half - 0.5 * PALM_SPACING)
    return np.linspace(-last, last, ceil(2.0 * half / PALM_SPACING))


def _rounded(length: float) -> float:
    """To a micrometre, so that sums of decimal lengths have no error in the last bit."""
    return round(float(length), 6)
