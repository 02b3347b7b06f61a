"""What goes wrong while the base moves: when it is told to rest, when it stands, what is reported.

The base drives slowly, so that it stands soon after it was told to: it takes 0.6 m/s² away.
"""

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from emulated import (
    SPEED,
    connected,
    drive,
    is_at_rest,
    measured,
    rest_after,
    set_off,
    soon,
    wait_for,
    wait_for_fault,
)

from hw import FaultKind, HardwareError
from hw.clock import stopwatch
from hw.emulators.omron import Motion, OmronEmulator, Options, Teleop

TOLD = 0.25
"""The base is told to rest within this time of the last good command [s] ..."""
STANDS = TOLD + 0.1 + SPEED / 0.6 + 0.15
"""... and stands after its own cycle and its way to rest, and a little [s]."""


def test_without_commands_the_base_rests():
    with OmronEmulator() as emulator, connected(emulator) as base:

        def attempt() -> float:
            last = set_off(emulator, base)
            told = measured("no commands", emulator, last)
            assert rest_after(emulator, last) < STANDS
            return told

        assert soon(attempt, TOLD) > 0.0
        assert base.read().faults == ()
        assert emulator.heard[-1].name == "stop"
        set_off(emulator, base)  # and it goes on with the next command
        base.close()  # which waits until the base is at rest
        assert emulator.controller.drive.twist()[0] < 0.02


def test_a_stop_is_sent_at_once_from_any_thread():
    with OmronEmulator() as emulator, connected(emulator) as base:

        def attempt() -> float:
            set_off(emulator, base)
            begun = stopwatch()
            thread = threading.Thread(target=base.stop)
            thread.start()
            thread.join()
            wait_for(lambda: emulator.heard[-1].name == "stop")
            return measured("stop", emulator, begun)

        soon(attempt, 0.05)


def test_a_server_that_freezes_and_comes_back():
    """As a pulled cable: silence. The base itself is out of reach; its own timeout stops it."""
    options = Options(teleop=Teleop(timeout=0.3))
    with OmronEmulator(options) as emulator, connected(emulator, silence=30.0) as base:
        set_off(emulator, base)
        last, calls = stopwatch(), []
        emulator.freeze()
        while stopwatch() - last < 0.5:
            begun = stopwatch()
            applied = base.send(np.array([SPEED, 0.0, 0.0]))
            state = base.read()
            calls.append(stopwatch() - begun)
        assert np.median(calls) < 0.01  # nobody has waited for the server
        assert applied[0] == 0.0
        assert {fault.kind for fault in state.faults} == {FaultKind.STALE_POSE}
        stands = rest_after(emulator, last)
        print(f"frozen server, its own timeout 0.3 s: stands after {stands:.2f} s")
        assert stands < 0.3 + 0.1 + SPEED / 0.6 + 0.5
        before, stood = len(emulator.heard), len(emulator.moved)
        emulator.freeze(False)
        wait_for(lambda: not base.read().faults and len(emulator.heard) > before)
        wait_for(lambda: emulator.heard[-1].is_zero)  # the end of what was under way meanwhile
        assert not any(one.v for one in list(emulator.moved)[stood:])


def test_a_server_that_stays_frozen_is_a_lost_connection_and_recovers():
    with (
        OmronEmulator() as emulator,
        connected(emulator, silence=0.8, connect_patience=1.0) as base,
    ):
        set_off(emulator, base)
        emulator.freeze()
        state = wait_for_fault(base, FaultKind.CONNECTION, "nothing heard for 0.8 s")
        assert all(fault.clearable for fault in state.faults)
        with pytest.raises(HardwareError, match="does not greet"):
            base.recover()
        emulator.freeze(False)
        base.recover()
        assert base.read().faults == ()
        set_off(emulator, base)


@pytest.mark.parametrize(
    ("happens", "words"),
    [("break_off", "connection to the base lost"), ("shut_down", "shuts its server down")],
)
def test_a_connection_that_ends(happens, words):
    with OmronEmulator() as emulator, connected(emulator) as base:
        last = set_off(emulator, base)
        getattr(emulator, happens)()
        state = wait_for_fault(base, FaultKind.CONNECTION, words)
        assert "check cable" in state.faults[0].text
        assert base.send(np.array([SPEED, 0.0, 0.0])).max() == 0.0
        assert measured(words, emulator, last) < 2 * TOLD  # over a new connection, made for that
        base.recover()
        assert base.read().faults == ()


def test_a_mistake_in_the_driver_does_not_leave_the_base_driving(monkeypatch):
    with OmronEmulator() as emulator, connected(emulator) as base:
        last = set_off(emulator, base)
        with monkeypatch.context() as patch:
            patch.setattr("hw.omron.link.Telemetry.take", lambda *_: 1 // 0)
            wait_for_fault(base, FaultKind.CONNECTION, "ZeroDivisionError")
        assert measured("mistake in the driver", emulator, last) < 2 * TOLD
        base.recover()
        assert base.read().faults == ()


def test_the_emergency_stop_is_told_and_recovered_from():
    with OmronEmulator() as emulator, connected(emulator, arcl="adept") as base:
        set_off(emulator, base)
        with emulator.held() as controller:
            controller.press()
        pressed = stopwatch()
        state = wait_for_fault(base, FaultKind.EMERGENCY_STOP, "release it")
        noticed = stopwatch() - pressed
        print(f"emergency stop: reported after {noticed:.2f} s")
        assert noticed < 1.0
        assert not state.faults[0].clearable
        assert is_at_rest(emulator)
        with pytest.raises(HardwareError, match="release it first"):
            base.recover()
        with emulator.held() as controller:
            controller.release()
        state = wait_for_fault(base, FaultKind.NOT_READY, "motors of the base are off")
        assert all(fault.clearable for fault in state.faults)
        base.send(np.array([SPEED, 0.0, 0.0]))
        assert is_at_rest(emulator)
        base.recover()
        assert base.read().faults == ()
        set_off(emulator, base)


def test_without_the_text_interface_a_base_that_does_not_follow_is_noticed():
    with OmronEmulator() as emulator, connected(emulator) as base:
        with emulator.held() as controller:
            controller.press()
        wait_for(lambda: drive(base, seconds=0.05) and base.read().faults)
        state = wait_for_fault(base, FaultKind.NOT_READY, "stands although it is commanded")
        assert "emergency stop" in state.faults[0].text
        with emulator.held() as controller:
            controller.release()
            controller.enable_motors()
        base.recover()
        set_off(emulator, base)
        assert base.read().faults == ()


def test_lost_localisation_stops_the_base_and_nothing_but_localising_helps():
    with OmronEmulator() as emulator, connected(emulator) as base:

        def attempt() -> float:
            emulator.options.lost = False
            wait_for(lambda: not base.read().faults)
            set_off(emulator, base)
            emulator.options.lost, begun = True, stopwatch()
            drive(base, seconds=0.5)
            state = wait_for_fault(base, FaultKind.STALE_POSE, "localise it in MobilePlanner")
            assert not state.faults[0].clearable
            return measured("localisation lost", emulator, begun)

        soon(attempt, 0.25 + TOLD)  # it is asked for every 0.25 s
        emulator.options.lost = False
        wait_for(lambda: not base.read().faults)


def test_the_score_of_the_text_interface_counts_where_the_other_has_no_known_scale():
    for scale, arcl in ((100.0, "adept"), (1000.0, "")):
        emulator = OmronEmulator(Options(score_scale=scale))
        with emulator, connected(emulator, arcl=arcl, least_score=0.5) as base:
            wait_for(lambda base=base: base.localisation_score is not None)
            assert base.localisation_score == pytest.approx(0.87, abs=0.001)
            emulator.options.score = 0.3
            wait_for_fault(base, FaultKind.STALE_POSE, "score is below 0.5")


def test_a_mode_that_is_locked_under_way():
    quick = Options(motion=Motion(docking=0.3))
    with OmronEmulator(quick) as emulator, connected(emulator) as base:
        set_off(emulator, base)
        with emulator.held() as controller:
            controller.dock(stopwatch())
        state = wait_for_fault(base, FaultKind.NOT_READY, "'Dock'")
        assert state.faults[0].clearable
        assert base.send(np.array([SPEED, 0.0, 0.0])).max() == 0.0
        with emulator.held() as controller:
            controller.dock(stopwatch(), leave=True)
        base.recover()  # waits until it is out
        assert base.read().faults == ()


@contextmanager
def somebody_else(emulator: OmronEmulator) -> Iterator[None]:
    """Who drives forwards all the time."""
    over = threading.Event()

    def command() -> None:
        while not over.wait(0.005):
            with emulator.held() as controller:
                controller.ratio_drive(50.0, 0.0, 100.0, stopwatch())

    thread = threading.Thread(target=command)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def test_a_second_commander_is_noticed():
    with OmronEmulator() as emulator, connected(emulator) as base:
        with somebody_else(emulator):
            wait_for(lambda: drive(base, v=0.0, seconds=0.1) and base.read().faults, 15.0)
            wait_for_fault(base, FaultKind.NOT_READY, "somebody else commands it")
        base.recover()
        wait_for(lambda: is_at_rest(emulator))
        assert base.read().faults == ()


def test_a_text_interface_that_goes_is_a_fault_and_comes_back():
    with OmronEmulator() as emulator, connected(emulator, arcl="adept") as base:
        with emulator.held():
            for client in emulator._arcl_clients:
                client.socket.shutdown(socket.SHUT_RDWR)
        wait_for_fault(base, FaultKind.CONNECTION, "emergency stop is not seen")
        base.recover()
        assert base.read().faults == ()
        emulator.text_faults.append("EncoderDegraded")
        state = wait_for_fault(base, FaultKind.NOT_READY, "EncoderDegraded")
        assert not state.faults[0].clearable
