"""The process that holds the connection to the arm; it never recovers by itself."""

import ctypes
import gc
import time
from collections.abc import Sequence
from typing import Any

from drivers.panda.explanations import MODES, explain, explain_connecting
from drivers.panda.library import LIMITS, load_library
from drivers.panda.records import ARM_COMMAND, ARM_READING, ArmReading, Mode
from drivers.panda.streaming import FRESH, SpeedError, SpeedMonitor, Streaming
from drivers.processes.child import EndError, Parent, Request, hurry, serve, still_alive
from drivers.processes.mailbox import Mailbox, open_memory
from hw.clock import stopwatch

_NAP = 0.004  # between two readings while the arm is not in a motion [s]
_CONNECTING, _RECOVERING = 20.0, 60.0  # timeouts [s]
_UNDER_WAY = 18.0  # timeout of a recovery that is under way already [s]
_NO_FILTER = 1000.0  # cutoff frequency at which the library's own filter is off [Hz]
_STIFFNESS = [3000.0, 3000.0, 3000.0, 2500.0, 2500.0, 2000.0, 2000.0]
"""(7,) of the arm's own joint controller, as the vendor's examples have it [Nm/rad]."""
_LOCK_PRESENT = 1  # MCL_CURRENT of `mlockall`
MEMORY = 2  # mailboxes: commands come in, readings go out


class ArmProcess:
    """The connection to the arm, and its state."""

    def __init__(
        self, library: Any, address: str, settings: dict[str, Any], memory: int, parent: Parent
    ) -> None:
        self._library, self._parent = library, parent
        shared = open_memory(memory)
        self._commands = Mailbox(shared, 0, ARM_COMMAND)
        self._readings = Mailbox(shared, 1, ARM_READING)
        self._contacts = settings["torques"], settings["forces"]
        self._lost = 0
        self._trouble = ""
        self._monitor = SpeedMonitor()
        self._is_set_up = False
        self._may_move = True
        still_alive(_CONNECTING)
        self._robot = library.Robot(address, library.RealtimeConfig.kIgnore)
        if self._look() in (Mode.IDLE, Mode.REFLEX):
            self._trouble = self._trouble or self._set_up()
            self._look()

    def run(self) -> None:
        """Serve until the parent has ended."""
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
        """Read and publish the state; its mode."""
        state = self._robot.read_once()
        mode = Mode(int(state.robot_mode))
        if mode is Mode.REFLEX and not self._trouble:
            # At rest some arms no longer report why they have stopped.
            now, last = str(state.current_errors), str(state.last_motion_errors)
            self._trouble = explain(f"{now if '_' in now else last} motion aborted by reflex")
        elif mode is Mode.USER_STOPPED and not self._trouble:
            # With the button released it looks idle, and refuses motions until recovered.
            self._trouble = explain("User Stop")
        self._allow(mode)
        self._publish(state)
        return mode

    def _is_wanted(self) -> bool:
        command = self._commands.get()
        return command is not None and stopwatch() - command[1] <= FRESH and any(command[2:])

    def _allow(self, mode: Mode) -> None:
        """After a stop of its own the arm may move once the commands have been zero."""
        if mode is not Mode.IDLE or self._trouble:
            self._may_move = False
        elif not self._is_wanted():
            self._may_move = True

    def _move(self, goal: Sequence[float] | None = None, speed: float = 0.5) -> bool:
        """Run a motion until it ends; whether its goal is reached."""
        self._monitor = SpeedMonitor()
        streaming = Streaming(
            LIMITS,
            self._commands,
            self._command,
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
        except (RuntimeError, SpeedError) as error:
            self._trouble = explain(error)
        self._lost += streaming.lost
        return streaming.arrived

    def _do(self, request: Request, mode: Mode) -> None:
        error = ""
        if request["do"] == "recover":
            error = self._recover(mode)
        elif self._trouble or mode is not Mode.IDLE:
            error = self._trouble or MODES.get(mode, f"the arm is in mode {mode.name.lower()}")
        elif not self._move(request["q"], request["speed"]):
            error = self._trouble or "the arm was stopped on its way"
        self._look()
        self._parent.answer(request, error)

    def _recover(self, mode: Mode) -> str:
        """Clear errors, also of an arm that looks idle after a user stop; why not."""
        until = stopwatch() + _UNDER_WAY
        while mode is Mode.RECOVERING and stopwatch() < until and self._parent.commands():
            still_alive()
            time.sleep(_NAP)
            mode = self._look()
        if mode is not Mode.RECOVERING and mode in MODES:
            return MODES[mode]
        if mode is Mode.REFLEX or self._trouble:
            still_alive(_RECOVERING)
            try:
                self._robot.automatic_error_recovery()
            except RuntimeError as error:
                if mode is Mode.REFLEX or "current mode" not in str(error):
                    return explain(error)  # otherwise there is nothing to clear
        self._trouble = self._set_up()
        return self._trouble

    def _set_up(self) -> str:
        if not self._is_set_up:
            torques, forces = self._contacts
            try:
                self._robot.set_collision_behavior(torques, torques, forces, forces)
                self._robot.set_joint_impedance(_STIFFNESS)
            except RuntimeError as error:
                return explain(error)
            self._is_set_up = True
        return ""

    def _command(self, state: Any, commanded: Sequence[float]) -> None:
        self._monitor.check(stopwatch(), state.dq, commanded)
        self._publish(state)

    def _publish(self, state: Any) -> None:
        reading = ArmReading(
            stamp=stopwatch(),
            mode=Mode(int(state.robot_mode)),
            q=tuple(state.q),
            qd=tuple(state.dq),
            lost=self._lost,
            hand_mass=state.m_ee,
            load=state.m_load,
            trouble=self._trouble,
        )
        reading.put(self._readings)


def _work(parent: Parent, address: str, settings: Any, memory: int) -> None:
    library = load_library()
    parent.tell(loaded=True)
    parent.claim(f"arm {address}")
    gc.collect()
    gc.freeze()
    gc.disable()
    hurry()
    try:
        arm = ArmProcess(library, address, settings, memory, parent)
    except RuntimeError as error:
        raise EndError(explain_connecting(error)) from error
    ctypes.CDLL(None).mlockall(_LOCK_PRESENT)  # as far as the system permits
    parent.tell(ready=True)
    arm.run()


def main() -> None:
    """Serve one parent."""
    serve(_work, explain)
