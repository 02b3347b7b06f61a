"""Lock of a robot: one program of this computer commands it, and others are told which."""

import os
from pathlib import Path
from typing import Self

from config import UserError
from hw.claims import Claim, holder_of
from robots import DriverOptions, HardwareFile

_WHERE = ("address", "host", "ip", "port", "device", "serial", "url", "domain", "namespace")
"""Options that tell one machine from another."""


class CommandedError(UserError):
    """Another program commands the robot."""


class RobotLock:
    """The right to command one robot; two files with the same machines are one robot."""

    def __init__(self, hardware: HardwareFile) -> None:
        self._hardware, self._claim = hardware, Claim(_name(hardware))

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
    pid = holder_of(_name(hardware))
    if pid is None:
        return ""
    process = Path(f"/proc/{pid}")
    try:
        words = (process / "cmdline").read_text().replace("\0", " ").split()
        return f"process {pid} of {process.owner()} (`{' '.join(words)[:80]}`)"
    except (OSError, KeyError):
        return f"process {pid}"


def _name(hardware: HardwareFile) -> str:
    return f"robot {_machine(hardware.base)} {_machine(hardware.arm)}"


def _machine(part: DriverOptions) -> list[str]:
    """Where a part is; if it does not say, its driver and its options, but measures and switches.

    With another speed limit it is the same machine.
    """
    options = part.model_dump()
    where = [options.get(key) for key in _WHERE]
    if all(one in (None, "") for one in where):
        told = [options[key] for key in sorted(options)]
        where = [
            one for one in told if isinstance(one, str | int | Path) and not isinstance(one, bool)
        ]
    return [os.path.realpath(str(one)) if str(one).startswith("/") else str(one) for one in where]
