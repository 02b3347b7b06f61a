"""Replay of a recorded robot: returns recorded readings, compares commands bit by bit."""

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from config.arrays import Array
from controller import Command
from hw.clock import Deliveries, Result
from hw.recording import reading
from hw.robot import HardwareError, PassivePart, Sensor
from hw.state import RobotState
from robots import RobotDescription

_BASE = ("base vx", "base vy", "base ω")


class RecordEndsError(HardwareError):
    """The recording has ended, or the replay has left it."""


@dataclass(frozen=True, kw_only=True)
class Difference:
    """The first command that differs from the recorded one."""

    number: int  # of the command, from 0
    time: float  # [s]
    velocity: str  # component that differs
    recorded: float
    replayed: float

    def __str__(self) -> str:
        """One line for people, with every digit."""
        return (
            f"command {self.number} at {self.time:.2f} s differs in {self.velocity}: "
            f"recorded {self.recorded!r}, replayed {self.replayed!r}"
        )


class ReplayClock:
    """Session time as recorded: first for a reading, then for its command."""

    is_real, lost = False, 0.0

    def __init__(self, times: Array) -> None:
        self._times = times
        self._next = 0
        self._now = 0.0
        self._coming: list[float] = []
        self._deliveries = Deliveries()

    def now(self) -> float:
        """Recorded seconds since the session began [s]."""
        if self._coming:
            self._now = self._coming.pop(0)
        return self._now

    def sleep_until(self, stamp: float) -> None:
        """Go on to the next turn; after the last one, to `stamp` [s]."""
        self._now = float(self._times[self._next]) if self._next < len(self._times) else stamp
        self._coming = []
        self._deliveries.deliver(self._now)

    def due(self, work: Future[Result], seconds: float) -> Future[Result]:
        """What gets the result of work `seconds` [s] from now."""
        return self._deliveries.add(work, self._now + seconds)

    def set(self, turn: int, *moments: float) -> None:
        """Return each of the `moments` [s] of a turn, one after the other."""
        self._next, self._coming = turn + 1, list(moments)


class ReplayRobot(PassivePart):
    """A recording as a robot: its `turns` of `turn_type`, `recall` of a thing by field, number."""

    def __init__(
        self,
        description: RobotDescription,
        turns: npt.NDArray[np.void],
        recall: Callable[[str, int], Any],
    ) -> None:
        self.description = description
        self.clock = ReplayClock(turns["time"])
        self.camera = Sensor(partial(self._latest, "frame"))
        self.laser = Sensor(partial(self._latest, "scan"))
        self._recall = recall
        self._recalled: dict[str, tuple[int, Any]] = {}  # newest of a field, with its number
        self.difference: Difference | None = None
        self.sent = 0  # number of compared commands
        self._turns = turns
        self._at = -1
        self._is_over = True  # the present turn is used up
        self._has_begun = False
        self.ran_out = False  # more was asked for than was recorded

    def begin(self) -> None:
        """Start the turns with the next reading; until then `read` returns the first one."""
        self._has_begun = True

    @property
    def row(self) -> npt.NDArray[np.void]:
        """The present turn; the first one at the start."""
        row: npt.NDArray[np.void] = self._turns[max(self._at, 0)]
        return row

    @property
    def next_row(self) -> npt.NDArray[np.void] | None:
        """The coming turn; None at the end."""
        return self._turns[self._at + 1] if self._at + 1 < len(self._turns) else None

    def read(self) -> RobotState:
        """The recorded reading of the next turn; RecordEndsError: there is none."""
        if not self._has_begun:
            return self._reading(self.row)
        self._is_over = True
        row = self.next_row
        if row is None or not row["read"] or self.difference is not None:
            self.ran_out |= row is None
            if row is not None:
                self.clock.set(self._at, float(row["time"]))
            raise RecordEndsError("the recorded readings end here")
        self._go_on()
        return self._reading(row)

    def send(self, command: Command) -> Command:
        """Compare with the recorded command, and return what was applied; or RecordEndsError."""
        row = self.next_row
        if self._is_over and row is not None and not row["read"]:  # sent without a reading
            self._go_on()
        if self._is_over or not self.row["sent"] or self.difference is not None:
            self.ran_out |= row is None
            raise RecordEndsError("the recorded commands end here")
        self._is_over = True
        row = self.row
        replayed = np.concatenate([command.base_twist, command.qd])
        differs = replayed.view(np.uint64) != row["command"].view(np.uint64)
        if differs.any():
            first = int(np.argmax(differs))
            self.difference = Difference(
                number=self.sent,
                time=float(row["sent_time"]),
                velocity=_BASE[first] if first < 3 else self.description.arm.called(first - 3),
                recorded=float(row["command"][first]),
                replayed=float(replayed[first]),
            )
            raise RecordEndsError(str(self.difference))
        self.sent += 1
        self.clock.set(self._at, float(row["sent_time"]))
        return Command(base_twist=row["applied"][:3].copy(), qd=row["applied"][3:].copy())

    def grip(self, width: float, force: float) -> None:
        """Do nothing: the result is in the readings."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None: ...

    def _go_on(self) -> None:
        self._at += 1
        self._is_over = False
        row = self.row
        sent = [float(row["sent_time"])] if row["sent"] else []
        self.clock.set(self._at, float(row["time"]), *sent)

    def _reading(self, row: npt.NDArray[np.void]) -> RobotState:
        return reading(row, self._thing(row, "faults") or (), self._thing(row, "localised"))

    def _latest(self, field: str, max_age: float) -> Any:
        newest = self._thing(self.row, field)
        if newest is None or float(self.row["time"]) - newest.stamp > max_age:
            return None
        return newest

    def _thing(self, row: npt.NDArray[np.void], field: str) -> Any:
        """What a turn refers to: the same object as long as the number is the same."""
        number = int(row[field])
        known, thing = self._recalled.get(field, (0, None))
        if number == 0:
            return None
        if number > 0 and number != known:
            thing = self._recall(field, number)
            self._recalled[field] = number, thing
        return thing
