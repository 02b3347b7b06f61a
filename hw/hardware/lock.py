"""Lock of a robot: one program commands it, and tells others which.

The lock is a claim on this computer, for all users, that the system releases when its holder ends.
Its holder answers requests with its identity and the time of its last command. The arm itself
refuses a commander on another computer; the base does not (docs/hardware.md).
"""

from __future__ import annotations

import getpass
import json
import os
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

from config import UserError
from hw.processes.claims import Claim, Holder, holder_of
from robots import HardwareFile

_SILENT = 2.0  # a commander without a command for this long is reported as silent [s]


class CommandedError(UserError):
    """Another program commands the robot."""


@dataclass(kw_only=True)
class Commander:
    """The program that commands a robot."""

    pid: int
    user: str
    program: str  # empty, like the rest, if it does not answer
    since: float  # [s since 1970]
    beat: float  # time of its last command [s since 1970]

    def __str__(self) -> str:
        if not self.program:
            return f"process {self.pid}, which does not answer"
        since = time.strftime("%H:%M", time.localtime(self.since))
        silent = time.time() - self.beat
        says = f", silent for {silent:.0f} s" if silent > _SILENT else ""
        return f"process {self.pid} of {self.user} (`{self.program}`, since {since}{says})"


class RobotLock:
    """The right to command one robot.

    Args:
        hardware: of the robot; two files with the same addresses are one robot.
    """

    def __init__(self, hardware: HardwareFile) -> None:
        self._robot = _name(hardware)
        self._claim = Claim(self._robot, self._introduce)
        program, now = " ".join([Path(sys.argv[0]).name, *sys.argv[1:3]]), time.time()
        self._who = Commander(pid=os.getpid(), user=_user(), program=program, since=now, beat=now)

    def take(self) -> Self:
        """Take it, until `release` or the end of this process.

        Raises:
            CommandedError: another program has it.
        """
        if self._claim.take() is None:
            who = _commander(holder_of(self._robot)) or "a program that ends now"
            raise CommandedError(
                f"the robot is commanded by {who}; a robot has one commander: end that one first"
            )
        return self

    def beat(self) -> None:
        """Record a command."""
        self._who.beat = time.time()

    def release(self) -> None:
        """Release it."""
        self._claim.release()

    def _introduce(self) -> str:
        return json.dumps(asdict(self._who))


def commander_of(hardware: HardwareFile) -> Commander | None:
    """The commander of a robot on this computer; None if there is none."""
    return _commander(holder_of(_name(hardware)))


def _name(hardware: HardwareFile) -> str:
    return f"robot {hardware.base.address} {hardware.base.port} {hardware.arm.address}"


def _commander(holder: Holder | None) -> Commander | None:
    if holder is None:
        return None
    try:
        answer = json.loads(holder.says)
        return Commander(
            pid=int(answer["pid"]),
            user=str(answer["user"]),
            program=str(answer["program"]),
            since=float(answer["since"]),
            beat=float(answer["beat"]),
        )
    except (ValueError, TypeError, LookupError):
        return Commander(pid=holder.pid, user="", program="", since=0.0, beat=0.0)


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError):
        return "somebody"
