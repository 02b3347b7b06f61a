"""Faults that come by themselves, at a time or in a phase."""

from math import inf
from types import SimpleNamespace

import pytest
from command_line import call
from harness import Harness
from recorded_runs import faulty_words

from app.core.snapshots import phases_of
from behaviours import LEAVES
from config import UserError
from extensions.faults import INJECTABLE
from extensions.faults.schedule import FaultSchedule


class Robot(list):
    """Remembers what it was given."""

    names = tuple(INJECTABLE)

    def inject(self, *given: object) -> None:
        self.append(given)


@pytest.mark.parametrize(
    ("text", "phases", "injected"),
    [
        ("reflex@2 for 3", "........", [(2, "reflex", 3.0)]),
        ("reflex@descend", ".ddd.dd", [(1, "reflex", inf)]),
        ("bumper@1, reflex@descend", ".d", [(1, "bumper", inf), (1, "reflex", inf)]),
    ],
    ids=["at a time", "phase entered", "two"],
)
def test_when_a_fault_is_injected(text, phases, injected):
    """A tick a second, the first in a pause; a letter is the phase of a tick."""
    robot, happened = Robot(), []
    schedule = FaultSchedule(text, robot)
    for second, letter in enumerate(phases):
        now = frozenset({"grasp", "descend"} if letter == "d" else ())
        schedule.show(SimpleNamespace(phases=now, time=second - 0.5, paused_s=0.5))
        happened += [(second, *given) for given in robot]
        robot.clear()
    assert happened == injected


def test_driving_with_something_in_the_hand_is_carrying():
    harness = Harness()
    navigate = LEAVES["navigate"].__new__(LEAVES["navigate"])
    navigate.context = harness.context
    assert phases_of(navigate) == ("navigate",)
    harness.robot.grip(0.04, 20.0)
    harness.run_for(None, 1.0)
    assert phases_of(navigate) == ("carry",)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "write it as reflex@12.5"),
        ("reflex", "write it as reflex@12.5"),
        ("reflx@3", "did you mean `reflex`?"),
        ("reflex@decend", "did you mean `descend`?"),
        ("reflex@nan", "`nan` is no time"),
        ("reflex@3 for a while", "give seconds"),
        ("reflex@3 for -1", "give seconds"),
        ("object taken@3", "no fault is called `object taken` here"),
    ],
)
def test_a_fault_that_cannot_be_is_refused(text, told):
    robot = Robot()
    robot.names = ("reflex",)
    with pytest.raises(UserError) as error:
        FaultSchedule(f"reflex@1,{text}", robot)
    assert str(error.value).startswith(f"--with faults:{text}: ")
    assert told in str(error.value)


TASK = "task: toy\nscene: single\ntree: {wait: {duration_s: 0.5}}\n"


def test_a_run_says_which_world_is_faulty_and_that_none_is(tmp_path):
    task = tmp_path / "toy.yaml"
    task.write_text(TASK)
    quiet = ("--view", "none", "--record", tmp_path / "runs", "--json")
    code, _, said = call("run", task, *quiet, "--with", "faults:reflex@0.2")
    assert (code, said.splitlines()[-1]) == (
        2,
        "--with faults: add --world faulty, or as faulty:physics another world",
    )
    code, _, said = call("run", task, *quiet, *faulty_words("emergency stop@0.2"))
    assert (code, "emergency stop, injected" in said) == (3, True)
    code, _, said = call("run", task, *quiet, "--world", "faulty:kinematik")
    assert (code, "did you mean `kinematic`?" in said) == (2, True)
