"""The driver of ROS 2 against a simulated robot in another process, which speaks nothing else."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from command_line import call, in_real_time
from program import program
from waiting import until

from extensions.ros2.messages import missing
from frankie_task.testing import check_driver
from hw import Clock, HardwareError, WallClock, parts_of
from hw.hardware import Verdict, examine
from hw.hardware.arming import prove
from robots import load_real_robot, load_robot
from robots.load import SHIPPED

pytestmark = [pytest.mark.realtime, pytest.mark.skipif(bool(missing()), reason=missing())]
NODE = Path(__file__).with_name("robot_node.py")
DOMAINS = count(os.getpid() % 150)
LATE = "node.delay, node.shuffles = 0.05, True"  # of its messages: each way, and in disorder


class Node:
    """The simulated robot, and the file of a robot that speaks with it."""

    def __init__(self, folder: Path, scene: str = "single", seed: int = 0, **changes: str) -> None:
        self.domain = next(DOMAINS)
        text = (SHIPPED / "ros2_example.yaml").read_text()
        for old, new in {"domain: 42": f"domain: {self.domain}", **changes}.items():
            assert old in text
            text = text.replace(old, new)
        self.path = folder / "ours.yaml"
        self.path.write_text(text)
        self.process = subprocess.Popen(
            [sys.executable, str(NODE), str(self.domain), scene, str(seed)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout.readline() == "ready\n"

    def do(self, statement: str = "pass") -> dict:
        self.process.stdin.write(statement + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    @contextmanager
    def frozen(self):
        self.process.send_signal(signal.SIGSTOP)
        yield
        self.process.send_signal(signal.SIGCONT)

    def close(self) -> None:
        self.process.kill()
        self.process.communicate()


def parts(path: Path, clock: Clock | None = None) -> dict:
    """The parts of a robot's file."""
    return parts_of(load_real_robot(path), load_robot(path), clock or WallClock())


@pytest.fixture
def node(tmp_path):
    one = Node(tmp_path)
    yield one
    one.close()


@contextmanager
def connected(path: Path, *kinds: str):
    """Some parts of a robot."""
    made = parts(path)
    with ExitStack() as closing:
        for kind in kinds:
            made[kind].connect()
            closing.callback(made[kind].close)
        yield [made[kind] for kind in kinds]


@pytest.mark.slow
@pytest.mark.parametrize("how", ["pass", LATE, "node.dies = 4.0"])
def test_pick_one_is_done_over_ros_2_alone(tmp_path, monkeypatch, how):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    site = {"speed_percent: 25": "speed_percent: 100", "\nhardware:": "map: household\nhardware:"}
    if how == LATE:  # so slowly, and with what `frankie-task calibrate delays` measures
        site = {"\nhardware:": "base_lag: 0.24\narm_lag: 0.18\nmap: household\nhardware:"}
    node = Node(tmp_path, "household", **site)
    prove(load_real_robot(node.path))  # else it moves at a tenth of its speeds
    words = ("--robot", node.path, "--record", tmp_path, "--view", "none", "--arm-the-robot")
    node.do(how)
    try:
        summary = call("run", "pick_one", *words, "--json")[1]
        if "dies" in how:
            told = json.loads(summary)
            assert told["outcome"] != "success", told
            assert f"nobody publishes /joint_states in domain {node.domain}" in told["reason"]
        else:
            told = in_real_time(summary)
            assert told["outcome"] == "success", told
            seen = node.do()
            assert (seen["hit"], seen["supports"].count("table")) == ("", 1)
    finally:
        node.close()


TWIST, QD = np.array([0.1, 0.0, 0.1]), 0.2 * np.eye(7)[6]


def drive(base, arm, seconds: float = 1.0) -> float:
    """Command both for a while; when that ended."""
    end = time.monotonic() + seconds
    while (now := time.monotonic()) < end:
        base.read(), arm.read()
        base.send(TWIST)
        arm.send(QD)
        time.sleep(0.01)
    return now


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["arm", "base", "gripper", "camera", "laser"])
def test_each_part_keeps_the_contract(node, kind):
    def make(context):
        return parts(node.path, context.clock)[kind]

    limits = {"age": 0.2, "rest": 0.4, "patience": 30.0}  # the last for a busy machine
    check_driver(kind, make, fault=None if kind == "laser" else node.frozen, **limits)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["pass", LATE, "node.timeouts = dict(base=0.06, arm=0.06)"])
def test_robots_rest_soon_after_the_last_command(node, how):
    """By our watchdog, or by the robot's own if ours is killed: 0.3 s and the way to the robot.

    Of that 0.23 s are its drives': from 0.1 m/s to 0.01 m/s with a time constant of 0.1 s.
    """
    with connected(node.path, "base", "arm") as (base, arm):
        node.do("node.timeouts = dict(base=9.0, arm=9.0)")
        node.do(how)
        last = drive(base, arm)
        if "0.06" in how:
            for part in (base, arm):
                part._process.process.kill()
        else:
            assert base.read().oTb.translation[0] > 0.03
            assert base.read().faults == arm.read().faults == ()
        time.sleep(1.5)
        after = node.do()["moved"] - last
    print(f"{how}: at rest after {after:.2f} s")
    assert 0.0 < after < 0.33 + 0.05 * (how == LATE)


@pytest.mark.slow
def test_the_doctor_sees_whether_a_robot_rests_without_commands(node):
    node.do("node.timeouts['arm'] = 9.0")  # velocity controllers of ros2_control have none
    found = list(examine(load_real_robot(node.path), armed=True))
    base, arm = (
        next(one for one in found if one.about == part and "without commands" in one.text)
        for part in ("base", "arm")
    )
    assert (base.verdict, arm.verdict) == (Verdict.GOOD, Verdict.BAD)
    assert 0.5 < float(base.text.split()[-2]) < 0.9


DRIVING = """
import sys
from test_ros2 import connected, drive
with connected(sys.argv[1], "base", "arm") as parts:
    drive(*parts, 60.0)
"""


@pytest.mark.slow
def test_a_program_that_is_killed_leaves_a_robot_at_rest(node):
    with program(DRIVING, node.path) as driving:
        until(lambda: node.do()["commanded"])
        time.sleep(0.5)
        driving.kill()
        killed = time.monotonic()
    time.sleep(1.0)
    assert 0.0 < node.do()["moved"] - killed < 0.4


@pytest.mark.slow
def test_a_killed_driver_is_a_fault_and_a_recovery_starts_another(node):
    with connected(node.path, "base") as (base,):
        base._process.process.kill()
        until(lambda: base.read().faults)
        assert "its driver has ended" in base.read().faults[0].text
        base.recover()
        before = base.read()
        assert before.faults == ()
        time.sleep(0.1)
        assert base.read().stamp > before.stamp


SPOILS = {
    "joint_states": ("one.position = [nan] * 8", r"\[panda_joint1\] = nan"),
    "odom": ("one.twist.twist.linear.x = nan", r"twist\[linear.x\] = nan"),
}


@pytest.mark.slow
@pytest.mark.parametrize("topic", SPOILS)
def test_malformed_messages_bring_to_rest_and_are_named(node, topic):
    spoils, told = SPOILS[topic]
    with connected(node.path, "base", "arm") as parts:
        drive(*parts)
        node.do(f"node.spoils['rt/{topic}'] = {spoils!r}")
        part, command = (parts[0], TWIST) if topic == "odom" else (parts[1], QD)
        begun = time.monotonic()
        while time.monotonic() < begun + 1.0:
            part.read()
            part.send(command)
            time.sleep(0.01)
        [fault] = part.read().faults
        assert re.search(told, fault.text)
        node.do("node.spoils.clear()")
        part.recover()
        assert part.read().faults == ()
    assert node.do()["moved"] - begun < 0.7


@pytest.mark.slow
def test_who_tells_the_place_on_the_map_is_found_missed_and_named(node):
    """Its publisher is volatile, the robot's reader asks for what was told before too."""
    text = node.path.read_text().replace("# localisation: /amcl_pose", "localisation: /amcl_pose")
    node.path.write_text(text)
    base = parts(node.path)["base"]
    with pytest.raises(HardwareError, match="/amcl_pose has told nothing yet"):
        base.connect()
    node.do("node.map = 'odom'")
    with pytest.raises(HardwareError, match=r"/amcl_pose .* header.frame_id = `odom`: not `map`"):
        base.connect()
    node.do("node.map = 'map'")
    with connected(node.path, "base") as (base,):
        assert base.read().localised.source == "/amcl_pose"
        time.sleep(0.5)
        node.do("node.spoils['rt/amcl_pose'] = 'one.pose.covariance = [nan] * 36'")
        until(lambda: base.read().faults)
        text = base.read().faults[0].text
        assert re.search(r"/amcl_pose .* pose.covariance\[0, 0\] = nan", text)
        assert "pose.covariance" in base.complaints[0]


@pytest.mark.slow
def test_who_is_not_there_is_named_when_connecting(tmp_path, node):
    node.path.write_text(node.path.read_text().replace("cmd_vel", "cmd_wel"))
    with pytest.raises(HardwareError, match=r"nobody listens to /cmd_wel in domain .*Twist"):
        parts(node.path)["base"].connect()
    node.path.write_text(node.path.read_text().replace("panda_joint7]", "panda_joint8]"))
    with pytest.raises(HardwareError, match=r"/joint_states .* it does not tell panda_joint8"):
        parts(node.path)["arm"].connect()
