"""The driver of the hand against the emulated one."""

import threading
import time

import pytest
from child_in_thread import child_in_thread
from emulated_panda import free_address, needs_library
from stepped_panda import SteppedHand
from waiting import until

from drivers.panda import PandaHand, hand_process
from drivers.processes.mailbox import share_memory
from hw import FaultKind, HardwareError, WallClock

pytestmark = needs_library
OPENING = 0.08


@pytest.fixture(scope="module")
def connected(emulator):
    hand = PandaHand(emulator.address, WallClock())
    hand.connect()
    yield hand
    hand.close()


@pytest.fixture
def hand(emulator, connected):
    emulator.do("block")
    connected.grip(OPENING, 20.0)
    return connected


def width_of(hand) -> float:
    """When a reading has come that is newer than now."""
    now = hand._clock.now()
    until(lambda: hand.read().stamp > now)
    return hand.read().width


@pytest.mark.realtime
def test_the_fingers_go_to_a_width_or_hold_an_object(hand, emulator):
    for block, width, reached in ((0.0, 0.03, 0.03), (0.0, 0.0, 0.0), (0.031, 0.0, 0.031)):
        hand.grip(OPENING, 20.0)
        emulator.do(f"block {block}")
        hand.grip(width, 20.0)
        assert width_of(hand) == pytest.approx(reached, abs=1e-3)
        if width == 0.0:
            assert hand.reading().is_grasped  # also of an empty hand: that is why nobody asks it
    assert hand.read().faults == ()


@pytest.mark.realtime
def test_a_stop_leaves_the_fingers_where_they_are(hand):
    failures = []

    def grip() -> None:
        try:
            hand.grip(0.0, 20.0)
        except HardwareError as error:
            failures.append(str(error))

    thread = threading.Thread(target=grip)
    thread.start()
    until(lambda: hand.read().moving)
    until(lambda: hand.reading().width < 0.06)
    hand.stop()
    thread.join(60.0)
    assert len(failures) == 1
    assert not hand.read().moving
    assert 0.0 < width_of(hand) < 0.06


@pytest.mark.realtime
def test_a_hand_that_falls_silent_is_a_fault_and_a_grip_connects_again(hand, emulator):
    emulator.do("unplug 1.3")
    begun = time.monotonic()
    until(lambda: hand.read().faults)
    assert hand.read().faults[0].kind is FaultKind.CONNECTION
    until(lambda: time.monotonic() - begun > 1.5)
    hand.grip(0.04, 20.0)
    assert width_of(hand) == pytest.approx(0.04, abs=1e-3)
    assert hand.read().faults == ()


def test_one_process_does_what_it_is_asked_and_a_second_is_refused(monkeypatch):
    hand = SteppedHand(monkeypatch, "unhomed")
    monkeypatch.setattr(hand_process, "load_library", lambda: hand)
    arguments = hand_process, free_address(), {"speed": 0.1}, share_memory(1)
    with child_in_thread(monkeypatch, *arguments) as (ask, told):
        for number, do in enumerate(("grip", "home", "grip")):
            ask(id=number, do=do, width=0.03, force=20.0)
        until(lambda: len(told()) == 5)
        assert [one.get("error") for one in told()] == [None, None, hand_process.NOT_HOMED, "", ""]
        assert hand.fingers.width == pytest.approx(0.03)
        ask(do="stop")
        until(lambda: hand.body.stops)
    with child_in_thread(monkeypatch, *arguments) as (_, told):
        until(lambda: len(told()) == 2)
        assert "another program on this computer commands it already" in told()[1]["error"]
