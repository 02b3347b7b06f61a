"""Tracking of one grasp over frames, in the world, until the camera is so near that it is locked.

The tracked grasp is smoothed with the candidate nearest to it, whatever its rank. The tracker
switches only to a candidate that is clearly better for several frames in a row, and not to one on
an object that the image cuts off: its visible part looks better than it is. A moving object is
expected where its velocity takes it, also once its grasp is locked.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from math import isinf

import numpy as np
from pinocchio import SE3, exp3, log3

from perception.grasp import Detection, GraspEstimate
from perception.grasps.velocity import GraspVelocity

LOST_AFTER = 15  # frames in a row without a candidate that is the tracked grasp
SWITCH_AFTER = 4  # frames in a row with a better candidate
_NEAR = 0.03, float(np.radians(30.0))  # largest distance of such a candidate [m, rad]
_REJECTED = 0.015, float(np.radians(20.0))  # largest distance to a failed grasp [m, rad]
_SMOOTHING = 0.4  # weight of the newest frame, 0 to 1
_SWITCH_RATIO = 1.4  # of the quality of a better candidate to the tracked, or ...
_SWITCH_ODDS = 2.5  # ... of the odds to hold, e.g. 0.93 to 0.84
_REMEMBERED = 32  # failed grasps
_TURN_WEIGHT = 0.2 / np.pi  # a right angle counts as much as a distance of 0.1 m [m/rad]
_HALF_TURN = SE3(np.diag([-1.0, -1.0, 1.0]), np.zeros(3))


class GraspTracker:
    """Tracks one grasp.

    Args:
        lock_distance: distance of the camera at which the grasp is locked, once it is known whether
            it moves; infinite locks it at once [m].
    """

    def __init__(self, lock_distance: float = 0.25) -> None:
        self.lock_distance = lock_distance
        self.reason = ""  # why the last `update` returned None
        self._rejected: deque[SE3] = deque(maxlen=_REMEMBERED)
        self.reset()

    @property
    def locked(self) -> bool:
        """Whether the tracked grasp is locked."""
        return self._locked

    def reset(self) -> None:
        """Drop the tracked grasp; failed grasps stay remembered."""
        self._tracked: GraspEstimate | None = None
        self._locked = False
        self._motion = GraspVelocity()
        self._frames_missed = 0
        self._frames_outdone = 0

    def reject(self, wTg: SE3) -> None:
        """Remember a failed grasp; similar candidates are avoided."""
        self._rejected.append(wTg)

    def forget(self) -> None:
        """Forget the failed grasps."""
        self._rejected.clear()

    def update(self, detection: Detection, wTc: SE3) -> GraspEstimate | None:
        """Update with the detection of a frame of a camera at `wTc`.

        Returns:
            The tracked grasp; None if there is none, and `reason` says why.
        """
        if not self._locked:
            self._follow([g for g in detection.grasps if not self._is_rejected(g)], detection)
        if self._tracked is None:
            return None
        self.reason = ""
        seen = self._tracked.wTg_at(detection.stamp)
        distance = np.linalg.norm(seen.translation - wTc.translation)
        is_known = self._motion.is_known or isinf(self.lock_distance)
        self._locked = self._locked or (is_known and bool(distance < self.lock_distance))
        return self._tracked

    def _follow(self, candidates: Sequence[GraspEstimate], detection: Detection) -> None:
        if self._tracked is None:
            if candidates:
                self._track(candidates[0])
            else:
                self.reason = detection.reason or "all grasps in sight have failed before"
            return
        tracked = self._tracked
        tracked = replace(tracked, wTg=tracked.wTg_at(detection.stamp), stamp=detection.stamp)
        near = [c for c in candidates if _close(c.wTg, tracked.wTg, *_NEAR)]
        if near:
            self._frames_missed = 0
            nearest = min(near, key=lambda c: _difference(c.wTg, tracked.wTg))
            velocity = self._motion(nearest.middle, nearest.stamp)
            tracked = replace(_blend(tracked, nearest, _SMOOTHING), velocity=velocity)
            self._tracked = tracked
        else:
            self._frames_missed += 1
            if self._frames_missed >= LOST_AFTER:
                motion = self._motion
                self.reset()
                if tracked.velocity.any():  # it goes on while it is not seen
                    self._motion = motion
                self.reason = f"the grasp was not seen again in {LOST_AFTER} frames"
                return
        best = next((c for c in candidates if c.whole), None)
        if best is None or best in near or not self._is_better(best.quality, tracked.quality):
            self._frames_outdone = 0
            return
        self._frames_outdone += 1
        if self._frames_outdone >= SWITCH_AFTER:
            self._track(best)

    def _is_better(self, quality: float, than: float) -> bool:
        odds = quality * (1.0 - than) >= _SWITCH_ODDS * than * (1.0 - quality)
        return quality >= _SWITCH_RATIO * than or odds

    def _track(self, grasp: GraspEstimate) -> None:
        if grasp.middle is None:
            is_same = self._motion.has_reached(grasp.wTg.translation[:2], grasp.stamp)
        else:
            is_same = self._motion.may_be_at(grasp.middle, grasp.stamp)
        if not is_same:
            self._motion = GraspVelocity()  # it is of another object
        velocity = self._motion(grasp.middle, grasp.stamp)
        self._tracked = replace(grasp, velocity=velocity)
        self._frames_missed = self._frames_outdone = 0

    def _is_rejected(self, grasp: GraspEstimate) -> bool:
        return any(_close(grasp.wTg, failed, *_REJECTED) for failed in self._rejected)


def _blend(tracked: GraspEstimate, newest: GraspEstimate, weight: float) -> GraspEstimate:
    """The newest estimate with pose, width and quality smoothed exponentially."""
    target = _same_way_round(newest.wTg, tracked.wTg)
    start = tracked.wTg
    turn = log3(start.rotation.T @ target.rotation)
    wTg = SE3(
        start.rotation @ exp3(weight * turn),
        start.translation + weight * (target.translation - start.translation),
    )
    width = tracked.width + weight * (newest.width - tracked.width)
    quality = tracked.quality + weight * (newest.quality - tracked.quality)
    return replace(newest, wTg=wTg, width=width, quality=quality)


def _same_way_round(wTg: SE3, reference: SE3) -> SE3:
    """A grasp or its equivalent with the fingers exchanged, whichever is turned less."""
    exchanged = wTg * _HALF_TURN
    return min((wTg, exchanged), key=lambda pose: _turn(pose, reference))


def _turn(a: SE3, b: SE3) -> float:
    return float(np.linalg.norm(log3(a.rotation.T @ b.rotation)))


def _close(a: SE3, b: SE3, distance: float, angle: float) -> bool:
    apart = np.linalg.norm((a.translation - b.translation)[:2])
    return bool(apart <= distance) and _turn(_same_way_round(a, b), b) <= angle


def _difference(a: SE3, b: SE3) -> float:
    """Distance of two grasps, turns included [m]."""
    apart = float(np.linalg.norm(a.translation - b.translation))
    return apart + _TURN_WEIGHT * _turn(_same_way_round(a, b), b)
