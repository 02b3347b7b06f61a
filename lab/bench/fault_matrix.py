"""Rows of the fault matrix: the faults, how they are injected, and the required reaction."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from pathlib import Path

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core import Setup
from behaviours import Leaf
from hw import WallClock

TREE = Path(__file__).parent / "tasks/one_object.yaml"
_BLOCKED = 1.5  # duration for which a leaf blocks [s of real time]

INTO = {"recover": 0.3, "navigate": 1.0, "carry": 1.0, "place": 0.5, "close": 0.05, "lock": 0.05}
"""Time of the injection after the beginning of a phase [s]: at full speed where there is one."""
USUALLY_INTO = 0.2  # the same in other phases [s]

Inject = Callable[[Setup, list[Behaviour]], Callable[[], None]]
"""Injects a fault into a run (its setup, the nodes of its tree); returns what ends it."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One row of the matrix: a fault that occurs once in a run."""

    name: str
    duration: float | None = None  # [s]; None for the rest of the run, if nothing clears it
    stops: bool = False  # whether the robot must come to rest
    real_clock: bool = False  # whether it is about real time: the robot waits for nothing
    inject: Inject | None = None  # None injects the fault of that name into the robot
    acknowledged: bool = False  # whether a simulated person acknowledges that it is over

    def begin(self, setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
        """Begin the fault; returns what ends it."""
        if self.inject is not None:
            return self.inject(setup, nodes)
        return _give(setup, self.name, inf if self.duration is None else self.duration)


def _give(setup: Setup, fault: str, duration: float = inf) -> Callable[[], None]:
    assert setup.injector is not None
    setup.injector.inject(fault, duration)
    return lambda: None


def _running_leaf(nodes: list[Behaviour]) -> Leaf:
    return [n for n in nodes if isinstance(n, Leaf) and n.status is Status.RUNNING][-1]


def _replace_method(owner: object, method: str, other: object) -> Callable[[], None]:
    """Replace a method of one object; returns what undoes it."""
    assert callable(getattr(owner, method))  # of another name nothing would happen
    vars(owner)[method] = other
    return lambda: vars(owner).pop(method, None)


def _leaf_raises(setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
    def update() -> Status:
        raise RuntimeError("a mistake in a leaf, injected")

    return _replace_method(_running_leaf(nodes), "update", update)


def _leaf_blocks(setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
    leaf = _running_leaf(nodes)

    def update() -> Status:
        undo()
        WallClock().sleep_until(_BLOCKED)
        return leaf.update()

    undo = _replace_method(leaf, "update", update)
    return undo


def _solver(setup: Setup) -> object:
    """Of the controller, which keeps it to itself."""
    return vars(setup.controller)["_solver"]


def _solver_gives_up(setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
    return _replace_method(_solver(setup), "solve", lambda qp, rows=None: None)


def _solver_raises(setup: Setup, nodes: list[Behaviour]) -> Callable[[], None]:
    def solve(qp: object, rows: object = None) -> None:
        raise ArithmeticError("the solver broke, injected")

    return _replace_method(_solver(setup), "solve", solve)


FAULTS = (
    Fault(name="reflex"),
    Fault(name="bumper"),
    Fault(name="bumper again", stops=True),
    Fault(name="emergency stop", duration=1.0, stops=True, acknowledged=True),
    Fault(name="stale pose", duration=1.0, stops=True, acknowledged=True),
    Fault(name="gripper dead"),
    Fault(name="gripper halfway"),
    Fault(name="object moved"),
    Fault(name="object taken"),
    Fault(name="frames lost", duration=3.0),
    Fault(name="frames late"),
    Fault(name="frames frozen", duration=3.0),
    Fault(name="picture frozen", duration=3.0),
    Fault(name="frames black", duration=3.0),
    Fault(name="frames empty", duration=3.0),
    Fault(name="frames sparse", duration=3.0),
    Fault(name="frames in millimetres", duration=3.0),
    Fault(name="frames transposed", duration=3.0),
    Fault(name="state frozen", duration=1.0, stops=True),
    Fault(name="stamps frozen", duration=1.0, stops=True),
    Fault(name="state nan", duration=0.2),
    Fault(name="localisation jump"),
    Fault(name="localisation drift"),
    Fault(name="base ignores commands", duration=2.0),
    Fault(name="base too fast", duration=2.0),
    Fault(name="readings late", duration=2.0),
    Fault(name="readings slow", duration=1.0, real_clock=True),
    Fault(name="reading fails", stops=True),
    Fault(name="reading breaks", stops=True),
    Fault(name="sending fails", stops=True),
    Fault(name="leaf raises", inject=_leaf_raises, stops=True),
    Fault(name="leaf blocks", inject=_leaf_blocks, stops=True, real_clock=True),
    Fault(name="solver gives up", inject=_solver_gives_up, duration=0.5),
    Fault(name="solver raises", inject=_solver_raises, stops=True),
)

QUICK = ("reflex", "gripper dead", "object taken", "state nan", "leaf raises")
"""The rows of `--quick`, in the phases `QUICK_PHASES`."""

QUICK_PHASES = ("carry", "place")
