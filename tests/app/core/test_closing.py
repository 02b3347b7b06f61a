"""A robot that cannot be connected or closed is told in a line, and is closed whatever happens."""

from pathlib import Path

import pytest
from command_line import call
from harness import detector, open_floor

from app.core import RunOptions, set_up
from app.core.setup import WorldModel
from hw import Backend, HardwareError, SimClock
from hw.sim import kinematic_robot
from robots import load_robot


class Balky:
    """A simulated robot that may raise in one of its calls, and counts how often it is closed."""

    def __init__(self, method: str = "", error: BaseException | None = None) -> None:
        self.clock, self.closed = SimClock(), 0
        self._robot = kinematic_robot(load_robot("frankie"), open_floor(), self.clock)
        self._method, self._error = method, error

    def __getattr__(self, name: str):
        self.closed += name == "close"
        return self._fail if name == self._method else getattr(self._robot, name)

    def _fail(self) -> None:
        raise self._error

    def opened(self):
        backend = Backend(robot=self, clock=self.clock, truth=None)
        return set_up(backend, detector(), RunOptions(tree=Path()), world_model=WorldModel())


@pytest.mark.parametrize(
    ("method", "error"), [("connect", OSError(5, "no route")), ("read", HardwareError("unplugged"))]
)
def test_a_robot_that_cannot_be_connected_is_a_hardware_fault_and_is_closed(method, error):
    robot = Balky(method, error)
    with pytest.raises(HardwareError, match=r"no route|unplugged"), robot.opened():
        raise AssertionError("it is not there")
    assert robot.closed


def test_the_robot_is_closed_whatever_happens_in_between():
    robot = Balky()
    with pytest.raises(KeyboardInterrupt), robot.opened():
        raise KeyboardInterrupt
    assert robot.closed


def test_a_run_tells_that_its_robot_could_not_be_closed(tmp_path, monkeypatch):
    def gone(_: object) -> None:
        raise ConnectionResetError("gone")

    monkeypatch.setattr("hw.composition.ComposedRobot.close", gone)
    task = tmp_path / "toy.yaml"
    task.write_text("task: toy\nscene: single\ntree: {wait: {duration_s: 0.1}}\n")
    code, out, _ = call("run", task, "--record", tmp_path / "runs", "--view", "none", "--json")
    assert code == 0
    assert "closing the robot failed (ConnectionResetError: gone)" in out
