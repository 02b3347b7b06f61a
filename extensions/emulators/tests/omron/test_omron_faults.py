"""What goes wrong while the base moves: it comes to rest, says why, and recovers."""

import socket

import numpy as np
import pytest
from emulated import (
    SPEED,
    TOLD,
    connected,
    drive,
    is_at_rest,
    repeating,
    set_off,
    told_to_rest,
    wait_for_fault,
)
from waiting import until

from extensions.emulators.omron import OmronEmulator, Options, Teleop
from hw import FaultKind, HardwareError
from hw.clock import stopwatch

pytestmark = pytest.mark.realtime

GO = np.array([SPEED, 0.0, 0.0])


def test_without_commands_or_told_to_stop_the_base_rests_and_goes_on_with_the_next():
    with OmronEmulator() as emulator, connected(emulator) as base:
        assert told_to_rest("no commands", emulator, set_off(emulator, base)) < TOLD
        until(lambda: emulator.heard[-1].name == "stop")
        set_off(emulator, base)
        stopped = stopwatch()
        base.stop()
        assert told_to_rest("stop", emulator, stopped) < 0.1
        assert base.read().faults == ()
        set_off(emulator, base)
        base.close()  # which waits until the base is at rest
        assert emulator.controller.drive.twist()[0] < 0.02


def test_a_frozen_server_is_a_stale_pose_then_a_lost_connection_and_recovers():
    """As a pulled cable: silence. The base itself is out of reach; its own timeout stops it."""
    options = Options(teleop=Teleop(timeout=0.3))
    with (
        OmronEmulator(options) as emulator,
        connected(emulator, silence=1.5, connect_patience=0.5) as base,
    ):
        set_off(emulator, base)
        emulator.options.frozen = True
        wait_for_fault(base, FaultKind.STALE_POSE, "no pose of the base")
        assert not base.send(GO).any()
        until(lambda: is_at_rest(emulator))
        state = wait_for_fault(base, FaultKind.CONNECTION, "nothing heard for 1.5 s")
        assert all(fault.clearable for fault in state.faults)
        with pytest.raises(HardwareError, match="does not greet"):
            base.recover()
        emulator.options.frozen = False
        base.recover()
        assert base.read().faults == ()
        set_off(emulator, base)


@pytest.mark.parametrize(
    ("happens", "words"),
    [("break_off", "connection to the base lost"), ("shut_down", "shuts its server down")],
)
def test_a_connection_that_ends(happens, words):
    with OmronEmulator() as emulator, connected(emulator) as base:
        set_off(emulator, base)
        moment = stopwatch()
        getattr(emulator, happens)()
        assert told_to_rest(happens, emulator, moment) < 2 * TOLD
        state = wait_for_fault(base, FaultKind.CONNECTION, words)
        assert "check cable" in state.faults[0].text
        assert not base.send(GO).any()
        base.recover()
        assert base.read().faults == ()


def test_a_mistake_in_the_driver_does_not_leave_the_base_driving(monkeypatch):
    with OmronEmulator() as emulator, connected(emulator) as base:
        set_off(emulator, base)
        with monkeypatch.context() as patch:
            patch.setattr("drivers.omron.link.Telemetry.take", lambda *_: 1 // 0)
            wait_for_fault(base, FaultKind.CONNECTION, "ZeroDivisionError")
        until(lambda: is_at_rest(emulator))
        base.recover()
        assert base.read().faults == ()


def test_the_emergency_stop_is_told_and_recovered_from():
    with OmronEmulator() as emulator, connected(emulator, arcl="adept") as base:
        set_off(emulator, base)
        with emulator.held() as controller:
            controller.press()
        state = wait_for_fault(base, FaultKind.EMERGENCY_STOP, "release it")
        assert not state.faults[0].clearable
        assert is_at_rest(emulator)
        with pytest.raises(HardwareError, match="release it first"):
            base.recover()
        with emulator.held() as controller:
            controller.release()
        state = wait_for_fault(base, FaultKind.NOT_READY, "motors of the base are off")
        assert all(fault.clearable for fault in state.faults)
        base.send(GO)
        assert is_at_rest(emulator)
        base.recover()
        assert base.read().faults == ()
        set_off(emulator, base)


def test_without_the_text_interface_a_base_that_does_not_follow_is_noticed():
    with OmronEmulator() as emulator, connected(emulator) as base:
        with emulator.held() as controller:
            controller.press()
        until(lambda: drive(base, seconds=0.05) and base.read().faults)
        state = wait_for_fault(base, FaultKind.NOT_READY, "stands although it is commanded")
        assert "emergency stop" in state.faults[0].text
        with emulator.held() as controller:
            controller.release()
            controller.enable_motors()
        base.recover()
        set_off(emulator, base)
        assert base.read().faults == ()


def test_lost_localisation_stops_the_base_and_nothing_but_localising_helps():
    options = Options(score_scale=100.0)  # one that ArNetworking does not tell
    with (
        OmronEmulator(options) as emulator,
        connected(emulator, arcl="adept", least_score=0.5) as base,
    ):
        set_off(emulator, base)
        emulator.options.lost = True
        state = wait_for_fault(base, FaultKind.STALE_POSE, "localise it in MobilePlanner")
        assert not state.faults[0].clearable
        assert not base.send(GO).any()
        until(lambda: is_at_rest(emulator))
        emulator.options.lost = False
        until(lambda: not base.read().faults)
        assert base.link.score == pytest.approx(0.87, abs=0.001)
        emulator.options.score = 0.3
        wait_for_fault(base, FaultKind.STALE_POSE, "score is below 0.5")


def test_a_mode_that_is_locked_under_way():
    with OmronEmulator() as emulator, connected(emulator) as base:
        set_off(emulator, base)
        with emulator.held() as controller:
            controller.dock()
        state = wait_for_fault(base, FaultKind.NOT_READY, "'Dock'")
        assert state.faults[0].clearable
        assert not base.send(GO).any()
        with emulator.held() as controller:
            controller.undock()
        base.recover()  # waits until it is out
        assert base.read().faults == ()


def test_a_second_commander_is_noticed():
    with OmronEmulator() as emulator, connected(emulator) as base:

        def somebody_else() -> None:
            with emulator.held() as controller:
                controller.ratio_drive(50.0, 0.0, 100.0, stopwatch())

        with repeating(somebody_else):
            until(lambda: drive(base, v=0.0, seconds=0.1) and base.read().faults)
            wait_for_fault(base, FaultKind.NOT_READY, "somebody else commands it")
        base.recover()
        until(lambda: is_at_rest(emulator))
        assert base.read().faults == ()


def test_a_text_interface_that_goes_is_a_fault_and_comes_back():
    with OmronEmulator() as emulator, connected(emulator, arcl="adept") as base:
        with emulator.held():
            for client in emulator.text_clients:
                client.socket.shutdown(socket.SHUT_RDWR)
        wait_for_fault(base, FaultKind.CONNECTION, "emergency stop is not seen")
        base.recover()
        assert base.read().faults == ()
        emulator.text_faults.append("EncoderDegraded")
        state = wait_for_fault(base, FaultKind.NOT_READY, "EncoderDegraded")
        assert not state.faults[0].clearable
