"""The process of the hand on an emulated hand, in simulated time and without sockets."""

import threading
import time
from functools import partialmethod
from types import SimpleNamespace
from typing import Any

from drivers.panda.hand_process import HandProcess
from drivers.processes.mailbox import share_memory
from extensions.emulators.panda.emulated_hand import EmulatedHand
from extensions.emulators.panda.joints_and_fingers import OPENING, FreeFingers
from extensions.emulators.panda.wire import HandCommand, HandStatus


class SteppedHand:
    """In place of the vendor's library; the process looks at the hand every 20 ms, as usual."""

    def __init__(self, monkeypatch, reported: str = "") -> None:
        self.fingers = FreeFingers()
        self.body = EmulatedHand(self.fingers, frozenset(filter(None, [reported])))
        self.at: dict[int, Any] = {}  # events, by milliseconds of the next motion
        self.is_silent = self._is_stopped = False
        self._heard = threading.Event()
        simulated = {"perf_counter": lambda: self.body.number / 1000.0}
        monkeypatch.setattr("hw.clock.time", SimpleNamespace(**vars(time) | simulated))
        self.Gripper = lambda address: self
        self.process = self.connect()

    def connect(self) -> HandProcess:
        """A new process on this hand."""
        self.process = HandProcess(self, "address", 0.1, share_memory(1))
        return self.process

    def read_once(self) -> SimpleNamespace:
        if self.is_silent:
            raise RuntimeError("libfranka gripper: UDP receive: Timeout")
        return SimpleNamespace(
            width=self.fingers.width,
            max_width=OPENING if self.body.is_homed else 0.0,
            is_grasped=self.body.is_grasped,
            temperature=30,
        )

    def _do(self, command: HandCommand, *arguments: float) -> bool:
        self._is_stopped = False
        self._heard.clear()
        begun, status = self.body.number, self.body.begin(command, arguments)
        while status is None:
            status = self.body.tick()
            self.at.pop(self.body.number - begun, lambda: None)()
            if self.body.number % 20 == 0:
                self._watch()
            if (motion := self.process._motion) is not None and motion.why:
                self._heard.wait(5.0)  # the stop, which comes on a thread of its own
            if self._is_stopped:
                status = HandStatus.ABORTED
        if status in (HandStatus.FAIL, HandStatus.ABORTED):
            how = "failed" if status is HandStatus.FAIL else "aborted"
            raise RuntimeError(f"libfranka gripper: Command {how}!")
        return status is HandStatus.SUCCESS

    homing = partialmethod(_do, HandCommand.HOMING)
    move = partialmethod(_do, HandCommand.MOVE)

    def grasp(self, width: float, speed: float, force: float, inner: float, outer: float) -> bool:
        return self._do(HandCommand.GRASP, width, inner, outer, speed, force)

    def stop(self) -> None:
        self._is_stopped = self.body.stop()
        self._heard.set()

    def _watch(self) -> None:
        try:
            self.process.watch()
        except RuntimeError as error:
            raise SystemExit(str(error)) from error  # as the process ends
