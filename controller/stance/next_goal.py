"""Departure for the next goal while the end effector is busy with this one.

As in Burgess-Limerick et al. (ICRA 2023) the base does not wait for the arm: it is led to its next
stance, and the arm compensates for the velocity that the lagging base really has. The base slows
down and stops as the arm comes near to a singularity or a joint limit.
"""

import numpy as np
from pinocchio import SE3

from config.arrays import Array
from config.planar import Pose2D
from config.poses import MapPose
from controller.floor.base_drive import drive_along
from controller.floor.route import Route
from controller.model import Lag, RobotModel
from controller.settings import ControllerSettings
from controller.stance.bias import StanceBias
from controller.stance.dexterity import dexterity
from controller.stance.finder import StanceFinder
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance

_SPEED = 0.4  # largest speed of the base meanwhile [m/s]
_BASE_WEIGHT = 0.1  # weight of the base velocity in the QP, as a share of the end effector's λ_δ
_ACCELERATION = 0.6  # share of the acceleration limits of the base
_LEAST_MANIPULABILITY, _SPARE_MANIPULABILITY = 0.08, 0.04
"""Manipulability at which the base stops, and excess at which it has its full weight."""
_LEAST_LIMIT_MARGIN, _SPARE_LIMIT_MARGIN = 0.1, 0.15
"""Margin to the joint limits at which the base stops, and excess for its full weight [rad]."""


class NextGoalApproach:
    """Leads the base to its stance for successive next goals."""

    def __init__(
        self, model: RobotModel, settings: ControllerSettings, finder: StanceFinder
    ) -> None:
        self._model = model
        self._settings = settings
        self._finder = finder
        self._dexterity = dexterity(model.description).usual
        self._route = Route(model, settings)
        self._accelerations = model.acceleration_limits[: model.n_base]
        self.reset()

    def reset(self) -> None:
        """Forget the next goal."""
        self._next: SE3 | None = None
        self._search: StanceSearch | None = None
        self._led: Array | None = None

    def stance_for(self, mTe: MapPose) -> Stance | None:
        """The stance that the base has left for, if it is for this goal."""
        search = self._search
        if search is None or mTe != self._next or not search.done or self._finder.why_none(search):
            return None
        return search.best

    def bias(
        self, mTe: MapPose, error: float, manipulability: float, lag: Lag, mTb: Pose2D, q: Array
    ) -> StanceBias | None:
        """The bias of one period; None as long as the next stance is not known.

        `mTe` is the next goal, `error` the distance of the end effector to its present one [m].
        """
        if self._led is None:
            self._led = lag.commanded[: self._model.n_base]
        if self._search is None or mTe != self._next:
            self._next = mTe.copy()
            self._search = self._finder.search(self._next, mTb, q)
        search = self._search
        if not search.done:
            search.advance()
        stance = search.best
        if not (search.done or search.chosen) or stance is None or self._finder.why_none(search):
            return None
        lead = self._route.lead(
            self._finder.floor, mTb, stance.base_for(self._next), stance.reverse
        )
        if lead.unreachable:
            return None
        velocity = drive_along(self._model, self._settings, lead, _SPEED)
        change = _ACCELERATION * self._settings.period * self._accelerations
        slower = np.abs(velocity) < np.abs(self._led)
        self._led = np.where(
            slower, velocity, np.clip(velocity, self._led - change, self._led + change)
        )
        weight = _BASE_WEIGHT / max(error, self._settings.min_error)
        weight *= self._ease(manipulability, q)
        return StanceBias(
            blend=0.0,
            min_tracking=0.0,
            base_weight=weight,
            base_velocity=self._led,
            posture_weight=0.0,
            pull=np.concatenate([weight * self._led, np.zeros(len(q))]),
            coasting=lag.base,
            response=lag.response,
        )

    def _ease(self, manipulability: float, q: Array) -> float:
        """Share of its weight that the base has at this dexterity of the arm."""
        limits = self._model.limits
        margin = float(np.minimum(q - limits.q_min, limits.q_max - q).min())
        stretch = (manipulability / self._dexterity - _LEAST_MANIPULABILITY) / _SPARE_MANIPULABILITY
        room = (margin - _LEAST_LIMIT_MARGIN) / _SPARE_LIMIT_MARGIN
        return min(1.0, max(0.0, min(stretch, room)))
