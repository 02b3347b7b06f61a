"""How a run ended, and its exit code."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


class End(Enum):
    """The ways a run can end."""

    SUCCESS = "success"
    FAILURE = "failure"
    """The tree failed."""
    CRASH = "crash"
    """A node of the tree raised an exception."""
    HARDWARE = "hardware fault"
    """The robot could not be read or commanded any more."""
    INTERRUPTED = "interrupted"

    @property
    def exit_code(self) -> int:
        """What the process tells the shell."""
        return {"success": 0, "failure": 1, "crash": 1, "hardware fault": 3}.get(self.value, 130)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How a run ended."""

    end: End
    reason: str
    """For people: what was achieved or what went wrong."""
    node: str = ""
    """The node that failed or crashed; empty if none did."""
    where: Behaviour | None = field(default=None, compare=False)
    """The node that `node` names, or that was at work; None if there is none to tell."""
    trace: str = ""
    """Where in the code a leaf crashed, as Python tells it; empty if none did."""
