"""Log of a task: attempts, grips, carried objects and places."""

from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from statistics import median

import numpy as np
from pinocchio import SE3

from behaviours.core.parameter_types import Region
from config.arrays import Array
from hw import DepthFrame, RobotState, TaskTime
from perception import ColourName, Segment

_WINDOW = 0.2  # over which the width of fingers at rest is judged: a bump lasts less than half [s]
_CHANGES = 0.0005  # a smaller change between its halves is none [m]

_LIFTED = 0.05  # a hand this far from the grasp has lifted what it holds [m]
_SEVERAL = 1.6  # times what it covers at least: a larger piece may be several objects
_BESIDE = 0.1  # what falls nearer to where it was grasped is in its region again [m]


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
    colour: ColourName | None = None
    """That it was chosen by, if it was."""
    lifted: bool = False
    """Whether the hand that held it has left the place of the grasp."""


class Fingers:
    """The distance between the finger pads over time: one reading is weak evidence.

    Of fingers that move it is the newest reading, of fingers at rest the median of 0.2 s.
    """

    def __init__(self) -> None:
        self._readings: deque[tuple[float, float]] = deque()
        self.width = 0.0
        """[m]"""
        self.empty = 0.0
        """Width at which they have stopped on nothing [m]; more than 0 by dirt, or an offset."""

    @property
    def rest(self) -> bool:
        """Whether they have been at rest, at one width, for the time that is judged."""
        widths = [width for _, width in self._readings]
        half = len(widths) // 2
        long = half and self._readings[-1][0] - self._readings[0][0] >= _WINDOW - 0.02
        return bool(long) and abs(median(widths[:half]) - median(widths[half:])) < _CHANGES

    def note(self, state: RobotState, opening: float) -> None:
        """Take a reading; wider apart than an `opening` [m] of the hand is an offset."""
        if state.gripper_moving:
            self._readings.clear()
        self._readings.append((state.stamp, state.gripper_width))
        while state.stamp - self._readings[0][0] > _WINDOW:
            self._readings.popleft()
        self.width = median(width for _, width in self._readings)
        if self.rest:
            self.empty = max(self.empty, self.width - opening)


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
    rested: float | None = None
    """Where they came to rest first [m]."""

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
    carried_before: int
    """All that had been grasped before it."""
    region: Region
    most: int = 0
    """Largest number seen there, with those placed since."""
    pieces: Sequence[Segment] = ()
    """Seen there last."""
    fell: bool = False
    """Whether an object fell back that was not looked for since: it may have rolled out."""
    covers: float = inf
    """What it covers at least, if it may have been one of several that were seen as one [m^2]."""
    lacks: bool = False
    """Whether less was there when it was looked for: with others it may not be missed by number."""


@dataclass(kw_only=True, eq=False)
class TaskLog:
    """Written by the behaviours, read by the summary and the terminal."""

    attempts: int = 0
    """How often the fingers closed to grasp."""
    carried: list[Carried] = field(default_factory=list)
    """The objects in order; the last one may still be carried."""
    grip_height: float = 0.0
    """Height of the grasp above the surface that the held object stood on [m]."""
    grip_outline: Array | None = None
    """(K, 3) in e, see `GraspEstimate.outline`; None if the image did not show it all."""
    grip_opening: float | None = None
    """Distance between the finger pads that left room around it then [m]; None before a grasp."""
    floor_error: float | None = None
    """How much higher the camera saw that surface than the map has it [m]; None: not seen."""
    last_grasp: SE3 | None = None
    """oTg of the last attempt."""
    fingers: Fingers = field(default_factory=Fingers)
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
    _release: tuple[Grip, float, Callable[[], None]] | None = None
    """The grip that opens, the opening that counts as a release [m], and a callback."""
    messages: list[tuple[TaskTime, str]] = field(default_factory=list)
    """Texts for people, and when."""
    warnings: list[str] = field(default_factory=list)
    """What was wrong with the robot's surroundings of messages and maps, each once."""
    pictures: list[tuple[str, DepthFrame]] = field(default_factory=list)
    """Those to keep under a name; who has kept them removes them."""
    _kept: Counter[str] = field(default_factory=Counter)

    @property
    def placed(self) -> int:
        """How many objects were seen standing at their place."""
        return sum(one.placed is not None for one in self.carried)

    def note_hand(self, hand: SE3, grasped_at: SE3, empty: str | None, now: TaskTime) -> None:
        """Notice when the fingers lose what they have lifted.

        What falls over a region that was looked at, or beside where the fingers closed, may be back
        in there, which a look has to tell; else it is gone.

        Args:
            hand: its pose, in odometry.
            grasped_at: where the fingers closed.
            empty: why they hold nothing; None if they seem to hold something.
            now: task time.
        """
        one = self.in_hand
        if one is None or (self._release is not None and self._release[0] is self.grip):
            return
        way = hand.translation - grasped_at.translation
        if empty is None:
            one.lifted = one.lifted or bool(np.linalg.norm(way) > _LIFTED)
        elif one.lifted:
            one.lifted = False
            is_beside = bool(np.linalg.norm(way[:2]) <= _BESIDE)
            over = grasped_at if is_beside else hand
            below = [it for it in self.stocks.values() if it.region.is_below(over.translation)]
            for stock in below:
                stock.fell = True
                covers = self._covers(stock.pieces, grasped_at.translation)
                stock.covers = min(stock.covers, covers)
            if not below and not is_beside:
                one.let_go = now
                self.say(now, f"what was held is gone: {empty}")

    def _covers(self, pieces: Sequence[Segment], grasped_at: Array) -> float:
        """See `Stock.covers`, of what the fingers closed on: as long as it is wide between them."""
        width = (self.closing and self.closing.rested) or inf
        away = [float(np.linalg.norm((one.centre - grasped_at)[:2])) for one in pieces]
        area = pieces[int(np.argmin(away))].area if away else 0.0
        return width**2 if area > _SEVERAL * width**2 else inf

    def lost(self, stock: Stock) -> int:
        """How many objects left the hand since the first look and were not seen to stand.

        Of objects that touch and so count as one, nobody would miss them.
        """
        begun = self.carried[stock.carried_before :]
        return sum(one.let_go is not None and one.placed is None for one in begun)

    @property
    def in_hand(self) -> Carried | None:
        """The object that was grasped last, until it is released at its place."""
        last = self.carried[-1] if self.carried else None
        return last if last is not None and last.let_go is None else None

    def gripped(self, target: float) -> None:
        """Log a command to the fingers: target width [m]."""
        width = self.fingers.width
        self.grip = Grip(target=target, begun_at=width, widest=width, narrowest=width)
        if self.grip.is_closing:
            self.closing = self.grip

    def note_width(self, state: RobotState, opening: float) -> None:
        """Take a reading of the distance between the pads of a hand that opens so far [m]."""
        self.fingers.note(state, opening)
        for grip in (self.grip, self.closing):
            if grip is not None:
                grip.note(self.fingers.width)
        if self.grip is not None and self.grip.rested is None and self.fingers.rest:
            self.grip.rested = self.fingers.width
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

    def attempt(self, begun: TaskTime, now: TaskTime, colour: ColourName | None = None) -> None:
        """Log that the fingers closed on what has a colour; the attempt began at `begun`."""
        self.attempts += 1
        if self.in_hand is None:
            self.carried.append(Carried(begun=begun))
        self.carried[-1].attempts += 1
        self.carried[-1].colour = colour
        self.carried[-1].grasp_time = now.since(begun)

    def say(self, now: TaskTime, text: str) -> None:
        """Log a text for people."""
        self.messages.append((now, text))

    def warn(self, now: TaskTime, text: str) -> None:
        """Log a text for people once, which the summary has as a warning too."""
        if text not in self.warnings:
            self.warnings.append(text)
            self.say(now, text)

    def keep(self, file: str, frame: DepthFrame) -> str:
        """Keep a picture; returns its name, with a number from the second one of a file on."""
        self._kept[file] += 1
        name = file if self._kept[file] == 1 else f"{file}.{self._kept[file]}"
        self.pictures.append((name, frame))
        return name

    def note_stock(self, region: Region, pieces: Sequence[Segment]) -> None:
        """Log what was seen in a region, each piece at least one object."""
        first = Stock(placed_before=self.placed, carried_before=len(self.carried), region=region)
        stock = self.stocks.setdefault(region.name, first)
        stock.most = max(stock.most, self.placed - stock.placed_before + len(pieces))
        less = sum(one.area for one in stock.pieces) - sum(one.area for one in pieces)
        stock.lacks = stock.lacks or (stock.fell and less > 0.5 * stock.covers)
        stock.fell, stock.covers, stock.pieces = False, inf, pieces
