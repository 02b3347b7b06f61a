"""What was tried and what was brought where: the figures of a task."""

from __future__ import annotations

from dataclasses import dataclass, field

from pinocchio import SE3

from hw import TaskTime


@dataclass(kw_only=True, eq=False)
class Carried:
    """One object on its way from where it was grasped to where it is placed."""

    begun: TaskTime
    """When the first attempt to grasp it began."""
    attempts: int = 0
    """How often the fingers closed for it."""
    grasp_time: float = 0.0
    """How long the attempt that succeeded took, from the first look to closed fingers [s]."""
    placed: TaskTime | None = None
    """When it was let go at its place."""


@dataclass(kw_only=True, eq=False)
class TaskLog:
    """Written by the behaviours, read by the summary and the status line."""

    attempts: int = 0
    """How often the fingers closed to grasp."""
    carried: list[Carried] = field(default_factory=list)
    """The objects in order; the last one may still be under way."""
    grip_height: float = 0.0
    """How high above what it stood on the held object is held [m]."""
    last_grasp: SE3 | None = None
    """wTg of the last attempt."""
    places_used: dict[str, int] = field(default_factory=dict)
    """How many places of every region are taken."""

    messages: list[tuple[TaskTime, str]] = field(default_factory=list)
    """What was told to people, and when."""

    @property
    def placed(self) -> int:
        """How many objects were let go at their place."""
        return sum(one.placed is not None for one in self.carried)

    def attempt(self, begun: TaskTime, now: TaskTime) -> None:
        """The fingers closed; `begun` is when this attempt began to look."""
        self.attempts += 1
        if not self.carried or self.carried[-1].placed is not None:
            self.carried.append(Carried(begun=begun))
        self.carried[-1].attempts += 1
        self.carried[-1].grasp_time = now - begun

    def say(self, now: TaskTime, text: str) -> None:
        """Tell people something."""
        self.messages.append((now, text))

    def place(self, now: TaskTime) -> None:
        """The held object was let go at its place."""
        self.carried[-1].placed = now
