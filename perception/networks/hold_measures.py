"""Measures of the patches around a grasp: room for the hand, and what the pads meet.

They spare the network from learning where the fingers are. The two sides of a grasp are equivalent,
so of each pair of measures the larger one comes first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import torch
from torch import Tensor

from perception.grasps.hand_geometry import hand_dimensions
from perception.grasps.patches import FAR_CELL, FAR_SHAPE, NEAR_CELL, NEAR_SHAPE, NUMBERS
from robots import GripperDescription, half_extents

Measure: TypeAlias = Callable[[Tensor, Tensor], Tensor]

MEASURES = 17  # of each grasp
_LEVELS = (-0.005, 0.0, 0.004)  # over the grasp centre, at which the pads meet the body [m]
_BODY = -0.006  # what is higher over the grasp centre than this is the body [m]
_STANDS = 0.008  # what is higher over the floor than this stands on it [m]
_CIRCLES = (0.05, 0.08)  # radii around the grasp in which that is counted [m]
_SLACK = 0.001  # between where the fingers are and where they should be [m]
_CLEARANCE, _RISE = 0.03, 0.02  # units of heights [m]
_LOWEST = -0.1  # of heights [m]


def hold_measures(
    near: Tensor,
    far: Tensor,
    far_unknown: Tensor,
    numbers: Tensor,
    gripper: GripperDescription,
) -> Tensor:
    """(N, MEASURES) of the order of 1, the same for a mirrored grasp.

    Arguments as in `GraspPatches`.
    """
    hand = hand_dimensions(gripper)
    of = {name: numbers[:, at, None, None] for at, name in enumerate(NUMBERS)}
    half_open, half_width = of["opening"] / 2.0, of["width"] / 2.0
    half_finger, half_pad = float(hand.lines[-1]), float(hand.lines[hand.pad_lines][-1])

    along, across = _cells(NEAR_SHAPE, NEAR_CELL)
    outwards, beside = along.abs() - half_open, across.abs()
    left_right, ends = (along < 0.0, along >= 0.0), (across > half_finger, across < -half_finger)
    pads, fingers = (
        (outwards >= -_SLACK) & (outwards <= thickness + _SLACK) & (beside <= half_finger + _SLACK)
        for thickness in (hand.pad_thickness, hand.finger_thickness)
    )
    before_pads = beside <= half_pad + 2.0 * _SLACK
    edges = before_pads & ((along.abs() - half_width + _SLACK).abs() < NEAR_CELL)
    held = before_pads & (along.abs() <= half_width + 2.0 * _SLACK)
    between = along.abs() <= half_width + 4.0 * _SLACK
    measures = [
        *_both(left_right, _highest, (near + hand.tip) / _CLEARANCE, pads),
        *_both(left_right, _highest, (near - hand.finger) / _CLEARANCE, fingers),
        *_both(ends, _mean, (near > _BODY).float(), between),
        _mean(near.clamp(-0.05, 0.05), held) / _RISE,
    ]
    for level in _LEVELS:
        measures += _both(left_right, _mean, (near > level).float(), edges)

    along, across = _cells(FAR_SHAPE, FAR_CELL)
    half_across, half_along, _ = half_extents(gripper.palm.shape)
    palm = (along.abs() <= half_along) & (across.abs() <= half_across)
    stands = (far + of["height"] > _STANDS).float()
    measures += [
        _highest((far - hand.palm) / _CLEARANCE, palm),
        _mean(far_unknown, palm),
        *(_mean(stands, torch.hypot(along, across) < radius) for radius in _CIRCLES),
    ]
    return torch.stack(measures, dim=1)


def _cells(shape: tuple[int, int], cell: float) -> tuple[Tensor, Tensor]:
    """Positions of the cells of a map along and across the closing direction [m]."""
    rows, columns = ((torch.arange(count) - 0.5 * (count - 1)) * cell for count in shape)
    return columns[None, None, :], rows[None, :, None]


def _both(
    sides: tuple[Tensor, Tensor], measure: Measure, values: Tensor, where: Tensor
) -> list[Tensor]:
    """A measure of some cells on either side, the larger one first."""
    values_of = torch.stack([measure(values, where & side) for side in sides])
    return [values_of.amax(0), values_of.amin(0)]


def _highest(values: Tensor, where: Tensor) -> Tensor:
    """(N,) the largest of some cells."""
    lowest = torch.full_like(values, _LOWEST / _CLEARANCE)
    return torch.where(where, values, lowest).amax((1, 2))


def _mean(values: Tensor, where: Tensor) -> Tensor:
    """(N,) the mean of some cells; 0 of none."""
    counted = where.float().expand_as(values)
    return (values * counted).sum((1, 2)) / counted.sum((1, 2)).clamp(min=1.0)
