"""Runs that really failed, each in a way of its own: `explain` names the node and the reason."""

from pathlib import Path

import pytest
from py_trees.common import Status

import behaviours
from app.core.launch import run_task
from app.core.run_options import RunOptions
from app.review import explain
from behaviours import Leaf
from hw import ComposedRobot, HardwareError
from trees.language import describe_leaves

HEAD = """\
task: toy
poses:
  near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}
  far: {xyz: [-40.0, 0.0, 0.7], rpy_deg: [180, 0, 0]}
regions:
  floor: {centre: [0.7, 0.0, 0.3], size: [0.4, 0.4, 0.6]}
tree:
"""


class CloseFingers(Leaf):
    """Closes the fingers on whatever is there."""

    key = "close_fingers"

    def initialise(self) -> None:
        self.grip(0.0, 20.0)

    def update(self) -> Status:
        moving = self.context.state.gripper_moving or self.context.state.gripper_width > 0.01
        return self.running("closing") if moving else self.success("closed")


class Sabotage(Leaf):
    """Does what a test wants to go wrong, and succeeds.

    Args:
        kind: what.
    """

    key = "sabotage"

    def __init__(self, name, context, *, kind: str) -> None:
        super().__init__(name, context)
        self._kind = kind

    def update(self) -> Status:
        match self._kind:
            case "crash":
                return self.success(str(1 / 0))
            case fault:
                self.context.robot.inner.inject(fault)
        return self.success(self._kind)


@pytest.fixture
def record(tmp_path, monkeypatch):
    """Runs a tree in the simulator and explains what it left."""
    for leaf in (CloseFingers, Sabotage):
        monkeypatch.setitem(behaviours.LEAVES, leaf.key, leaf)
    described = describe_leaves(behaviours.LEAVES)
    monkeypatch.setattr("trees.language.registry.declared_leaves", lambda: dict(described))

    def run(tree: str):
        path = tmp_path / "toy.yaml"
        path.write_text(HEAD + "".join(f"  {line}\n" for line in tree.strip().splitlines()))
        result = run_task(RunOptions(tree=path, scene="single", record=tmp_path / "runs"))
        told = explain(result.folder)
        text = str(told)
        assert told.outcome == result.outcome.end.value
        assert told.node is not None
        assert told.node.name in text
        assert told.reason in text
        return told, text

    return run


def test_a_pose_that_is_not_reached_in_time(record):
    told, text = record("""
sequence:
  - wait: {duration_s: 0.1}
  - navigate: {to: far, timeout_s: 0.4}
""")
    assert told.node.path == "sequence/navigate"
    assert told.reason.startswith("not at far after 0.4 s")
    assert told.since == pytest.approx(0.52, abs=0.03)
    assert told.values["goal distance [m]"] > 39.0
    assert "goal distance [m]" in text
    assert "0.10 s  ✔ wait: waited" in text


def test_an_injected_fault_that_only_a_person_may_clear(record):
    told, text = record("""
fallback:
  - name: the job
    sequence:
      - sabotage: {kind: emergency stop}
      - navigate: {to: near}
  - recover: {arm: ready}
""")
    assert told.outcome == "hardware fault"
    assert told.node.path == "fallback/the job/navigate"
    assert told.reason == "emergency stop, injected; nobody is here to acknowledge it"
    assert told.faults == ["emergency stop, injected"]
    assert "The robot failed at " in text
    assert "! emergency stop, injected" in text


def test_a_crash_in_a_leaf(record):
    told, text = record("""
sequence:
  - name: first
    wait: {duration_s: 0.05}
  - name: clumsy
    sabotage: {kind: crash}
""")
    assert told.node.path == "sequence/clumsy"
    assert told.reason == "ZeroDivisionError: division by zero"
    assert Path(__file__).name in told.code
    assert "in update" in told.code
    assert told.code in text


def test_hardware_that_stops_answering(record, monkeypatch):
    read, answers = ComposedRobot.read, iter(range(60))

    def unplugged(robot):
        if next(answers, None) is None:
            raise HardwareError("the arm does not answer: check its cable")
        return read(robot)

    monkeypatch.setattr(ComposedRobot, "read", unplugged)
    told, text = record("""
sequence:
  - wait: {duration_s: 0.2}
  - navigate: {to: far}
""")
    assert told.outcome == "hardware fault"
    assert told.node.path == "sequence/navigate"
    assert told.reason == "the arm does not answer: check its cable"
    assert "during navigate" in text


def test_of_nodes_with_the_same_name_it_is_the_one_that_crashed(record):
    told, _ = record("""
sequence:
  - name: same
    wait: {duration_s: 0.02}
  - name: same
    sabotage: {kind: crash}
  - name: same
    wait: {duration_s: 0.02}
""")
    assert told.node.path == "sequence/same 2"


def test_a_success_is_told_with_what_went_wrong_on_the_way(tmp_path, record):
    path = tmp_path / "toy.yaml"
    path.write_text(HEAD + "  fallback:\n    - holding_object\n    - wait: {duration_s: 0.1}\n")
    result = run_task(RunOptions(tree=path, scene="single", record=tmp_path / "runs"))
    text = str(explain(result.folder))
    assert "It succeeded: wait: waited" in text
    assert "✗ holding_object" in text
    assert "At that moment" not in text
