"""A base over TCP: it takes lines `v w`, and tells `x y heading v w` 50 times a second."""

import socket
import threading
from math import cos, sin

import numpy as np
from pinocchio import SE3

from frankie_task import BaseState, DriverContext, DriverOptions, Fault, FaultKind, HardwareError

PERIOD = 0.02  # of commands [s]
FRESH = 0.1  # a command holds for this long, then the base is told to rest [s]
SILENT = 0.3  # without a line for this long the connection is lost [s]


class Options(DriverOptions):
    """Below `hardware.base` in a robot file."""

    address: str
    port: int = 5000


class LineBase:
    """The driver: `connect` and `recover` may wait, nothing else does."""

    def __init__(self, options: Options, context: DriverContext) -> None:
        self._at, self._clock = (options.address, options.port), context.clock
        self._is_open = threading.Event()
        self._state: BaseState | None = None
        self._command = (-FRESH, 0.0, 0.0)  # when it was given, v, w

    def connect(self) -> None:
        self._state, first = None, threading.Event()
        try:
            self._socket = socket.create_connection(self._at, timeout=3.0)
        except OSError as error:
            raise HardwareError(f"no base at {self._at[0]}: {error}; is it switched on?") from error
        self._is_open.set()
        threading.Thread(target=self._hear, args=(first,), daemon=True).start()
        threading.Thread(target=self._tell, daemon=True).start()
        if not first.wait(3.0):
            self.close()
            raise HardwareError(f"the base at {self._at[0]} accepts a connection and says nothing")

    def read(self) -> BaseState:
        state, now = self._state, self._clock.now()
        assert state is not None, "connect first"
        if now - state.stamp <= SILENT:
            return state
        text = f"the base at {self._at[0]} does not answer: look at its cable"
        fault = Fault(kind=FaultKind.CONNECTION, text=text, clearable=True)
        # Its stamp goes on, so that the run can wait for a recovery.
        return BaseState(stamp=now, oTb=state.oTb, twist=np.zeros(3), faults=(fault,))

    def send(self, twist):
        is_good = np.isfinite(twist).all() and not self.read().faults
        v, _, w = twist if is_good else np.zeros(3)
        self._command = (self._clock.now(), float(v), float(w))
        return np.array([v, 0.0, w])

    def stop(self) -> None:
        self._command = (-FRESH, 0.0, 0.0)

    def recover(self) -> None:
        if self.read().faults:
            self.close()
            self.connect()

    def close(self) -> None:
        self.stop()
        if self._is_open.is_set():
            self._is_open.clear()
            self._socket.close()  # the base stops by itself

    def _hear(self, first: threading.Event) -> None:
        try:
            for line in self._socket.makefile():
                x, y, heading, v, w = map(float, line.split())
                c, s = cos(heading), sin(heading)
                turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
                self._state = BaseState(
                    stamp=self._clock.now(),
                    oTb=SE3(turn, np.array([x, y, 0.0])),
                    twist=np.array([v, 0.0, w]),
                )
                first.set()
        except (OSError, ValueError):
            pass  # `read` tells of the silence

    def _tell(self) -> None:
        """The watchdog: what is sent depends on the age of the command."""
        pause = threading.Event()
        while self._is_open.is_set():
            given, v, w = self._command
            if self._clock.now() - given > FRESH:
                v = w = 0.0
            try:
                self._socket.sendall(f"{v} {w}\n".encode())
            except OSError:
                return
            pause.wait(PERIOD)
