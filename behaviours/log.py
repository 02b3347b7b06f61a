"""What was tried and what was brought where: the figures of a task."""

from __future__ import annotations

from collections.abc import Callable
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
    let_go: TaskTime | None = None
    """When the fingers opened at its place."""
    placed: TaskTime | None = None
    """When it was seen standing at its place."""


@dataclass(kw_only=True, eq=False)
class Grip:
    """One command to the fingers, and what they have done since."""

    target: float
    """The width that they were told to go to [m]."""
    begun_at: float
    """The width that they had then [m]."""
    widest: float
    """The largest width since [m]."""
    narrowest: float
    """The smallest width since [m]."""

    @property
    def is_closing(self) -> bool:
        """Whether it was to bring them nearer to each other."""
        return self.target < self.begun_at

    @property
    def moved(self) -> float:
        """How far they have moved since [m]."""
        return max(self.widest - self.begun_at, self.begun_at - self.narrowest)

    def note(self, width: float) -> None:
        """Take a reading of the width [m]."""
        self.widest, self.narrowest = max(self.widest, width), min(self.narrowest, width)


@dataclass(kw_only=True, eq=False)
class Stock:
    """What was seen in a region that objects are taken from."""

    placed_before: int
    """How many had been placed when it was first looked at."""
    most: int = 0
    """How many have been seen there at least, those placed since counted in."""


@dataclass(kw_only=True, eq=False)
class TaskLog:
    """Written by the behaviours, read by the summary and the terminal."""

    attempts: int = 0
    """How often the fingers closed to grasp."""
    carried: list[Carried] = field(default_factory=list)
    """The objects in order; the last one may still be under way."""
    grip_height: float = 0.0
    """How high above what it stood on the held object is held [m]."""
    last_grasp: SE3 | None = None
    """wTg of the last attempt."""
    grip: Grip | None = None
    """The last command to the fingers; None before the first."""
    closing: Grip | None = None
    """The last one that was to close them."""
    places_used: dict[str, set[int]] = field(default_factory=dict)
    """The numbers of the places of every region that are taken; the first is 1."""
    places_blocked: dict[str, set[int]] = field(default_factory=dict)
    """Those at which lowering an object failed."""
    stocks: dict[str, Stock] = field(default_factory=dict)
    """What was seen in the regions that were looked into, by their name."""
    _release: tuple[Grip, float, Callable[[], None]] | None = None
    """The grip that lets go, from which opening on [m], and what is done then."""

    messages: list[tuple[TaskTime, str]] = field(default_factory=list)
    """What was told to people, and when."""

    @property
    def placed(self) -> int:
        """How many objects were seen standing at their place."""
        return sum(one.placed is not None for one in self.carried)

    @property
    def in_hand(self) -> Carried | None:
        """The object that was grasped last, if it was not let go at its place."""
        last = self.carried[-1] if self.carried else None
        return last if last is not None and last.let_go is None else None

    def gripped(self, target: float, width: float) -> None:
        """The fingers, now at a width, were told to go to another one; both [m]."""
        self.grip = Grip(target=target, begun_at=width, widest=width, narrowest=width)
        if self.grip.is_closing:
            self.closing = self.grip

    def note_width(self, width: float) -> None:
        """Take a reading of the distance between the finger pads [m]."""
        for grip in (self.grip, self.closing):
            if grip is not None:
                grip.note(width)
        if self._release is not None:
            letting_go, opened, then = self._release
            if letting_go is self.grip and letting_go.moved > opened:
                self._release = None
                then()

    def when_let_go(self, opened: float, then: Callable[[], None]) -> None:
        """Do something once the fingers, just told to open, have opened so far [m].

        That is so whatever becomes of the behaviour: fingers that open go on with it when the arm
        has stopped. Another command to the fingers calls it off.
        """
        assert self.grip is not None
        self._release = (self.grip, opened, then)

    def attempt(self, begun: TaskTime, now: TaskTime) -> None:
        """The fingers closed; `begun` is when this attempt began to look."""
        self.attempts += 1
        if self.in_hand is None:
            self.carried.append(Carried(begun=begun))
        self.carried[-1].attempts += 1
        self.carried[-1].grasp_time = now.since(begun)

    def say(self, now: TaskTime, text: str) -> None:
        """Tell people something."""
        self.messages.append((now, text))

    def note_stock(self, region: str, standing: int) -> None:
        """At least so many objects were seen standing in a region."""
        stock = self.stocks.setdefault(region, Stock(placed_before=self.placed))
        stock.most = max(stock.most, self.placed - stock.placed_before + standing)
