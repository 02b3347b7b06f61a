"""The way to a stance: where the base is led now, and which posture the arm takes meanwhile.

Mostly the base goes to its place and the arm to its posture, together. Where the arm would hit
something on that way it is carried; and the base goes first to where a line begins on which it can
go straight in, waits there until the arm has unfolded, and goes in.
"""

from __future__ import annotations

from math import hypot

import numpy as np

from controller.command import Array
from controller.floor import FloorMap, Pose2D, Route
from controller.model import RobotModel
from controller.settings import GuidanceSettings
from controller.stance.bias import Remaining
from controller.stance.docking import moved
from controller.stance.free_space import FreeSpace
from controller.stance.stance import Stance
from controller.stance.transport_posture import TransportPosture

_AT_DOCK = 0.1
"""A base that is nearer than this to the line on which it goes in does so [m and rad] ..."""
_TURNED = 1.0
"""... or, past the middle of that line, when it is turned by less than this [rad] ..."""
_UNFOLDED = 0.5
"""... and no joint is farther than this from the posture of the stance [rad]."""


class Approach:
    """The way of one robot to one stance after the other.

    Args:
        model: the robot.
        guidance: how fast the arm unfolds.
        route: leads its base.
    """

    def __init__(self, model: RobotModel, guidance: GuidanceSettings, route: Route) -> None:
        self._model = model
        self._joint_speed = guidance.joint_speed
        self._route = route
        self._carrying = TransportPosture(model, guidance.posture_time)
        self.reset()

    def reset(self) -> None:
        """Forget the stance."""
        self._stance: Stance | None = None
        self.docks = False
        """Whether the base is led to where it will go straight in."""
        self._goes_in = False
        self._carrying.reset()

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
        """What is left of the way, and where it leads now.

        Args:
            stance: where it leads.
            base: where that has the base.
            distance: of the end effector to the goal, rotation included [m].
            wTb: base pose.
            q: (7,) joint positions [rad].
            floor: what stands around, seen from above.
            space: the same in full; None on an open floor.
            follows: the goal moves: the arm is not carried.
        """
        if stance is not self._stance:
            self.docks = self._goes_in = False
            self._stance = stance
        if self.docks and self._is_docked(stance, base, wTb, q):
            self.docks, self._goes_in = False, True
        dock = stance.dock if self.docks and not follows else None
        target = base if dock is None else moved(base, dock)
        lead = self._route.lead(floor, wTb, target, stance.reverse)
        joint_error, carried = stance.q - q, None
        size = np.abs(joint_error)
        joint_time = float((size / self._model.limits.qd).max())
        if not follows and not self._goes_in:
            way = self._route.way
            times = lead.time_left, joint_time / self._joint_speed
            carried = self._carrying.posture(space, way, wTb, q, stance, times, waits=self.docks)
            self.docks = self.docks or (carried is not None and stance.dock is not None)
        if dock is not None:
            straight = hypot(*dock) / float(self._model.limits.base_twist[0])
            lead = lead._replace(time_left=lead.time_left + straight)
        if carried is not None:
            joint_error = carried - q
            size = np.abs(joint_error)
            joint_time = float((size / self._model.limits.qd).max())
        return Remaining(
            distance,
            base_target=lead.target if lead.final else target.relative_to(wTb),
            lead=lead,
            joint_error=joint_error,
            max_joint_error=float(size.max()),
            joint_time=joint_time,
            carried=carried is not None,
            docks=dock is not None,
        )

    def _is_docked(self, stance: Stance, base: Pose2D, wTb: Pose2D, q: Array) -> bool:
        """Whether the base is on the line, at its beginning or past it, the arm in its posture."""
        assert stance.dock is not None
        x, y, turn = wTb.relative_to(base)
        dx, dy = stance.dock
        share = min(1.0, max(0.0, (x * dx + y * dy) / (dx * dx + dy * dy)))
        near = hypot(x - share * dx, y - share * dy) < _AT_DOCK
        turned = _AT_DOCK if share > 0.5 else _TURNED
        return near and abs(turn) < turned and bool(np.abs(stance.q - q).max() < _UNFOLDED)
