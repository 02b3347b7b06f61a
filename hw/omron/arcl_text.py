"""The lines of the text interface, and what they tell.

What is in Omron's manual (I617-E-01) is marked [M], what was read in drivers [D].
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from enum import Enum

_LONGEST_LINE = 65536


class Motors(Enum):
    """What `queryMotors` says, and events besides [M]."""

    ENABLED = "motors enabled"
    DISABLED = "motors disabled"
    PRESSED = "estop pressed"
    RELIEVED = "estop relieved"


@dataclass(frozen=True)
class ArclState:
    """What the text interface told last."""

    motors: Motors | None = None
    faults: tuple[str, ...] = ()
    score: float | None = None
    """Of the localisation, 0 to 1."""
    error: str = ""
    """The last `Error:` line."""
    lost: str = ""
    """Why the connection is gone; empty while it is there."""


class Lines:
    """Cuts a stream of bytes into lines without their ends."""

    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> list[str]:
        """The lines that are complete with these bytes."""
        *lines, self._buffer = (self._buffer + data).split(b"\n")
        self._buffer = self._buffer[-_LONGEST_LINE:]
        return [line.decode("utf-8", "replace").strip() for line in lines]

    @property
    def rest(self) -> str:
        """A line that has not ended yet: a prompt."""
        return self._buffer.decode("utf-8", "replace").strip()


class Reader:
    """Makes a state of lines."""

    def __init__(self) -> None:
        self.state = ArclState()
        self._listed: list[str] = []

    def take(self, line: str) -> None:
        """One line."""
        low = line.lower()
        key, _, value = line.partition(":")
        match key.lower():
            case "faultlist":
                self._listed.append(" ".join(value.split()[:2]))
            case "end of faultlist":
                self.state = replace(self.state, faults=tuple(self._listed))
                self._listed = []
            case "localizationscore":
                with suppress(ValueError):
                    self.state = replace(self.state, score=float(value))
            case "error":
                self.state = replace(self.state, error=value.strip())
            case _:
                for motors in Motors:
                    if low.startswith(motors.value):
                        self.state = replace(self.state, motors=motors)


def tells_setting(line: str) -> bool:
    """Whether a line tells one value of the configuration [M]."""
    return line.lower().startswith("getconfigsectionvalue:")


def setting_of(line: str) -> tuple[str, float | str]:
    """Name and value of a setting; a number where it is one."""
    name, _, value = line.partition(":")[2].strip().partition(" ")
    with suppress(ValueError):
        return name, float(value)
    return name, value.strip()
