"""Whatever is raised, wherever, at 1 m/s: the robot comes to rest within limits, and it is told."""

import numpy as np
import pytest
from controlled_run import session_of
from harness import Harness, looking_down
from py_trees.common import Status

from app.core.outcome import End
from app.live import Control
from behaviours import Leaf
from controller import Command, GoalError, PoseGoal
from hw import HardwareError
from trees.words.composites import Sequence

AWAY = looking_down(8.0, 0.0, 0.8)
RAISE_AT = 5

PLACES = ["read", "send", "leaf", "tree", "camera", "controller", "gate", "context"]
ERRORS = [ValueError("bad value"), HardwareError("unplugged"), KeyboardInterrupt()]
OTHERS = [MemoryError("no memory"), GoalError("not finite"), SystemExit(0), GeneratorExit()]
CASES = [
    *((place, ERRORS[0], True) for place in PLACES),
    *((place, error, False) for place in ("read", "send", "leaf") for error in ERRORS),
    *(
        pytest.param(place, error, for_ever, marks=pytest.mark.slow)
        for place in PLACES
        for error in OTHERS
        for for_ever in (False, True)
    ),
]


class Driver(Leaf):
    """Drives off, looking for grasps as a leaf does."""

    key = "driver"

    def __init__(self, name, context, halted) -> None:
        super().__init__(name, context)
        self._halted = halted

    def update(self) -> Status:
        self.pursue(PoseGoal(wTe=AWAY))
        self.context.vision.new_frame()
        return self.running("driving")

    def terminate(self, new_status: Status) -> None:
        self._halted()


class Stage:
    """A session in which one call raises from some tick on."""

    def __init__(self, place: str, error: BaseException, *, for_ever: bool) -> None:
        self.harness = harness = Harness()
        self.error, self.for_ever = error, for_ever
        self.ticks, self.raised, self.stops = [], 0, 0
        self._set_going()
        self.control = Control()
        leaf = Driver("driver", harness.context, lambda: None)
        self.root = Sequence("sequence", [leaf])
        self._wrap(place, leaf)
        stop = harness.robot.stop

        def counted_stop() -> None:
            self.stops += 1
            stop()

        harness.robot.stop = counted_stop
        self.session, self.measurements = session_of(harness, self.root, self.control, self._watch)

    def _set_going(self) -> None:
        """The base drives at 1 m/s from the beginning."""
        going = np.array([1.0, 0.0, 0.0])
        self.harness.robot._robot._base._body.base_twist = going
        self.harness.gate.applied = Command(base_twist=going, qd=np.zeros(7))

    def _watch(self, tick) -> None:
        self.ticks.append(tick)
        if len(self.ticks) == 150:
            self.control.stop()

    def _wrap(self, place: str, leaf: Leaf) -> None:
        owner, name = {
            "read": (self.harness.robot, "read"),
            "send": (self.harness.robot, "send"),
            "leaf": (leaf, "update"),
            "halt": (leaf, "terminate"),
            "tree": (self.root, "advance"),
            "camera": (self.harness.context.vision._camera, "latest"),
            "controller": (self.harness.controller, "step"),
            "gate": (self.harness.gate, "judge"),
            "context": (self.harness.context, "end_tick"),
        }[place]
        call = getattr(owner, name)

        def wrapped(*args, **kwargs):
            due = len(self.ticks) >= RAISE_AT and (self.for_ever or not self.raised)
            if due:
                self.raised += 1
                raise self.error
            return call(*args, **kwargs)

        setattr(owner, name, wrapped)

    def run(self):
        self.outcome = self.session.run()
        self.at_end = self.true_speed
        self.harness.clock.sleep_until(self.harness.clock.now() + 1.0)
        return self.outcome

    @property
    def true_speed(self) -> float:
        """Of the simulated robot itself, whatever the wrapped calls do [m/s or rad/s]."""
        state = self.harness.robot._robot.read()
        return float(np.abs((*state.base_twist, *state.qd)).max())

    def assert_kept_limits(self) -> None:
        commands = np.array([(*t.applied.base_twist, *t.applied.qd) for t in self.ticks])
        limits = self.harness.controller.model.limits
        allowed = np.concatenate([limits.base_emergency, limits.qdd]) * 0.01
        assert (np.abs(np.diff(commands, axis=0)) <= allowed + 1e-9).all()
        assert np.abs(commands[:, 0]).max() > 0.98
        assert self.measurements.limit_violations == 0


def expected_end(place: str, error: BaseException) -> End:
    """As docs/safety.md documents it."""
    if isinstance(error, KeyboardInterrupt):
        return End.INTERRUPTED
    if isinstance(error, HardwareError) or place in ("read", "send", "gate"):
        return End.HARDWARE
    return End.CRASH


@pytest.mark.parametrize(("place", "error", "for_ever"), CASES, ids=str)
def test_an_exception_anywhere_ends_at_rest_with_a_typed_outcome(place, error, for_ever):
    stage = Stage(place, error, for_ever=for_ever)
    outcome = stage.run()
    assert stage.raised
    assert outcome.end is expected_end(place, error)
    assert stage.true_speed < 1e-3
    assert stage.root.status is not Status.RUNNING  # halted
    stage.assert_kept_limits()
    if outcome.end is End.CRASH and place != "context":
        assert outcome.node == "driver" or place == "tree"
    if place == "send" and for_ever:
        assert stage.stops == 1  # nothing else is left
    else:
        assert stage.at_end < 1e-3
    text = str(error)
    if outcome.end is not End.INTERRUPTED and text:
        assert text in outcome.reason


def test_an_exception_while_the_tree_is_halted_changes_nothing_else():
    stage = Stage("halt", ERRORS[0], for_ever=True)
    outcome = stage.run()
    assert outcome.end is End.INTERRUPTED
    assert stage.raised
    assert stage.true_speed < 1e-3


def test_a_robot_that_never_comes_to_rest_is_stopped_by_its_own_means():
    stage = Stage("leaf", ValueError("bad value"), for_ever=False)
    read = stage.harness.robot.read

    def restless():
        state = read()
        return type(state)(**{**vars(state), "qd": np.full(7, 0.01)})

    stage.harness.robot.read = restless
    assert stage.run().end is End.CRASH
    assert stage.stops == 1
