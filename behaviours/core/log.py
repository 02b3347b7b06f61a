"""Log of a task: attempts, grips, carried objects and places."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from hw import DepthFrame, TaskTime


@dataclass(kw_only=True, eq=False)
class Carried:
    """One object, from its first grasp attempt to its place."""

    begun: TaskTime
    """Start of the first attempt to grasp it."""
    attempts: int = 0
    """How often the fingers closed for it."""
    grasp_time: float = 0.0
    """Duration of the successful attempt, from the first look to closed fingers [s]."""
    let_go: TaskTime | None = None
    """When the fingers opened at its place."""
    placed: TaskTime | None = None
    """When it was seen standing at its place."""
    lifted: bool = False
    """Whether the hand that held it has left the place of the grasp."""


@dataclass(kw_only=True, eq=False)
class Grip:
    """One command to the fingers, and their motion since."""

    target: float
    """Commanded width [m]."""
    begun_at: float
    """Width at the command [m]."""
    widest: float
    """Largest width since [m]."""
    narrowest: float
    """Smallest width since [m]."""

    @property
    def is_closing(self) -> bool:
        """Whether the command was to close."""
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
    """Objects seen in a region that they are taken from."""

    placed_before: int
    """Objects placed before the first look."""
    dropped_before: int
    """Those that had left the hand before it otherwise."""
    carried_before: int
    """All that had been grasped before it."""
    most: int = 0
    """Largest number seen there, with those placed since."""


@dataclass(kw_only=True, eq=False)
class TaskLog:
    """Written by the behaviours, read by the summary and the terminal."""

    attempts: int = 0
    """How often the fingers closed to grasp."""
    carried: list[Carried] = field(default_factory=list)
    """The objects in order; the last one may still be carried."""
    grip_height: float = 0.0
    """Height of the grasp above the surface that the held object stood on [m]."""
    grip_outline: npt.NDArray[np.float64] | None = None
    """(K, 3) in e, see `GraspEstimate.outline`; None if the image did not show it all."""
    grip_opening: float | None = None
    """Distance between the finger pads that left room around it then [m]; None before a grasp."""
    floor_error: float | None = None
    """How much higher the camera saw that surface than the map has it [m]; None: not seen."""
    last_grasp: SE3 | None = None
    """wTg of the last attempt."""
    grip: Grip | None = None
    """The last command to the fingers; None before the first."""
    closing: Grip | None = None
    """The last command to close them."""
    places_used: dict[str, set[int]] = field(default_factory=dict)
    """Numbers of the used places of every region; the first is 1."""
    places_blocked: dict[str, set[int]] = field(default_factory=dict)
    """The same of places at which lowering an object failed."""
    places_unseen: dict[str, set[int]] = field(default_factory=dict)
    """The same of places that the camera did not see: another object may hide them less."""
    stocks: dict[str, Stock] = field(default_factory=dict)
    """By the name of the region."""
    dropped: list[npt.NDArray[np.float64]] = field(default_factory=list)
    """(3,) where the hand was on the map when a lifted object left it, but at its place [m]."""
    _release: tuple[Grip, float, Callable[[], None]] | None = None
    """The grip that opens, the opening that counts as a release [m], and a callback."""
    messages: list[tuple[TaskTime, str]] = field(default_factory=list)
    """Texts for people, and when."""
    pictures: list[tuple[str, DepthFrame]] = field(default_factory=list)
    """Those to keep under a name; who has kept them removes them."""
    _kept: Counter[str] = field(default_factory=Counter)

    @property
    def placed(self) -> int:
        """How many objects were seen standing at their place."""
        return sum(one.placed is not None for one in self.carried)

    @property
    def is_letting_go(self) -> bool:
        """Whether the fingers open to set down what they hold."""
        return self._release is not None and self._release[0] is self.grip

    def note_hand(self, mTe: SE3, has_left: bool, empty: str | None, now: TaskTime) -> None:
        """Log what the fingers say of the object in the hand, and notice when it is lost.

        Args:
            mTe: the hand on the map.
            has_left: whether it is away from where the fingers closed.
            empty: why it holds nothing; None if it seems to hold something.
            now: task time.
        """
        one = self.in_hand
        if one is None or self.is_letting_go:
            return
        if empty is None:
            one.lifted = one.lifted or has_left
        elif one.lifted:
            one.lifted = False
            self.dropped.append(mTe.translation.copy())
            if self.grip is not None and self.grip.is_closing:
                x, y, _ = mTe.translation
                self.say(now, f"what was held was lost around {x:.2f}, {y:.2f}: {empty}")

    def astray(self, stock: Stock, mTr: SE3, size: npt.NDArray[np.float64]) -> int:
        """How many objects were lifted since the first look, and neither placed nor put back.

        What left the hand over the region, at `mTr` on the map and of `size` (3,) [m], is there:
        the next look finds it. Of two that touched and count as one, nobody would miss the other.
        """
        where = [mTr.actInv(point)[:2] for point in self.dropped[stock.dropped_before :]]
        elsewhere = sum(bool((np.abs(xy) > size[:2] / 2.0).any()) for xy in where)
        begun = self.carried[stock.carried_before :]
        return elsewhere + sum(one.let_go is not None and one.placed is None for one in begun)

    @property
    def in_hand(self) -> Carried | None:
        """The object that was grasped last, until it is released at its place."""
        last = self.carried[-1] if self.carried else None
        return last if last is not None and last.let_go is None else None

    def gripped(self, target: float, width: float) -> None:
        """Log a command to the fingers: target and present width [m]."""
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
        """Call `then` once the opening fingers have moved by `opened` [m], even without the leaf.

        Another command to the fingers cancels it.
        """
        assert self.grip is not None
        self._release = (self.grip, opened, then)

    def attempt(self, begun: TaskTime, now: TaskTime) -> None:
        """Log that the fingers closed; the attempt began at `begun`."""
        self.attempts += 1
        if self.in_hand is None:
            self.carried.append(Carried(begun=begun))
        self.carried[-1].attempts += 1
        self.carried[-1].grasp_time = now.since(begun)

    def say(self, now: TaskTime, text: str) -> None:
        """Log a text for people."""
        self.messages.append((now, text))

    def keep(self, file: str, frame: DepthFrame) -> str:
        """Keep a picture; returns its name, with a number from the second one of a file on."""
        self._kept[file] += 1
        name = file if self._kept[file] == 1 else f"{file}.{self._kept[file]}"
        self.pictures.append((name, frame))
        return name

    def note_stock(self, region: str, standing: int) -> None:
        """Log that at least `standing` objects were seen in a region."""
        here = Stock(
            placed_before=self.placed,
            dropped_before=len(self.dropped),
            carried_before=len(self.carried),
        )
        stock = self.stocks.setdefault(region, here)
        stock.most = max(stock.most, self.placed - stock.placed_before + standing)
