"""The arm of a Franka Panda as a part of a robot."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hw.clock import Clock, stopwatch
from hw.panda.arm_process import MEMORY
from hw.panda.explanations import needs_a_person
from hw.panda.generation import PANDA, missing
from hw.panda.lead import Lead
from hw.panda.records import ARM_COMMAND, ARM_READING, ArmReading, Mode
from hw.processes.mailbox import Mailbox
from hw.processes.process import DriverProcess, NoAnswerError
from hw.robot import HardwareError
from hw.state import ArmState, Array, Fault, FaultKind

_SILENT = 0.15
"""An arm that says nothing for so long does not answer [s]."""
_ZERO = (0.0,) * 7
_RECOVERY, _WAY = 20.0, 60.0
"""How long that may take [s]."""
_APART = 2.0
"""Between two recoveries [s]."""
_MODES = {
    Mode.OTHER: "its joints are locked: unlock them on its Desk page and activate FCI",
    Mode.GUIDING: "it is being guided by hand: let go of the buttons at its wrist",
    Mode.RECOVERING: "its recovery is under way, which takes up to 16 s",
}


@dataclass(frozen=True, kw_only=True)
class ArmSettings:
    """What a site may choose."""

    torques: tuple[float, ...] = (20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0)
    """(7,) torques of a contact at which the arm stops [Nm]."""
    forces: tuple[float, ...] = (20.0, 20.0, 20.0, 25.0, 25.0, 25.0)
    """(6,) forces and torques at the hand at which the arm stops [N, Nm]."""
    lead: float = 0.0
    """By how much joints follow a velocity too late; they are commanded so much ahead of it [s]."""
    connecting: float = 6.0
    """How long the arm may take to answer at first [s]."""


class PandaArm:
    """A Panda that follows joint velocities; a process of its own holds the connection.

    After a reflex, and after a person has stopped it, it moves again only when it was recovered
    and the commands have been zero for a moment.

    Args:
        address: of the arm in the network.
        clock: session time.
        settings: of the site.
    """

    def __init__(self, address: str, clock: Clock, settings: ArmSettings | None = None) -> None:
        settings = settings or ArmSettings()
        self._clock, self._offset = clock, 0.0
        contacts = {"torques": settings.torques, "forces": settings.forces}
        self._process = DriverProcess(
            "hw.panda.arm_process", "Panda", address, contacts, MEMORY, settings.connecting, missing
        )
        self._commands = Mailbox(self._process.memory, 0, ARM_COMMAND)
        self._readings = Mailbox(self._process.memory, 1, ARM_READING)
        self._writing = threading.Lock()
        self._lead = Lead(settings.lead, PANDA.limits.qdd)
        self._given = 0
        self._is_recovering, self._may_recover_at = False, 0.0

    def connect(self) -> None:
        """Start the process, and see that the arm can be commanded.

        Raises:
            HardwareError: it cannot be; the text says why and what to do.
        """
        self._offset = self._clock.now() - stopwatch()
        self._put(0.0, _ZERO)
        self._process.start()
        reading = self.reading()
        cause = _MODES.get(reading.mode)
        if reading.mode is Mode.USER_STOPPED:
            cause = "its stop button is pressed: release it"
        if cause is not None:
            self.close()
            raise HardwareError(f"the {self._process.what}: {cause}")

    def reading(self) -> ArmReading:
        """All that the driver knows; stamps are those of `stopwatch`.

        Raises:
            HardwareError: there never was one.
        """
        return self._process.told(ArmReading.get(self._readings))

    def read(self) -> ArmState:
        """The newest reading, stamped when it arrived.

        From an arm that does not answer it is the last one, at rest, with a fault and the stamp of
        now: a recovery gets its chance.
        """
        reading = self.reading()
        is_silent = self._is_recovering or bool(self._silence(reading))
        return ArmState(
            stamp=self._clock.now() if is_silent else reading.stamp + self._offset,
            q=np.array(reading.q),
            qd=np.zeros(7) if is_silent else np.array(reading.qd),
            faults=tuple(self._faults(reading)),
        )

    def send(self, qd: Array) -> Array:
        """Follow joint velocities (7,) [rad/s] for one period.

        Zero while there is a fault, and instead of what is no number.
        """
        is_good = np.isfinite(qd).all() and not self._faults(self.reading())
        applied = np.array(qd, dtype=float) if is_good else np.zeros(7)
        now = stopwatch()
        self._put(now, self._lead.of(applied, now))
        return applied

    def move_to(self, q: Sequence[float], speed: float = 0.3) -> None:
        """Go to joint positions (7,) [rad] straight in joint space; waits until it is there.

        Nothing looks out for obstacles. `stop` and any command end it.

        Args:
            q: for example the `ready` of a robot's description.
            speed: of the fastest joint [rad/s].

        Raises:
            HardwareError: it did not get there.
        """
        try:
            self._process.ask(_WAY, do="move", q=list(map(float, q)), speed=speed)
        except (NoAnswerError, KeyboardInterrupt):
            self.stop()
            raise

    def recover(self) -> None:
        """Clear a reflex; connect again if the arm or its driver does not answer.

        A healthy arm, which may be in a motion, is left alone. Waits until the last recovery was
        2 s ago: what comes back at once is not cleared away in a loop.

        Raises:
            HardwareError: that cannot be done now.
        """
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
        """Come to rest as fast as limits allow, in any state and from any thread."""
        self._put(0.0, _ZERO)

    def close(self) -> None:
        """Stop, and end the process once the arm rests."""
        self.stop()
        self._process.end()

    def _put(self, stamp: float, qd: Sequence[float] | Array) -> None:
        with self._writing:
            self._given += 1
            self._commands.put(self._given, stamp, *qd)

    def _silence(self, reading: ArmReading) -> str:
        """Why there is nothing new; empty if there is, and while a recovery keeps it silent."""
        longest = _RECOVERY if self._is_recovering else _SILENT
        return self._process.silence(reading.stamp, longest)

    def _faults(self, reading: ArmReading) -> list[Fault]:
        what = self._process.what

        def fault(kind: FaultKind, cause: str, *, clearable: bool) -> list[Fault]:
            return [Fault(kind=kind, text=f"the {what}: {cause}", clearable=clearable)]

        if silence := self._silence(reading):
            return fault(FaultKind.CONNECTION, silence, clearable=True)
        if self._is_recovering:
            return fault(FaultKind.NOT_READY, _MODES[Mode.RECOVERING], clearable=True)
        if reading.mode is Mode.USER_STOPPED:
            cause = "its stop button is pressed: release it, then recover"
            return fault(FaultKind.EMERGENCY_STOP, cause, clearable=False)
        if reading.mode in _MODES:
            recovering = reading.mode is Mode.RECOVERING
            return fault(FaultKind.NOT_READY, _MODES[reading.mode], clearable=recovering)
        if reading.trouble:
            by_hand = reading.mode is Mode.REFLEX and needs_a_person(reading.trouble)
            return fault(FaultKind.REFLEX, reading.trouble, clearable=not by_hand)
        return []
