"""The Franka Hand as a part of a robot."""

from __future__ import annotations

from dataclasses import dataclass

from hw.clock import Clock, stopwatch
from hw.panda.generation import missing
from hw.panda.hand_process import MEMORY
from hw.panda.records import HAND_READING, HandReading
from hw.processes.mailbox import Mailbox
from hw.processes.process import DriverProcess
from hw.state import Fault, FaultKind, GripperState

_SILENT = 0.5
"""A hand that says nothing for so long does not answer [s]."""
_LONGEST = 15.0
"""What a motion of the fingers may take [s]."""


@dataclass(frozen=True, kw_only=True)
class HandSettings:
    """What a site may choose."""

    speed: float = 0.1
    """Of the fingers [m/s]."""
    connecting: float = 6.0
    """How long the hand may take to answer at first; homing comes on top of it [s]."""


class PandaHand:
    """A Franka Hand; a process of its own holds the connection.

    Whether the hand holds something is told by the width, not by what the hand says of a grasp.

    Args:
        address: of the arm that carries it.
        clock: session time.
        settings: of the site.
    """

    def __init__(self, address: str, clock: Clock, settings: HandSettings | None = None) -> None:
        settings = settings or HandSettings()
        self._clock, self._offset = clock, 0.0
        self._process = DriverProcess(
            "hw.panda.hand_process",
            "Franka Hand",
            address,
            {"speed": settings.speed},
            MEMORY,
            settings.connecting,
            missing,
        )
        self._readings = Mailbox(self._process.memory, 0, HAND_READING)
        self._gripping = 0

    def connect(self) -> None:
        """Start the process; a hand that was not homed since it was switched on is homed.

        Raises:
            HardwareError: the hand cannot be reached; the text says why and what to do.
        """
        self._offset = self._clock.now() - stopwatch()
        self._process.start()

    def reading(self) -> HandReading:
        """All that the driver knows; stamps are those of `stopwatch`.

        Raises:
            HardwareError: there never was one.
        """
        return self._process.told(HandReading.get(self._readings))

    def read(self) -> GripperState:
        """The newest reading, stamped when it arrived."""
        reading = self.reading()
        cause = self._process.end_of_it()
        if not cause and stopwatch() - reading.stamp > _SILENT:
            cause = "it says nothing: look at the cable and the power"
        text = f"the {self._process.what}: {cause}"
        return GripperState(
            stamp=reading.stamp + self._offset,
            width=reading.width,
            moving=self._gripping > 0,
            faults=(Fault(kind=FaultKind.CONNECTION, text=text, clearable=True),) if cause else (),
        )

    def grip(self, width: float, force: float) -> None:
        """Move the fingers, pressing with a force [N]; waits until they rest.

        Raises:
            HardwareError: the fingers did not reach the width, or the hand does not answer.
        """
        self._gripping += 1
        try:
            if self._process.end_of_it():
                self.connect()
            self._process.ask(_LONGEST, do="grip", width=float(width), force=float(force))
        finally:
            self._gripping -= 1

    def recover(self) -> None:
        """Connect again if the hand or its driver does not answer.

        Raises:
            HardwareError: it cannot be reached.
        """
        if self.read().faults:
            self._process.kill()
            self.connect()

    def stop(self) -> None:
        """The fingers stop where they are."""
        if self._gripping:
            self._process.say(do="stop")

    def close(self) -> None:
        """Stop, and end the process."""
        self.stop()
        self._process.end()
