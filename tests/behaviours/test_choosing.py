"""Which object is meant: `grasp` with a choice, `detect`, and objects as goals."""

from dataclasses import replace

import numpy as np
import pytest
from ended import failure
from harness import ON_TABLE, TABLE_TOP, block, table_world, with_the_hand_at
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Detect, DetectedObjects, Grasp, Key, Navigate
from behaviours.look_at import LookAt
from robots import Geom

RED, BLUE, GREEN = (214, 60, 50), (60, 110, 190), (80, 170, 80)


def painted(obj, colour):
    """The object in a colour."""
    return replace(obj, parts=tuple(Geom(p.shape, p.pose, p.name, colour) for p in obj.parts))


@pytest.fixture
def three():
    """A small red, a large red and a blue block, the robot looking down at them."""
    world = table_world(
        painted(block((0.012, 0.012, 0.02), x=0.62, y=0.08, name="small red"), RED),
        painted(block((0.02, 0.04, 0.02), x=0.74, y=0.06, name="large red"), RED),
        painted(block((0.018, 0.03, 0.02), x=0.68, y=-0.08, name="blue"), BLUE),
    )
    return with_the_hand_at(world, 0.6, 0.0, TABLE_TOP + 0.45)


@pytest.mark.parametrize(
    ("words", "taken"),
    [
        ({"colour": "red", "choose": "smallest"}, "small red"),
        ({"choose": "nearest"}, "small red"),
        ({"min_width_mm": 38.0}, "large red"),
    ],
)
def test_the_hand_closes_on_what_was_asked_for(three, words, taken):
    grasp = Grasp("grasp", three.context, within=ON_TABLE, **words)
    assert three.run(grasp) is Status.SUCCESS, grasp.feedback_message
    assert three.world.held is three.world.find(taken)


def test_what_is_not_there_is_not_replaced_by_something_else(three):
    grasp = Grasp("grasp", three.context, within=ON_TABLE, colour="green", patience_s=0.5)
    assert "a green object is not among the 3 objects in sight" in failure(three, grasp)
    assert three.world.held is None

    grasp = Grasp("grasp", three.context, within=ON_TABLE, colour="red", patience_s=0.5)
    camera = three.context.vision._camera
    three.context.vision._camera = Colourless(camera)
    assert "the camera of this robot sees no colours" in failure(three, grasp)


class Colourless:
    """A camera that sees no colours."""

    def __init__(self, camera) -> None:
        self._camera, self._last = camera, (None, None)

    def latest(self, max_age):
        frame = self._camera.latest(max_age)
        if frame is not self._last[0]:
            self._last = frame, frame and replace(frame, paint=None)
        return self._last[1]


def test_what_is_detected_is_a_goal(three):
    found, count = Key[DetectedObjects]("found"), Key[int]("count")
    detect = Detect(
        "see", three.context, region=ON_TABLE, list=found, count=count, choose="largest"
    )
    assert three.run(detect) is Status.SUCCESS
    assert count.read() == 3
    large, blue, small = found.read()
    assert (large.colour, blue.colour, small.colour) == ("red", "blue", "red")
    assert np.linalg.norm(large.position[:2] - [0.74, 0.06]) < 0.004
    assert large.width == pytest.approx(0.04, abs=0.004)
    assert three.run(LookAt("look", three.context, at=blue)) is Status.SUCCESS
    assert three.run(Navigate("go", three.context, to=blue)) is Status.SUCCESS
    camera = three.context.oTe * three.robot.description.camera.eTc
    assert np.linalg.norm(camera.translation[:2] - blue.position[:2]) < 0.02
    assert three.run(Grasp("grasp", three.context, within=blue)) is Status.SUCCESS
    assert three.world.held is three.world.find("blue")


@pytest.mark.parametrize(("width", "count"), [(None, "at least 0"), (200.0, "0")])
def test_what_a_thing_hides_may_have_the_colour_that_is_counted(width, count):
    tall = painted(block(x=0.84, half=(0.02, 0.04, 0.09), name="tall"), BLUE)
    behind = painted(block(x=0.885, half=(0.01, 0.01, 0.01), name="behind"), RED)
    harness = with_the_hand_at(table_world(tall, behind), 0.6, 0.0, TABLE_TOP + 0.35)
    found = Key[int]("count")
    words = {"colour": "red", "min_width_mm": width}
    leaf = Detect("detect", harness.context, region=ON_TABLE, count=found, **words)
    assert harness.run(leaf) is Status.SUCCESS, leaf.feedback_message
    assert str(found.read()) == count


def test_what_was_detected_stays_and_is_told_on_the_map_while_odometry_drifts(three):
    here, key = three.context.localisation, Key[DetectedObjects]("found")
    here.mTo = SE3(np.eye(3), np.array([0.3, -0.2, 0.0]))
    here.oTm = here.mTo.inverse()
    detect = Detect("see", three.context, region=ON_TABLE, list=key, choose="largest")
    assert three.run(detect) is Status.SUCCESS
    one = key.read()[0]
    then, on_map = one.position, here.mTo.act(one.position)
    told = f"the red object at {on_map[0]:.2f}, {on_map[1]:.2f} on the map"
    assert detect.feedback_message.startswith(f"3 of 3: {told}")
    here.mTo, here.oTm = SE3.Identity(), SE3.Identity()  # odometry drifts
    assert str(one).startswith(told)
    np.testing.assert_allclose(one.position, on_map)
    assert one.contains(on_map[None]).all()
    assert not one.contains(then[None]).any()


def test_what_stands_in_the_way_can_be_taken_first():
    """One block 10 mm before another that is meant, and one far away."""
    world = table_world(
        painted(block((0.015, 0.03, 0.02), x=0.64, name="before"), GREEN),
        painted(block((0.015, 0.015, 0.02), x=0.68, name="between"), RED),
        painted(block((0.015, 0.015, 0.02), x=0.66, y=0.15, name="far"), BLUE),
    )
    harness = with_the_hand_at(world, 0.61, 0.05, TABLE_TOP + 0.45)
    grasp = Grasp("grasp", harness.context, within=ON_TABLE, colour="red", neighbour=True)
    assert harness.run(grasp) is Status.SUCCESS, grasp.feedback_message
    assert world.held is world.find("before")


def test_neighbours_that_touch_are_not_taken_along():
    world = table_world(
        painted(block((0.015, 0.03, 0.02), x=0.68, name="left"), GREEN),
        painted(block((0.015, 0.03, 0.02), x=0.71, name="right"), BLUE),
    )
    harness = with_the_hand_at(world, 0.63, 0.0, TABLE_TOP + 0.45)
    grasp, stands = Grasp("grasp", harness.context, within=ON_TABLE, colour="blue"), [0.68, 0, 0.52]
    assert harness.run(grasp) is Status.SUCCESS, grasp.feedback_message
    assert world.held is world.find("right")
    np.testing.assert_allclose(world.find("left").pose.translation, stands, atol=0.01)
