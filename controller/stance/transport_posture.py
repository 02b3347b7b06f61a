"""Transport posture: how the arm is carried where its motion to the stance would hit an obstacle.

The arm may reach out farther than a passage of the base is wide. Where it would hit an obstacle on
its motion to the posture of the stance, it is carried in the ready posture until the last such
place is passed and there is room to unfold. The path is checked from its end, a pose in every
period.
"""

import numpy as np

from config.arrays import Array
from config.planar import Pose2D, difference, wrap
from controller.model import RobotModel
from controller.stance.docking import ROOM, YIELD, transport_posture, unfolds
from controller.stance.free_space import FreeSpace
from controller.stance.stance import Stance

_SPACING = 0.15  # largest distance of poses that are checked [m] ...
_TURN = 0.3  # ... and largest turn between them [rad]
_UNFOLDING_ROOM = 0.02  # clearance of an arm that unfolds, unless it has less [m]
_RADIAN = 0.4  # distance equivalent to a radian, to measure the progress of the base [m]


class TransportPosture:
    """Decides on successive paths where the arm needs its transport posture.

    `pace` is the share of the base's time that the arm takes.
    """

    def __init__(self, model: RobotModel, pace: float) -> None:
        self._pace = pace
        self._ready = model.description.arm.ready
        self.reset()

    def reset(self) -> None:
        """Forget the path."""
        self._way: Array | None = None
        self._poses = np.zeros((0, 3))
        self._room = 0.0  # clearance of the arm at the end of the path, at most `ROOM` [m]
        self._at = 0
        self._last = -1  # the last pose at which the arm is known to hit an obstacle
        self._unseen = 0  # poses before this one were not checked yet
        self._carries = False
        self._free = False  # whether the whole path is free for an arm that unfolds from now on

    def posture(
        self,
        space: FreeSpace | None,
        way: Array,
        mTb: Pose2D,
        q: Array,
        stance: Stance,
        times: tuple[float, float],
        *,
        waits: bool = False,
    ) -> Array | None:
        """The transport posture (j,) where the arm needs it now, else None.

        `way` are (N, 3) base poses of the path, the same object as long as it is the same; `q` are
        (j,) joint positions [rad], `times` the least times of base and arm to the stance [s]. With
        `waits` it does not unfold without room, even at the end of the path.
        """
        if space is None or not len(way):
            return None
        aim = stance.q
        if way is not self._way:
            carries = self._carries
            self.reset()
            self._way, self._poses, self._carries = way, thinned(way), carries
            self._unseen = len(self._poses) - 1
            self._room = self._distance(space, self._unseen, aim) - YIELD
        self._advance(mTb)
        self._check_next(space, q, aim, times)
        if self._last > self._at:
            self._carries = True
        elif self._carries:
            ends = self._at + 1 == len(self._poses) and not waits
            now = space.room(mTb, q, _UNFOLDING_ROOM)
            free = ends or self._free or unfolds(space, mTb, q, aim, now - YIELD)
            self._carries = not free
        return transport_posture(self._ready, aim) if self._carries else None

    def _check_next(
        self, space: FreeSpace, q: Array, aim: Array, times: tuple[float, float]
    ) -> None:
        """Check one more pose of the path, from its end; repeatedly while the arm is carried."""
        end = len(self._poses) - 1
        if self._unseen <= self._at:
            if not self._carries:
                return
            self._unseen = end + 1
        self._unseen -= 1
        there = aim + self._late(self._unseen, *times) * (q - aim)
        if self._unseen == end:
            base, room = Pose2D(*self._poses[end].tolist()), min(self._room, _UNFOLDING_ROOM)
            hits = not unfolds(space, base, there, aim, room)
        else:
            hits = self._distance(space, self._unseen, there) < self._room
        if hits:
            self._last, self._unseen, self._free = self._unseen, self._at, False
        elif self._unseen <= self._at:
            self._last, self._free = -1, True

    def _late(self, number: int, base_time: float, arm_time: float) -> float:
        """Remaining share of the arm's motion when the base is at a pose; see `Approach.bias`."""
        end = len(self._poses) - 1
        left = (end - number) / max(1, end - self._at)
        passed = (1.0 - left) * base_time
        at_most = passed / arm_time if arm_time > 0.0 else 1.0
        late: float = left ** (1.0 / self._pace)
        return max(late, 1.0 - at_most)

    def _distance(self, space: FreeSpace, number: int, q: Array) -> float:
        """Distance of the arm to obstacles at a pose of the path, at most `ROOM` [m]."""
        return space.room(Pose2D(*self._poses[number].tolist()), q, ROOM)

    def _advance(self, mTb: Pose2D) -> None:
        """Update the index of the pose that the base has reached."""
        dx, dy, turn = (self._poses[self._at :] - mTb).T
        away = np.hypot(dx, dy) + _RADIAN * np.abs(wrap(turn))
        farther = np.flatnonzero(np.diff(away) > 0.0)
        self._at += int(farther[0]) if len(farther) else len(away) - 1


def thinned(way: Array) -> Array:
    """Poses (M, 3) of a path (N, 3) at the spacing of the checks, and its last one."""
    kept = [way[0]]
    for pose in way[1:]:
        before, off = kept[-1], difference(pose, kept[-1])
        turns = int(abs(off[2]) // _TURN)  # on the spot
        if turns or np.hypot(off[0], off[1]) >= _SPACING:
            shares = np.arange(1, turns + 1)[:, None] / (turns + 1)
            kept += [*(before + shares * off), pose]
    return np.array([*kept, way[-1]])
