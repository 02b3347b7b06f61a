"""Faults on request: how a task copes with them is seen before the robot has them."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Self

from controller import Command
from hw.robot import Camera, Robot
from hw.state import Fault, FaultKind, RobotState
from robots import RobotDescription

INJECTABLE: Mapping[str, Fault] = MappingProxyType(
    {
        fault.kind.value: fault
        for fault in (
            Fault(kind=FaultKind.REFLEX, text="reflex of the arm, injected", clearable=True),
            Fault(kind=FaultKind.EMERGENCY_STOP, text="emergency stop, injected", clearable=False),
            Fault(
                kind=FaultKind.STALE_POSE, text="stale pose of the base, injected", clearable=False
            ),
        )
    }
)
"""What can be injected, by name."""


class FaultInjection:
    """A robot that also has the faults that a person gives it.

    Args:
        robot: what it is otherwise.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._lock = threading.Lock()
        self._faults: dict[str, Fault] = {}

    def inject(self, name: str) -> None:
        """Have a fault of `INJECTABLE` from the next reading on; from any thread."""
        with self._lock:
            self._faults[name] = INJECTABLE[name]

    def clear(self) -> None:
        """Have no injected fault any more, whatever its kind; from any thread."""
        with self._lock:
            self._faults.clear()

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
        """The robot's reading, with the injected faults."""
        state = self._robot.read()
        with self._lock:
            faults = tuple(self._faults.values())
        return replace(state, faults=(*state.faults, *faults)) if faults else state

    def send(self, command: Command) -> Command:
        """As the robot does; the gate brakes as long as there is a fault."""
        return self._robot.send(command)

    def grip(self, width: float, force: float) -> None:
        """As the robot does."""
        self._robot.grip(width, force)

    def recover(self) -> None:
        """As the robot does; clears the injected faults that a program may clear, too."""
        self._robot.recover()
        with self._lock:
            self._faults = {n: f for n, f in self._faults.items() if not f.clearable}

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
