"""Odometry and localisation of the base: what stays where it is when the pose on the map jumps."""

from dataclasses import replace
from math import radians
from struct import pack

import numpy as np
import pinocchio as pin
import pytest
from emulated import SPEED, connected, repeating, wait_for_fault
from pinocchio import SE3
from waiting import until

from config.planar import Pose2D
from drivers.omron.base import begun, continued
from drivers.omron.handshake import Catalogue
from drivers.omron.packet import Packet, number_field
from drivers.omron.telemetry import ENCODERS, POSE, Pose, Telemetry
from extensions.emulators.frankie.emulated_world import EmulatedWorld
from extensions.emulators.omron import OmronEmulator, Options, Unicycle
from extensions.emulators.panda import ArmLink
from hw import FaultKind
from robots import load_robot

START, OFFSET = Pose2D(1.0, -2.0, 2.0), (0.5, -0.3, 0.2)
NUMBERS = 299
NUMBER_OF = {name: number for number, name in enumerate((*POSE, *ENCODERS), NUMBERS + 1)}


def placed(pose) -> SE3:
    """A pose on the floor: x, y [m] and heading [rad], or one of the driver."""
    x, y, heading = pose.place if isinstance(pose, Pose) else pose
    return SE3(pin.utils.rotate("z", heading), np.array([x, y, 0.0]))


def moving(v: int, w: int) -> Packet:
    """`updateNumbers` of a base with these velocities [mm/s, deg/s]."""
    return Packet(NUMBERS, pack("<hiihhhhb", 870, 0, 0, 0, v, w, 0, -128))


def telling(pose, encoders=None) -> Telemetry:
    """Of a base that rests there at 1 s: x, y [m] and heading [rad]."""
    told = dict(zip(POSE, pose, strict=True))
    if encoders is not None:
        told |= dict(zip(ENCODERS, encoders, strict=True))
    numbers = {"updateNumbers": NUMBERS} | {name: NUMBER_OF[name] for name in told}
    telemetry = Telemetry(Catalogue(numbers=numbers))
    for name, value in told.items():
        scaled = np.degrees(value) if name.endswith("Th") else 1000.0 * value
        telemetry.take(Packet(NUMBER_OF[name], b"d" + number_field(scaled)), 1.0)
    telemetry.take(moving(0, 0), 1.0)
    return telemetry


def test_without_encoders_odometry_is_the_integral_of_the_measured_velocity():
    base = telling(START)
    for velocity, at in (((200, 30), 2.0), ((200, 30), 4.0), ((0, 0), 5.0)):
        base.take(moving(*velocity), at)
    radius, turn = 0.2 / radians(30.0), radians(90.0)  # half of it, all of it for 2 s, half of it
    there = (radius * np.sin(turn), radius * (1.0 - np.cos(turn)), turn)
    assert placed(base.odometry).isApprox(placed(there), 1e-9)


COUNTED, LATER = (5.0, 6.0, -1.0), (1.02, -1.99, 2.02)


@pytest.mark.parametrize(
    ("before", "now", "there"),
    [
        pytest.param(COUNTED, COUNTED, START, id="encoders that count on"),
        pytest.param(COUNTED, (0.0, 0.0, 0.0), LATER, id="a base that has restarted"),
        pytest.param(None, None, LATER, id="no encoders"),
    ],
)
def test_a_new_connection_goes_on_in_the_same_world(before, now, there):
    """Without encoders that have counted on, the way meanwhile is that on the map."""
    then, later = telling(START, before), telling(LATER, now)
    oTo = begun(then)
    assert (oTo * placed(then.odometry)).isApprox(placed(START), 1e-5)
    found = continued(oTo, then, later) * placed(later.odometry)
    assert found.isApprox(placed(there), 1e-5)


def test_the_world_begins_with_the_map_and_stays_when_the_localised_pose_jumps():
    wheels = Unicycle(START)
    with (
        OmronEmulator(Options(seed=4, offset=OFFSET), wheels) as emulator,
        connected(emulator, localisation={"sigma": 0.03}) as base,
    ):
        assert base.link.telemetry.has_encoders
        begin = base.read()
        believed = placed(np.add(START, OFFSET))
        assert begin.oTb.isApprox(believed, 1e-4)
        assert begin.localised.mTb.isApprox(believed, 1e-4)
        sigma = np.sqrt(np.diag(begin.localised.covariance))
        np.testing.assert_allclose(sigma, (0.03, 0.03, radians(0.5)))
        with repeating(lambda: base.send(np.array([SPEED, 0.0, -0.4]))):
            until(lambda: wheels.twist()[0] > 0.1)
        base.stop()
        until(lambda: not base.read().twist.any() and not any(wheels.twist()))
        emulator.options.offset = (0.0, 0.0, 0.0)
        there = placed(wheels.pose())
        until(lambda: base.read().localised.mTb.isApprox(there, 1e-4))
        gone = believed * placed(START).actInv(there)
        until(lambda: base.read().oTb.isApprox(gone, 1e-4))
        emulator.break_off()
        wait_for_fault(base, FaultKind.CONNECTION, "connection to the base lost")
        base.recover()
        state = base.read()
        assert state.oTb.isApprox(gone, 1e-4)
        assert state.localised.mTb.isApprox(there, 1e-4)
        assert state.localised.stamp <= state.stamp
        assert state.faults == ()


def test_a_base_that_lists_its_encoders_and_does_not_send_them_is_driven_without():
    with OmronEmulator() as emulator:
        entries = emulator._requests.entries
        for name in ENCODERS:
            entries[name] = replace(entries[name], answer=lambda _: None)
        with connected(emulator, connect_patience=0.3) as base:
            assert not base.link.telemetry.has_encoders
            assert base.read().faults == ()


def test_a_lost_base_has_no_localised_pose_and_the_world_begins_once_it_has():
    options = Options(offset=OFFSET, lost=True)
    with OmronEmulator(options) as emulator, connected(emulator) as base:
        wait_for_fault(base, FaultKind.STALE_POSE, "does not know where it is")
        assert base.read().localised is None
        options.offset = START
        until(lambda: np.allclose(base.link.telemetry.pose.place.x, START[0]))
        options.lost = False
        until(lambda: base.read().localised is not None)
        assert base.read().oTb.isApprox(placed(START), 1e-4)
        good = base.read().localised.covariance
        options.score = 0.35
        until(lambda: np.allclose(base.read().localised.covariance, 4.0 * good))
        options.lost = True
        until(lambda: base.read().localised is None)
        assert base.read().oTb.isApprox(placed(START), 1e-4)


def world_of(level: str) -> EmulatedWorld:
    return EmulatedWorld("frankie", "kinematic", "single", 3, ArmLink(), level)


def test_an_emulated_robot_is_as_wrong_as_its_level():
    exact, good = world_of("exact"), world_of("good")
    assert exact.localised() == exact.pose() == good.pose()
    assert exact.encoders() == good.encoders() == (0.0, 0.0, 0.0)
    off = np.abs(np.subtract(good.localised(), good.pose()))
    assert 0.0 < off[:2].max() < 0.1
    assert off[2] > 0.0
    eTc = load_robot("frankie").camera.eTc
    assert np.linalg.norm(eTc.actInv(good.body.description.camera.eTc).translation) > 0.002
    assert not exact.is_lost
    assert not good.is_lost


def test_an_emulated_outage_is_told(tmp_path):
    level = tmp_path / "outages.yaml"
    level.write_text("outages: {interval: 0.1, duration: 1.0}\n")
    world = world_of(str(level))
    until(lambda: world._step() or world.is_lost)
    with OmronEmulator(Options(), world) as emulator, connected(emulator) as base:
        wait_for_fault(base, FaultKind.STALE_POSE, "does not know where it is")
        assert base.read().localised is None
