"""How the arm is carried on a way on which the posture of the stance would hit something.

The base finds its way by itself; the arm may reach out farther than a passage is wide. Where it
would hit something, as far as it will have come to the posture of its stance, it is carried as it
is when it is ready, the hand over the front of the base, until the last such place is passed and
there is room to unfold. The way is looked at from its end, a pose in every period.
"""

from __future__ import annotations

import numpy as np

from controller.command import Array
from controller.floor import Pose2D, wrap
from controller.model import RobotModel
from controller.stance.docking import PARTS, ROOM, YIELD, carried, unfolds
from controller.stance.free_space import FreeSpace, se3_of
from controller.stance.stance import Stance

_SPACING = 0.15
"""Between the poses that are looked at [m] ..."""
_TURN = 0.3
"""... or so much turned [rad]."""
_UNFOLDING_ROOM = 0.02
"""What an arm that unfolds needs, unless it has less [m]."""
_RADIAN = 0.4
"""What a turn counts like, to tell how far the base has come [m]."""


class TransportPosture:
    """Tells where on one way after the other the arm is to be carried.

    Args:
        model: the robot.
        pace: share of the base's time that the arm takes.
    """

    def __init__(self, model: RobotModel, pace: float) -> None:
        self._pace = pace
        self._ready = model.description.arm.ready
        self.reset()

    def reset(self) -> None:
        """Forget the way."""
        self._way: Array | None = None
        self._poses = np.zeros((0, 3))
        self._room = 0.0
        """What the arm needs: as much as it has at the end, if that is less [m]."""
        self._at = 0
        self._last = -1
        """The last pose at which the arm hits something, as far as is known."""
        self._unseen = 0
        """Poses before this one were not looked at yet."""
        self._carries = False
        self._free = False
        """Whether all the way was found free for an arm that unfolds from now on."""

    def posture(
        self,
        space: FreeSpace | None,
        way: Array,
        wTb: Pose2D,
        q: Array,
        stance: Stance,
        times: tuple[float, float],
        *,
        waits: bool = False,
    ) -> Array | None:
        """The posture (7,) to carry the arm in now; None if it may take that of the stance.

        Args:
            space: what stands around; None on an open floor.
            way: (N, 3) poses of the base; the same object as long as it is the same.
            wTb: base pose.
            q: (7,) joint positions [rad].
            stance: where the way leads.
            times: that base and arm take at least, to there [s].
            waits: at the end of the way, too, the arm does not unfold without room.
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
        self._advance(wTb)
        self._look_on(space, q, aim, times)
        if self._last > self._at:
            self._carries = True
        elif self._carries:
            ends = self._at + 1 == len(self._poses) and not waits
            now = space.nearest(se3_of(wTb), q, PARTS, _UNFOLDING_ROOM).distance
            free = ends or self._free or unfolds(space, wTb, q, aim, now - YIELD)
            self._carries = not free
        return carried(self._ready, aim) if self._carries else None

    def _look_on(self, space: FreeSpace, q: Array, aim: Array, times: tuple[float, float]) -> None:
        """Look at one more pose of the way, from its end, again and again while it carries.

        The farther the base has come, the less the arm will have unfolded where something is.
        """
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
        """Share of the arm's way to its posture that is left when the base is at a pose.

        It hurries as `bias_towards` has it: by a share of the time that the base has left.
        """
        end = len(self._poses) - 1
        left = (end - number) / max(1, end - self._at)
        passed = (1.0 - left) * base_time
        at_most = passed / arm_time if arm_time > 0.0 else 1.0
        late: float = left ** (1.0 / self._pace)
        return max(late, 1.0 - at_most)

    def _distance(self, space: FreeSpace, number: int, q: Array) -> float:
        """From the arm to what is around, the base at a pose of the way; at most `ROOM`."""
        pose = Pose2D(*self._poses[number].tolist())
        return space.nearest(se3_of(pose), q, PARTS, ROOM).distance

    def _advance(self, wTb: Pose2D) -> None:
        """Note how far the base has come."""
        poses = self._poses
        while self._at + 1 < len(poses):
            here, there = (
                np.hypot(pose[0] - wTb.x, pose[1] - wTb.y)
                + _RADIAN * abs(wrap(float(pose[2]) - wTb.heading))
                for pose in poses[self._at : self._at + 2]
            )
            if there > here:
                return
            self._at += 1


def thinned(way: Array) -> Array:
    """Poses (M, 3) of a way (N, 3), no nearer to each other than is looked at, and its last."""
    kept = [way[0]]
    for pose in way[1:]:
        moved = np.hypot(*(pose[:2] - kept[-1][:2]))
        turned = abs(wrap(float(pose[2] - kept[-1][2])))
        steps = int(turned // _TURN)
        if moved < _SPACING and steps == 0:
            continue
        turn = wrap(float(pose[2] - kept[-1][2]))
        before = kept[-1]
        for k in range(1, steps + 1):  # turns on the spot between two pieces of the way
            share = k / (steps + 1)
            middle = before + share * np.array([*(pose[:2] - before[:2]), turn])
            kept.append(middle)
        kept.append(pose)
    return np.array([*kept, way[-1]])
