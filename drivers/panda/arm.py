"""The arm of a Franka Panda as a part of a robot."""

import threading
from collections.abc import Iterator, Sequence
from typing import Annotated, TypeAlias

import numpy as np
from pydantic import Field

from drivers.panda.arm_process import MEMORY
from drivers.panda.explanations import MODES, needs_a_person
from drivers.panda.library import INTERFACE_VERSION, LIMITS, missing
from drivers.panda.records import ARM_COMMAND, ARM_READING, ArmReading, Mode
from drivers.panda.streaming import FRESH
from drivers.processes.mailbox import Mailbox
from drivers.processes.process import DriverProcess, NoAnswerError, ProcessPart
from hw import (
    ArmState,
    Array,
    Clock,
    Fault,
    FaultKind,
    Finding,
    HardwareError,
    Verdict,
    ages,
    stopwatch,
)
from robots import DriverOptions, Positive, RobotDescription, Text

_SILENT = 0.15  # without a state for this long the arm does not answer [s]
_OLD_STATE = 50.0  # largest age of a state that is good [ms]
_ZERO = (0.0,) * 7
_RECOVERY, _WAY = 20.0, 60.0  # timeouts of a recovery and of `move_to` [s]
_APART = 2.0  # shortest time between two recoveries [s]
_SHORTEST = 0.01  # shortest time between two commands for their slope [s]: a shorter one is noise

_Six: TypeAlias = tuple[Positive, Positive, Positive, Positive, Positive, Positive]
_Seven: TypeAlias = tuple[Positive, Positive, Positive, Positive, Positive, Positive, Positive]


class PandaOptions(DriverOptions):
    """A Franka Panda."""

    address: Text
    torques: _Seven = (20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0)
    """Contact thresholds at which the arm stops [Nm]."""
    forces: _Six = (20.0, 20.0, 20.0, 25.0, 25.0, 25.0)  # [N, Nm]
    lead: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0  # delay of the joints, compensated [s]


class Lead:
    """Compensates the lag T [s] of the joints: they are commanded r + T dr/dt to do r.

    The slope is that of the last two commands, within qdd (7,) [rad/s^2]. A command to rest,
    and one after a pause, does not change.
    """

    def __init__(self, seconds: float, qdd: Sequence[float]) -> None:
        self._seconds, self._qdd = seconds, np.array(qdd)
        self._last: Array = np.zeros(7)
        self._at = -np.inf

    def of(self, qd: Array, now: float) -> Array:
        """What to command instead of (7,) velocities [rad/s] at a time [s]."""
        before, gap = self._last, now - self._at
        self._last, self._at = qd, now
        if not self._seconds or gap > FRESH or not qd.any():
            return qd
        slope = (qd - before) / max(gap, _SHORTEST)
        return qd + self._seconds * np.clip(slope, -self._qdd, self._qdd)


class PandaArm(ProcessPart):
    """A Panda that follows joint velocities; after a stop of its own only once it was recovered."""

    def __init__(
        self,
        address: str,
        clock: Clock,
        options: PandaOptions | None = None,
        connecting: float = 6.0,
    ) -> None:
        options = options or PandaOptions(address=address)
        self.address = address
        contacts = {"torques": options.torques, "forces": options.forces}
        module = "drivers.panda.arm_process"
        process = DriverProcess(module, "Panda", address, contacts, MEMORY, connecting, missing)
        super().__init__(process, clock)
        self._commands = Mailbox(self._process.memory, 0, ARM_COMMAND)
        self._readings = Mailbox(self._process.memory, 1, ARM_READING)
        self._writing = threading.Lock()
        self._lead = Lead(options.lead, LIMITS.qdd)
        self._given = 0
        self._is_recovering, self._may_recover_at = False, 0.0

    def connect(self) -> None:
        """Start the process, and check that the arm can be commanded; else HardwareError.

        While a person guides it, it is read all the same, as to teach poses: that is a fault then.
        """
        self._put(0.0, _ZERO)
        super().connect()
        reading = self.reading()
        if reading.mode is not Mode.GUIDING and reading.mode in MODES:
            self.close()
            raise HardwareError(f"the {self._process.what}: {MODES[reading.mode]}")

    def reading(self) -> ArmReading:
        """The newest state of the arm; stamps are those of `stopwatch`."""
        return self._process.told(ArmReading.get(self._readings))

    def read(self) -> ArmState:
        """The newest reading, stamped on arrival; of a silent arm at rest, with a fault, now."""
        reading = self.reading()
        is_silent = self._is_recovering or bool(self._silence(reading))
        return ArmState(
            stamp=self._clock.now() if is_silent else reading.stamp + self._offset,
            q=np.array(reading.q),
            qd=np.zeros(7) if is_silent else np.array(reading.qd),
            faults=tuple(self._faults(reading)),
        )

    def send(self, qd: Array) -> Array:
        """Follow joint velocities (7,) [rad/s]; zero while there is a fault, or if not finite."""
        is_good = np.isfinite(qd).all() and not self._faults(self.reading())
        applied = np.array(qd, dtype=float) if is_good else np.zeros(7)
        now = stopwatch()
        self._put(now, self._lead.of(applied, now))
        return applied

    def move_to(self, q: Sequence[float], speed: float = 0.3) -> None:
        """Go to q (7,) [rad] straight in joint space, unchecked, at a speed [rad/s]."""
        try:
            self._process.ask(_WAY, do="move", q=list(map(float, q)), speed=speed)
        except (NoAnswerError, KeyboardInterrupt):
            self.stop()
            raise

    def examine(self, robot: RobotDescription) -> Iterator[Finding]:
        """Protocol, masses, age of states."""
        ready = "" if self._faults(self.reading()) else ", ready to move"
        yield Finding("arm", Verdict.GOOD, f"interface version {INTERFACE_VERSION}{ready}")
        reading = self.reading()
        text = (
            f"Desk says that the hand weighs {reading.hand_mass:.2f} kg and carries "
            f"{reading.load:.2f} kg: the camera and its mount count, too"
        )
        yield Finding("arm", Verdict.OPEN, text)
        yield ages("arm", "states", lambda: stopwatch() - self.reading().stamp, _OLD_STATE)

    def recover(self) -> None:
        """Clear a reflex, once in 2 s at most; connect a silent arm again; raises HardwareError."""
        reading = self.reading()
        if self._silence(reading):
            self._process.kill()
            self.connect()
        elif self._faults(reading):
            self._clock.sleep_until(self._may_recover_at)
            self._is_recovering = True
            try:
                self._process.ask(_RECOVERY, do="recover")
            finally:
                self._is_recovering = False
                self._may_recover_at = self._clock.now() + _APART

    def stop(self) -> None:
        """Come to rest as fast as limits allow; from any thread."""
        self._put(0.0, _ZERO)

    def _put(self, stamp: float, qd: Sequence[float] | Array) -> None:
        with self._writing:
            self._given += 1
            self._commands.put(self._given, stamp, *qd)

    def _silence(self, reading: ArmReading) -> str:
        """Why there are no new states; empty if there are, and during a recovery."""
        longest = _RECOVERY if self._is_recovering else _SILENT
        return self._process.silence(reading.stamp, longest)

    def _faults(self, reading: ArmReading) -> list[Fault]:
        if silence := self._silence(reading):
            return [self._fault(FaultKind.CONNECTION, silence)]
        if self._is_recovering:
            return [self._fault(FaultKind.NOT_READY, MODES[Mode.RECOVERING])]
        if reading.mode in MODES:
            is_stop = reading.mode is Mode.USER_STOPPED
            kind = FaultKind.EMERGENCY_STOP if is_stop else FaultKind.NOT_READY
            is_recovering = reading.mode is Mode.RECOVERING
            return [self._fault(kind, MODES[reading.mode], clearable=is_recovering)]
        if reading.trouble:
            by_hand = reading.mode is Mode.REFLEX and needs_a_person(reading.trouble)
            return [self._fault(FaultKind.REFLEX, reading.trouble, clearable=not by_hand)]
        return []
