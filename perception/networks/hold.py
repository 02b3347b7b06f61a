"""The hold network: how likely a grasp holds, from the height patches around it.

It learns from grasps that were executed in physics (`frankie-task grasp outcomes`): 1 for those
that held to the end of the shaking without a hard contact.
"""

from __future__ import annotations

from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from perception.frame import Array
from perception.grasps.hand_geometry import hand_sizes
from perception.grasps.patches import (
    FAR_SHAPE,
    NEAR_SHAPE,
    NUMBERS,
    GraspPatches,
    HoldProbability,
)
from perception.networks.hold_measures import MEASURES, hold_measures
from perception.networks.proposer import fused_form, one_thread
from perception.networks.weights import read_metadata, read_state
from robots import GripperDescription

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


def load_hold(path: Path, gripper: GripperDescription) -> HoldProbability:
    """The probability that grasps of a hand hold, by the weights of a file.

    Raises:
        WeightsError: the file is missing, unreadable or of another network.
    """
    network = HoldNetwork()
    network.load_state_dict(read_state(path, network))
    return probability_by(network, gripper)


def shipped_hold(gripper: GripperDescription) -> HoldProbability | None:
    """The same by the shipped weights; None for a hand that they were not fitted to."""
    with as_file(files("perception") / "weights" / "hold.safetensors") as path:
        if read_metadata(path).get("hand") != hand_sizes(gripper):
            return None
        return load_hold(path, gripper)


def probability_by(network: HoldNetwork, gripper: GripperDescription) -> HoldProbability:
    """A function that evaluates a network on one thread, in its fastest form."""
    fused = fused_form(network)

    def probability(patches: GraspPatches) -> Array:
        with one_thread(), torch.inference_mode():
            logits = fused(*as_tensors(patches, gripper))
            likely: Array = logits.sigmoid().numpy().astype(float)
        return likely

    return probability
