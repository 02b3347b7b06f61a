"""Motions of the arm, planned as a whole before it moves."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias

import numpy as np
from pinocchio import SE3

from controller.collision import CollisionModels
from controller.command import Array, KinematicState, PoseGoal
from controller.model import RobotModel
from controller.planning.arm_space import ArmSpace, FreeTest
from controller.planning.inverse_kinematics import postures_at, straight_postures
from controller.planning.rrt import planning_library, rrt_connect
from controller.planning.settings import PlanningSettings
from controller.planning.trajectory import Trajectory, timed
from controller.stance import bank
from controller.stance_settings import StanceSettings
from controller.surroundings import Surroundings

_Tests: TypeAlias = Callable[[Array], FreeTest]

_ANY_SPEED = 10.0
"""Where nobody asks for one [m/s]."""


class ArmPlanner:
    """Plans from where the arm is, the base standing.

    Args:
        model: the robot.
        settings: of planning.
        stance: how near to a limit a joint may come.
        period: of control [s].
        models: where the shapes of robot and surroundings are made.

    Raises:
        PlanningError: the library is not installed.
    """

    def __init__(
        self,
        model: RobotModel,
        settings: PlanningSettings,
        stance: StanceSettings,
        period: float,
        models: CollisionModels,
    ) -> None:
        planning_library()
        self._model = model
        self._settings = settings
        self._stance = stance
        self._period = period
        self._models = models
        self._bank = bank(model.description)
        self._seed = 0

    def to_posture(
        self, state: KinematicState, q: Array, surroundings: Surroundings
    ) -> Trajectory | None:
        """The arm to joint positions q (7,) [rad]; None if no way was found."""
        space = self._space(state.wTb, surroundings)
        is_free = space.test(state.q, hand_may_touch=False)
        return self._along(self._first(state.q, [q], lambda _: is_free), _ANY_SPEED)

    def to_pose(
        self, state: KinematicState, goal: PoseGoal, surroundings: Surroundings
    ) -> Trajectory | None:
        """The hand to a pose, straight if that is asked for; None if no way was found."""
        settings, model, wTb = self._settings, self._model, state.wTb
        space, touch = self._space(wTb, surroundings), goal.hand_may_touch
        if goal.straight:
            path = straight_postures(
                model,
                self._stance,
                wTb,
                goal.wTe,
                state.q,
                settings.straight_step,
                settings.straight_jump,
            )
            is_free = space.test(state.q, hand_may_touch=touch)
            if path is not None and is_free.all_free(path, settings.resolution):
                return self._along(path, goal.speed)
        postures = postures_at(model, self._stance, self._bank, wTb, goal.wTe, state.q)
        path = self._first(
            state.q, postures, lambda q: space.test(state.q, q, hand_may_touch=touch)
        )
        return self._along(path, goal.speed)

    def _first(self, start: Array, goals: Iterable[Array], test_for: _Tests) -> Array | None:
        """The path (M, 7) to the first of some postures that is free and to which there is one."""
        settings, tried = self._settings, 0
        for goal in goals:
            is_free = test_for(goal)
            if not is_free(goal):
                continue
            if is_free.all_free(np.array([start, goal]), settings.resolution):
                return np.array([start, goal])
            self._seed += 1
            path = rrt_connect(
                start,
                goal,
                (self._model.limits.q_min, self._model.limits.q_max),
                is_free,
                seed=self._seed,
                checks=settings.checks,
                shortcuts=settings.shortcuts,
                resolution=settings.resolution,
            )
            tried += 1
            if path is not None or tried == settings.candidates:
                return path
        return None

    def _space(self, wTb: SE3, surroundings: Surroundings) -> ArmSpace:
        model = self._models.around(surroundings)
        model.place(wTb, self._model.description.arm.ready, [o.geom for o in surroundings.moving])
        return ArmSpace(model, wTb, self._settings.clearance, self._settings.close_clearance)

    def _along(self, path: Array | None, speed: float) -> Trajectory | None:
        if path is None:
            return None
        settings = self._settings
        return timed(
            self._model,
            path,
            self._period,
            speed=speed,
            speed_share=settings.speed_share,
            acceleration_share=settings.acceleration_share,
        )
