"""A gripper in ROS 2: the action GripperCommand or ParallelGripperCommand, by rmw_cyclonedds."""

import threading
import uuid
from dataclasses import replace
from functools import partial
from typing import Any, Literal, Self

import numpy as np
from pydantic import model_validator

from extensions.ros2.carrier import Route
from extensions.ros2.checked_messages import joints
from extensions.ros2.messages import message
from extensions.ros2.part import Ros2Options, Ros2Part
from hw import DriverContext, GripperState, HardwareError, stopwatch

_ACCEPTING, _LONGEST, _POLL = 3.0, 30.0, 0.005  # timeouts, and period of looks [s]
_SUCCEEDED = 4  # action_msgs/GoalStatus
_FOREVER = 1e9
_CANCEL = "action_msgs/srv/CancelGoal_Request"


class GripperOptions(Ros2Options):
    """A parallel gripper whose width is linear in one joint."""

    joint: str  # in `states`
    open: float  # its position where the fingers are as far apart as the robot's file says
    closed: float = 0.0
    states: str = "joint_states"
    action: str = "gripper_controller/gripper_cmd"
    type: Literal["GripperCommand", "ParallelGripperCommand"] = "GripperCommand"

    @model_validator(mode="after")
    def _opens(self) -> Self:
        if self.open == self.closed:
            raise ValueError("`open` and `closed` are the same")
        return self


class Ros2Gripper(Ros2Part):
    """A gripper; `grip` waits for the result of its action."""

    _part = "gripper"

    def __init__(self, options: GripperOptions, context: DriverContext) -> None:
        self._options, self._opening = options, context.robot.gripper.opening
        self._action = f"control_msgs/action/{options.type}"
        path = f"{options.name(options.action).lstrip('/')}/_action"
        routes = [options.hears(options.states, "sensor_msgs/msg/JointState")]
        for service, kind in (("send_goal", "SendGoal"), ("get_result", "GetResult")):
            kinds = (f"{self._action}_{kind}_Request", f"{self._action}_{kind}_Response")
            routes.append(Route(f"rq/{path}/{service}Request", kinds[0], False, sensor=False))
            routes.append(Route(f"rr/{path}/{service}Reply", kinds[1], True, sensor=False))
        routes.append(Route(f"rq/{path}/cancel_goalRequest", _CANCEL, False, sensor=False))
        doors = {0: partial(joints, names=(options.joint,))}
        super().__init__(options, context.clock, routes, doors)
        self._state: GripperState | None = None
        self._client, self._number = uuid.uuid4().int >> 64, 0
        self._goal: Any = None

    def read(self) -> GripperState:
        """The newest width; of a silent gripper the last one, with a fault, now."""
        faults, state = self._faults(), self._state
        assert state is not None, "connect first"
        stamp = self._clock.now() if faults else state.stamp
        return replace(state, stamp=stamp, moving=self._goal is not None, faults=faults)

    def grip(self, width: float, force: float) -> None:
        """Move the fingers to a width [m] with a force [N] until they rest; or HardwareError."""
        options, share = self._options, width / self._opening
        position = options.closed + share * (options.open - options.closed)
        command: dict[str, Any] = {"position": position, "max_effort": force}
        if options.type == "ParallelGripperCommand":
            state = {"position": np.array([position]), "effort": np.array([force])}
            joint = message("sensor_msgs/msg/JointState", name=[options.joint], **state)
            command = {"command": joint}
        goal = np.frombuffer(uuid.uuid4().bytes, np.uint8)
        self._goal = message("unique_identifier_msgs/msg/UUID", uuid=goal)
        try:
            answer = self._call(1, _ACCEPTING, "SendGoal", goal_id=self._goal, **command)
            if not answer.accepted:
                raise HardwareError(f"{options.action} refuses to go to {width:.3f} m")
            result = self._call(3, _LONGEST, "GetResult", goal_id=self._goal)
            done, pause = self._clock.now(), threading.Event()
            while not self._trouble() and self.read().stamp < done:  # a width from before
                pause.wait(_POLL)
        finally:
            self._goal = None
        if result.status != _SUCCEEDED and not result.stalled:
            raise HardwareError(f"{options.action} ended with status {result.status}")

    def stop(self) -> None:
        """Cancel the grip."""
        if (goal := self._goal) is not None:
            self._ask(5, _CANCEL, goal_id=goal)

    def _hear(self) -> None:
        options = self._options
        for stamp, ((position,), _) in self._new(0):
            share = (position - options.closed) / (options.open - options.closed)
            width = float(np.clip(share, 0.0, 1.0)) * self._opening
            self._state = GripperState(stamp=stamp, width=width, moving=False)

    def _ask(self, route: int, kind: str, **fields: Any) -> int:
        self._number += 1
        request = message(kind, client=self._client, number=self._number, **fields)
        self._publish(route, request, holds=_FOREVER)
        return self._number

    def _call(self, route: int, patience: float, kind: str, **fields: Any) -> Any:
        """Ask by a topic, and wait for the answer by the next one; HardwareError: none comes."""
        number = self._ask(route, f"{self._action}_{kind}_Request", **fields)
        until, pause = stopwatch() + patience, threading.Event()
        while stopwatch() < until:
            for _, answer in self._new(route + 1):
                if (answer.client, answer.number) == (self._client, number):
                    return answer
            if trouble := self._trouble():
                raise HardwareError(trouble)
            pause.wait(_POLL)
        raise HardwareError(f"{self._options.action} does not answer {kind} within {patience:g} s")
