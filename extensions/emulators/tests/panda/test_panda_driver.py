"""The driver of the arm against the emulated robot, over real sockets and with the real library."""

import re
import signal
import threading
import time

import numpy as np
import pytest
from emulated_panda import IN_TIME, drive, needs_library
from waiting import until

from drivers.panda import PandaArm
from hw import FaultKind, HardwareError, WallClock

pytestmark = [pytest.mark.realtime, needs_library]
ZERO = np.zeros(7)
SPEED = 0.3
READY = np.array([0.0, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785])


@pytest.fixture(scope="module")
def connected(emulator):
    arm = PandaArm(emulator.address, WallClock())
    arm.connect()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("drivers.panda.arm._APART", 0.2)
        yield arm
    arm.close()


@pytest.fixture
def arm(emulator, connected):
    """At rest, healthy, near its ready pose."""
    connected.stop()
    emulator.do("release")
    if connected.read().faults:
        connected.recover()
    until(lambda: not connected.read().faults)
    if np.abs(connected.read().q - READY).max() > 0.5:
        connected.move_to(READY, speed=1.0)
    emulator.do("forget")
    return connected


def stream(arm, seconds, qd):
    """Command a velocity, or a function of time, at 100 Hz; the last command's time."""
    begun = time.monotonic()
    for tick in range(round(seconds * 100)):
        arm.send(np.array(qd(tick * 0.01) if callable(qd) else qd))
        time.sleep(max(0.0, begun + (tick + 1) * 0.01 - time.monotonic()))
    return time.monotonic()


def joint(number, speed):
    qd = ZERO.copy()
    qd[number] = speed
    return qd


def moving(arm, emulator, speed=SPEED):
    """In a motion at a steady speed."""
    stream(arm, 0.1, ZERO)
    begun = time.monotonic()
    while emulator.tell()["qd"][0] < 0.9 * speed:
        stream(arm, 0.1, joint(0, speed))
        assert time.monotonic() < begun + 60.0, (emulator.tell(), arm.reading())


def test_wild_commands_leave_no_limit(arm, emulator):
    rng = np.random.default_rng(3)
    for _ in range(15):
        seconds, qd = rng.choice([0.01, 0.03, 0.1]), rng.uniform(-5.0, 5.0, 7)
        stream(arm, seconds, qd)
        stream(arm, seconds, -qd)
    stream(arm, 0.3, ZERO)
    told = emulator.tell()
    assert told["violations"] == []
    assert max(told["speed"], told["acceleration"], told["jerk"]) <= 1.0
    assert arm.read().faults == ()


def test_one_percent_of_late_and_lost_packets_is_survived(arm, emulator):
    emulator.do("delay 0.01 0.005")
    emulator.do("drop 0.01")
    stream(arm, 1.0, lambda t: SPEED * np.sin(8.0 * t) * np.ones(7))
    told = emulator.tell()
    emulator.do("drop 0")
    emulator.do("delay 0")
    assert arm.read().faults == ()
    assert told["violations"] == []
    assert told["lost"] > 0


def test_a_reflex_is_a_fault_and_waits_for_a_recovery(arm, emulator):
    moving(arm, emulator)
    emulator.do("reflex joint_reflex")
    until(lambda: arm.read().faults)
    (fault,) = arm.read().faults
    assert fault.kind is FaultKind.REFLEX
    assert fault.clearable
    assert "joint_reflex" in fault.text
    emulator.wait(lambda told: told["resting"] > 0.0)
    # Commands do not clear it, and recovering does not make it move.
    assert not arm.send(joint(0, SPEED)).any()
    arm.recover()
    assert arm.read().faults == ()
    stream(arm, 0.2, ZERO)
    assert emulator.tell()["mode"] == "IDLE"
    moving(arm, emulator)


@pytest.mark.parametrize(
    ("done", "kind", "hint"),
    [("stop", FaultKind.EMERGENCY_STOP, "release it"), ("lock", FaultKind.NOT_READY, "unlock")],
)
def test_its_button_and_its_locks_stop_it_and_only_a_person_clears_that(
    arm, emulator, done, kind, hint
):
    moving(arm, emulator)
    emulator.do(done)
    emulator.wait(lambda told: told["resting"] > 0.0)
    until(lambda: any(one.kind is kind for one in arm.read().faults))
    fault = arm.read().faults[0]
    assert not fault.clearable
    assert hint in fault.text
    with pytest.raises(HardwareError, match=hint):
        arm.recover()
    emulator.do("release")
    until(lambda: all(one.clearable for one in arm.read().faults))
    stream(arm, 0.2, joint(0, SPEED))
    assert emulator.tell()["mode"] == "IDLE"  # it has to be acknowledged
    arm.recover()
    stream(arm, 0.1, ZERO)
    moving(arm, emulator)


def test_a_silent_robot_is_a_fault_and_comes_back_by_a_recovery(arm, emulator):
    moving(arm, emulator)
    begun = time.monotonic()
    emulator.do("unplug 1.0")
    until(lambda: arm.read().faults)
    (fault,) = arm.read().faults
    assert fault.kind is FaultKind.CONNECTION
    assert "cable" in fault.text
    if IN_TIME:  # the robot itself stops when nothing arrives
        told = emulator.wait(lambda told: told["resting"] > 0.0)
        assert told["errors"] == ["communication_constraints_violation"]
    time.sleep(max(0.0, begun + 1.1 - time.monotonic()))
    arm.recover()
    until(lambda: not arm.read().faults)
    stream(arm, 0.1, ZERO)
    moving(arm, emulator)


def test_the_ready_pose_is_reached_and_a_stop_ends_the_way(arm, emulator):
    goal = np.array([0.3, -0.2, 0.1, -2.0, 0.2, 2.1, 0.7])
    arm.move_to(goal, speed=1.0)
    until(lambda: np.abs(arm.read().q - goal).max() < 5e-3)
    timer = threading.Timer(0.2, arm.stop)
    timer.start()
    with pytest.raises(HardwareError, match="stopped on its way"):
        arm.move_to(READY, speed=0.3)
    assert emulator.tell()["violations"] == []


def test_a_second_commander_is_refused(arm, emulator):
    second = PandaArm(emulator.address, WallClock(), connecting=2.0)
    with pytest.raises(HardwareError, match=r"another program .* \(process \d+\)"):
        second.connect()
    assert arm.read().faults == ()


def test_a_joint_that_is_faster_than_commanded_is_stopped(arm, emulator):
    emulator.do("rush 0.2")  # less than the margin
    moving(arm, emulator)
    emulator.do("rush 0.5")
    faults = drive(arm, 1.0)
    emulator.do("rush")
    assert faults == list(arm.read().faults)
    (fault,) = faults
    assert re.search(r"joint 1 moved at 0.\d+ rad/s and was told -?0.00 rad/s", fault.text)
    assert emulator.wait(lambda told: told["resting"] > 0.0)["mode"] == "IDLE"
    arm.recover()
    moving(arm, emulator)


def test_a_driver_that_gets_no_time_is_no_cable_and_it_stays_in_memory(arm):
    process = arm._process.process
    with open(f"/proc/{process.pid}/status") as status:
        assert int(re.search(r"VmLck:\s+(\d+)", status.read())[1]) > 0
    reading = arm.reading()
    assert (reading.hand_mass, reading.load) == (pytest.approx(0.73), 0.0)
    process.send_signal(signal.SIGSTOP)
    until(lambda: arm.read().faults)
    texts = {fault.text for _ in range(10) for fault in drive(arm, 0.05)}
    process.send_signal(signal.SIGCONT)
    (text,) = texts
    assert "this computer is too busy" in text
