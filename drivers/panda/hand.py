"""The Franka Hand as a part of a robot."""

from collections.abc import Callable, Iterator
from typing import Any

from drivers.panda.hand_process import HOMING, MEMORY, NOT_HOMED, patience
from drivers.panda.library import missing
from drivers.panda.records import HAND_READING, REACHED, HandReading
from drivers.processes.mailbox import Mailbox
from drivers.processes.process import DriverProcess, NoAnswerError, ProcessPart
from hw import Clock, Fault, FaultKind, Finding, GripperState, HardwareError, Verdict
from robots import DriverOptions, Positive, RobotDescription, Text

_SILENT = 0.5  # without a state for this long the hand does not answer [s]
_CONNECTING = 6.0  # timeout of connecting [s]
_MARGIN = 5.0  # added to the timeouts of its process [s]
_HELD = (
    "it was not homed and may hold something, which homing would drop: take that out, and home it "
    "on its Desk page"
)


class HandOptions(DriverOptions):
    """A Franka Hand."""

    address: Text | None = None  # None: that of the arm
    speed: Positive = 0.1  # [m/s]


class PandaHand(ProcessPart):
    """A Franka Hand; its fingers move only in `grip`, `home`, and a `recover` that homes."""

    def __init__(self, address: str, clock: Clock, speed: float = 0.1) -> None:
        module, settings = "drivers.panda.hand_process", {"speed": speed}
        made = module, "Franka Hand", address, settings, MEMORY, _CONNECTING, missing
        super().__init__(DriverProcess(*made), clock)
        self._readings = Mailbox(self._process.memory, 0, HAND_READING)
        self._longest = patience(speed) + _MARGIN
        self._gripping = 0
        self._is_homing = self._holds = self._is_unsettled = False

    def reading(self) -> HandReading:
        """The newest state of the hand; stamps are those of `stopwatch`."""
        return self._process.told(HandReading.get(self._readings))

    def read(self) -> GripperState:
        """The newest reading, stamped on arrival."""
        reading = self.reading()
        return GripperState(
            stamp=reading.stamp + self._offset,
            width=reading.width,
            moving=self._gripping > 0,
            faults=self._faults(reading),
        )

    def grip(self, width: float, force: float) -> None:
        """Move the fingers to a width [m] with a force [N] until they rest; or HardwareError."""
        self._gripping += 1
        try:
            if self._process.end_of_it():
                self.connect()
            self._is_unsettled = True
            self._ask(self._longest, do="grip", width=float(width), force=float(force))
            self._is_unsettled, self._holds = False, self.reading().width > width + REACHED
        finally:
            self._gripping -= 1

    def prepare(self, announce: Callable[[str], None]) -> None:
        """Home it if it was not."""
        if not self.reading().is_homed:
            announce("the hand was not homed since it was on: now its fingers close and open")
            self.home()

    def home(self) -> None:
        """Home a hand that was not homed since power-on; HardwareError: it may hold an object."""
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

    def examine(self, robot: RobotDescription) -> Iterator[Finding]:
        """Width and temperature, once it was homed."""
        if (reading := self.reading()).is_homed:
            text = f"{1000.0 * reading.width:.0f} mm open, {reading.temperature} degrees C"
            yield Finding("gripper", Verdict.GOOD, text)

    def recover(self) -> None:
        """Connect again, stop a failed motion, and home the hand if empty; raises HardwareError."""
        if self._silence(self.reading()):
            self._process.kill()
            self.connect()
        if self._is_unsettled and not self._gripping:
            if self.reading().is_homed:  # otherwise it has forgotten the motion, and a stop lets go
                self._process.say(do="stop")
            self._is_unsettled = False
        self.home()

    def stop(self) -> None:
        """Stop the fingers where they are."""
        if self._gripping or self._is_homing:
            self._process.say(do="stop")

    def _ask(self, longest: float, **request: Any) -> None:
        """Command a motion; a process that does not answer in time is killed."""
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
        return (self._fault(kind, cause, clearable=clearable),) if cause else ()
