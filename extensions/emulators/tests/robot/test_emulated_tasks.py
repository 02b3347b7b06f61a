"""Whole tasks by the drivers of the real robot, on emulators of all its parts, in real time."""

import json
import signal
import subprocess
import time
from pathlib import Path

import pytest
from command_line import call, in_real_time
from emulated_robot import emulated, needs_drivers, robot_file
from program import program

from app.core import replay_run
from config import UserError
from hw import WorldOptions, open_backend
from hw.clock import stopwatch
from hw.hardware import commander_of
from robots import load_real_robot

pytestmark = [pytest.mark.realtime, needs_drivers]

SHORT = """\
task: short
poses:
  near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}
tree:
  sequence:
    - recover: {arm: ready}
    - open_gripper
    - navigate: {to: near}
"""


RUN = "from frankie_task_cli import main; main()"
ATTENDED = """
import sys
from pathlib import Path
from app.core import RunOptions, run_task
from trees import find

options = RunOptions(
    tree=find("pick_place"),
    robot=sys.argv[1],
    localisation="exact",
    record=Path(sys.argv[2]),
    acknowledge_after=1.0,
)
print(run_task(options).summary.to_json())
"""


def summary(process: subprocess.Popen[str]) -> dict:
    """What a run tells at its end."""
    out, _ = process.communicate(timeout=400.0)
    assert out
    return in_real_time(out)


def test_a_run_starts_the_emulators_and_ends_them(tmp_path):
    """A short task, from its file to sockets and back; at a share of its speeds, and replayed."""
    slower = {"speed_percent: 100": "speed_percent: 60"}
    path, task = robot_file(tmp_path, **slower), tmp_path / "short.yaml"
    task.write_text(SHORT)
    words = ("--robot", path, "--record", tmp_path, "--json", "--view", "none")
    words += ("--scene", "single", "--localisation", "good", "--registration", "none")
    told = json.loads(call("run", task, *words)[1])
    assert (told["outcome"], told["world"], told["robot"]) == ("success", "emulated", "robot")
    assert told["contacts"] == 0
    assert not any(str(path) in line for line in running())
    (folder,) = tmp_path.glob("*-short")
    assert replay_run(folder).identical


def running() -> list[str]:
    """Command lines of all processes."""
    lines = []
    for place in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            lines.append(place.read_bytes().replace(b"\0", b" ").decode(errors="replace"))
        except OSError:
            continue
    return lines


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_base_and_arm_come_to_rest_when_the_program_is_killed_or_suspended(tmp_path, how):
    """Commanded to rest within 0.25 s of the last good command, by the emulators' own clocks."""
    path, task = robot_file(tmp_path), tmp_path / "far.yaml"
    task.write_text(SHORT.replace("[0.9, 0.1, 0.7]", "[2.2, 0.4, 0.9]"))
    run = ["run", task, "--robot", path, "--view", "none", "--json", "--record", tmp_path]
    run += ["--scene", "single", "--seed", "1", "--localisation", "exact"]
    with emulated(path) as link, program(RUN, *run) as process:
        wait_until(link, lambda told: told["wanted"][0] > 0.2 and brisk(told["qd"]), process)
        process.send_signal(how)
        killed = stopwatch()
        rests = wait_until(link, lambda told: told["wanted"] == [0.0, 0.0])
        wait_until(link, lambda told: max(map(abs, (*told["twist"], *told["qd"]))) < 0.01)
        arm = link.do("arm tell")
        base_after = rests["stamp"] - rests["still"] - killed
        arm_after = arm["now"] - arm["still"] - killed
        print(f"{how.name} | {base_after:.2f} | {arm_after:.2f}")
        assert base_after < 0.25
        assert arm["still"] > 0.0
        assert arm_after < 0.25
        process.send_signal(signal.SIGCONT)
        process.kill()
        process.wait()
        assert commander_of(load_real_robot(path).hardware) == ""


def brisk(qd) -> bool:
    """Faster, joint 2 needs longer to brake than it may take here."""
    return 0.3 < max(map(abs, qd)) < 1.0


def wait_until(link, done, process=None, patience: float = 60.0):
    """Until the emulators tell something; what they tell."""
    until = time.monotonic() + patience
    while not done(told := link.do("tell")):
        assert process is None or process.poll() is None, process.communicate()
        assert time.monotonic() < until, told
        time.sleep(0.005)
    return told


def on_the_table(link) -> int:
    return sum(support == "table" for support in link.do("supports")["supports"].values())


def wait_for(link, objects: int, process: subprocess.Popen[str], patience: float = 120.0) -> None:
    """Until that number of objects stand on the table; a run that does not get there is ended."""
    until = time.monotonic() + patience
    while on_the_table(link) < objects:
        if process.poll() is not None or time.monotonic() > until:
            process.send_signal(signal.SIGINT)
            pytest.fail(f"the run has not placed {objects}: {summary(process)}")
        time.sleep(0.5)


@pytest.mark.slow
def test_emulators_of_another_world_are_named(tmp_path):
    path, other = robot_file(tmp_path), WorldOptions(scene="household", seed=0)
    words = "--world kinematic --scene single --seed 1 --localisation exact"
    with emulated(path, "single", 1), pytest.raises(UserError, match=words):
        open_backend(str(path), "kinematic", other)


@pytest.mark.slow
def test_pick_place_goes_on_after_what_goes_wrong(tmp_path):
    """Packets of arm and base that are late, a reflex, the emergency stop, and no camera."""
    path = robot_file(tmp_path)
    with (
        emulated(path, "household", 0) as link,
        program(ATTENDED, path, tmp_path) as process,
    ):
        link.do("delay 0.01 0.005")
        wait_for(link, 1, process)
        link.do("arm reflex")
        wait_for(link, 2, process)
        link.do("stop")
        time.sleep(3.0)
        link.do("release")
        wait_for(link, 3, process)
        link.do("blind 3")
        told = summary(process)
        assert (told["outcome"], told["placed"]) == ("success", 10), told
        assert told["limit_violations"] == 0
        assert on_the_table(link) == 10
