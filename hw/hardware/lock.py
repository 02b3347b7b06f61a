"""One program commands a robot; a second one is told which.

The lock is a file of this computer that the system lets go of when its holder ends, however it
ends. Its holder writes into it who it is, and with every command, but not more often than every
half second, when it commanded last: its heartbeat. The arm itself refuses a commander of another
computer; the base does not (docs/hardware.md).
"""

from __future__ import annotations

import fcntl
import getpass
import json
import os
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

from config import UserError
from hw.clock import stopwatch
from robots import HardwareFile

_BEAT = 0.5
"""[s]"""
_SILENT = 2.0
"""A commander that has commanded nothing for so long is told to be silent [s]."""


class CommandedError(UserError):
    """Another program commands the robot."""


@dataclass(kw_only=True)
class Commander:
    """Who commands a robot."""

    pid: int
    user: str
    program: str
    since: float
    """[s since 1970]"""
    beat: float
    """When it commanded last [s since 1970]."""

    def __str__(self) -> str:
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
        self._path = _path(hardware)
        self._file: int | None = None
        self._beat = 0.0
        self._who: Commander | None = None

    def take(self) -> Self:
        """Take it, until `release` or the end of this process.

        Raises:
            CommandedError: another program has it.
        """
        if self._file is not None:
            return self
        file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            who = _read(file) or "another program"
            os.close(file)
            raise CommandedError(
                f"the robot is commanded by {who}; a robot has one commander: end that one first"
            ) from None
        self._file = file
        program = " ".join([Path(sys.argv[0]).name, *sys.argv[1:3]])
        self._who = Commander(
            pid=os.getpid(), user=_user(), program=program, since=time.time(), beat=time.time()
        )
        self._write()
        return self

    def beat(self) -> None:
        """Tell that a command was given."""
        if self._who is not None and stopwatch() - self._beat > _BEAT:
            self._who.beat = time.time()
            self._write()

    def release(self) -> None:
        """Let go of it."""
        if self._file is not None:
            os.ftruncate(self._file, 0)
            os.close(self._file)
            self._file = self._who = None

    def _write(self) -> None:
        assert self._file is not None
        assert self._who is not None
        self._beat = stopwatch()
        text = json.dumps(asdict(self._who)).encode()
        os.pwrite(self._file, text.ljust(1000), 0)


def commander_of(hardware: HardwareFile) -> Commander | None:
    """Who commands a robot from this computer; None if nobody does."""
    try:
        file = os.open(_path(hardware), os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return _read(file)
    finally:
        os.close(file)
    return None


def _path(hardware: HardwareFile) -> Path:
    name = f"{hardware.base.address}-{hardware.base.port}-{hardware.arm.address}"
    plain = "".join(letter if letter.isalnum() else "-" for letter in name)
    return Path(tempfile.gettempdir()) / f"frankie-task-robot-{plain}.lock"


def _read(file: int) -> Commander | None:
    try:
        return Commander(**json.loads(os.pread(file, 1000, 0)))
    except (ValueError, TypeError):
        return None


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError):
        return "somebody"
