"""The hold network: how likely a grasp holds, from the height patches around it.

It learns from grasps that were executed in physics (`frankie-task grasp outcomes`): 1 for those
that held to the end of the shaking without a hard contact.
"""

from collections.abc import Callable
from copy import deepcopy
from importlib.resources import as_file, files
from itertools import pairwise
from pathlib import Path
from typing import TypeAlias

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from perception.frame import Array
from perception.grasps.hand_geometry import hand_dimensions, hand_sizes
from perception.grasps.patches import (
    FAR_CELL,
    FAR_SHAPE,
    NEAR_CELL,
    NEAR_SHAPE,
    NUMBERS,
    GraspPatches,
    HoldProbability,
)
from perception.networks.proposer import one_thread
from perception.networks.weights import read_metadata, read_state
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

CHANNELS = (16, 32)  # of the first layer and of those after it
_HIDDEN = 64  # units before the last
_LENGTH, _FAR_LENGTH = 0.03, 0.05  # units of the heights in both maps [m]
_NUMBERS = 13 + MEASURES  # beside the maps


def _block(before: int, after: int) -> nn.Module:
    return nn.Sequential(
        nn.Conv2d(before, after, 3, padding=1, bias=False), nn.BatchNorm2d(after), nn.ReLU()
    )


class HoldNetwork(nn.Module):
    """Two small stacks of convolutions, one for each map, and a perceptron on both."""

    def __init__(self) -> None:
        super().__init__()
        first, then = CHANNELS
        pool = nn.MaxPool2d(2)
        blocks = _block(3, first), _block(first, then), _block(then, then), _block(then, then)
        self.near = nn.Sequential(blocks[0], pool, blocks[1], pool, blocks[2], pool, blocks[3])
        self.far = nn.Sequential(
            _block(3, first), pool, _block(first, then), pool, _block(then, then), pool
        )
        cells = sum(rows * columns // 64 for rows, columns in (NEAR_SHAPE, FAR_SHAPE))
        self.head = nn.Sequential(
            nn.Dropout(0.3),
            nn.Linear(then * cells + _NUMBERS, _HIDDEN),
            nn.ReLU(),
            nn.Dropout(0.2),
            nn.Linear(_HIDDEN, 1),
        )

    def forward(
        self,
        near: Tensor,
        near_unknown: Tensor,
        far: Tensor,
        far_unknown: Tensor,
        numbers: Tensor,
        measures: Tensor,
    ) -> Tensor:
        """(N,) logits of the probability; the arguments are those of `as_tensors`."""
        height = numbers[:, NUMBERS.index("height"), None, None]
        near_maps = (
            near.clamp(-0.05, 0.05) / _LENGTH,
            near_unknown,
            (near + height).clamp(0.0, 0.15) / _FAR_LENGTH,
        )
        far_maps = (
            far.clamp(-0.1, 0.1) / _FAR_LENGTH,
            far_unknown,
            (far + height).clamp(0.0, 0.2) / _FAR_LENGTH,
        )
        seen = [
            self.near(torch.stack(near_maps, dim=1)).flatten(1),
            self.far(torch.stack(far_maps, dim=1)).flatten(1),
        ]
        return torch.as_tensor(
            self.head(torch.cat([*seen, _scaled(numbers), measures], dim=1))[:, 0]
        )


def _scaled(numbers: Tensor) -> Tensor:
    """(N, 13) of the order of 1, the same for a mirrored object."""
    of = dict(zip(NUMBERS, numbers.unbind(1), strict=True))
    along, across = of["middle_along"].abs(), of["middle_across"].abs()
    lever = torch.hypot(along, across)
    return torch.stack(
        [
            of["score"],
            of["score"].sqrt(),
            of["width"] / 0.04,
            of["opening"] / 0.08,
            of["depth"] / 0.02,
            of["height"] / 0.05,
            along / 0.05,
            across / 0.05,
            lever / 0.08,
            of["volume"].clamp(min=0.0) ** (1.0 / 3.0) / 0.05,
            of["whole"],
            of["camera_distance"] / 0.4,
            of["camera_cosine"],
        ],
        dim=1,
    )


def as_tensors(patches: GraspPatches, gripper: GripperDescription) -> tuple[Tensor, ...]:
    """The arguments of `HoldNetwork.forward`: the fields of patches, and their `hold_measures`."""
    fields = (patches.near, patches.near_unknown, patches.far, patches.far_unknown, patches.numbers)
    near, near_unknown, far, far_unknown, numbers = (
        torch.from_numpy(np.asarray(each, dtype=np.float32)) for each in fields
    )
    measures = hold_measures(near, far, far_unknown, numbers, gripper)
    return near, near_unknown, far, far_unknown, numbers, measures


def load_hold_network(path: Path) -> HoldNetwork:
    """The network with the weights of a file.

    Raises:
        WeightsError: the file is missing, unreadable or of another network.
    """
    network = HoldNetwork()
    network.load_state_dict(read_state(path, network))
    return network


def load_hold(path: Path, gripper: GripperDescription) -> HoldProbability:
    """The probability that grasps of a hand hold, by the weights of a file.

    Raises:
        WeightsError: see `load_hold_network`.
    """
    return probability_by(load_hold_network(path), gripper)


def shipped_hold(gripper: GripperDescription, *, tilted: bool = False) -> HoldProbability | None:
    """The same by the shipped weights; None for a hand that they were not fitted to.

    Args:
        gripper: the hand.
        tilted: for tilted approaches, not from straight above.
    """
    name = "hold_tilted.safetensors" if tilted else "hold.safetensors"
    with as_file(files("perception") / "weights" / name) as path:
        if read_metadata(path).get("hand") != hand_sizes(gripper):
            return None
        return load_hold(path, gripper)


def probability_by(network: HoldNetwork, gripper: GripperDescription) -> HoldProbability:
    """A function that evaluates a network on one thread, in its fastest form."""
    fused = _fused(deepcopy(network).eval())
    fused.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def probability(patches: GraspPatches) -> Array:
        with one_thread(), torch.inference_mode():
            logits = fused(*as_tensors(patches, gripper))
            likely: Array = logits.sigmoid().numpy().astype(float)
        return likely

    return probability


def _fused(module: nn.Module) -> nn.Module:
    """Fold every batch norm into the convolution before it."""
    for name, child in module.named_children():
        setattr(module, name, _fused(child))
    if not isinstance(module, nn.Sequential):
        return module
    layers = list(module)
    for index, (convolution, norm) in enumerate(pairwise(layers)):
        if isinstance(convolution, nn.Conv2d) and isinstance(norm, nn.BatchNorm2d):
            layers[index : index + 2] = fuse_conv_bn_eval(convolution, norm), nn.Identity()
    return nn.Sequential(*layers)


def hold_measures(
    near: Tensor, far: Tensor, far_unknown: Tensor, numbers: Tensor, gripper: GripperDescription
) -> Tensor:
    """(N, MEASURES) of the order of 1, the same for a mirrored grasp; see `GraspPatches`."""
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
