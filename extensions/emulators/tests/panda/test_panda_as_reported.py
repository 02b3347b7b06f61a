"""The driver of arm and hand against robots that behave as real ones were reported to."""

import re
import threading
import time

import numpy as np
import pytest
from emulated_panda import connected, drive, emulated, free_address, needs_library
from stepped_panda import SteppedHand
from waiting import until

from drivers.panda import PandaArm, PandaHand
from drivers.panda.hand_process import NOT_HOMED
from extensions.emulators.panda import AS_REPORTED
from hw import FaultKind, HardwareError, WallClock

BLOCK, OPENING, FORCE = 0.031, 0.08, 20.0
REFUSED = {
    "udp-blocked": "firewall",
    "wrong-version": "it is an FR3",
    "locked": "unlock",
    "user-stopped": "release it",
}
"""What keeps the arm from being commanded, and is told when it is connected."""
LOST = {
    "velocity-violation": "joint_velocity_violation; a joint was faster than it may be",
    "lost-bursts": "communication_constraints_violation; ",
    "slow-line": "communication_constraints_violation; ",
}
"""What no recovery heals for long."""
HANDS = [
    *("unhomed", "slow-homing", "move-blocks", "stop-unheeded", "move-fails"),
    *("second-grasp-fails", "second-grasp-false", "wide-grasp-fails", "strict-grasp"),
    *("never-grasped", "slow-hand"),
]
ARMS = [
    *("stop-needs-recovery", "needs-recovery", "slow-recovery", "forgets-errors", "late-reflex")
]


def test_every_report_names_its_source_and_is_tried_here():
    assert {*HANDS, *ARMS, *REFUSED, *LOST, "guided"} == AS_REPORTED.keys()
    assert all(re.search(r"[a-z0-9]+ #[0-9]+", one.source) for one in AS_REPORTED.values())


@pytest.mark.parametrize("reported", ["", *HANDS])
def test_a_hand_grips_holds_and_opens(monkeypatch, reported):
    hand = SteppedHand(monkeypatch, reported)
    body, process = hand.body, hand.process
    if not body.is_homed:
        assert process.grip(OPENING, FORCE) == NOT_HOMED
        assert (body.number, body.homings) == (0, 0)
        assert process.home() == ""
    assert process.grip(OPENING, FORCE) == ""
    hand.fingers.block = BLOCK
    for _ in range(2):  # what is held already is held
        begun = body.number
        assert process.grip(0.0, FORCE) == ""
        assert body.number - begun < 3000
        assert (hand.fingers.width, body.stops) == (BLOCK, 0)
    assert process.grip(OPENING, FORCE) == ""
    begun = body.number
    if reported == "stop-unheeded":
        with pytest.raises(SystemExit, match="do not listen to a stop"):
            process.grip(0.02, FORCE)
        process = hand.connect()
    else:
        assert process.grip(0.02, FORCE) == ""
    assert body.number - begun < 4500
    assert hand.fingers.width == BLOCK
    assert process.grip(OPENING, FORCE) == ""
    assert hand.fingers.width == OPENING


def test_a_hand_may_be_silent_while_homing_and_stops_at_once(monkeypatch):
    hand = SteppedHand(monkeypatch, "unhomed")
    hand.at = {300: lambda: setattr(hand, "is_silent", True)}
    hand.at[900] = lambda: setattr(hand, "is_silent", False)
    assert hand.process.home() == ""
    hand.at[200] = hand.process.stop
    assert "stopped on their way" in hand.process.grip(0.03, FORCE)
    assert hand.fingers.width == pytest.approx(0.06, abs=1e-3)
    hand.at[20] = lambda: setattr(hand, "is_silent", True)
    with pytest.raises(SystemExit, match="UDP receive"):
        hand.process.grip(0.03, FORCE)


def test_fingers_that_cannot_close_are_a_result_and_open_again(monkeypatch):
    hand = SteppedHand(monkeypatch, "wide-grasp-fails")
    hand.fingers.block = 0.076
    assert "Command failed!; the fingers could not do it" in hand.process.grip(0.0, FORCE)
    assert hand.process.grip(OPENING, FORCE) == ""


@needs_library
@pytest.mark.realtime
@pytest.mark.parametrize("is_known", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_hand_that_comes_back_drops_nothing(is_known):
    with emulated() as emulator:
        with connected(PandaHand(emulator.address, WallClock())) as hand:
            emulator.do(f"block {BLOCK}")
            hand.grip(0.0, FORCE)
            hand._process.process.kill()
            until(lambda: hand.read().faults)
            hand.recover()
            assert hand.read().faults == ()
            if is_known:
                loses_its_power(hand, emulator)
        if not is_known:  # to a program that has never seen it before
            with connected(PandaHand(emulator.address, WallClock())) as hand:
                loses_its_power(hand, emulator)
        told = emulator.tell()
        assert told["width"] == pytest.approx(BLOCK, abs=1e-3)
        assert (told["homings"], told["stops"]) == (0, 0)


def loses_its_power(hand, emulator):
    emulator.do("blackout")
    until(lambda: hand.read().faults)
    (fault,) = hand.read().faults
    assert not fault.clearable
    with pytest.raises(HardwareError, match="take that out, and home it on its Desk page"):
        hand.recover()


def moves(arm) -> bool:
    drive(arm, 0.1, 0.0)
    until(lambda: drive(arm, 0.1) or arm.read().qd[6] > 0.2)
    return not arm.read().faults


@needs_library
@pytest.mark.realtime
@pytest.mark.slow
@pytest.mark.parametrize("reported", ARMS)
def test_an_arm_moves_again_after_one_recovery(reported):
    with emulated(reported) as emulator, connected(PandaArm(emulator.address, WallClock())) as arm:
        if reported == "needs-recovery":
            (fault,) = arm.read().faults
            assert "recover" in fault.text
            assert fault.clearable
            arm.recover()
        assert emulator.tell()["commands"] == 0
        assert moves(arm)
        before = emulator.tell()["recoveries"]
        if reported in ("forgets-errors", "late-reflex", "slow-recovery"):
            emulator.do("reflex joint_reflex")
            name = "joint_reflex"
        else:
            emulator.do("stop")
            drive(arm, 0.2)
            emulator.do("release")
            name = "stop button"
        emulator.wait(lambda told: told["resting"] > 0.1)
        until(lambda: drive(arm, 0.1) and all(one.clearable for one in arm.read().faults))
        assert name in arm.read().faults[0].text
        recovery = threading.Thread(target=arm.recover)
        recovery.start()
        seen = []
        while recovery.is_alive():
            seen += [fault for fault in drive(arm, 0.05) if fault not in seen]
        # what it was, that it is on its way, and nothing that changes from moment to moment
        assert len(seen) <= 2, seen
        if reported == "slow-recovery":
            assert seen[-1].kind is FaultKind.NOT_READY
            assert "recovery is under way" in seen[-1].text
        assert arm.read().faults == ()
        assert moves(arm)
        assert emulator.tell()["recoveries"] == before + 1


@needs_library
@pytest.mark.realtime
@pytest.mark.slow
@pytest.mark.parametrize("reported", LOST)
def test_what_comes_back_is_named_and_not_recovered_in_a_loop(monkeypatch, reported):
    monkeypatch.setattr("drivers.panda.arm._APART", 0.7)
    seconds = 4.5 if reported == "lost-bursts" else 2.0  # those come every 2 s
    with emulated(reported) as emulator, connected(PandaArm(emulator.address, WallClock())) as arm:
        emulator.do("patience 20")
        seen, begun = [], time.monotonic()
        while time.monotonic() < begun + seconds:
            seen += [fault for fault in drive(arm, 0.2) if fault not in seen]
            arm.recover()
            drive(arm, 0.1, 0.0)
        assert any(LOST[reported] in fault.text for fault in seen), seen
        assert {fault.kind for fault in seen} == {FaultKind.REFLEX}
        assert len({fault.text for fault in seen}) <= 2, seen
        assert 2 <= emulator.tell()["recoveries"] <= 1 + (time.monotonic() - begun) / 0.7


@needs_library
@pytest.mark.slow
@pytest.mark.parametrize("reported", REFUSED)
def test_why_it_cannot_be_commanded_is_said(reported):
    with emulated(reported) as emulator:
        arm = PandaArm(emulator.address, WallClock(), connecting=4.0)
        with pytest.raises(HardwareError, match=REFUSED[reported]):
            arm.connect()
        if reported == "udp-blocked":
            with pytest.raises(HardwareError, match=REFUSED[reported]):
                PandaHand(emulator.address, WallClock()).connect()
        assert emulator.tell()["commands"] == 0


@needs_library
def test_an_arm_that_is_guided_by_hand_is_read_and_not_commanded():
    with emulated("guided") as emulator:
        with connected(PandaArm(emulator.address, WallClock(), connecting=4.0)) as arm:
            (fault,) = arm.read().faults
            assert fault.kind is FaultKind.NOT_READY
            assert "by hand" in fault.text
            assert not np.any(arm.send(np.full(7, 0.1)))
        assert emulator.tell()["commands"] == 0


def refusal(address: str) -> str:
    arm = PandaArm(address, WallClock(), connecting=1.5)
    with pytest.raises(HardwareError) as caught:
        arm.connect()
    text = str(caught.value)
    assert address in text
    assert "\n" not in text
    return text


def test_without_the_library_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr("drivers.panda.library.find_spec", lambda _: None)
    arm = PandaArm("127.0.0.1", WallClock())
    with pytest.raises(HardwareError, match=r'pip install "frankie-task\[hardware\]"'):
        arm.connect()


@needs_library
def test_where_nobody_listens_fci_is_not_active():
    assert "activate FCI" in refusal(free_address())
    assert "no such host" in refusal("no-such-panda.invalid")
