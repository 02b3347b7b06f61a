"""Following one grasp from frame to frame, in the world, until it is so near that it is fixed.

Three states: nothing followed, following, locked. While following, the grasp is smoothed with the
candidate nearest to it, wherever that is in the ranking, so that a better looking one elsewhere
does not pull the hand to and fro; only one that is clearly better for several frames in a row does.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pinocchio import SE3, exp3, log3

from perception.grasp import Detection, GraspEstimate

NEAR_DISTANCE = 0.03
"""A candidate this near to the followed grasp ... [m]"""
NEAR_ANGLE = np.radians(30.0)
"""... and turned by no more than this is the same grasp [rad]."""
SMOOTHING = 0.4
"""Share of the newest frame in the followed grasp."""
LOST_AFTER = 8
"""Frames without a near candidate after which the grasp is lost."""
CLEARLY_BETTER = 1.4
"""Another grasp has to be so many times as good as the followed one ..."""
SWITCH_AFTER = 4
"""... for so many frames in a row to be followed instead."""
REJECTED_DISTANCE = 0.015
"""A candidate this near to a grasp that failed ... [m]"""
REJECTED_ANGLE = np.radians(20.0)
"""... and turned by no more than this is avoided [rad]."""
REMEMBERED = 32
"""How many failed grasps are remembered."""

_HALF_TURN = SE3(np.diag([-1.0, -1.0, 1.0]), np.zeros(3))


class GraspTracker:
    """Follows one grasp.

    Args:
        lock_distance: once the camera is nearer to the grasp than this, it stays as it is [m].
    """

    def __init__(self, lock_distance: float = 0.25) -> None:
        self.lock_distance = lock_distance
        self.reason = ""
        """Why the last `update` gave nothing; empty when it gave a grasp."""
        self._rejected: deque[SE3] = deque(maxlen=REMEMBERED)
        self.reset()

    @property
    def locked(self) -> bool:
        """Whether the followed grasp is fixed."""
        return self._locked

    def reset(self) -> None:
        """Follow nothing; failed grasps stay remembered."""
        self._followed: GraspEstimate | None = None
        self._locked = False
        self._unseen = 0
        self._outdone = 0

    def reject(self, wTg: SE3) -> None:
        """Remember a grasp that failed; candidates like it are avoided from now on."""
        self._rejected.append(wTg)

    def forget(self) -> None:
        """Forget the failed grasps."""
        self._rejected.clear()

    def update(self, detection: Detection, wTc: SE3) -> GraspEstimate | None:
        """Take in one frame.

        Args:
            detection: what was found in it.
            wTc: camera in the world when it was captured.

        Returns:
            The followed grasp, or None, and then `reason` says why.
        """
        if not self._locked:
            self._follow([g for g in detection.grasps if not self._is_rejected(g)], detection)
        if self._followed is None:
            return None
        self.reason = ""
        distance = np.linalg.norm(self._followed.wTg.translation - wTc.translation)
        self._locked = self._locked or bool(distance < self.lock_distance)
        return self._followed

    def _follow(self, candidates: Sequence[GraspEstimate], detection: Detection) -> None:
        if self._followed is None:
            if candidates:
                self._adopt(candidates[0])
            else:
                self.reason = detection.reason or "all grasps in sight have failed before"
            return
        followed = self._followed
        near = [c for c in candidates if _alike(c.wTg, followed.wTg, NEAR_DISTANCE, NEAR_ANGLE)]
        if near:
            self._unseen = 0
            self._followed = followed = _blend(
                followed, min(near, key=lambda c: _difference(c.wTg, followed.wTg))
            )
        else:
            self._unseen += 1
            if self._unseen >= LOST_AFTER:
                self.reset()
                self.reason = f"the grasp was not seen again in {LOST_AFTER} frames"
                return
        best = candidates[0] if candidates else None
        if best is None or best in near or best.quality < CLEARLY_BETTER * followed.quality:
            self._outdone = 0
            return
        self._outdone += 1
        if self._outdone >= SWITCH_AFTER:
            self._adopt(best)

    def _adopt(self, grasp: GraspEstimate) -> None:
        self.reset()
        self._followed = grasp

    def _is_rejected(self, grasp: GraspEstimate) -> bool:
        return any(
            _alike(grasp.wTg, failed, REJECTED_DISTANCE, REJECTED_ANGLE)
            for failed in self._rejected
        )


def _blend(followed: GraspEstimate, newest: GraspEstimate) -> GraspEstimate:
    """The newest estimate, its pose and width drawn towards the followed one's."""
    target = _same_way_round(newest.wTg, followed.wTg)
    start = followed.wTg
    turn = log3(start.rotation.T @ target.rotation)
    wTg = SE3(
        start.rotation @ exp3(SMOOTHING * turn),
        start.translation + SMOOTHING * (target.translation - start.translation),
    )
    width = followed.width + SMOOTHING * (newest.width - followed.width)
    quality = followed.quality + SMOOTHING * (newest.quality - followed.quality)
    return replace(newest, wTg=wTg, width=width, quality=quality)


def _same_way_round(wTg: SE3, reference: SE3) -> SE3:
    """A grasp, or the equal one with its fingers exchanged: whichever is turned less."""
    exchanged = wTg * _HALF_TURN
    return min((wTg, exchanged), key=lambda pose: _turn(pose, reference))


def _turn(a: SE3, b: SE3) -> float:
    return float(np.linalg.norm(log3(a.rotation.T @ b.rotation)))


def _alike(a: SE3, b: SE3, distance: float, angle: float) -> bool:
    apart = np.linalg.norm((a.translation - b.translation)[:2])
    return bool(apart <= distance) and _turn(_same_way_round(a, b), b) <= angle


def _difference(a: SE3, b: SE3) -> float:
    """How unlike two grasps are; a right angle counts as 0.1 m."""
    apart = float(np.linalg.norm(a.translation - b.translation))
    return apart + 0.2 / np.pi * _turn(_same_way_round(a, b), b)
