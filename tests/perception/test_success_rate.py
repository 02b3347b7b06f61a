"""What the person who runs the robot cares about: most first choices of grasp hold."""

import pytest

from app.grasps.evaluate import empty_container
from hw.sim import load_scene
from perception import GraspDetector


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "least"), [("household", 0.8), ("clutter", 0.75)])
def test_most_grasps_hold_until_the_container_is_empty(scene: str, least: float) -> None:
    detector = GraspDetector()
    ends: list[str] = []
    for seed in (2_000_000, 2_000_001):
        world = load_scene(scene, seed)
        ends += empty_container(world, detector, seed)
        assert len(world.objects) <= 1
    assert ends.count("held") / len(ends) >= least
