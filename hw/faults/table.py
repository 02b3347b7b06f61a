"""The table of faults: what can be injected, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from math import nan
from types import MappingProxyType

from config import UserError, suggest
from hw.faults.effect import Effect
from hw.faults.frames import (
    FramesFilled,
    FramesFrozen,
    FramesInMillimetres,
    FramesLate,
    FramesLost,
    FramesTransposed,
    PictureFrozen,
)
from hw.faults.motion import (
    BaseIgnoresCommands,
    BaseTooFast,
    GripperDead,
    GripperHalfway,
    SendingFails,
)
from hw.faults.objects import ObjectMoved, ObjectTaken
from hw.faults.readings import (
    ComesBack,
    FrozenStamps,
    FrozenState,
    LateReadings,
    LocalisationDrift,
    LocalisationJump,
    NotANumber,
    ReadingFails,
    Reported,
    SlowReading,
)
from hw.robot import HardwareError
from hw.state import Fault, FaultKind


class InjectionError(UserError):
    """A fault that cannot be injected."""


@dataclass(frozen=True, kw_only=True)
class Injectable:
    """One row of the table."""

    name: str
    make: Callable[[], Effect]
    what: str  # What happens, for people
    clearable: bool = False  # Whether `Robot.recover` clears it
    of_world: bool = False  # Whether it is done to the world, not to the robot


def _reported(kind: FaultKind, text: str, clearable: bool = False) -> Injectable:
    fault = Fault(kind=kind, text=f"{text}, injected", clearable=clearable)
    return Injectable(
        name=kind.value,
        make=partial(Reported, fault),
        what=f"the robot reports: {text}",
        clearable=clearable,
    )


def _gone(part: str) -> Callable[[], Exception]:
    return lambda: HardwareError(f"{part} does not answer, injected")


_bumped = Fault(kind=FaultKind.BUMPER, text="bumper of the base again, injected", clearable=True)

_TABLE = (
    _reported(FaultKind.REFLEX, "reflex of the arm", clearable=True),
    _reported(FaultKind.BUMPER, "bumper of the base", clearable=True),
    _reported(FaultKind.EMERGENCY_STOP, "emergency stop"),
    _reported(FaultKind.STALE_POSE, "stale pose of the base"),
    Injectable(
        name="bumper again",
        make=partial(ComesBack, _bumped, 0.3, 3),
        what="the robot reports: bumper of the base, and again after each of three recoveries",
    ),
    Injectable(name="gripper dead", make=GripperDead, what="the fingers do not move"),
    Injectable(name="gripper halfway", make=GripperHalfway, what="the fingers stop half way"),
    Injectable(name="frames lost", make=FramesLost, what="no frame arrives"),
    Injectable(name="frames late", make=partial(FramesLate, 0.3), what="frames arrive 0.3 s late"),
    Injectable(name="frames frozen", make=FramesFrozen, what="one frame, again and again"),
    Injectable(
        name="picture frozen",
        make=PictureFrozen,
        what="one picture, with fresh stamps and camera poses",
    ),
    Injectable(name="frames black", make=partial(FramesFilled, 0.0), what="every depth is 0"),
    Injectable(name="frames empty", make=partial(FramesFilled, nan), what="every depth is NaN"),
    Injectable(
        name="frames sparse",
        make=partial(FramesFilled, nan, 0.5),
        what="every second depth, at random, is NaN",
    ),
    Injectable(
        name="frames in millimetres",
        make=FramesInMillimetres,
        what="depth is in millimetres, and said to be in metres",
    ),
    Injectable(
        name="frames transposed", make=FramesTransposed, what="rows and columns are exchanged"
    ),
    Injectable(name="state frozen", make=FrozenState, what="one reading, again, with fresh stamps"),
    Injectable(name="stamps frozen", make=FrozenStamps, what="the stamps of readings stand still"),
    Injectable(name="state nan", make=NotANumber, what="the joint positions read NaN"),
    Injectable(
        name="localisation jump",
        make=partial(LocalisationJump, 0.2, 15.0),
        what="the base believes to be 0.2 m and 15° off",
    ),
    Injectable(
        name="localisation drift",
        make=partial(LocalisationDrift, 0.03),
        what="the base adds 3 % to the distance that it drives",
    ),
    Injectable(
        name="base ignores commands", make=BaseIgnoresCommands, what="the base rolls to a stop"
    ),
    Injectable(
        name="base too fast",
        make=partial(BaseTooFast, 3.0),
        what="the base is three times as fast as told",
    ),
    Injectable(
        name="readings late", make=partial(LateReadings, 0.05), what="readings arrive 50 ms late"
    ),
    Injectable(
        name="readings slow",
        make=partial(SlowReading, 0.03),
        what="every reading blocks the loop for 30 ms of real time",
    ),
    Injectable(
        name="reading fails",
        make=partial(ReadingFails, _gone("the robot")),
        what="`read` raises HardwareError",
    ),
    Injectable(
        name="reading breaks",
        make=partial(ReadingFails, partial(ConnectionResetError, "connection lost, injected")),
        what="`read` raises an OSError",
    ),
    Injectable(
        name="sending fails",
        make=partial(SendingFails, _gone("the robot")),
        what="`send` raises HardwareError",
    ),
    Injectable(
        name="object moved",
        make=partial(ObjectMoved, 0.1),
        what="an object is pushed aside by 0.1 m; a held one is dropped",
        of_world=True,
    ),
    Injectable(
        name="object taken",
        make=ObjectTaken,
        what="an object is taken away, out of the hand too, until the fault is cleared",
        of_world=True,
    ),
)

INJECTABLE: Mapping[str, Injectable] = MappingProxyType({row.name: row for row in _TABLE})
"""What can be injected, by name."""


def injectable(name: str) -> Injectable:
    """The row of that name.

    Raises:
        InjectionError: there is none.
    """
    if name not in INJECTABLE:
        raise InjectionError(f"no fault is called `{name}`; {suggest(name, INJECTABLE)}")
    return INJECTABLE[name]
