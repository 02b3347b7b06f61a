"""Plausibility checks of depth frames: shape, type, scale, pose, stamp and picture.

A message names the mistake and its probable cause, in one line without changing numbers.
"""

from math import inf, isfinite

import numpy as np

from perception.frame import Frame
from perception.geometry import FloatArray, world_maps

_EVERY = 16  # scale and picture are judged by every n-th row and column [px]
_NEAREST, _FARTHEST = 0.1, 20.0  # range of a wrist camera in the middle of an image [m]
_BELOW_FLOOR = 0.3  # nothing is lower than this in a world whose floor is at 0 [m]
_MOST = 0.5  # share of the pixels that neither noise nor holes explain
_STILL, _STILL_TURN = 0.5e-3, 2e-3  # a camera that moves less stands still [m, rad]
_MOVED, _TURNED = 3e-3, 0.01  # a camera that moves more sees another picture [m, rad]
_NOISY = 0.3  # share of the pixels that noise alone changes between images
_LEVEL = 1e-3  # largest height difference in a picture of a level plane [m]


def frame_problem(frame: Frame) -> str:
    """What is wrong with a frame by itself, and its probable cause; empty if nothing is.

    Mirrored images, a depth of half or twice its scale, and a wrong pose cannot be detected.
    """
    depth, camera = np.asarray(frame.depth), frame.intrinsics
    if mistake := _mistake_in_shape(depth.shape, (camera.height, camera.width)):
        return mistake
    if not np.issubdtype(depth.dtype, np.floating):
        hint = ": is it in millimetres?" if np.issubdtype(depth.dtype, np.integer) else ""
        return f"the depth image holds {depth.dtype}, not metres as floating-point numbers{hint}"
    if not np.isfinite(frame.oTc.homogeneous).all():
        return "the camera's pose is not finite"
    if not isfinite(frame.stamp):
        return "the frame's stamp is not finite"
    seen = _sample(depth)
    middle = np.median(seen) if len(seen := seen[(seen > 0.0) & (seen < inf)]) else 1.0
    if middle > _FARTHEST:
        return "the depth is far beyond what a camera measures: millimetres given as metres?"
    if middle < _NEAREST:
        return "the depth is nearer than a camera measures: metres divided by 1000?"
    heights = _heights(frame)
    if len(heights) and np.mean(heights < -_BELOW_FLOOR) > _MOST:
        return "the depth leads below the floor: a wrong scale (0.1 mm as mm), or a wrong pose?"
    return ""


class FrameChecker:
    """Checks the frames of one camera in sequence, each once."""

    def __init__(self) -> None:
        self._stamp = -inf
        self._picture: Frame | None = None  # first frame with the newest picture
        self._is_noisy = False  # whether no two images of this camera are the same

    def mistake(self, frame: Frame) -> str:
        """Why not to trust a frame, see `frame_problem`; empty if it is trusted."""
        if mistake := frame_problem(frame):
            return mistake
        goes_back, self._stamp = frame.stamp < self._stamp, frame.stamp
        if goes_back:
            return "the frame is stamped before the one that came earlier: the camera's clock jumps"
        before = self._picture
        if before is None or not _same(before.depth, frame.depth):
            self._is_noisy = self._is_noisy or (before is not None and _is_noise(before, frame))
            self._picture = frame
            return ""
        if _moves(before, frame, _MOVED, _TURNED) and not _both_level(before, frame):
            return "the picture has not changed while the hand moved: the camera hangs"
        return "the picture does not change, not even its noise: the camera hangs" * self._is_noisy

    def relocalise(self) -> None:
        """Accept a jump of the poses while the camera has not moved."""
        if not self._is_noisy:
            self._picture = None


def _mistake_in_shape(shape: tuple[int, ...], wanted: tuple[int, int]) -> str:
    if shape == wanted:
        return ""
    hint = "was it scaled or cut without them?"
    if len(shape) == 3:
        hint = "it has channels, as an image in colour"
    elif shape == wanted[::-1]:
        hint = "is it transposed?"
    return f"the depth image has shape {shape}, not (H, W) = {wanted} of its intrinsics: {hint}"


def _same(one: FloatArray, other: FloatArray) -> bool:
    return np.array_equal(_sample(one), _sample(other), equal_nan=True) and np.array_equal(
        one, other, equal_nan=True
    )


def _is_noise(before: Frame, frame: Frame) -> bool:
    """Whether two images differ nearly everywhere though the camera has not moved."""
    if _moves(before, frame, _STILL, _STILL_TURN):
        return False
    one, other = _sample(before.depth), _sample(frame.depth)
    both = (one > 0.0) & (other > 0.0)
    return bool(both.any() and np.mean(one[both] != other[both]) > _NOISY)


def _moves(before: Frame, frame: Frame, distance: float, angle: float) -> bool:
    motion = before.oTc.actInv(frame.oTc)
    turn = np.arccos(np.clip((np.trace(motion.rotation) - 1.0) / 2.0, -1.0, 1.0))
    return bool(np.linalg.norm(motion.translation) > distance or turn > angle)


def _both_level(before: Frame, frame: Frame) -> bool:
    """Whether both show one level plane without noise, which looks the same from anywhere."""
    heights = np.concatenate([_heights(before), _heights(frame)])
    return len(heights) == 0 or bool(np.ptp(heights) < _LEVEL)


def _heights(frame: Frame) -> FloatArray:
    """(N,) heights in odometry of a sample of the pixels [m]."""
    depth = _sample(frame.depth).astype(float)
    rows, columns = (np.arange(0, side, _EVERY, dtype=float) for side in frame.depth.shape)
    u, v = columns[None, :], rows[:, None]
    (heights,) = world_maps(depth, frame.intrinsics, frame.oTc, u, v, axes=(2,))
    return heights[(depth > 0.0) & (depth < inf)]


def _sample(depth: FloatArray) -> FloatArray:
    sample: FloatArray = np.asarray(depth)[::_EVERY, ::_EVERY]
    return sample
