"""Least squares over poses, the uncertainty of the result, and a check with held-out views."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from scipy.optimize import least_squares

from config.arrays import Array

View = TypeVar("View")
Poses = tuple[SE3, ...]
Residuals = Callable[[Poses, Sequence[View]], Array]  # (N, M) residuals of poses on N views


_STEPS = 60
_HELD, _FEWEST_HELD = 0.25, 3  # share of the views that are held out, and their least number
_SINGULAR = 1e10  # condition of a normal matrix that leaves poses undetermined


@dataclass(frozen=True)
class Spread:
    """Distance of poses."""

    mm: float
    deg: float


def difference(one: SE3, other: SE3) -> Spread:
    """Distance of two poses."""
    apart = float(np.linalg.norm(one.translation - other.translation))
    turned = float(np.linalg.norm(pin.log3(one.rotation.T @ other.rotation)))
    return Spread(1e3 * apart, float(np.rad2deg(turned)))


class Problem(Generic[View]):
    """Poses with the smallest residuals, by robust least squares.

    `free` tells for each pose which of its six freedoms (x, y, z, rotations) are estimated;
    residuals larger than `scale` count less.
    """

    def __init__(
        self, residuals: Residuals[View], free: Sequence[Sequence[int]], scale: float
    ) -> None:
        self._residuals, self._free, self._scale = residuals, free, scale

    def solve(self, start: Poses, views: Sequence[View]) -> Poses:
        """The best poses from a start."""
        return self._moved(start, self._minimised(start, views).x)

    def _minimised(self, start: Poses, views: Sequence[View]) -> Any:
        """SciPy's result; its unknowns are the motions of the poses, each in its own frame."""
        return least_squares(
            lambda x: self._residuals(self._moved(start, x), views).ravel(),
            np.zeros(sum(map(len, self._free))),
            loss="soft_l1",
            f_scale=self._scale,
            x_scale="jac",
            max_nfev=_STEPS,
        )

    def solve_checked(
        self,
        start: Callable[[Sequence[View]], Poses],
        views: Sequence[View],
        check: Callable[[Poses, Sequence[View]], list[Spread]],
    ) -> tuple[Poses, list[Spread]]:
        """The best poses, and the errors of views that were held out of a first fit."""
        used, held = ([views[k] for k in part] for part in split(len(views)))
        poses = self.solve(start(used), used)
        return self.solve(poses, views), check(poses, held)

    def rms(self, poses: Poses, views: Sequence[View]) -> float:
        """Root mean square of the residuals, each a point in the plane or in space."""
        residuals = self._residuals(poses, views)
        return float(np.sqrt((residuals**2).sum(-1).mean()))

    def uncertainty(self, poses: Poses, views: Sequence[View]) -> Spread:
        """Standard error of the first pose: the larger of two estimates.

        The jackknife, which leaves out one view at a time, accounts for correlated errors within a
        view. The curvature of the cost accounts for what the views do not determine at all.
        """
        jacobian = self._minimised(poses, views).jac
        normal = jacobian.T @ jacobian
        if np.linalg.cond(normal) > _SINGULAR:
            return Spread(float("inf"), float("inf"))
        others = [
            self.solve(poses, [one for one in views if one is not left_out])[0]
            for left_out in views
        ]
        first, count = poses[0], len(views)
        shifts = [first.rotation.T @ (one.translation - first.translation) for one in others]
        turns = [pin.log3(first.rotation.T @ one.rotation) for one in others]
        deviations = np.column_stack([shifts, turns])
        left_out = (count - 1) / count * ((deviations - deviations.mean(0)) ** 2).sum(0)
        variance = 0.5 * self.rms(poses, views) ** 2
        error = np.maximum(left_out, variance * np.diag(np.linalg.inv(normal))[:6])
        shift, turn = np.sqrt(error[:3].sum()), np.sqrt(error[3:].sum())
        return Spread(float(1e3 * shift), float(np.rad2deg(turn)))

    def _moved(self, start: Poses, x: Array) -> Poses:
        """Poses after small motions, each in its own frame."""
        moved, at = [], 0
        for pose, free in zip(start, self._free, strict=True):
            motion = np.zeros(6)
            motion[list(free)] = x[at : at + len(free)]
            at += len(free)
            moved.append(pose * SE3(pin.exp3(motion[3:]), motion[:3]))
        return tuple(moved)


def split(count: int) -> tuple[list[int], list[int]]:
    """Views to use, and views to hold out, spread evenly."""
    held = max(_FEWEST_HELD, round(_HELD * count))
    out = sorted({int((k + 0.5) * count / held) for k in range(held)})
    return [k for k in range(count) if k not in out], out
