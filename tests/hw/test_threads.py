"""A computer that starts no more threads or processes: rest and words, never a dead watchdog."""

import time
from types import SimpleNamespace

import pytest
from full_computer import full_computer
from waiting import until

from config.plugins import PluginError, imported
from drivers.panda.hand_process import HandProcess
from drivers.processes.mailbox import share_memory
from drivers.processes.process import DriverProcess
from hw import ComposedRobot, HardwareError, Patience, SimClock, Watchdog, Worker
from hw.clock import WallClock
from robots import load_robot

FULL = r"starts no more threads"
QUICK = Patience(stop=0.05, interrupt=0.15, abandon=0.3)


@pytest.mark.parametrize("stops", [True, False])
def test_the_watchdog_of_a_full_computer_stops_interrupts_and_abandons(monkeypatch, stops):
    done = []

    def stop():
        done.append("stop")
        if not stops:
            raise OSError("the line is cut")

    with Watchdog(stop, lambda: done.append("abandon"), QUICK) as watchdog:
        with full_computer(monkeypatch):
            begun = time.monotonic()
            while len(done) < 2 and time.monotonic() < begun + 3.0:
                try:
                    time.sleep(0.02)
                except BaseException as error:
                    done.append(type(error).__name__)
        until(lambda: "abandon" in done)
    assert done == ["stop", "LoopBlockedError", "abandon"]
    assert ("the line is cut" in watchdog.failure) is not stops


def test_a_second_stall_is_stopped_too():
    stops = []
    with Watchdog(lambda: stops.append(1), patience=Patience(stop=0.05)) as watchdog:
        for number in (1, 2):
            until(lambda number=number: len(stops) == number)
            watchdog.feed()
            time.sleep(0.03)
    assert watchdog.stalls >= 2


def test_a_watchdog_that_cannot_begin_says_so(monkeypatch):
    with full_computer(monkeypatch), pytest.raises(HardwareError, match=FULL):
        Watchdog(lambda: None).__enter__()


def test_work_beside_the_loop_needs_no_thread_later(monkeypatch):
    worker = Worker(WallClock(), 0.0)
    with full_computer(monkeypatch):
        assert worker.submit(lambda: 7).result(2.0) == 7
        with pytest.raises(HardwareError, match=FULL):
            Worker(SimClock(), 0.0)
    worker.shutdown()


def test_a_robot_that_may_not_grip_later_is_not_opened(monkeypatch):
    part = SimpleNamespace(grip=lambda *_: None)
    parts = dict.fromkeys(("arm", "base", "gripper", "camera"), part)
    with full_computer(monkeypatch), pytest.raises(HardwareError, match=FULL):
        ComposedRobot(load_robot("frankie"), **parts, clock=WallClock())


def test_a_hand_is_stopped_though_no_thread_starts(monkeypatch):
    stopped = []
    state = SimpleNamespace(width=0.04, max_width=0.08, is_grasped=False, temperature=30)
    hand = SimpleNamespace(read_once=lambda: state, stop=lambda: stopped.append(1))
    library = SimpleNamespace(Gripper=lambda _: hand)
    process = HandProcess(library, "nowhere", 0.1, share_memory(1))
    with full_computer(monkeypatch):
        for number in (1, 2):
            process.stop()
            until(lambda number=number: len(stopped) == number)


def test_a_driver_whose_process_does_not_start_says_so(monkeypatch):
    process = DriverProcess(
        "drivers.panda.arm_process", "Panda", "10.0.0.1", {}, 1, 1.0, lambda: ""
    )
    with (
        full_computer(monkeypatch),
        pytest.raises(HardwareError, match=r"Panda at 10.0.0.1.*no more"),
    ):
        process.start()
    assert process.end_of_it()


def test_a_plugin_that_gets_no_thread_is_named(monkeypatch):
    entry = SimpleNamespace(value="somewhere", load=lambda: None)
    with full_computer(monkeypatch), pytest.raises(PluginError, match="new thread"):
        imported(entry, 1.0)
