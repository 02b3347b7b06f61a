"""How the driver ends, and who stops the arm then."""

import pytest
from emulated_panda import connected, emulated, needs_library
from program import program
from waiting import until

from drivers.panda import PandaArm
from hw import FaultKind, HardwareError, WallClock

pytestmark = pytest.mark.realtime

PARENT = """
import sys, time
import numpy as np
from hw import WallClock
from drivers.panda import PandaArm
arm = PandaArm(sys.argv[1], WallClock())
arm.connect()
while True:
    arm.send(np.array([0.3, 0, 0, 0, 0, 0, 0.0]))
    time.sleep(0.01)
"""


@needs_library
def test_the_arm_stops_and_the_driver_ends_when_its_parent_is_killed(emulator):
    with program(PARENT, emulator.address) as parent:
        emulator.wait(lambda told: told["mode"] == "MOVE" and told["qd"][0] > 0.28)
        parent.kill()
        told = emulator.wait(lambda told: told["still"] > 0.0)
        assert told["errors"] == told["violations"] == []
        told = emulator.wait(lambda told: not told["has_commander"])
        assert told["mode"] == "IDLE"


@needs_library
def test_a_driver_that_is_killed_is_a_fault_and_a_recovery_starts_another(emulator):
    with connected(PandaArm(emulator.address, WallClock())) as arm:
        arm._process.process.kill()
        until(lambda: arm.read().faults)
        (fault,) = arm.read().faults
        assert fault.kind is FaultKind.CONNECTION
        arm.recover()
        assert arm.read().faults == ()
    arm.close()


@needs_library
@pytest.mark.slow
def test_a_robot_that_is_switched_off_is_a_fault():
    with (
        emulated() as emulator,
        connected(PandaArm(emulator.address, WallClock(), connecting=1.5)) as arm,
    ):
        emulator.process.kill()
        until(lambda: arm.read().faults)
        with pytest.raises(HardwareError, match="activate FCI"):
            arm.recover()
        assert arm.read().faults[0].kind is FaultKind.CONNECTION
