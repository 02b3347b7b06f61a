"""Robots of other people's drivers: what doctor, lock, clock and summary make of them."""

import pytest

import frankie_task
from hw.hardware import CommandedError, RobotLock, Verdict, examine
from robots import load_real_robot

PARTS = """\
import numpy as np
from pinocchio import SE3
from frankie_task import *

class Options(DriverOptions):
    device: str = ""
    unit: int = 0
    limit: float = 0.5
    fails: str = ""

class Own(PassivePart):
    def __init__(self, options: Options, context):
        self.fails, self.clock, self.robot = options.fails, context.clock, context.robot
        self.do("make")
    def do(self, what):
        if what == self.fails:
            raise LookupError(f"no {what}\\nat all")
        return self.clock.now()
    def connect(self):
        self.do("connect")
    def close(self):
        self.do("close")
    def send(self, velocity):
        return velocity

class OwnBase(Own):
    def read(self):
        return BaseState(stamp=self.do("read"), oTb=SE3.Identity(), twist=np.zeros(3))

class OwnArm(Own):
    def read(self):
        return ArmState(stamp=self.do("read"), q=self.robot.arm.ready, qd=np.zeros(7))

class OwnGripper(Own):
    def read(self):
        return GripperState(stamp=self.do("read"), width=0.08, moving=False)
    def grip(self, width, force): ...

class OwnCamera(Own):
    def faults(self):
        return ()
    def latest(self):
        self.do("read")
"""
KINDS = ("base", "arm", "gripper", "camera")


@pytest.fixture
def robot(install, tmp_path, monkeypatch):
    """Writes a robot file; options of parts by their kinds, as YAML."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr("hw.findings.LOOKS", 5)
    monkeypatch.setattr("hw.hardware.part_diagnostics._FIRST", 5)
    monkeypatch.setattr("hw.hardware.computer._NAPS", 50)
    for kind in KINDS:
        install(PARTS, "drivers", f"{kind}.own", f"Own{kind.capitalize()}")

    def written(name="ours", **options):
        path = tmp_path / f"{name}.yaml"
        parts = [f"  {kind}: {{driver: own, {options.get(kind, '')}}}" for kind in KINDS]
        path.write_text("\n".join(["robot: frankie", "hardware:", *parts]) + "\n")
        return path

    return written


def findings(path):
    return list(examine(load_real_robot(path)))


def test_doctor_asks_for_what_the_file_uses_and_waits_for_a_first_image(robot):
    found = findings(robot())
    assert not [one for one in found if one.about == "installed"]
    bad = {one.about: one.text for one in found if one.verdict is Verdict.BAD}
    assert "there are no readings" in bad["camera"]
    assert not {"base", "arm", "gripper"} & set(bad)


@pytest.mark.parametrize("fails", ["make", "connect", "read", "close"])
def test_doctor_survives_what_a_driver_raises(robot, fails):
    found = findings(robot(arm=f"fails: {fails}"))
    (told,) = [one for one in found if f"no {fails} at all" in one.text]
    assert told.verdict is Verdict.BAD
    assert "LookupError" in told.text
    assert fails == "make" or any(one.about == "gripper" for one in found)


def lock(path):
    return RobotLock(load_real_robot(path).hardware)


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("device: /dev/ttyUSB0", "device: /dev/ttyUSB1", False),
        ("device: /dev/ttyUSB0", "device: /dev/ttyUSB0, limit: 0.1, unit: 2", True),
        ("unit: 0", "unit: 1", False),
        ("limit: 0.2", "limit: 0.3", True),
    ],
)
def test_a_robot_is_where_its_parts_are(robot, one, other, same):
    first, second = lock(robot("first", base=one)), lock(robot("second", base=other))
    first.take()
    try:
        if same:
            with pytest.raises(CommandedError):
                second.take()
        else:
            second.take().release()
    finally:
        first.release()


def test_a_script_runs_it_by_the_clock_on_the_wall_and_tells_nothing_of_a_scene(robot, tmp_path):
    task = tmp_path / "task.yaml"
    task.write_text("task: no\ntree: {compare: {value: 1, equals: 2}}\n")
    site = tmp_path / "hall.yaml"
    furniture = "fixtures: [{name: post, centre: [5, 5, 0.5], size: [0.1, 0.1, 1.0]}]\n"
    options = {"robot": str(robot()), "record": tmp_path / "runs"}
    with pytest.raises(frankie_task.UserError, match="--arm-the-robot"):
        frankie_task.run_task(task, **options)
    site.write_text("fixtures: 1\n")
    with pytest.raises(frankie_task.UserError, match="fixtures"):
        frankie_task.run_task(task, armed=True, map=site, **options)
    site.write_text(furniture)
    summary = frankie_task.run_task(task, armed=True, map=site, **options).summary
    assert summary.outcome == "failure"
    assert (summary.scene, summary.seed) == (str(site), None)
    assert (summary.objects, summary.placed) == (None, None)
