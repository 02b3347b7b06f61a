"""The Franka Hand as a part of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hw.clock import Clock, stopwatch
from hw.panda.generation import missing
from hw.panda.hand_process import HOMING, MEMORY, NOT_HOMED, patience
from hw.panda.records import HAND_READING, REACHED, HandReading
from hw.processes.mailbox import Mailbox
from hw.processes.process import DriverProcess, NoAnswerError
from hw.robot import HardwareError
from hw.state import Fault, FaultKind, GripperState

_SILENT = 0.5
"""A hand that says nothing for so long does not answer [s]."""
_MARGIN = 5.0
"""By which its process gives a motion up earlier than is waited for it here [s]."""
_HELD = (
    "it was not homed and may hold something, which homing would drop: take that out, and home it "
    "on its Desk page"
)


@dataclass(frozen=True, kw_only=True)
class HandSettings:
    """What a site may choose."""

    speed: float = 0.1
    """Of the fingers [m/s]."""
    connecting: float = 6.0
    """How long the hand may take to answer at first [s]."""


class PandaHand:
    """A Franka Hand; a process of its own holds the connection.

    The fingers move in `grip` and in `home` only, and in a `recover` that homes. Whether the hand
    holds something is told by the width, not by what the hand says of a grasp.

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
        self._longest = patience(settings.speed) + _MARGIN
        self._gripping = 0
        self._is_homing = self._holds = self._is_unsettled = False

    def connect(self) -> None:
        """Start the process. Nothing moves: a hand that was not homed has a fault.

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
        return GripperState(
            stamp=reading.stamp + self._offset,
            width=reading.width,
            moving=self._gripping > 0,
            faults=self._faults(reading),
        )

    def grip(self, width: float, force: float) -> None:
        """Move the fingers, pressing with a force [N]; waits until they rest.

        Closing on what is held already does nothing: its force stays that of the first time.

        Raises:
            HardwareError: the fingers did not reach the width, the hand was not homed, or does not
                answer.
        """
        self._gripping += 1
        try:
            if self._process.end_of_it():
                self.connect()
            self._is_unsettled = True
            self._ask(self._longest, do="grip", width=float(width), force=float(force))
            self._is_unsettled, self._holds = False, self.reading().width > width + REACHED
        finally:
            self._gripping -= 1

    def home(self) -> None:
        """Home a hand that was not homed since it was switched on: it closes, then it opens.

        Raises:
            HardwareError: that has failed, or the hand may hold something.
        """
        reading = self.reading()
        if reading.is_homed:
            return
        if self._may_hold(reading):
            raise HardwareError(f"the {self._process.what}: {_HELD}")
        self._is_homing = True
        try:
            self._ask(HOMING + _MARGIN, do="home")
        finally:
            self._is_homing = False

    def recover(self) -> None:
        """Connect again if the hand or its driver does not answer, and stop fingers that failed.

        A hand that was not homed is homed, unless it may hold something.

        Raises:
            HardwareError: it cannot be reached or homed.
        """
        if self._silence(self.reading()):
            self._process.kill()
            self.connect()
        if self._is_unsettled and not self._gripping:
            if self.reading().is_homed:  # else it has forgotten the motion, and a stop lets go
                self._process.say(do="stop")
            self._is_unsettled = False
        self.home()

    def stop(self) -> None:
        """The fingers stop where they are."""
        if self._gripping or self._is_homing:
            self._process.say(do="stop")

    def close(self) -> None:
        """Stop, and end the process."""
        self.stop()
        self._process.end()

    def _ask(self, longest: float, **request: Any) -> None:
        """Have the fingers do something; a process that does not give up in time is given up."""
        try:
            self._process.ask(longest, **request)
        except NoAnswerError:
            self._process.kill()
            raise

    def _may_hold(self, reading: HandReading) -> bool:
        return self._holds or reading.may_hold

    def _silence(self, reading: HandReading) -> str:
        return self._process.silence(reading.stamp, HOMING if self._is_homing else _SILENT)

    def _faults(self, reading: HandReading) -> tuple[Fault, ...]:
        kind, cause, clearable = FaultKind.CONNECTION, self._silence(reading), True
        if not cause and self._is_homing:
            kind, cause = FaultKind.NOT_READY, "it is being homed: keep clear of its fingers"
        elif not cause and not reading.is_homed:
            clearable = not self._may_hold(reading)
            kind, cause = FaultKind.NOT_READY, NOT_HOMED if clearable else _HELD
        text = f"the {self._process.what}: {cause}"
        return (Fault(kind=kind, text=text, clearable=clearable),) if cause else ()
