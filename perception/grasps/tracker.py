"""Tracking of one grasp over frames, in odometry, until the camera is so near that it is locked.

The tracked grasp is smoothed with the candidate nearest to it, whatever its rank. The tracker
switches only to a candidate that is clearly better for several frames in a row, and not to one on
an object that the image cuts off: its visible part looks better than it is. A moving object is
expected where its velocity takes it, also once its grasp is locked.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from math import hypot, inf, isinf

import numpy as np
from pinocchio import SE3, exp3, log3

from config.arrays import Array
from config.poses import OdometryPose
from perception.detected_grasp import Detection, GraspEstimate

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
_UNSEARCHED = "no picture is searched yet"
_SLIP = 0.05  # error of odometry, as a share of a distance
_DOUBT = 0.01  # a grasp is locked by a picture in which it is known to this [m]


class GraspTracker:
    """Tracks one grasp.

    Args:
        lock_distance: distance of the camera at which the grasp is locked, once it is known whether
            it moves; infinite locks it at once [m].
    """

    def __init__(self, lock_distance: float = 0.25) -> None:
        self.lock_distance = lock_distance
        self.mTo = SE3.Identity()
        """Where the world is on the map now: failed grasps are remembered there."""
        self.reason = ""  # why the last `update` returned None
        self._rejected: deque[SE3] = deque(maxlen=_REMEMBERED)
        self.reset()

    @property
    def locked(self) -> bool:
        """Whether the tracked grasp is locked."""
        return self._locked

    def reset(self) -> None:
        """Drop the tracked grasp; failed grasps stay remembered."""
        self.reason = _UNSEARCHED
        self._tracked: GraspEstimate | None = None
        self._locked = False
        self._motion = GraspVelocity()
        self._frames_missed = 0
        self._frames_outdone = 0

    def reject(self, oTg: OdometryPose) -> None:
        """Remember a failed grasp; similar candidates are avoided."""
        self._rejected.append(self.mTo * oTg)

    def forget(self) -> None:
        """Forget the failed grasps."""
        self._rejected.clear()

    def update(
        self, detection: Detection, oTc: OdometryPose, *, age: float = 0.0, driven: float = 0.0
    ) -> GraspEstimate | None:
        """Update with the detection of a frame of a camera at `oTc`.

        What is seen stays true as far as odometry knows how the camera has moved since, and the
        velocity of the object where that is: a grasp in more doubt than `_DOUBT` is not locked.

        Args:
            detection: the grasps in the frame.
            oTc: of the camera at its capture.
            age: of the frame [s].
            driven: how far the camera has moved since [m].

        Returns:
            The tracked grasp; None if there is none, and `reason` says why.
        """
        if not self._locked:
            self._follow([g for g in detection.grasps if not self._is_rejected(g)], detection)
        if self._tracked is None:
            return None
        self.reason = ""
        seen = self._tracked.oTg_at(detection.stamp)
        distance = np.linalg.norm(seen.translation - oTc.translation)
        is_known = self._motion.is_known or isinf(self.lock_distance)
        doubt = _SLIP * driven + (_UNSTEADY * age if self._tracked.velocity.any() else 0.0)
        is_known &= doubt <= _DOUBT
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
        tracked = replace(tracked, oTg=tracked.oTg_at(detection.stamp), stamp=detection.stamp)
        near = [c for c in candidates if _close(c.oTg, tracked.oTg, *_NEAR)]
        if near:
            self._frames_missed = 0
            nearest = min(near, key=lambda c: _difference(c.oTg, tracked.oTg))
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
            is_same = self._motion.has_reached(grasp.oTg.translation[:2], grasp.stamp)
        else:
            is_same = self._motion.may_be_at(grasp.middle, grasp.stamp)
        if not is_same:
            self._motion = GraspVelocity()  # it is of another object
        velocity = self._motion(grasp.middle, grasp.stamp)
        self._tracked = replace(grasp, velocity=velocity)
        self._frames_missed = self._frames_outdone = 0

    def _is_rejected(self, grasp: GraspEstimate) -> bool:
        mTg = self.mTo * grasp.oTg
        return any(_close(mTg, failed, *_REJECTED) for failed in self._rejected)


def _blend(tracked: GraspEstimate, newest: GraspEstimate, weight: float) -> GraspEstimate:
    """The newest estimate with pose, width and quality smoothed exponentially."""
    target = _same_way_round(newest.oTg, tracked.oTg)
    start = tracked.oTg
    turn = log3(start.rotation.T @ target.rotation)
    oTg = SE3(
        start.rotation @ exp3(weight * turn),
        start.translation + weight * (target.translation - start.translation),
    )
    width = tracked.width + weight * (newest.width - tracked.width)
    quality = tracked.quality + weight * (newest.quality - tracked.quality)
    shown = tracked if newest.outline is None else newest
    outline = shown.outline
    if outline is not None:
        T = oTg.actInv(shown.oTg)
        outline = outline @ T.rotation.T + T.translation
    return replace(newest, oTg=oTg, width=width, quality=quality, outline=outline)


def _same_way_round(oTg: OdometryPose, reference: SE3) -> SE3:
    """A grasp or its equivalent with the fingers exchanged, whichever is turned less."""
    exchanged = oTg * _HALF_TURN
    return min((oTg, exchanged), key=lambda pose: _turn(pose, reference))


def _turn(a: SE3, b: SE3) -> float:
    return float(np.linalg.norm(log3(a.rotation.T @ b.rotation)))


def _close(a: SE3, b: SE3, distance: float, angle: float) -> bool:
    """Whether two grasps are about the same, at any depth along the approach of b."""
    apart, approach = a.translation - b.translation, b.rotation[:, 2]
    across = np.linalg.norm(apart - approach * (approach @ apart))
    return bool(across <= distance) and _turn(_same_way_round(a, b), b) <= angle


def _difference(a: SE3, b: SE3) -> float:
    """Distance of two grasps, turns included [m]."""
    apart = float(np.linalg.norm(a.translation - b.translation))
    return apart + _TURN_WEIGHT * _turn(_same_way_round(a, b), b)


_WINDOW = 0.6  # of the fit [s]
_LEAST_TIME, _LEAST_FRAMES = 0.1, 5  # of observation until the velocity is known [s] ...
_PATIENCE = 0.2  # ... or until it counts as standing still [s]
_LEAST_SPEED = 0.05  # slower objects stand still [m/s]
_STRAIGHTNESS = 0.1  # largest rms scatter about the line, as a share of its length
_JUMP = 0.02  # a middle is that of another object if it came farther than this [m] ...
_FASTEST = 0.3  # ... and farther than at this speed [m/s]
_ASTRAY = 0.01  # largest distance of a middle from the line [m] ...
_UNSTEADY = 0.03  # ... plus this change of speed: the image shows only a part [m/s]
_REACH = 0.08  # largest distance of a grasp on the object from its middle [m]


class GraspVelocity:
    """The horizontal velocity of one grasp."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, float, float]] = deque()
        self._since = inf
        self._velocity = np.zeros(3)
        self._line: tuple[Array, Array] | None = None  # mean of (stamp, x, y), and rate
        self._astray = 0
        self.is_known = False  # whether it was seen for long enough

    def __call__(self, middle: tuple[float, float] | None, stamp: float) -> Array:
        """Velocity (3,) after one more frame [m/s]; zeros if it stands still.

        `middle` is x, y of the object in odometry [m]; None if it is not seen.
        """
        seen = self._seen
        self._since = min(self._since, stamp)
        rests = middle is None or not seen or self._is_at_rest(middle, stamp)
        self.is_known = self.is_known or (rests and stamp - self._since >= _PATIENCE)
        if middle is None or not self.may_be_at(middle, stamp):
            return self._velocity
        if self._is_astray(middle, stamp):
            self._astray += 1
            if self._astray < _LEAST_FRAMES:
                return self._velocity
            seen.clear()
            self._line = None
        self._astray = 0
        seen.append((stamp, *middle))
        while stamp - seen[0][0] > _WINDOW and len(seen) > _LEAST_FRAMES:
            seen.popleft()
        time = stamp - seen[0][0]
        if len(seen) < _LEAST_FRAMES or time < _LEAST_TIME:
            return self._velocity
        self.is_known = True
        mean = np.mean(seen, axis=0)
        table = np.array(seen) - mean
        times, places = table[:, 0], table[:, 1:]
        rate = times @ places / (times @ times)
        self._line = mean, rate
        speed = np.linalg.norm(rate)
        scatter = np.sqrt(np.mean(np.sum((places - np.outer(times, rate)) ** 2, axis=1)))
        moves = speed >= _LEAST_SPEED and scatter <= _STRAIGHTNESS * speed * time
        self._velocity = np.array([*rate, 0.0]) if moves else np.zeros(3)
        return self._velocity

    def _is_at_rest(self, middle: tuple[float, float], stamp: float) -> bool:
        """Whether a middle is where it was first seen of late."""
        then, x, y = self._seen[0]
        return hypot(middle[0] - x, middle[1] - y) < max(_LEAST_SPEED * (stamp - then), _ASTRAY)

    def may_be_at(self, middle: tuple[float, float], stamp: float) -> bool:
        """Whether the object can have come there since it was seen last."""
        if not self._seen:
            return True
        then, x, y = self._seen[-1]
        return hypot(middle[0] - x, middle[1] - y) <= _JUMP + _FASTEST * (stamp - then)

    def has_reached(self, place: Array, stamp: float) -> bool:
        """Whether the moving object has come to a grasp at (2,) x, y without a visible middle."""
        if self._line is None or not self._velocity.any():
            return False
        return bool(np.linalg.norm(self._expected(stamp) - place) <= _REACH)

    def _expected(self, stamp: float) -> Array:
        """(2,) the middle by the line [m]."""
        assert self._line is not None
        mean, rate = self._line
        there: Array = mean[1:] + rate * (stamp - mean[0])
        return there

    def _is_astray(self, middle: tuple[float, float], stamp: float) -> bool:
        """Whether a middle is too far from the line."""
        if self._line is None or not self._seen:
            return False
        since = stamp - self._seen[-1][0]
        away = np.linalg.norm(self._expected(stamp) - middle)
        return bool(away > _ASTRAY + _UNSTEADY * since)
