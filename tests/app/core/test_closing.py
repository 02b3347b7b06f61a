"""A robot that cannot be connected or closed is told in a line, and is closed whatever happens."""

from pathlib import Path

import pytest
from command_line import call
from harness import detector, open_floor

from app.core import RunOptions, set_up
from app.core.world_model import WorldModel
from hw import Backend, HardwareError, SimClock
from hw.sim import kinematic_robot
from robots import load_robot


class Balky:
    """A simulated robot that raises in some of its calls, and counts how often it is closed."""

    def __init__(self, **raises: BaseException) -> None:
        self.clock = SimClock()
        self._inner = kinematic_robot(load_robot("frankie"), open_floor(), self.clock)
        self._raises = raises
        self.closed = 0

    def __getattr__(self, name: str):
        if name == "close":
            self.closed += 1
        if name in self._raises:
            error = self._raises[name]

            def failing(*_: object) -> None:
                raise error

            return failing
        return getattr(self._inner, name)


def opened(robot: Balky):
    return set_up(
        Backend(robot=robot, clock=robot.clock, truth=None),
        detector(),
        RunOptions(tree=Path()),
        world_model=WorldModel(),
    )


@pytest.mark.parametrize(
    ("method", "error"),
    [("connect", OSError(5, "no route")), ("read", HardwareError("unplugged"))],
)
def test_a_robot_that_cannot_be_connected_is_a_hardware_fault_and_is_closed(method, error):
    robot = Balky(**{method: error})
    with pytest.raises(HardwareError, match=r"no route|unplugged"), opened(robot):
        raise AssertionError("it is not there")
    assert robot.closed


def test_the_robot_is_closed_whatever_happens_in_between():
    robot = Balky()
    with pytest.raises(KeyboardInterrupt), opened(robot):
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
