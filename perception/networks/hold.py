"""The hold network: how likely a grasp holds, from the height patches around it.

It learns from grasps that were executed in physics (`frankie-task grasp outcomes`): 1 for those
that held to the end of the shaking without a hard contact.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from config.arrays import Array, Image, Mask
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
from perception.networks.layers import Convolution, max_pool
from perception.networks.weights import SHIPPED, Weights, read_metadata, read_weights
from robots import GripperDescription, half_extents

Values: TypeAlias = Image | Mask
Measure: TypeAlias = Callable[[Values, Mask], Image]

_LEVELS = (-0.005, 0.0, 0.004)  # over the grasp centre, at which the pads meet the body [m]
_BODY = -0.006  # what is higher over the grasp centre than this is the body [m]
_STANDS = 0.008  # what is higher over the floor than this stands on it [m]
_CIRCLES = (0.05, 0.08)  # radii around the grasp in which that is counted [m]
_SLACK = 0.001  # between where the fingers are and where they should be [m]
_CLEARANCE, _RISE = 0.03, 0.02  # units of heights [m]
_LOWEST = -0.1  # of heights [m]
_LENGTH, _FAR_LENGTH = 0.03, 0.05  # units of the heights in both maps [m]
HOLD_NUMBERS = 30  # scalars and measures of each grasp
_EPSILON = 1e-5  # of the batch norms, as PyTorch has it


class HoldInputs(NamedTuple):
    """The input of the hold network for N grasps, all of the order of 1."""

    near: Image  # (N, 32, 48, 3) heights over the grasp, unknown, heights over the floor
    far: Image  # (N, 32, 32, 3) as `near`
    numbers: Image  # (N, HOLD_NUMBERS) the same for a mirrored grasp


class HoldNetwork:
    """Two small stacks of convolutions, one for each map, and a perceptron on both."""

    def __init__(self, weights: Weights) -> None:
        self._near, self._far = (
            [_normed_convolution(weights, f"{stack}.{2 * index}") for index in range(count)]
            for stack, count in (("near", 4), ("far", 3))
        )
        self._hidden, self._out = (
            (weights[f"head.{index}.weight"].T, weights[f"head.{index}.bias"]) for index in (1, 4)
        )

    def __call__(self, inputs: HoldInputs) -> Array:
        """(N,) how likely the grasps hold."""
        near, far = inputs.near, inputs.far
        for layer in self._near[:-1]:
            near = max_pool(layer(near))
        near = self._near[-1](near)
        for layer in self._far:
            far = max_pool(layer(far))
        count = len(inputs.numbers)
        seen = [maps.transpose(0, 3, 1, 2).reshape(count, -1) for maps in (near, far)]
        hidden = np.concatenate([*seen, inputs.numbers], axis=1) @ self._hidden[0]
        logits = np.maximum(hidden + self._hidden[1], 0.0) @ self._out[0] + self._out[1]
        likely: Array = 1.0 / (1.0 + np.exp(-logits[:, 0].astype(float)))
        return likely


def _normed_convolution(weights: Weights, name: str) -> Convolution:
    """A convolution into which the batch norm behind it is folded."""
    norm = {key: weights[f"{name}.1.{key}"] for key in ("running_mean", "weight", "bias")}
    scale = norm["weight"] / np.sqrt(weights[f"{name}.1.running_var"] + np.float32(_EPSILON))
    kernel = weights[f"{name}.0.weight"] * scale[:, None, None, None]
    return Convolution(kernel, norm["bias"] - norm["running_mean"] * scale)


def load_hold(path: Path, gripper: GripperDescription) -> HoldProbability:
    """The probability that grasps of a hand hold, by the weights of a file.

    Raises:
        WeightsError: the file is missing, unreadable or of another network.
    """
    network = HoldNetwork(read_weights(path, "hold"))
    return lambda patches: network(hold_inputs(patches, gripper))


def shipped_hold(gripper: GripperDescription, *, tilted: bool = False) -> HoldProbability | None:
    """The same by the shipped weights; None for a hand that they were not fitted to.

    Args:
        gripper: the hand.
        tilted: for tilted approaches, not from straight above.
    """
    path = SHIPPED / ("hold_tilted.safetensors" if tilted else "hold.safetensors")
    if read_metadata(path).get("hand") != hand_sizes(gripper):
        return None
    return load_hold(path, gripper)


def hold_inputs(patches: GraspPatches, gripper: GripperDescription) -> HoldInputs:
    """The input of the network for grasps of a hand."""
    near, far = (np.asarray(each, dtype=np.float32) for each in (patches.near, patches.far))
    of = dict(zip(NUMBERS, patches.numbers.T, strict=True))
    height = of["height"][:, None, None]
    near_maps = (
        np.clip(near, -0.05, 0.05) / _LENGTH,
        patches.near_unknown,
        np.clip(near + height, 0.0, 0.15) / _FAR_LENGTH,
    )
    far_maps = (
        np.clip(far, -0.1, 0.1) / _FAR_LENGTH,
        patches.far_unknown,
        np.clip(far + height, 0.0, 0.2) / _FAR_LENGTH,
    )
    measures = hold_measures(near, far, patches.far_unknown, of, gripper)
    return HoldInputs(
        np.stack(near_maps, axis=-1, dtype=np.float32),
        np.stack(far_maps, axis=-1, dtype=np.float32),
        np.stack([*_scaled(of), *measures], axis=-1, dtype=np.float32),
    )


def _scaled(of: dict[str, Image]) -> list[Image]:
    """The scalars, of the order of 1 and the same for a mirrored object; (N,) each."""
    along, across = np.abs(of["middle_along"]), np.abs(of["middle_across"])
    return [
        of["score"],
        np.sqrt(of["score"]),
        of["width"] / 0.04,
        of["opening"] / 0.08,
        of["depth"] / 0.02,
        of["height"] / 0.05,
        along / 0.05,
        across / 0.05,
        np.hypot(along, across) / 0.08,
        np.cbrt(np.maximum(of["volume"], 0.0)) / 0.05,
        of["whole"],
        of["camera_distance"] / 0.4,
        of["camera_cosine"],
    ]


def hold_measures(
    near: Image, far: Image, far_unknown: Mask, of: dict[str, Image], gripper: GripperDescription
) -> list[Image]:
    """Measures of the maps, of the order of 1 and the same for a mirrored grasp; (N,) each."""
    hand = hand_dimensions(gripper)
    half_open, half_width = (0.5 * of[name][:, None, None] for name in ("opening", "width"))
    half_finger, half_pad = hand.lines[-1], hand.lines[hand.pad_lines][-1]

    along, across = _cells(NEAR_SHAPE, NEAR_CELL)
    outwards, beside = np.abs(along) - half_open, np.abs(across)
    left_right, ends = (along < 0.0, along >= 0.0), (across > half_finger, across < -half_finger)
    pads, fingers = (
        (outwards >= -_SLACK) & (outwards <= thickness + _SLACK) & (beside <= half_finger + _SLACK)
        for thickness in (hand.pad_thickness, hand.finger_thickness)
    )
    before_pads = beside <= half_pad + 2.0 * _SLACK
    edges = before_pads & (np.abs(np.abs(along) - half_width + _SLACK) < NEAR_CELL)
    held = before_pads & (np.abs(along) <= half_width + 2.0 * _SLACK)
    between = np.abs(along) <= half_width + 4.0 * _SLACK
    measures = [
        *_both(left_right, _highest, (near + hand.tip) / _CLEARANCE, pads),
        *_both(left_right, _highest, (near - hand.finger) / _CLEARANCE, fingers),
        *_both(ends, _mean, near > _BODY, between),
        _mean(np.clip(near, -0.05, 0.05), held) / _RISE,
    ]
    for level in _LEVELS:
        measures += _both(left_right, _mean, near > level, edges)

    along, across = _cells(FAR_SHAPE, FAR_CELL)
    half_across, half_along, _ = half_extents(gripper.palm.shape)
    palm = (np.abs(along) <= half_along) & (np.abs(across) <= half_across)
    stands = far + of["height"][:, None, None] > _STANDS
    return [
        *measures,
        _highest((far - hand.palm) / _CLEARANCE, palm),
        _mean(far_unknown, palm),
        *(_mean(stands, np.hypot(along, across) < radius) for radius in _CIRCLES),
    ]


def _cells(shape: tuple[int, int], cell: float) -> tuple[Image, Image]:
    """Positions of the cells of a map along and across the closing direction [m]."""
    rows, columns = (
        (np.arange(count, dtype=np.float32) - 0.5 * (count - 1)) * cell for count in shape
    )
    return columns[None, None, :], rows[None, :, None]


def _both(
    sides: tuple[Mask, Mask], measure: Measure, values: Values, where: Mask
) -> tuple[Image, Image]:
    """A measure of some cells on either side, the larger one first."""
    one, other = (measure(values, where & side) for side in sides)
    return np.maximum(one, other), np.minimum(one, other)


def _highest(values: Values, where: Mask) -> Image:
    """(N,) the largest of some cells."""
    highest: Image = np.where(where, values, np.float32(_LOWEST / _CLEARANCE)).max(axis=(1, 2))
    return highest


def _mean(values: Values, where: Mask) -> Image:
    """(N,) the mean of some cells; 0 of none."""
    counted = np.maximum(np.count_nonzero(where, axis=(1, 2)), 1)
    mean: Image = np.sum(values * where, axis=(1, 2), dtype=np.float32) / counted
    return mean
