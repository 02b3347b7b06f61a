"""From frame to grasps in the world: exact geometry, unusable frames, and the shipped weights."""

import numpy as np
import pytest
from pinocchio import SE3, exp3

from behaviours.core.parameter_types import Region
from config.arrays import Array, Image, Mask
from hw import DepthFrame
from hw.sim import D435Noise, DepthRenderer, Hand, SimObject, World
from perception import Candidates, GraspDetector, Proposals
from perception.frame import ObjectRegion
from perception.grasps.candidates import SpreadPoints
from robots import Box, Geom, load_robot

ROBOT = load_robot("frankie")
GRIPPER, CAMERA = ROBOT.gripper, ROBOT.camera.intrinsics
FLOOR = 0.456
WORKSPACE = Region(
    name="container",
    mTr=SE3(np.eye(3), np.array([3.0, 0.0, FLOOR + 0.1])),
    size=np.array([0.44, 0.36, 0.20]),
)


def looking_down(height: float, yaw: float = 0.0, tilt: tuple[float, float] = (0.0, 0.0)) -> SE3:
    rotation = exp3(np.array([*tilt, 0.0])) @ exp3(np.array([0.0, 0.0, yaw]))
    return SE3(rotation @ np.diag([1.0, -1.0, -1.0]), np.array([3.0, 0.0, FLOOR + height]))


def box_world(yaw: float = 0.5, x: float = 3.03, y: float = -0.02) -> World:
    """A box of 120 x 40 x 50 mm in a container."""
    part = Geom(Box((0.06, 0.02, 0.025)), SE3.Identity())
    turn = exp3(np.array([0.0, 0.0, yaw]))
    obj = SimObject(
        name="box", parts=(part,), mass=0.2, pose=SE3(turn, np.array([x, y, FLOOR + 0.025]))
    )
    fixtures = [
        Geom(Box((0.23, 0.19, 0.1)), SE3(np.eye(3), np.array([3.0, 0.0, FLOOR - 0.1])), "stand")
    ]
    for dx, dy, hx, hy in ((0.223, 0, 0.003, 0.186), (0, 0.183, 0.226, 0.003)):
        for sign in (1, -1):
            centre = np.array([3.0 + sign * dx, sign * dy, FLOOR + 0.025])
            fixtures.append(Geom(Box((hx, hy, 0.025)), SE3(np.eye(3), centre), "wall"))
    return World(fixtures, [obj])


def frame(world: World, oTc: SE3, seed: int = 0) -> DepthFrame:
    depth = DepthRenderer(CAMERA).render(world.shapes(), oTc)
    noisy = D435Noise().apply(depth, ROBOT.camera, np.random.default_rng(seed))
    return DepthFrame(depth=noisy, intrinsics=CAMERA, oTc=oTc, stamp=4.5)


@pytest.fixture(scope="module")
def detector() -> GraspDetector:
    return GraspDetector.shipped(GRIPPER)


@pytest.mark.parametrize(("yaw", "tilt"), [(-0.9, (0.0, 0.0)), (0.5, (0.1, -0.08))])
def test_the_shipped_weights_grasp_a_box_across_and_say_where_in_the_image(detector, yaw, tilt):
    world, oTc = box_world(yaw), looking_down(0.42, 0.3, tilt)
    found = detector.detect(frame(world, oTc), WORKSPACE)
    assert found.reason == ""
    best = found.grasps[0]
    turn = np.arctan2(best.oTg.rotation[1, 1], best.oTg.rotation[0, 1]) - (yaw + np.pi / 2)
    assert abs((turn + np.pi / 2) % np.pi - np.pi / 2) < np.deg2rad(12)
    assert best.width == pytest.approx(0.04, abs=0.006)
    assert best.stamp == 4.5
    assert best.oTg.rotation[:, 2] == pytest.approx([0.0, 0.0, -1.0])
    hand = Hand(GRIPPER, best.oTg)
    assert world.collision(hand, best.opening) is None
    assert world.close_fingers(hand, best.opening, 20.0).holding == "box"
    assert best.quality > 0.95
    x, y, z = oTc.actInv(np.array([*best.oTg.translation[:2], FLOOR + 0.05]))
    assert best.pixel == pytest.approx([383 * x / z + 319.5, 383 * y / z + 239.5], abs=2.0)
    closing = oTc.rotation.T @ best.oTg.rotation[:, 1]
    assert abs(np.sin(best.angle - np.arctan2(closing[1], closing[0]))) < 0.1


def test_only_what_lies_in_the_workspace_is_grasped(detector):
    beside = WORKSPACE.oTr * SE3(np.eye(3), np.array([-0.15, 0.0, 0.0]))
    elsewhere = Region(name="elsewhere", mTr=beside, size=np.array([0.10, 0.36, 0.20]))
    found = detector.detect(frame(box_world(), looking_down(0.42)), elsewhere)
    assert found.grasps == ()
    assert found.reason == "nothing stands out in the workspace"
    assert not found.quality.any()


class Astray:
    """Proposes a single grasp, in a corner where the hand meets the wall."""

    name = "astray"

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        pixel, none = np.array([[20.0, 20.0]]), np.zeros(1)
        one = Candidates(pixel=pixel, angle=none, width=none, quality=np.ones(1))
        return Proposals(one, np.zeros_like(image), directions=1)


class Half:
    """The half of the box beyond its middle, as a segmented object."""

    floor = FLOOR

    def contains(self, points: Array) -> Mask:
        inside: Mask = WORKSPACE.contains(points) & (points[:, 0] > 3.03)
        return inside

    def owns(self, centres: Array, contacts: Array, pads: Array) -> Mask:
        owned: Mask = self.contains(contacts.reshape(-1, 3)).reshape(-1, 2).all(axis=1)
        return owned & self.contains(centres)


def test_on_given_objects_the_check_looks_everywhere_if_no_proposal_fits():
    seen = frame(box_world(), looking_down(0.4))
    astray = GraspDetector(GRIPPER, [Astray(), SpreadPoints()])
    spread = GraspDetector(GRIPPER, [SpreadPoints()])
    found, everywhere = (one.detect(seen, Half()) for one in (astray, spread))
    assert found.grasps
    assert not found.reason
    assert [one.quality for one in found.grasps] == [one.quality for one in everywhere.grasps]
    other = astray.detect(seen, WORKSPACE)
    assert not other.grasps
    assert "does not fit" in other.reason


def test_a_detector_without_a_source_of_candidates_is_refused():
    with pytest.raises(ValueError, match="need a source of candidates"):
        GraspDetector(GRIPPER, [])


def test_a_grasp_on_a_thing_closes_on_that_thing_alone(detector):
    seen, half = frame(box_world(), looking_down(0.4)), Half()
    assert isinstance(half, ObjectRegion)
    assert not isinstance(WORKSPACE, ObjectRegion)
    grasps = detector.detect(seen, half).grasps
    assert grasps
    for one in grasps:
        aside = 0.5 * one.width * one.oTg.rotation[:, 1]
        assert half.contains(one.oTg.translation + np.stack([-aside, aside])).all()
    free = detector.detect(seen, WORKSPACE).grasps
    assert any(one.oTg.translation[0] < 3.03 for one in free)


@pytest.mark.parametrize(("above", "aside"), [(0.6, 0.28), (0.8, -0.4), (1.0, 0.45)])
@pytest.mark.parametrize("workspace", [WORKSPACE, None])
def test_what_stands_beside_the_middle_of_the_image_is_grasped(detector, above, aside, workspace):
    oTc = looking_down(above)
    oTc.translation[0] += aside
    table = World(box_world().fixtures[:1], box_world().objects)
    found = detector.detect(frame(table, oTc), workspace)
    assert found.grasps, found.reason
    assert np.hypot(*(found.grasps[0].oTg.translation[:2] - [3.03, -0.02])) < 0.06


def test_without_a_workspace_the_support_is_found_in_the_frame(detector: GraspDetector) -> None:
    found = detector.detect(frame(box_world(), looking_down(0.42)))
    best = found.grasps[0]
    assert np.hypot(*(best.oTg.translation[:2] - [3.03, -0.02])) < 0.06
    assert FLOOR + 0.02 < best.oTg.translation[2] < FLOOR + 0.04


BAD_FRAMES = {
    "all missing": np.full((480, 640), np.nan),
    "infinite": np.full((480, 640), np.inf),
    "negative": np.full((480, 640), -1.0),
    "constant": np.full((480, 640), 0.4),
    "empty": np.zeros((0, 0)),
    "tiny": np.full((4, 4), 0.4),
    "looking up": np.random.default_rng(0).uniform(0.3, 0.5, (480, 640)),
}


@pytest.mark.parametrize("name", BAD_FRAMES)
def test_unusable_frames_give_a_reason_and_no_exception(detector, name):
    depth = BAD_FRAMES[name].astype(np.float32)
    oTc = SE3.Identity() if name == "looking up" else looking_down(0.42)
    bad = DepthFrame(depth=depth, intrinsics=CAMERA, oTc=oTc, stamp=1.0)
    for workspace in (None, WORKSPACE):
        found = detector.detect(bad, workspace)
        assert found.grasps == ()
        assert found.reason
        assert "\n" not in found.reason
