"""What the base tells, whatever the network does to it, and the driver as a part of a robot."""

import re
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from emulated import base_of, connected, drive, driving, is_at_rest, set_off, wait_for
from pinocchio import SE3
from pinocchio.utils import rotate

from controller import Command
from hw import ArmState, ComposedRobot, Gate, GripperState, HardwareError, WallClock
from hw.clock import stopwatch
from hw.emulators.omron import Motion, OmronEmulator, Options, Teleop, Unicycle
from hw.omron import OmronBase
from robots import load_robot

CONDITIONS = {
    "a good network": Options(seed=1),
    "late by up to 90 ms": Options(seed=3, jitter=0.09),
    "a few bytes at a time, late, with damaged frames": Options(
        seed=6, pieces=True, jitter=0.04, delay=0.02, garbage=True
    ),
}


def away(base: OmronBase, wheels: Unicycle) -> float:
    """Distance of the pose that is read from the true one [m]."""
    seen = base.read().wTb.translation[:2]
    return float(np.hypot(*(seen - wheels.pose()[:2])))


@pytest.mark.parametrize("options", CONDITIONS.values(), ids=CONDITIONS)
def test_the_base_drives_and_tells_where_it_is_under(options):
    wheels = Unicycle((1.0, -2.0, 3.0))
    with OmronEmulator(options, wheels) as emulator, connected(emulator) as base:
        start = base.read()
        np.testing.assert_allclose(start.wTb.translation, (1.0, -2.0, 0.0), atol=2e-3)
        heading = np.arctan2(start.wTb.rotation[1, 0], start.wTb.rotation[0, 0])
        assert heading == pytest.approx(3.0, abs=1e-4)
        assert start.battery == pytest.approx(0.87)
        late = 0.05 + options.delay + options.jitter
        with driving(base, w=-0.4):
            wait_for(lambda: wheels.twist()[0] > 0.1)
            wait_for(lambda: away(base, wheels) < 0.01 + 0.3 * late)
        base.stop()
        wait_for(lambda: not base.read().twist.any())
        still = np.array([*wheels.pose()[:2], 0.0])
        wait_for(lambda: np.abs(base.read().wTb.translation - still).max() < 2e-3)
        assert base.read().faults == ()


def test_without_the_fine_pose_the_coarse_one_is_taken():
    wheels = Unicycle((0.0, 0.0, pi / 2))
    coarse = OmronEmulator(None, wheels, faults=("no fine pose",))
    with coarse, connected(coarse, lists_patience=0.3) as base:
        set_off(coarse, base)
        base.stop()
        wait_for(lambda: not base.read().twist.any())
        assert base.read().wTb.translation[1] == pytest.approx(wheels.pose()[1], abs=2e-3)


def test_readings_are_of_the_moment_and_do_not_wait():
    with OmronEmulator() as emulator, connected(emulator) as base:
        stamps = [base.read().stamp for _ in range(1000)]
        assert stamps == sorted(stamps)
        begun = stopwatch()
        emulator.freeze()
        for _ in range(1000):
            base.read()
            base.send(np.zeros(3))
        assert stopwatch() - begun < 2.0
        emulator.freeze(False)


def test_what_is_applied_is_told():
    with OmronEmulator() as emulator, connected(emulator) as base:
        for wanted, applied in (
            ((0.1, 0.0, 0.0), (0.1, 0.0, 0.0)),
            ((0.02, 0.0, 0.01), (0.02, 0.0, 0.01)),
            ((0.2, 0.3, 0.1), (0.2, 0.0, 0.1)),  # it cannot move sideways
            ((2.0, 0.0, 0.4), (1.0, 0.0, 0.2)),  # slower along the same arc
            ((-0.5, 0.0, 0.0), (-0.25, 0.0, 0.0)),
            ((np.nan, 0.0, 0.0), (0.0, 0.0, 0.0)),
            ((0.0, 0.0, np.inf), (0.0, 0.0, 0.0)),
        ):
            np.testing.assert_allclose(base.send(np.array(wanted)), applied, atol=1e-9)


def test_a_base_can_be_left_and_connected_again():
    with OmronEmulator() as emulator:
        base = base_of(emulator, arcl="adept")
        for _ in range(2):
            base.connect()
            drive(base, seconds=0.1)
            base.close()
            base.close()


def test_the_text_interface_drives_to_goals_and_docks():
    quick = Options(motion=Motion(docking=0.2))
    with OmronEmulator(quick) as emulator, connected(emulator, arcl="adept") as base:
        text = base.arcl
        assert text.goals() == ["table", "bin"]
        with emulator.held() as controller:
            controller.drive = Unicycle((0.9, 0.0, 0.0))
        text.go_to("table")
        assert emulator.controller.drive.pose()[0] == pytest.approx(1.0, abs=0.05)
        with pytest.raises(HardwareError, match="CommandError"):
            text.go_to("nowhere")
        text.dock()
        wait_for(lambda: base.read().faults)
        text.undock()
        wait_for(lambda: not base.read().faults)
        assert base.localisation_score == pytest.approx(0.87)


def test_the_base_is_told_where_it_is():
    wheels = Unicycle((1.0, 1.0, 0.5))
    with OmronEmulator(None, wheels, faults=("lost",)) as emulator, connected(emulator) as base:
        wait_for(lambda: base.read().faults)
        place = SE3(rotate("z", -pi / 2), np.array([2.0, -3.0, 0.0]))
        base.localise(place)
        wait_for(lambda: not base.read().faults)
        wait_for(lambda: (base.read().wTb.inverse() * place).homogeneous[:2, 3].max() < 2e-3)
        assert base.read().wTb.isApprox(place, 2e-3)


def test_the_values_of_the_site_are_read_from_the_base():
    teleop = Teleop(forwards=0.67, backwards=0.2, dead_translation=0.0)
    with OmronEmulator(Options(teleop=teleop)) as emulator, connected(emulator) as base:
        site = base.read_site()
        assert (site.forward, site.reverse, site.dead_translation) == (0.67, 0.2, 0.0)
        assert site.turn == pytest.approx(np.radians(50.0))
        assert site.turn_at_forward == pytest.approx(np.radians(25.0))
    options = Options(omit=frozenset({"getConfigBySectionsV4"}))
    missing = pytest.raises(HardwareError, match="getConfigBySectionsV4")
    with OmronEmulator(options) as emulator, connected(emulator) as base, missing:
        base.read_site()


def test_what_the_base_offers_is_known():
    with OmronEmulator() as emulator, connected(emulator) as base:
        catalogue = base.catalogue
        number = catalogue.number("ratioDrive")
        assert catalogue.arguments[number][0].startswith("double: trans")
        assert catalogue.groups[number] == "Movement"
        assert len(catalogue.arguments[catalogue.number("gotoGoal")][0]) > 10_000
        assert len(catalogue.offers) > 30


def test_the_first_contact_of_the_page_works_with_the_emulator(capsys):
    page = Path(__file__).parents[3] / "docs" / "hardware.md"
    code, *_ = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    with OmronEmulator() as emulator:
        for said, here in (
            ('host="10.10.10.10"', f'host="127.0.0.1", port={emulator.port}'),
            ('password="adept"', f'password="adept", port={emulator.arcl_port}'),
        ):
            assert said in code
            code = code.replace(said, here)
        exec(compile(code, str(page), "exec"), {})
        assert is_at_rest(emulator)
        assert emulator.controller.drive.pose()[0] > 0.01
    assert "double: trans" in capsys.readouterr().out


class Still:
    """The parts of the robot that are not tested here: they are there, and rest."""

    def __init__(self, clock: WallClock) -> None:
        self._clock = clock

    def connect(self) -> None: ...

    stop = close = recover = connect

    def send(self, qd: np.ndarray) -> np.ndarray:
        return qd

    def grip(self, width: float, force: float) -> None: ...

    def latest(self) -> None: ...

    def faults(self) -> tuple[()]:
        return ()


class StillArm(Still):
    def read(self) -> ArmState:
        ready = load_robot("frankie").arm.ready
        return ArmState(stamp=self._clock.now(), q=ready, qd=np.zeros(7))


class StillGripper(Still):
    def read(self) -> GripperState:
        return GripperState(stamp=self._clock.now(), width=0.08, moving=False)


def test_a_composed_robot_drives_it_through_the_gate():
    """In real time, with the limits of the base: what the gate passes is what the base does."""
    frankie = load_robot("frankie")
    limits = replace(frankie.limits, base_acceleration=np.array([0.5, 0.5, 2.6]))
    clock, period, ticks = WallClock(), 0.01, 0
    with OmronEmulator() as emulator:
        robot = ComposedRobot(
            frankie,
            arm=StillArm(clock),
            base=base_of(emulator, clock=clock),
            gripper=StillGripper(clock),
            camera=Still(clock),
            clock=clock,
        )
        gate = Gate(robot, replace(frankie, limits=limits), period)
        with robot:
            until = clock.now() + 1.0
            while clock.now() < until:
                state = robot.read()
                last = gate.continue_from(state, clock.now())
                speed = min(0.3, float(last.base_twist[0]) + 0.004)
                command = Command(base_twist=np.array([speed, 0.0, 0.0]), qd=np.zeros(7))
                gate.send(command, state, clock.now())
                ticks += 1
                clock.sleep_until(clock.now() + period)
            assert state.faults == ()
            assert emulator.controller.drive.pose()[0] > 0.03
            assert sum(gate.refusals.values()) < ticks / 2  # late ticks, on a busy machine
