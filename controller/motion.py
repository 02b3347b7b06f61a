"""What turns the goals of behaviours into commands."""

from __future__ import annotations

from typing import Protocol

from controller.command import Command, KinematicState, MotionGoal
from controller.model import RobotModel
from controller.report import StepReport
from controller.settings import ControllerSettings
from controller.surroundings import OPEN_FLOOR, Surroundings


class MotionController(Protocol):
    """One step of control after the other, towards a goal that may be another in every step."""

    @property
    def model(self) -> RobotModel:
        """The robot."""

    @property
    def settings(self) -> ControllerSettings:
        """The control period, and what else it has of the holistic controller."""

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute now what the first step in surroundings needs; else it does so itself."""

    def step(
        self,
        state: KinematicState,
        goal: MotionGoal | None,
        last: Command,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> tuple[Command, StepReport]:
        """The command for the next period, and what there is to say about the goal."""
