"""Recording of everything that the loop gets from its robot and sends to it, for a replay."""

from collections.abc import Callable
from concurrent.futures import Future
from enum import IntEnum
from functools import partial
from math import inf, nan
from typing import Generic, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller import Command
from hw.clock import Clock, Result
from hw.robot import Camera, Laser, Robot, RobotWrapper, Seen, Sensor
from hw.state import DepthFrame, Fault, LaserScan, LocalisedPose, PartStamps, RobotState


def turn_type(j: int) -> np.dtype[np.void]:
    """The type of a turn of the loop, for an arm of j joints.

    Its number from 0, the time of its reading [s], whether a person had ended
    the run, whether there was a reading, the action of the loop (`Turn`), whether a person
    acknowledged an emergency stop; the reading (`battery` NaN: not reported; `parts` are the stamps
    of arm, base and gripper); the frame of the camera and the scan of the laser; whether a command
    was sent, its time [s], command and applied command (base twist, joint velocities). Sets of
    faults, localised poses, frames and scans are numbers of what `Notes.thing` got (from 1; 0:
    none, -1: not asked for). Times are what the loop got from the session's clock, since the gate
    decides by them. `wTb` is the base in odometry, named as in the first recordings.
    """
    return np.dtype(
        [
            *(("number", "u4"), ("time", "f8"), ("stopped", "?"), ("read", "?"), ("turn", "u1")),
            *(("acknowledged", "?"), ("stamp", "f8"), ("wTb", "f8", (3, 4))),
            *(("base_twist", "f8", 3), ("q", "f8", (j,)), ("qd", "f8", (j,)), ("width", "f8")),
            *(("moving", "?"), ("recovering", "?"), ("battery", "f8"), ("parts_told", "?")),
            *(("parts", "f8", 3), ("faults", "u4")),
            *(("localised", "u4"), ("frame", "i4"), ("scan", "i4"), ("sent", "?")),
            *(("sent_time", "f8"), ("command", "f8", (3 + j,)), ("applied", "f8", (3 + j,))),
        ]
    )


class Turn(IntEnum):
    """What the loop did with a reading."""

    NONE = 0  # only braking
    TREE = 1  # ticked the tree
    PAUSED = 2  # the tree was paused by a person


Thing: TypeAlias = tuple[Fault, ...] | LocalisedPose | DepthFrame | LaserScan
"""What turns refer to by a number."""


class Notes(Protocol):
    """Receiver of a recording; its methods must not raise or block."""

    def turn(self, row: npt.NDArray[np.void]) -> None:
        """A turn is complete: a row of `turn_type`; the array is reused afterwards."""

    def thing(self, field: str, number: int, thing: Thing) -> None:
        """What a number in `faults`, `localised`, `frame` or `scan` of the turns stands for."""


class RecordedClock:
    """The session's clock, which remembers the answers that the loop got."""

    def __init__(self, clock: Clock) -> None:
        self._clock, self.is_real = clock, clock.is_real
        self._first: float | None = None
        self.latest = clock.now()  # answered last [s]

    def now(self) -> float:
        """Seconds since the session began [s]."""
        self.latest = self._clock.now()
        self._first = self.latest if self._first is None else self._first
        return self.latest

    def sleep_until(self, stamp: float) -> None:
        """Until `stamp` [s]."""
        self._clock.sleep_until(stamp)

    def due(self, work: Future[Result], seconds: float) -> Future[Result]:
        """As of the session's clock."""
        return self._clock.due(work, seconds)

    @property
    def lost(self) -> float:
        """As of the session's clock."""
        return self._clock.lost

    def begin_turn(self) -> None:
        """The next answer is the time of a new turn."""
        self._first = None

    @property
    def turn(self) -> float:
        """The time of this turn [s]."""
        return self.now() if self._first is None else self._first


class _Asked(Generic[Seen]):
    def __init__(self, field: str, ask: Callable[[], Seen | None]) -> None:
        self.field = field
        self.ask: Callable[[], Seen | None] = ask
        self.newest: Seen | None = None
        self.is_asked = False


class RecordedRobot(RobotWrapper):
    """A robot whose turns are recorded from `record` on; in a turn all get the same frame."""

    def __init__(self, robot: Robot, clock: Clock) -> None:
        super().__init__(robot)
        self.inner = robot  # the robot inside
        self.clock = RecordedClock(clock)  # session time for the loop
        self._notes: Notes | None = None
        self._empty = np.zeros((), turn_type(len(robot.description.arm.joints)))
        self._empty["frame"] = self._empty["scan"] = -1
        self._empty["battery"] = nan
        self._row = self._empty.copy()
        self._is_open = False
        self._stopped = False
        self._turns = 0
        self._known_faults: dict[tuple[Fault, ...], int] = {}
        self._noted: dict[str, tuple[int, Thing]] = {}  # newest of a field, with its number
        self.broken = ""  # why a replay is impossible; empty otherwise
        self._frames = _Asked("frame", lambda: self._robot.camera.latest(inf))
        self._scans = _Asked("scan", lambda: self._robot.laser.latest(inf))

    def record(self, notes: Notes) -> None:
        """Record every turn from the next reading on."""
        self._notes = notes

    def note_turn(self, turn: Turn) -> None:
        """Record what the loop does with the last reading."""
        self._row["turn"] = turn

    def note_acknowledged(self) -> None:
        """Record that a person has acknowledged an emergency stop in this turn."""
        self._row["acknowledged"] = True

    def note_stopped(self) -> None:
        """Record that a person had ended the run before the coming turn."""
        self._stopped = True

    def end(self) -> None:
        """Hand on the last turn, and stop recording."""
        self._hand_on()
        self._notes = None

    @property
    def camera(self) -> Camera:
        """The camera of the robot, asked once a turn."""
        return Sensor(partial(self._latest, self._frames))

    @property
    def laser(self) -> Laser:
        """The laser of the robot, asked once a turn."""
        return Sensor(partial(self._latest, self._scans))

    def read(self) -> RobotState:
        """See `Robot`."""
        self._hand_on()
        self._frames.is_asked = self._scans.is_asked = False
        self.clock.begin_turn()
        state = self._robot.read()
        if self._notes is not None:
            self._begin()
            self._row["read"] = True
            try:
                _put(self._row, state)
            except (ValueError, TypeError) as error:  # a driver's mistake; the gate judges it
                self.broken = self.broken or f"a reading has a wrong shape ({error})"
            self._row["faults"] = self._faults(state.faults)
            self._row["localised"] = self._number("localised", state.localised)
        return state

    def send(self, command: Command) -> Command:
        """See `Robot`."""
        applied = self._robot.send(command)
        if self._notes is not None:
            if not self._is_open or self._row["sent"]:
                self._hand_on()
                self._begin()
            row = self._row
            row["sent"], row["sent_time"] = True, self.clock.latest
            try:
                row["command"][:3], row["command"][3:] = command.base_twist, command.qd
                row["applied"][:3], row["applied"][3:] = applied.base_twist, applied.qd
            except (ValueError, TypeError) as error:
                self.broken = self.broken or f"a command has a wrong shape ({error})"
        return applied

    def _latest(self, sensor: _Asked[Seen], max_age: float) -> Seen | None:
        if not sensor.is_asked:
            sensor.newest, sensor.is_asked = sensor.ask(), True
            if self._notes is not None:
                self._row[sensor.field] = self._number(sensor.field, sensor.newest)
        newest = sensor.newest
        if newest is None or self.clock.turn - newest.stamp > max_age:
            return None
        return newest

    def _begin(self) -> None:
        self._row = self._empty.copy()
        self._row["number"], self._turns = self._turns, self._turns + 1
        self._row["stopped"] = self._stopped
        self._is_open = True

    def _hand_on(self) -> None:
        if self._is_open and self._notes is not None:
            self._row["time"] = self.clock.turn
            self._notes.turn(self._row)
        self._is_open = False

    def _number(self, field: str, thing: Thing | None) -> int:
        """The number of a thing; the same object has the same number."""
        if thing is None:
            return 0
        number, last = self._noted.get(field, (0, None))
        if thing is not last:
            number += 1
            self._noted[field] = number, thing
            if self._notes is not None:
                self._notes.thing(field, number, thing)
        return number

    def _faults(self, faults: tuple[Fault, ...]) -> int:
        """The number of a set of faults; equal ones have the same number."""
        if not faults:
            return 0
        if faults not in self._known_faults:
            self._known_faults[faults] = self._number("faults", faults)
        return self._known_faults[faults]


def _put(row: npt.NDArray[np.void], state: RobotState) -> None:
    row["stamp"] = state.stamp
    row["wTb"][:, :3], row["wTb"][:, 3] = state.oTb.rotation, state.oTb.translation
    row["base_twist"], row["q"], row["qd"] = state.base_twist, state.q, state.qd
    row["width"] = state.gripper_width
    row["moving"], row["recovering"] = state.gripper_moving, state.recovering
    if state.battery is not None:
        row["battery"] = state.battery
    if state.stamps is not None:
        row["parts_told"], row["parts"] = True, state.stamps


def reading(
    row: npt.NDArray[np.void], faults: tuple[Fault, ...], localised: LocalisedPose | None
) -> RobotState:
    """The reading of a turn, bit for bit."""
    battery = float(row["battery"])
    return RobotState(
        stamp=float(row["stamp"]),
        oTb=SE3(row["wTb"][:, :3].copy(), row["wTb"][:, 3].copy()),
        base_twist=row["base_twist"].copy(),
        q=row["q"].copy(),
        qd=row["qd"].copy(),
        gripper_width=float(row["width"]),
        gripper_moving=bool(row["moving"]),
        recovering=bool(row["recovering"]),
        faults=faults,
        battery=None if np.isnan(battery) else battery,
        localised=localised,
        stamps=PartStamps(*row["parts"].tolist()) if row["parts_told"] else None,
    )
