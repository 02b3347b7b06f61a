"""The driver on bases that behave as real ones were reported to; what holds on each of them."""

import itertools

import numpy as np
import pytest
from emulated import connected, drive, is_at_rest, wait_for_fault
from waiting import until

from extensions.emulators.omron import AS_REPORTED, OmronEmulator, Options
from extensions.emulators.omron.onboard_controller import Teleop
from hw import FaultKind, HardwareError
from hw.state import Fault

pytestmark = pytest.mark.realtime

TOLD = 0.15
WHY = {
    "dead-zone-larger": "stands although it is commanded",
    "full-scale-is-top": "told 0.15 m/s and 0 deg/s, and was stopped: `full_scale`",
    "safe-drive-blocks": "stands although it is commanded",
    "direction-reversed": "goes the other way",
    "arcl-kicks-out": "text interface of the base lost",
}
"""The fault that a way ends in while the base is driven; the others drive as they are told."""


def emulator_of(*ways: str) -> OmronEmulator:
    return OmronEmulator(Options(teleop=Teleop(timeout=0.3)), as_reported=ways)


def peak(emulator: OmronEmulator) -> float:
    """The highest speed of the wheels so far [m/s]."""
    return max(abs(one.v) for one in emulator.moved)


def gone(emulator: OmronEmulator) -> float:
    """The way so far [m]."""
    moves = itertools.pairwise(emulator.moved)
    return sum(before.v * (after.at - before.at) for before, after in moves)


@pytest.mark.slow
@pytest.mark.parametrize("way", AS_REPORTED)
def test_whatever_a_base_does_it_never_runs_away_and_never_stands_in_silence(way):
    with emulator_of(way) as emulator, connected(emulator, arcl="adept") as base:
        assert not emulator.heard or {one.name for one in emulator.heard} == {"stop"}
        assert peak(emulator) == 0.0
        faults: set[Fault] = set()
        turns = 25 if way in ("pose-jumps", "arcl-kicks-out") else 12  # those come after 2 s
        for _ in range(turns):
            drive(base, TOLD, seconds=0.1)
            faults |= set(base.read().faults)
        said = " | ".join(fault.text for fault in faults)
        assert len(faults) <= 1, said  # one text for one cause, whatever it measures
        if way in WHY:
            assert WHY[way] in said
        else:
            assert said == ""
            assert gone(emulator) > 0.5 * TOLD * 0.1 * turns * 0.67
        assert peak(emulator) < TOLD + 0.04 + 0.015 + 0.3  # for 0.2 s, and its way to rest
        base.stop()
        until(lambda: is_at_rest(emulator))


def test_a_base_that_is_too_fast_is_stopped_and_not_driven_on_by_a_program():
    """`full_scale` of the file is not that of the base: told 0.3 m/s it goes at 0.54 m/s."""
    with emulator_of("full-scale-is-top") as emulator, connected(emulator) as base:
        until(lambda: drive(base, 0.3, seconds=0.1) and base.read().faults)
        state = wait_for_fault(base, FaultKind.NOT_READY, "and was stopped")
        assert "told 0.3" in state.faults[0].text
        assert not state.faults[0].clearable
        until(lambda: is_at_rest(emulator))
        with pytest.raises(HardwareError, match="and was stopped"):
            base.recover()
        assert base.send(np.array([0.3, 0.0, 0.0])).max() == 0.0
        assert base.read().faults == state.faults


def test_where_the_button_of_the_base_is_needed_that_is_said(monkeypatch):
    monkeypatch.setattr("drivers.omron.arcl._PATIENCE", 0.3)
    with emulator_of("brake-button") as emulator, connected(emulator, arcl="adept") as base:
        with emulator.held() as controller:
            controller.press()
            controller.release()
        wait_for_fault(base, FaultKind.NOT_READY, "motors of the base are off")
        with pytest.raises(HardwareError, match="push the motor button"):
            base.recover()
        with emulator.held() as controller:
            controller.push_button()
        until(lambda: not base.read().faults)


def test_recoveries_that_follow_each_other_wait_longer_and_longer(monkeypatch):
    monkeypatch.setattr("drivers.omron.base._PAUSES", (0.0, 0.2, 0.4))
    with OmronEmulator() as emulator, connected(emulator, arcl="adept") as base:
        with emulator.held() as controller:
            controller.press()
        wait_for_fault(base, FaultKind.EMERGENCY_STOP, "release it")

        def fails() -> bool:
            with pytest.raises(HardwareError, match="release it first"):
                base.recover()
            return True

        took = [until(fails) for _ in range(4)]
        assert took[1] > 0.2
        assert min(took[2:]) > 0.4
