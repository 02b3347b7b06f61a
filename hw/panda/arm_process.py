"""The process that holds the connection to the arm.

It never recovers by itself. After the arm has stopped of its own accord, it moves again only once
it has been recovered and the commands have been zero.
"""

from __future__ import annotations

import gc
import json
import sys
import time
from collections.abc import Sequence
from typing import Any

from hw.clock import stopwatch
from hw.panda.explanations import explain
from hw.panda.generation import PANDA, load_library
from hw.panda.records import ARM_COMMAND, ARM_READING, Mode
from hw.panda.streaming import FRESH, Streaming, reading_of
from hw.processes.child import Parent, Request, claim, hurry, leave, still_alive
from hw.processes.mailbox import Mailbox, open_memory

_NAP = 0.004
"""Between two readings while the arm is not in a motion [s]."""
_CONNECTING, _RECOVERING = 20.0, 60.0
"""How long that may take [s]."""
_NO_FILTER = 1000.0
"""Cutoff frequency at which the library's own filter is off [Hz]."""
_ZERO = (0.0,) * 7
MEMORY = 2
"""Mailboxes: commands come in, readings go out."""


class ArmProcess:
    """The arm's connection, and what is known of the arm.

    Args:
        library: of the vendor.
        address: of the arm.
        settings: torques (7,) [Nm] and forces (6,) [N, Nm] of contacts at which it stops.
        memory: descriptor of the shared memory.
        parent: who commands.
    """

    def __init__(
        self, library: Any, address: str, settings: dict[str, Any], memory: int, parent: Parent
    ) -> None:
        self._library, self._parent = library, parent
        shared = open_memory(memory)
        self._commands = Mailbox(shared, 0, ARM_COMMAND)
        self._readings = Mailbox(shared, 1, ARM_READING)
        self._lost = 0
        self._trouble = ""
        self._may_move = True
        still_alive(_CONNECTING)
        self._robot = library.Robot(address, library.RealtimeConfig.kIgnore)
        torques, forces = settings["torques"], settings["forces"]
        if Mode(int(self._robot.read_once().robot_mode)) in (Mode.IDLE, Mode.REFLEX):
            self._robot.set_collision_behavior(torques, torques, forces, forces)
        self._look()

    def run(self) -> None:
        """Until there is no parent any more."""
        while self._parent.commands():
            still_alive()
            mode = self._look()
            if request := self._parent.request():
                self._do(request, mode)
            elif self._may_move and self._is_wanted():
                self._move()
            else:
                time.sleep(_NAP)

    def _look(self) -> Mode:
        """Read the arm and tell; what it is doing."""
        state = self._robot.read_once()
        mode = Mode(int(state.robot_mode))
        if mode is Mode.REFLEX and not self._trouble:
            self._trouble = explain(f"{state.current_errors} motion aborted by reflex")
        self._allow(mode)
        self._publish(state, _ZERO)
        return mode

    def _is_wanted(self) -> bool:
        """Whether there is a fresh command to move."""
        command = self._commands.get()
        return command is not None and stopwatch() - command[1] <= FRESH and any(command[2:])

    def _allow(self, mode: Mode) -> None:
        """After a stop of its own, the arm may move when nobody wants it to for a moment."""
        if mode is not Mode.IDLE or self._trouble:
            self._may_move = False
        elif not self._is_wanted():
            self._may_move = True

    def _move(self, goal: Sequence[float] | None = None, speed: float = 0.5) -> bool:
        """Be in a motion until it ends; whether the goal is reached, if there is one."""
        streaming = Streaming(
            PANDA.limits,
            self._commands,
            self._publish,
            lambda: self._parent.is_gone,
            self._library.JointVelocities,
            goal,
            speed,
        )
        try:
            self._robot.control_joint_velocity(
                streaming,
                self._library.ControllerMode.kJointImpedance,
                limit_rate=True,
                cutoff_frequency=_NO_FILTER,
            )
        except RuntimeError as error:
            self._trouble = explain(error)
        self._lost += streaming.lost
        return streaming.arrived

    def _do(self, request: Request, mode: Mode) -> None:
        error = ""
        if request["do"] == "recover":
            error = self._recover(mode)
        elif self._trouble or mode is not Mode.IDLE:
            error = self._trouble or f"the arm is in mode {mode.name.lower()}"
        elif not self._move(request["q"], request["speed"]):
            error = self._trouble or "the arm was stopped on its way"
        self._look()
        self._parent.answer(request, error)

    def _recover(self, mode: Mode) -> str:
        """Clear what a program may clear; why not."""
        if mode is Mode.USER_STOPPED:
            return explain("User Stop pressed")
        if mode in (Mode.OTHER, Mode.GUIDING):
            return f"the arm is in mode {mode.name.lower()}; look at its Desk page"
        if mode is Mode.REFLEX:
            still_alive(_RECOVERING)
            try:
                self._robot.automatic_error_recovery()
            except RuntimeError as error:
                return explain(error)
        self._trouble = ""
        return ""

    def _publish(self, state: Any, commanded: Sequence[float]) -> None:
        reading_of(state, commanded=commanded, lost=self._lost, trouble=self._trouble).put(
            self._readings
        )


def main() -> None:
    """Serve one parent; arguments: address, settings as JSON, descriptor of the shared memory."""
    address, settings, memory = sys.argv[1], json.loads(sys.argv[2]), int(sys.argv[3])
    parent = Parent()
    try:
        library = load_library()
        parent.tell(loaded=True)
        if other := claim("arm", address):
            parent.tell(error=other)
            leave(1)
        gc.collect()
        gc.freeze()
        gc.disable()
        hurry()
        arm = ArmProcess(library, address, settings, memory, parent)
        parent.tell(ready=True)
        arm.run()
    except Exception as error:
        parent.tell(error=explain(error))
        leave(1)
    leave()
