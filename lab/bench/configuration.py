"""Configuration of a measurement: robot, preset of the controller, limits of the base."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from config.poses import MapPose
from controller import (
    PAPER,
    PRESETS,
    Command,
    ControllerSettings,
    HolisticController,
    KinematicState,
    MotionGoal,
    PoseGoal,
    RobotModel,
    StepReport,
    Surroundings,
)
from lab.bench.peers import LACKS, peer_step
from lab.bench.simulated_motion import Step
from robots import load_robot, with_base_speeds

EXAMPLE = "example"
"""The preset of the paper's controller whose velocities are scaled as in its published example."""

_SETTINGS: dict[str, ControllerSettings] = {**PRESETS, EXAMPLE: PAPER}
_PUBLISHED_BASE_SPEED = 4.0  # limit of the base in the published robot descriptions [m/s and rad/s]
_FAR, _FAR_GAIN, _NEAR_GAIN = 0.5, 0.7, 1.4
"""The published example multiplies its velocities by 0.7 / e where e > 0.5 m, else by 1.4."""


@dataclass(frozen=True, kw_only=True)
class Configuration:
    """One robot with one controller; can be sent to another process."""

    robot: str
    preset: str = "frankie"
    base_speed: float | None = None  # largest speed [m/s]; None is that of the preset
    reverse_speed: float | None = None
    """Largest reverse speed of the base [m/s]; None keeps its ratio to the forward speed, which is
    1 for a published controller."""
    period: float = 0.01  # control period [s]
    changes: tuple[tuple[str, Any], ...] = ()  # settings that differ from the preset, by name

    def model(self) -> RobotModel:
        """A new model of the robot."""
        description = load_robot(self.robot)
        if self.preset in (EXAMPLE, "paper"):
            speed = self.base_speed or _PUBLISHED_BASE_SPEED
            description = with_base_speeds(description, speed, turn_rate=_PUBLISHED_BASE_SPEED)
            description = with_base_speeds(description, reverse=speed)  # as published
            return RobotModel(with_base_speeds(description, None, self.reverse_speed))
        return RobotModel(with_base_speeds(description, self.base_speed, self.reverse_speed))

    def controller(self, model: RobotModel) -> HolisticController:
        """A new controller."""
        settings = replace(_SETTINGS[self.preset], period=self.period, **dict(self.changes))
        return HolisticController(model, settings)

    def step(self, model: RobotModel) -> Step:
        """The step of a new controller.

        Raises:
            ConfigError: a peer is not installed.
        """
        if self.preset in LACKS:
            return peer_step(self.preset, model, self.period)
        step = self.controller(model).step
        return _as_published(step) if self.preset == EXAMPLE else step


def _as_published(plain: Step) -> Step:
    """The step of the published example, whose velocities are scaled whatever the limits."""

    def step(
        state: KinematicState,
        goal: MotionGoal[MapPose] | None,
        last: Command,
        surroundings: Surroundings,
    ) -> tuple[Command, StepReport]:
        command, report = plain(state, goal, last, surroundings)
        if not isinstance(goal, PoseGoal):
            return command, report
        mTe = state.mTb * report.bTe
        error = float(np.abs(mTe.actInv(goal.target).translation).sum())
        gain = _FAR_GAIN / error if error > _FAR else _NEAR_GAIN
        return Command(base_twist=command.base_twist * gain, qd=command.qd * gain), report

    return step
