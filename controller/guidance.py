"""The way out of local minima: towards a stance that is known to reach the goal.

Far from the goal the base is led to where it will stand and the arm to the posture it will have;
near the goal the end effector takes over. The two are blended in one qp by their weights.
"""

from __future__ import annotations

from math import cos, hypot, inf, sin
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.base_drive import Planar, drive_to, time_to_drive
from controller.command import Array, PoseGoal
from controller.model import RobotModel
from controller.postures import bank
from controller.self_collision import SelfCollision
from controller.servo import PoseError
from controller.settings import ControllerSettings
from controller.stance import Stance, choose_stance

_ROTATION_SHARE = 0.3
"""An error of one radian counts like this many metres."""
_NEAR, _BLEND = 0.10, 0.5
"""Guidance begins this far from the goal and is whole after another so much [m]."""
_WORTH_IT = 0.35
"""A new goal nearer than this is approached without guidance, until it stalls [m]."""
_CLOSE = 0.06
"""Nearer than this nothing counts as a stall and a detour is over [m]."""
_JUMP, _TURN = 0.1, cos(0.3)
"""A goal that moves or turns this far in one period is another goal [m, a cosine]."""
_RISE, _TILT = 0.05, 0.97
"""A goal that rises [m] or tilts (a cosine) away from its stance needs another one."""
_AT_BASE, _AT_HEADING, _AT_JOINT = 0.4, 0.6, 0.8
"""Nearer than this to the stance the guidance fades [m, rad, rad]."""
_FASTEST_FOLD = 3.0
"""Largest rate at which the arm folds into its posture [1/s]."""
_SLOW_FOLD = 0.4
"""Share of the base's time to go that the arm's folding takes."""
_JOINT_SHARE = 0.7
"""Share of the joint speeds that folding may use."""
_BETTER = 1e-3
"""What counts as progress [m, s or rad]."""
_DETOURS = 4
"""After so many stalls before the same goal the end effector goes on alone."""


class StanceBias(NamedTuple):
    """What the guidance asks of one qp."""

    share: float
    """s in [0, 1]: 0 leaves all to the end effector, 1 nearly all to base and arm."""
    base: Array
    """(n_base,) wanted velocities of the base's degrees of freedom."""
    arm: Array
    """(7,) wanted joint velocities [rad/s]."""
    detour: bool
    """Whether the end effector has no say until the stance is near."""


class _Way(NamedTuple):
    """What is left to do."""

    far: float
    """Of the end effector's way; rotation counts by `_ROTATION_SHARE` [m]."""
    there: Planar
    """Where the base is to stand, seen from it."""
    to_go: float
    """Least time for the base to get there [s]."""
    fold: Array
    """(7,) what is left for the arm's joints [rad]."""
    farthest: float
    """The largest of that [rad]."""
    least: float
    """Time that it takes at the joints' full speed [s]."""


class Guide:
    """Keeps the stance of one goal from tick to tick.

    Args:
        model: the robot.
        settings: the weights and costs.
        body: the robot's shapes.
    """

    def __init__(
        self, model: RobotModel, settings: ControllerSettings, body: SelfCollision
    ) -> None:
        self._model = model
        self._settings = settings
        self._body = body
        self._bank = bank(model.description)
        self.forget()

    def forget(self) -> None:
        """The next goal is a new one."""
        self._goal: SE3 | None = None
        self._begun_with: SE3 | None = None
        self._failed: tuple[Stance, ...] = ()
        self._detours_left = _DETOURS
        self._take(None)

    def bias(self, goal: PoseGoal, error: PoseError, base: Planar, q: Array) -> StanceBias | None:
        """Where the goal's stance pulls base and arm; None if the end effector goes alone.

        Args:
            goal: where the end effector is to be.
            error: how far it is from there.
            base: where the base is.
            q: (7,) where the arm is [rad].
        """
        far = error.position + _ROTATION_SHARE * error.orientation
        if goal.wTe != self._goal:
            if self._is_another(goal.wTe):
                self._begun_with = goal.wTe.copy()
                self._failed, self._detours_left = (), _DETOURS
                worth_it = far > _WORTH_IT and not goal.straight
                self._take(self._choose(goal, base, q) if worth_it else None)
            self._goal = goal.wTe.copy()
        way = self._way(goal, far, base, q)
        if self._stalled(way) and not goal.straight and self._detours_left:
            self._detours_left -= 1
            if self._stance is not None:
                self._failed = (*self._failed, self._stance)
            self._take(self._choose(goal, base, q) if self._detours_left else None, detour=True)
            way = self._way(goal, far, base, q)
        return None if self._stance is None else self._towards(self._stance, way, goal, base)

    def _take(self, stance: Stance | None, detour: bool = False) -> None:
        self._stance = stance
        self._detour = detour
        self._least = (inf, inf, inf)
        self._waited = 0

    def _choose(self, goal: PoseGoal, base: Planar, q: Array) -> Stance:
        model, settings = self._model, self._settings
        return choose_stance(
            model, settings, self._bank, self._body, goal.wTe, base, q, failed=self._failed
        )

    def _is_another(self, wTe: SE3) -> bool:
        """Whether a goal has jumped, or crept to where its stance does not reach it."""
        if self._goal is None or self._begun_with is None:
            return True
        moved = wTe.translation - self._goal.translation
        cosine = (float(np.vdot(wTe.rotation, self._goal.rotation)) - 1.0) / 2.0
        rise = float(wTe.translation[2] - self._begun_with.translation[2])
        tilt = float(wTe.rotation[2] @ self._begun_with.rotation[2])
        jumped = float(moved @ moved) > _JUMP * _JUMP or cosine < _TURN
        return jumped or abs(rise) > _RISE or tilt < _TILT

    def _way(self, goal: PoseGoal, far: float, base: Planar, q: Array) -> _Way:
        stance = self._stance
        if stance is None:
            return _Way(far, Planar(0.0, 0.0, 0.0), 0.0, np.zeros(len(q)), 0.0, 0.0)
        there = stance.base_for(goal.wTe).seen_from(base)
        to_go = time_to_drive(self._model, there, stance.reverse)
        fold = stance.q - q
        left = np.abs(fold)
        least = float((left / self._model.limits.qd).max())
        return _Way(far, there, to_go, fold, float(left.max()), least)

    def _stalled(self, way: _Way) -> bool:
        """Whether nothing has come nearer for a while: not the goal, the base's place, the arm."""
        if way.far < _CLOSE:
            self._take(self._stance)
            return False
        a, b, c = self._least
        near, soon, folded = a - way.far, b - way.to_go, c - way.farthest
        if max(near, soon, folded) > _BETTER:
            self._least = (min(a, way.far), min(b, way.to_go), min(c, way.farthest))
            self._waited = 0
        else:
            self._waited += 1
        return self._waited * self._settings.period >= self._settings.patience

    def _towards(self, stance: Stance, way: _Way, goal: PoseGoal, base: Planar) -> StanceBias:
        there = way.there
        share = min(
            1.0,
            max(
                hypot(there.x, there.y) / _AT_BASE,
                abs(there.heading) / _AT_HEADING,
                way.farthest / _AT_JOINT,
            ),
        )
        if not self._detour:
            share = min(share, max(0.0, (way.far - _NEAR) / _BLEND))
        model = self._model
        drive = drive_to(model, self._settings, there, reverse=stance.reverse, fastest=goal.speed)
        if goal.twist.any():
            c, s = cos(base.heading), sin(base.heading)
            vx, vy = goal.twist[0], goal.twist[1]
            drive += model.description.base.axes[:2].T @ [c * vx + s * vy, c * vy - s * vx]
        folding = max(1.0 / _FASTEST_FOLD, _SLOW_FOLD * way.to_go, way.least / _JOINT_SHARE)
        return StanceBias(share, drive, way.fold / folding, self._detour)
