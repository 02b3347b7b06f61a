"""The laser of the base: its points on the map come back to the base."""

from math import inf

import numpy as np
import pytest
from emulated import SPEED, connected, repeating
from waiting import until

from config.planar import Pose2D
from drivers.omron import OmronLaser
from drivers.omron.laser import read_points
from drivers.omron.packet import Fields, LayoutError
from extensions.emulators.frankie.emulated_world import EmulatedWorld
from extensions.emulators.omron import OmronEmulator, Options, Unicycle
from extensions.emulators.panda import ArmLink
from hw import WallClock
from robots import load_robot

LASER = load_robot("frankie").laser
POST = Pose2D(3.0, 1.0, 0.0)


class Beside(Unicycle):
    """Wheels beside a post that the laser sees."""

    def echoes(self):
        post = POST.relative_to(self.pose())
        return ((post.x, post.y),) * 3


def test_a_scan_is_in_the_base_at_its_capture_whatever_the_base_takes_for_its_pose():
    wheels = Beside(Pose2D(1.0, -2.0, 2.0))
    offset = (0.5, -0.3, 0.2)
    with (
        OmronEmulator(Options(seed=2, offset=offset), wheels) as emulator,
        connected(emulator) as base,
    ):
        laser = OmronLaser(lambda: base.echoes, LASER, WallClock())
        until(lambda: laser.latest() is not None)
        scan = laser.latest()
        assert laser.latest() is scan
        assert scan.points.shape == (3, 3)
        np.testing.assert_allclose(scan.points[0], [*wheels.echoes()[0], 0.19], atol=2e-3)
        distance = np.linalg.norm(scan.points[0] - LASER.bTs.translation)
        np.testing.assert_allclose(scan.ranges, distance)

        def is_right() -> bool:
            new, seen = laser.latest(), wheels.echoes()[0]
            return new is not scan and np.linalg.norm(new.points[0][:2] - seen) < 0.05

        with repeating(lambda: base.send(np.array([SPEED, 0.0, -0.4]))):
            until(lambda: wheels.twist()[0] > 0.1)
            until(is_right)


def test_a_base_without_a_laser_and_one_that_sees_nothing_have_no_points():
    with OmronEmulator() as emulator, connected(emulator) as base:
        until(lambda: base.echoes is not None)
        assert base.echoes.points.shape == (0, 2)
    without = Options(omit=frozenset({"Laser_1Current"}))
    with OmronEmulator(without) as emulator, connected(emulator) as base:
        assert OmronLaser(lambda: base.echoes, LASER, WallClock()).latest() is None


def test_points_are_read_in_millimetres_and_a_scan_that_ends_too_early_is_refused():
    whole = bytes.fromhex("01000000e803000030f8ffff")
    np.testing.assert_allclose(read_points(Fields(whole)), [[1.0, -2.0]])
    for payload in (b"", whole[:4], whole[:-1], b"\xff" * 4):
        with pytest.raises(LayoutError):
            read_points(Fields(payload))


def test_the_emulated_robot_sees_the_furniture_of_its_scene():
    world = EmulatedWorld("frankie", "kinematic", "single", 0, ArmLink())
    points = np.array(world.echoes())
    nearest = min(np.linalg.norm(points - LASER.bTs.translation[:2], axis=1), default=inf)
    assert nearest == pytest.approx(1.31, abs=0.05)
