"""Faults that come by themselves: at a time or in a phase, from a file or the command line."""

from dataclasses import dataclass, field
from math import inf

import pytest
from harness import Harness
from py_trees.common import Status
from typer.testing import CliRunner

from app.commands import app
from app.core import ScheduledFault, parse_fault, phases_of, read_faults
from app.core.fault_schedule import FaultSchedule, ScheduleError
from behaviours import LEAVES, Leaf
from config import ConfigError


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


def run(fault: ScheduledFault, phases: str, seed: int = 0) -> list[tuple[int, str]]:
    """What happens at which tick, a second apart; a letter is the phase of a tick."""
    leaf = Working("leaf", Harness().context)
    leaf.status = Status.RUNNING
    robot = Injected()
    schedule = FaultSchedule([fault], robot, [leaf], seed)
    happened = []
    for second, letter in enumerate(phases):
        leaf.phase = {"d": "descend", "c": "close"}.get(letter, "")
        schedule.update(float(second))
        happened += [(second, call) for call in robot.calls]
        robot.calls.clear()
    return happened


@pytest.mark.parametrize(
    ("entry", "phases", "injected"),
    [
        ({"at_s": 2.0, "for_s": 3.0}, "........", [(2, "reflex for 3")]),
        ({"phase": "descend"}, ".ddd.dd", [(1, "reflex")]),
        ({"phase": "descend", "after_s": 2.0}, ".d.dddd", [(5, "reflex")]),
        (
            {"phase": "descend", "occurrence": 2, "times": 2},
            ".d.d.d.d.d",
            [(3, "reflex"), (5, "reflex")],
        ),
        ({"phase": "wait"}, "..", [(0, "reflex")]),
    ],
    ids=["at a time", "phase entered", "into a phase", "from the second time", "key of a leaf"],
)
def test_when_a_fault_is_injected(entry, phases, injected):
    assert run(ScheduledFault(fault="reflex", **entry), phases) == injected


def test_by_chance_and_the_same_with_the_same_seed():
    fault = ScheduledFault(fault="reflex", phase="descend", probability=0.5, times=100)
    often = run(fault, ".d" * 40)
    assert 10 <= len(often) <= 30
    assert often == run(fault, ".d" * 40)
    assert often != run(fault, ".d" * 40, seed=1)


def test_driving_with_something_in_the_hand_is_carrying():
    harness = Harness()
    navigate = LEAVES["navigate"].__new__(LEAVES["navigate"])
    navigate.context = harness.context
    assert phases_of(navigate) == {"navigate"}
    harness.robot.grip(0.04, 20.0)
    harness.run_for(None, 1.0)
    assert phases_of(navigate) == {"carry"}


def test_a_file_is_read_strictly_with_all_its_mistakes(tmp_path):
    path = tmp_path / "faults.yaml"
    path.write_text(
        "faults:\n"
        "  - {fault: reflx, phase: descend}\n"
        "  - {fault: reflex, phase: decend}\n"
        "  - {fault: reflex}\n"
        "  - {fault: reflex, at_s: 1, times: 2}\n"
        "  - {fault: reflex, at_s: .nan}\n"
        "  - {fault: reflex, at_s: 1, fore_s: 2}\n"
    )
    with pytest.raises(ConfigError) as error:
        read_faults(path)
    lines = str(error.value).replace(f"{path}:", "").splitlines()
    assert len(lines) == 6
    assert lines[0].startswith("2:13: ")
    assert "did you mean `reflex`?" in lines[0]
    assert "did you mean `descend`?" in lines[1]
    assert "give either `at_s` or `phase`" in lines[2]
    assert "are about a phase" in lines[3]
    assert "did you mean `for_s`?" in lines[5]
    path.write_text("faults:\n  - fault: frames lost\n    phase: approach\n    for_s: 2\n")
    assert read_faults(path) == (ScheduledFault(fault="frames lost", phase="approach", for_s=2.0),)


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("reflex@12.5", {"fault": "reflex", "at_s": 12.5}),
        ("frames lost@approach", {"fault": "frames lost", "phase": "approach"}),
        ("frames lost@carry for 2", {"fault": "frames lost", "phase": "carry", "for_s": 2.0}),
    ],
)
def test_the_short_form(text, entry):
    assert parse_fault(text) == ScheduledFault(**entry)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("reflex", "write it as reflex@12.5"),
        ("reflx@3", "did you mean `reflex`?"),
        ("reflex@decend", "did you mean `descend`?"),
        ("reflex@3 for a while", "a number"),
        ("reflex@3 for -1", "greater than 0"),
    ],
)
def test_a_short_form_that_says_nothing_is_refused(text, told):
    with pytest.raises(ScheduleError) as error:
        parse_fault(text)
    assert str(error.value).startswith(f"--fault {text}: ")
    assert told in str(error.value)


def test_a_run_with_faults_says_what_happened_and_is_the_same_every_time(tmp_path):
    task = tmp_path / "go.yaml"
    task.write_text(
        "task: go\nposes: {far: {xyz: [2.0, 0.5, 0.7], rpy_deg: [180, 0, 0]}}\n"
        "tree:\n  retry: 2\n  sequence: [recover, {navigate: {to: far}}]\n"
    )
    logs = []
    for name in ("a", "b"):
        arguments = ["run", str(task), "--fault", "reflex@navigate", "--view", "none"]
        result = CliRunner().invoke(app, [*arguments, "--record", str(tmp_path / name)])
        assert result.exit_code == 0, result.output
        (folder,) = (tmp_path / name).iterdir()
        logs.append((folder / "events.jsonl").read_text())
    assert "reflex of the arm, injected" in logs[0]
    assert logs[0] == logs[1]
