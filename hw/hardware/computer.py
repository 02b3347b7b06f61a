"""Findings about the computer: libraries, and real-time behaviour."""

import os
import platform
import time
from collections.abc import Callable, Iterator, Set
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from pinocchio import SE3

from config import extra
from controller import Command, HolisticController, KinematicState, PoseGoal, RobotModel
from hw.clock import stopwatch
from hw.findings import Finding, Verdict, is_good
from hw.state import DepthFrame
from hw.system import has_priorities, run_at
from hw.threads import begun
from perception import GraspDetector
from robots import RobotDescription

_NAPS, _NAP = 1000, 0.001  # number and time of the sleeps that measure the computer [s]
_LIBRARIES = (
    ("panda-python", {"panda", "franka_hand"}, "arm and hand"),
    ("pyrealsense2", {"realsense"}, "camera"),
)
_LATE = 20.0  # the arm stops when commands are this late [ms]
_STEPS, _SEARCHES = 60, 3  # of the controller, and for grasps, that are timed
_TICK = 4.2  # a whole tick of the control loop, in steps of the controller
_LONG_SEARCH = 0.15  # [s]


def computer(drivers: Set[str] | None = None) -> Iterator[Finding]:
    """Whether the libraries of these drivers, of all by default, are there; 1 kHz is on time."""
    for package, users, what in _LIBRARIES:
        if drivers is not None and not users & drivers:
            continue
        try:
            yield Finding("installed", Verdict.GOOD, f"{package} {version(package)} ({what})")
        except PackageNotFoundError:
            told = f"{package} is missing ({what}): {extra('hardware')}"
            verdict = Verdict.OPEN if drivers is None else Verdict.BAD
            yield Finding("installed", verdict, told)
    allowed, median, worst = _measure()
    if has_priorities():
        hint = "" if allowed else ": `@realtime - rtprio 99` in /etc/security/limits.conf"
        text = f"real-time priority is {'granted' if allowed else 'refused'}{hint}"
        yield is_good("computer", allowed, text)
    else:
        name = platform.system().replace("Darwin", "macOS")
        text = f"no real-time priority on {name}: a real robot is driven from Linux"
        yield Finding("computer", Verdict.OPEN, text)
    if "PREEMPT_RT" in os.uname().version.replace(" ", "_"):
        yield Finding("computer", Verdict.GOOD, "a real-time kernel")
    else:
        yield Finding("computer", Verdict.OPEN, "no real-time kernel (PREEMPT_RT)")
    places = Path("/sys/devices/system/cpu").glob("cpu[0-9]*/cpufreq/scaling_governor")
    if governors := {path.read_text().strip() for path in places}:
        good = governors == {"performance"}
        text = f"clock governor: {', '.join(sorted(governors))}"
        hint = "" if good else "; `cpupower frequency-set -g performance`"
        yield is_good("computer", good, text + hint)
    text = f"a loop of 1 ms is late by {median:.2f} ms in the middle, {worst:.1f} ms at worst"
    yield is_good("computer", worst < _LATE, text)


def room(robot: RobotDescription, detector: GraspDetector | None = None) -> Iterator[Finding]:
    """How much faster than necessary the computer is: a control tick, and a search for grasps."""
    model = RobotModel(robot)
    controller, still = HolisticController(model), Command.stop(len(robot.arm.joints))
    state = KinematicState(SE3.Identity(), robot.arm.ready)
    goal = PoseGoal(target=SE3(np.eye(3), np.array([1.0, 0.0, 0.0])) * model.bTe(state.q))
    tick = _TICK * _median(_STEPS, lambda: controller.step(state, goal, still))
    share = controller.settings.period / tick
    verdict = Verdict.GOOD if share > 1.5 else Verdict.OPEN if share > 1.0 else Verdict.BAD
    period = f"{1000 * controller.settings.period:g} ms"
    slow = "" if share > 1.5 else ": ticks will be left out"
    text = f"a control tick takes about {1000 * tick:.1f} ms of {period}{slow}"
    yield Finding("computer", verdict, text)
    camera = robot.camera
    over_a_table = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 0.5]))
    depth = np.full((camera.intrinsics.height, camera.intrinsics.width), 0.5, np.float32)
    depth[depth.shape[0] // 2 :][:40, depth.shape[1] // 2 :][:, :40] = 0.45
    frame = DepthFrame(depth=depth, intrinsics=camera.intrinsics, oTc=over_a_table, stamp=0.0)
    detector = detector or GraspDetector.shipped(robot.gripper)
    search = _median(_SEARCHES, lambda: detector.detect(frame))
    text = f"a search for grasps takes {search:.2f} s"
    slow = "" if search < _LONG_SEARCH else ": the hand waits for it, and grasps nothing that moves"
    yield Finding("computer", Verdict.OPEN if slow else Verdict.GOOD, text + slow)


def _median(count: int, work: Callable[[], object]) -> float:
    """Duration of work that is repeated [s]."""
    seconds = []
    for _ in range(count):
        begun = stopwatch()
        work()
        seconds.append(stopwatch() - begun)
    return float(np.median(seconds))


def _measure() -> tuple[bool, float, float]:
    """Whether a thread gets real-time priority, and how late it wakes: median and worst [ms]."""
    granted, late = [False], []

    def measure() -> None:
        granted[0] = run_at(1)
        for _ in range(_NAPS):
            due = stopwatch() + _NAP
            time.sleep(_NAP)
            late.append(1000.0 * (stopwatch() - due))

    begun(measure, "measures").join()
    return granted[0], float(np.median(late)), max(late)
