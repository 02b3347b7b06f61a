"""Whatever is raised, wherever, at 1 m/s: the robot comes to rest within limits, and it is told."""

from dataclasses import replace

import numpy as np
import pytest
from controlled_run import TroubledRun
from py_trees.common import Status

from app.core.outcome import End
from controller import Command, GoalError
from hw import HardwareError

PLACES = ["read", "send", "leaf", "tree", "camera", "controller", "gate", "context"]
BAD = ValueError("bad value")
OTHERS = [
    *(HardwareError("unplugged"), KeyboardInterrupt(), GoalError("not finite")),
    *(SystemExit(0), GeneratorExit()),
]
CASES = [
    *((place, BAD, for_ever) for place in PLACES for for_ever in (True, False)),
    *((place, error, False) for place in ("read", "send", "leaf", "tree") for error in OTHERS),
]


class Stage(TroubledRun):
    """A run at 1 m/s in which one call raises once, or from then on."""

    def __init__(self, place: str, error: BaseException, *, for_ever: bool) -> None:
        super().__init__(place, self._fail, since=5, until=150)
        self._error, self._for_ever, self.raised = error, for_ever, 0
        going = np.array([1.0, 0.0, 0.0])
        self.harness.robot._robot._base.body.base_twist = going
        self.harness.gate.applied = Command(base_twist=going, qd=np.zeros(7))

    def _fail(self) -> None:
        if self._for_ever or not self.raised:
            self.raised += 1
            raise self._error

    def run(self):
        super().run()
        self.at_end = self.true_speed
        self.harness.clock.sleep_until(self.harness.clock.now() + 1.0)
        return self.outcome


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
    assert np.abs(stage.commands[:, 0]).max() > 0.98
    stage.assert_kept_limits(emergency=True)
    if outcome.end is End.CRASH and place != "context":
        assert outcome.node == "driver" or place == "tree"
    if place == "send" and for_ever:
        assert len(stage.stops) == 1  # nothing else is left
    else:
        assert stage.at_end < 1e-3
    if outcome.end is not End.INTERRUPTED:
        assert str(error) in outcome.reason


def test_an_exception_while_the_tree_is_halted_changes_nothing_else():
    stage = Stage("halt", BAD, for_ever=True)
    assert stage.run().end is End.INTERRUPTED
    assert stage.raised
    assert stage.true_speed < 1e-3


def test_a_robot_that_never_comes_to_rest_is_stopped_by_its_own_means():
    stage = Stage("leaf", BAD, for_ever=False)
    read = stage.harness.robot.read
    stage.harness.robot.read = lambda: replace(read(), qd=np.full(7, 0.01))
    assert stage.run().end is End.CRASH
    assert len(stage.stops) == 1
