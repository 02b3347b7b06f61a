"""Approach of a stance: where the base is led now, and which posture the arm takes meanwhile.

Usually base and arm move to the stance together. Where the arm would hit an obstacle on the way, it
takes its transport posture; the base then drives to the dock of the stance, waits there until the
arm has unfolded, and drives straight in.
"""

from math import hypot

import numpy as np

from controller.command import Array
from controller.floor.base_drive import Pose2D
from controller.floor.floor_map import FloorMap
from controller.floor.route import Route
from controller.model import RobotModel
from controller.settings import GuidanceSettings
from controller.stance.bias import Remaining
from controller.stance.docking import moved
from controller.stance.free_space import FreeSpace
from controller.stance.stance import Stance
from controller.stance.transport_posture import TransportPosture

_AT_DOCK = 0.1  # the base drives in when nearer than this to the line from the dock [m and rad] ...
_TURNED = 1.0  # ... or, past its middle, turned by less than this [rad] ...
_UNFOLDED = 0.5  # ... and when no joint is farther than this from the posture of the stance [rad]
_PAST = 0.05  # it backs out to a dock that it has passed by more than this [m]


class Approach:
    """The approach of one robot to successive stances."""

    def __init__(self, model: RobotModel, guidance: GuidanceSettings, route: Route) -> None:
        self._model = model
        self._joint_speed = guidance.joint_speed
        self._route = route
        self._transport = TransportPosture(model, guidance.posture_time)
        self.reset()

    def reset(self) -> None:
        """Forget the stance."""
        self._stance: Stance | None = None
        self.docks = False  # whether the base is led to the dock
        self._goes_in = self._backs_out = False
        self._transport.reset()

    def remaining(
        self,
        stance: Stance,
        base: Pose2D,
        distance: float,
        wTb: Pose2D,
        q: Array,
        floor: FloorMap,
        space: FreeSpace | None,
        *,
        follows: bool = False,
    ) -> Remaining:
        """The remaining motion, and where it leads now.

        `base` is the base pose of the stance, `distance` that of the end effector to the goal,
        rotation included [m]; `q` are (j,) joint positions [rad]; `space` are the static obstacles
        in 3D, None on an open floor. If it `follows` a moving goal, there is no transport posture.
        """
        if stance is not self._stance:
            self.docks = self._goes_in = self._backs_out = False
            self._stance = stance
        if self.docks and self._is_docked(stance, base, wTb, q):
            self.docks, self._goes_in = False, True
        dock = stance.dock if self.docks and not follows else None
        target = base if dock is None else moved(base, dock)
        self._backs_out = dock is not None and (self._backs_out or _is_past(dock, base, wTb))
        lead = self._route.lead(floor, wTb, target, stance.reverse != self._backs_out)
        joint_error, transport = stance.q - q, None
        max_joint_error, joint_time = self._left(joint_error)
        if not follows and not self._goes_in:
            way = self._route.way
            times = lead.time_left, joint_time / self._joint_speed
            transport = self._transport.posture(space, way, wTb, q, stance, times, waits=self.docks)
            self.docks = self.docks or (transport is not None and stance.dock is not None)
        if dock is not None:
            straight = hypot(*dock) / float(self._model.limits.base_twist[0])
            lead = lead._replace(time_left=lead.time_left + straight)
        if transport is not None:
            joint_error = transport - q
            max_joint_error, joint_time = self._left(joint_error)
        return Remaining(
            distance,
            base_target=lead.target if lead.final else target.relative_to(wTb),
            lead=lead,
            joint_error=joint_error,
            max_joint_error=max_joint_error,
            joint_time=joint_time,
            in_transport=transport is not None,
            docks=dock is not None,
        )

    def _left(self, joint_error: Array) -> tuple[float, float]:
        """The largest of joint errors (7,) [rad], and the time for them at full speed [s]."""
        size = np.abs(joint_error)
        return max(size.tolist()), max((size / self._model.limits.qd).tolist())

    def _is_docked(self, stance: Stance, base: Pose2D, wTb: Pose2D, q: Array) -> bool:
        """Whether the base is on the line from the dock and the arm in its posture."""
        assert stance.dock is not None
        x, y, turn = wTb.relative_to(base)
        dx, dy = stance.dock
        share = min(1.0, max(0.0, (x * dx + y * dy) / (dx * dx + dy * dy)))
        near = hypot(x - share * dx, y - share * dy) < _AT_DOCK
        turned = _AT_DOCK if share > 0.5 else _TURNED
        return near and abs(turn) < turned and bool(np.abs(stance.q - q).max() < _UNFOLDED)


def _is_past(dock: tuple[float, float], base: Pose2D, wTb: Pose2D) -> bool:
    """Whether the base stands between the dock and its place."""
    x, y, turn = wTb.relative_to(base)
    (dx, dy), length = dock, hypot(*dock)
    along, beside = (x * dx + y * dy) / length, abs(x * dy - y * dx) / length
    return abs(along) < length - _PAST and beside < _AT_DOCK and abs(turn) < _TURNED
