"""On the move: the base sets out for the next goal while the end effector is busy with this one.

As in Burgess-Limerick et al. (ICRA 2023) the base does not wait for the arm. It is led to where it
will stand for the next goal, and the arm makes up for its motion. A base is slow to take up a
velocity, so what the arm makes up for is the velocity that the base has and not the one it is told.
The base gets slower as the arm comes to the end of what it can do, stretched or with a joint at its
limit, and stops before.
"""

from __future__ import annotations

import numpy as np
from pinocchio import SE3

from controller.base_lag import BaseLag
from controller.command import Array
from controller.floor import Pose2D, Route, drive_along
from controller.model import RobotModel
from controller.settings import ControllerSettings
from controller.stance.bias import StanceBias
from controller.stance.finder import StanceFinder
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance


class NextGoalApproach:
    """Leads the base to where it will stand for one next goal after the other.

    Args:
        model: the robot.
        settings: of the controller; `guidance` is not None.
        finder: of the stances.
    """

    def __init__(
        self, model: RobotModel, settings: ControllerSettings, finder: StanceFinder
    ) -> None:
        self._model = model
        self._settings = settings
        self._finder = finder
        self._route = Route(model, settings)
        self._accelerations = model.acceleration_limits[: model.n_base]
        self.reset()

    def reset(self) -> None:
        """Forget the next goal."""
        self._next: SE3 | None = None
        self._search: StanceSearch | None = None
        self._led: Array | None = None

    def stance_for(self, wTe: SE3) -> Stance | None:
        """Where the base has set out for, if that was for this goal; None if not, or not yet."""
        search = self._search
        if search is None or wTe != self._next or not search.done or self._finder.why_none(search):
            return None
        return search.best

    def bias(
        self, wTe: SE3, error: float, manipulability: float, lag: BaseLag, wTb: Pose2D, q: Array
    ) -> StanceBias | None:
        """The bias of one period; None as long as it is not known where to stand next.

        Args:
            wTe: the next goal of the end effector.
            error: distance of the end effector to its present goal [m].
            manipulability: of the arm.
            lag: how fast the base is.
            wTb: base pose.
            q: (7,) joint positions [rad].
        """
        if self._led is None:
            self._led = lag.told
        if self._search is None or wTe != self._next:
            self._next = wTe.copy()
            self._search = self._finder.search(self._next, wTb, q)
        search = self._search
        if not search.done:
            search.advance()
        stance, onward = search.best, self._settings.onward
        if not (search.done or search.chosen) or stance is None or self._finder.why_none(search):
            return None
        lead = self._route.lead(
            self._finder.floor, wTb, stance.base_for(self._next), stance.reverse
        )
        if lead.unreachable:
            return None
        velocity = drive_along(self._model, self._settings, lead, onward.speed)
        change = onward.acceleration * self._settings.period * self._accelerations
        slower = np.abs(velocity) < np.abs(self._led)
        self._led = np.where(
            slower, velocity, np.clip(velocity, self._led - change, self._led + change)
        )
        weight = onward.base_weight / max(error, self._settings.min_error)
        return StanceBias(
            blend=0.0,
            min_tracking=0.0,
            base_weight=weight * self._ease(manipulability, q),
            base_velocity=self._led,
            posture_weight=0.0,
            joint_velocity=np.zeros(len(q)),
            coasting=lag.velocity,
            response=lag.response,
        )

    def _ease(self, manipulability: float, q: Array) -> float:
        """Share of its weight that the base has, so that the arm does not come to its end."""
        onward, limits = self._settings.onward, self._model.limits
        margin = float(np.minimum(q - limits.q_min, limits.q_max - q).min())
        stretch = (manipulability - onward.least_manipulability) / onward.spare_manipulability
        room = (margin - onward.least_limit_margin) / onward.spare_limit_margin
        return min(1.0, max(0.0, min(stretch, room)))
