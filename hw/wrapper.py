"""A robot around another robot: what it does not change, it passes on."""

from __future__ import annotations

from typing import Self

from controller import Command
from hw.robot import Camera, Robot
from hw.state import RobotState
from robots import RobotDescription


class RobotWrapper:
    """Does as the robot inside does; a subclass changes some of it.

    Args:
        robot: the one inside.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot

    @property
    def description(self) -> RobotDescription:
        """That of the robot."""
        return self._robot.description

    @property
    def camera(self) -> Camera:
        """That of the robot."""
        return self._robot.camera

    def connect(self) -> None:
        """As the robot does."""
        self._robot.connect()

    def read(self) -> RobotState:
        """As the robot does."""
        return self._robot.read()

    def send(self, command: Command) -> Command:
        """As the robot does."""
        return self._robot.send(command)

    def grip(self, width: float, force: float) -> None:
        """As the robot does."""
        self._robot.grip(width, force)

    def recover(self) -> None:
        """As the robot does."""
        self._robot.recover()

    def stop(self) -> None:
        """As the robot does."""
        self._robot.stop()

    def close(self) -> None:
        """As the robot does."""
        self._robot.close()

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
