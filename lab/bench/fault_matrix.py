"""What goes wrong in the bench of faults, and how: the rows of its matrix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core import Setup
from behaviours import Leaf
from hw import WallClock

_BLOCKED = 1.5
"""How long a leaf blocks [s of real time]."""

INTO = {"recover": 0.3, "navigate": 1.0, "carry": 1.0, "place": 0.5, "close": 0.05, "lock": 0.05}
"""How long after a phase has begun it goes wrong [s]: at full speed where there is one."""
USUALLY_INTO = 0.2
"""The same in other phases [s]."""

Plant = Callable[[Setup, list[Behaviour]], Callable[[], None]]
"""Does something to a run (its setup, the nodes of its tree); returns what undoes it."""


@dataclass(frozen=True, kw_only=True)
class Trouble:
    """One row of the matrix: something that goes wrong once in a run."""

    name: str
    lasts: float | None = None
    """How long [s]; None for the rest of the run, if the task does not clear it."""
    stops: bool = False
    """Whether the robot has to come to rest."""
    paced: bool = False
    """Whether it is about real time, and the run goes in real time."""
    plant: Plant | None = None
    """How it is done; None injects the fault of that name."""
    acknowledged: bool = False
    """Whether a stand-in for a person acknowledges that it is over."""

    def begin(self, setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
        """Let it go wrong; returns what ends it."""
        if self.plant is not None:
            return self.plant(setup, nodes)
        setup.robot.inject(self.name, inf if self.lasts is None else self.lasts)
        return lambda: None


def _running_leaf(nodes: list[Behaviour]) -> Leaf:
    return [n for n in nodes if isinstance(n, Leaf) and n.status is Status.RUNNING][-1]


def _in_place_of(owner: object, method: str, other: object) -> Callable[[], None]:
    """Put something in place of a method of one object; returns what undoes it."""
    vars(owner)[method] = other
    return lambda: vars(owner).pop(method, None)


def _leaf_raises(setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
    def update() -> Status:
        raise RuntimeError("a mistake in a leaf, injected")

    return _in_place_of(_running_leaf(nodes), "update", update)


def _leaf_blocks(setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
    leaf = _running_leaf(nodes)

    def update() -> Status:
        undo()
        WallClock().sleep_until(_BLOCKED)
        return leaf.update()

    undo = _in_place_of(leaf, "update", update)
    return undo


def _solver_gives_up(setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
    return _in_place_of(setup.controller, "_solve", lambda qp, q: None)


def _solver_raises(setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
    def solve(qp: object, q: object) -> None:
        raise ArithmeticError("the solver broke, injected")

    return _in_place_of(setup.controller, "_solve", solve)


TROUBLES = (
    Trouble(name="reflex"),
    Trouble(name="bumper"),
    Trouble(name="bumper again", stops=True),
    Trouble(name="emergency stop", lasts=1.0, stops=True, acknowledged=True),
    Trouble(name="stale pose", lasts=1.0, stops=True, acknowledged=True),
    Trouble(name="gripper dead"),
    Trouble(name="gripper halfway"),
    Trouble(name="object moved"),
    Trouble(name="object taken"),
    Trouble(name="frames lost", lasts=3.0),
    Trouble(name="frames late"),
    Trouble(name="frames frozen", lasts=3.0),
    Trouble(name="picture frozen", lasts=3.0),
    Trouble(name="frames black", lasts=3.0),
    Trouble(name="frames empty", lasts=3.0),
    Trouble(name="frames sparse", lasts=3.0),
    Trouble(name="frames in millimetres", lasts=3.0),
    Trouble(name="frames transposed", lasts=3.0),
    Trouble(name="state frozen", lasts=1.0, stops=True),
    Trouble(name="stamps frozen", lasts=1.0, stops=True),
    Trouble(name="state nan", lasts=0.2),
    Trouble(name="localisation jump"),
    Trouble(name="localisation drift"),
    Trouble(name="base ignores commands", lasts=2.0),
    Trouble(name="base too fast", lasts=2.0),
    Trouble(name="readings late", lasts=2.0),
    Trouble(name="readings slow", lasts=1.0, paced=True),
    Trouble(name="reading fails", stops=True),
    Trouble(name="reading breaks", stops=True),
    Trouble(name="sending fails", stops=True),
    Trouble(name="leaf raises", plant=_leaf_raises, stops=True),
    Trouble(name="leaf blocks", plant=_leaf_blocks, stops=True, paced=True),
    Trouble(name="solver gives up", plant=_solver_gives_up, lasts=0.5),
    Trouble(name="solver raises", plant=_solver_raises, stops=True),
)
"""All rows."""

QUICK = ("reflex", "gripper dead", "object taken", "state nan", "leaf raises")
"""The rows that `--quick` runs, in the phases `QUICK_PHASES`."""

QUICK_PHASES = ("carry", "place")
