"""Who may move a real robot: it is armed, slow at first, and has one commander."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from emulated_robot import ROOT

from controller import Command
from hw import WorldOptions, open_backend
from hw.hardware import CommandedError, NotArmedError, RobotLock, commander_of
from hw.hardware.arming import is_proven, least_percent, prove, slowness, speed_note, speed_percent
from hw.hardware.opening import CommandedRobot
from hw.state import Fault, FaultKind
from robots import RealRobot, load_real_robot
from robots.load import SHIPPED

HOLD = """
import sys, time
from hw.hardware import RobotLock
from robots import load_real_robot
lock = RobotLock(load_real_robot(sys.argv[1]).hardware).take()
print("taken", flush=True)
sys.stdin.readline()
"""


@contextmanager
def holding(real: RealRobot) -> Iterator[subprocess.Popen[str]]:
    """Another program that commands the robot, until it is killed."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(real.path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "taken\n"
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def real(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RealRobot:
    """A robot with addresses that lead nowhere, which was never driven."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    path = tmp_path / "ours.yaml"
    text = (SHIPPED / "frankie_site.yaml").read_text()
    path.write_text(text.replace("10.10.10.10", f"127.9.{os.getpid() % 250}.1"))
    robot = load_real_robot(path)
    assert robot is not None
    return robot


def test_a_real_robot_that_is_not_armed_is_refused_in_one_line(real: RealRobot) -> None:
    with pytest.raises(NotArmedError, match="--arm-the-robot") as error:
        open_backend(str(real.path), "kinematic", WorldOptions(scene="single"))
    assert "\n" not in str(error.value)
    assert commander_of(real.hardware) == ""


def test_the_first_start_is_at_a_tenth_until_a_run_has_gone_well(real: RealRobot) -> None:
    assert speed_percent(real) == 10.0
    assert "first time" in speed_note(real)
    prove(real)
    assert is_proven(real)
    assert speed_percent(real) == 25.0
    text = real.path.read_text()
    real.path.write_text(text + "arm_mount: {xyz: [0.16, 0.0, 0.38]}\n")
    assert speed_percent(real) == 10.0, "a file that says something else begins anew"
    real.path.write_text(text + "# nothing new\n")
    assert speed_percent(real) == 25.0
    real.path.write_text(text.replace("speed_percent: 25", "speed_percent: 40"))
    faster = load_real_robot(real.path)
    assert faster is not None
    assert speed_percent(faster) == 40.0, "who has seen it move may let it move faster"


def test_a_base_of_another_make_has_no_speed_that_is_too_slow() -> None:
    foreign = load_real_robot(SHIPPED / "ros2_example.yaml")
    assert foreign is not None
    assert (least_percent(foreign), slowness(foreign)) == (0.0, "")


QUALITY = (
    "quality: {views: 9, residual: 0.2, uncertainty: {mm: 1, deg: 1}, held_out: {mm: 1, deg: 1}}"
)


@pytest.mark.parametrize("mount", ["arm_mount", "camera_mount"])
def test_a_new_calibration_begins_anew_though_the_robot_file_only_names_it(real, mount):
    calibration = real.path.with_name("ours_calibrated.yaml")

    def calibrate(x: float) -> None:
        calibration.write_text(f"{mount}: {{xyz: [{x}, 0.0, 0.1]}}\n{QUALITY}\n")

    calibrate(0.1)
    real.path.write_text(real.path.read_text() + f"{mount}: {calibration.name}\n")
    prove(real)
    assert is_proven(real)
    calibrate(0.1001)
    assert not is_proven(real)
    calibrate(0.1)
    assert is_proven(real)


def test_a_second_commander_is_told_who_the_first_is(real: RealRobot) -> None:
    with holding(real) as process:
        with pytest.raises(CommandedError, match=f"process {process.pid} of .*end that one first"):
            RobotLock(real.hardware).take()
        assert f"process {process.pid} of" in commander_of(real.hardware)
        process.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WNOWAIT)
        with pytest.raises(CommandedError, match=f"process {process.pid} of"):
            RobotLock(real.hardware).take()
    assert commander_of(real.hardware) == "", "the lock of a dead process holds nobody up"
    RobotLock(real.hardware).take().release()


class Toy:
    """A robot that has faults when it is told to."""

    def __init__(self) -> None:
        self.faults: tuple[Fault, ...] = ()

    def connect(self) -> None: ...
    def close(self) -> None: ...

    def read(self):
        return self

    def send(self, command: Command) -> Command:
        return command


GO = Command(base_twist=np.array([0.1, 0.0, 0.0]), qd=np.zeros(7))
REFLEX = Fault(kind=FaultKind.REFLEX, text="reflex", clearable=True)


@pytest.mark.parametrize(
    ("command", "faults", "proven"),
    [(GO, (), True), (Command.stop(7), (), False), (GO, (REFLEX,), False)],
)
def test_a_file_is_proven_by_motion_that_ends_without_a_fault(real, command, faults, proven):
    toy = Toy()
    robot = CommandedRobot(toy, real, RobotLock(real.hardware), lambda: None)
    robot.connect()
    assert commander_of(real.hardware)
    robot.send(command)
    toy.faults = faults
    robot.read()
    robot.close()
    assert commander_of(real.hardware) == ""
    assert is_proven(real) is proven
