"""Lock of a robot: one program of this computer commands it, and tells others which."""

import getpass
import sys
from pathlib import Path
from typing import Self

from config import UserError
from hw.processes.claims import Claim, holder_of
from robots import HardwareFile

_MACHINE = ("address", "port", "domain", "namespace")  # options that tell one robot from another


class CommandedError(UserError):
    """Another program commands the robot."""


class RobotLock:
    """The right to command one robot; two files with the same addresses are one robot."""

    def __init__(self, hardware: HardwareFile) -> None:
        self._hardware, self._claim = hardware, Claim(_name(hardware), _introduction)

    def take(self) -> Self:
        """Take it, until `release` or the end of this process; CommandedError: another has it."""
        if self._claim.take() is None:
            who = commander_of(self._hardware) or "a program that ends now"
            raise CommandedError(
                f"the robot is commanded by {who}; a robot has one commander: end that one first"
            )
        return self

    def release(self) -> None:
        """Release it."""
        self._claim.release()


def commander_of(hardware: HardwareFile) -> str:
    """The program that commands a robot on this computer, for people; empty if there is none."""
    holder = holder_of(_name(hardware))
    if holder is None:
        return ""
    return f"process {holder.pid}{holder.says or ', which does not answer'}"


def _introduction() -> str:
    try:
        user = getpass.getuser()
    except (OSError, KeyError):
        user = "somebody"
    return f" of {user} (`{' '.join([Path(sys.argv[0]).name, *sys.argv[1:3]])}`)"


def _name(hardware: HardwareFile) -> str:
    parts = hardware.base, hardware.arm
    return " ".join(["robot", *(str(getattr(one, key, "")) for one in parts for key in _MACHINE)])
