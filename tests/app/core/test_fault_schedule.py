"""Faults that come by themselves, at a time or in a phase."""

from dataclasses import dataclass, field
from math import inf

import pytest
from harness import Harness
from py_trees.common import Status

from app.core import ScheduledFault, parse_fault, phases_of
from app.core.fault_schedule import FaultSchedule
from behaviours import LEAVES, Leaf
from config import UserError


class Working(Leaf):
    """Is in whatever phase the test says."""

    key = "wait"
    phase = ""

    def update(self) -> Status:
        return Status.RUNNING


@dataclass
class Injected:
    """Stands in for the robot, and notes what it is given."""

    calls: list = field(default_factory=list)

    def check(self, name: str) -> None:
        pass

    def inject(self, name: str, duration: float) -> None:
        self.calls.append(name if duration == inf else f"{name} for {duration:g}")


@pytest.mark.parametrize(
    ("entry", "phases", "injected"),
    [
        ({"at_s": 2.0, "for_s": 3.0}, "........", [(2, "reflex for 3")]),
        ({"phase": "descend"}, ".ddd.dd", [(1, "reflex")]),
        ({"phase": "wait"}, "..", [(0, "reflex")]),
    ],
    ids=["at a time", "phase entered", "key of a leaf"],
)
def test_when_a_fault_is_injected(entry, phases, injected):
    """A tick a second; a letter is the phase of a tick."""
    leaf = Working("leaf", Harness().context)
    leaf.status = Status.RUNNING
    robot = Injected()
    schedule = FaultSchedule([ScheduledFault(fault="reflex", **entry)], robot, [leaf])
    happened = []
    for second, letter in enumerate(phases):
        leaf.phase = {"d": "descend"}.get(letter, "")
        schedule.update(float(second))
        happened += [(second, done) for done in robot.calls]
        robot.calls.clear()
    assert happened == injected


def test_driving_with_something_in_the_hand_is_carrying():
    harness = Harness()
    navigate = LEAVES["navigate"].__new__(LEAVES["navigate"])
    navigate.context = harness.context
    assert phases_of(navigate) == {"navigate"}
    harness.robot.grip(0.04, 20.0)
    harness.run_for(None, 1.0)
    assert phases_of(navigate) == {"carry"}


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("reflex@12.5", {"fault": "reflex", "at_s": 12.5}),
        ("frames lost@carry for 2", {"fault": "frames lost", "phase": "carry", "for_s": 2.0}),
    ],
)
def test_a_fault_is_read_from_the_command_line(text, entry):
    assert parse_fault(text) == ScheduledFault(**entry)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("reflex", "write it as reflex@12.5"),
        ("reflx@3", "did you mean `reflex`?"),
        ("reflex@decend", "did you mean `descend`?"),
        ("reflex@nan", "`nan` is no time"),
        ("reflex@3 for a while", "give seconds"),
        ("reflex@3 for -1", "give seconds"),
    ],
)
def test_a_fault_that_says_nothing_is_refused(text, told):
    with pytest.raises(UserError) as error:
        parse_fault(text)
    assert str(error.value).startswith(f"--fault {text}: ")
    assert told in str(error.value)
