"""The judge of grasps by physics, and `grasp eval`."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from command_line import call
from pinocchio import SE3

from hw.sim import SimObject, World
from lab.grasps import evaluation
from lab.grasps.choice import NetworkChoice
from lab.grasps.scenes import FLOOR, ROBOT, random_view
from perception import GraspDetector, GraspEstimate
from robots import Box, Geom

pytest.importorskip("mujoco", reason="needs the extra `physics`")

HALF = (0.06, 0.02, 0.02)


def box_alone() -> World:
    """A long box along x on a table."""
    table = Geom(Box((0.5, 0.5, 0.05)), SE3(np.eye(3), np.array([0, 0, FLOOR - 0.05])), "table")
    here = SE3(np.eye(3), np.array([0.0, 0.0, FLOOR + HALF[2]]))
    parts = (Geom(Box(HALF), SE3.Identity(), "box"),)
    return World([table], [SimObject(name="box 1", parts=parts, mass=0.2, pose=here)])


def grasp(y: float = 0.0, z: float = 0.02) -> GraspEstimate:
    wTg = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, y, FLOOR + z]))
    return GraspEstimate(
        oTg=wTg, width=0.04, quality=1.0, stamp=0.0, pixel=(0, 0), angle=0.0, opening=0.06
    )


@pytest.mark.parametrize(
    ("asked", "end", "hard"),
    [
        (grasp(), "held", False),
        (grasp(z=0.07), "nothing between the fingers", False),
        (grasp(y=0.03, z=0.011), "nothing between the fingers", True),  # a finger into the box
    ],
)
def test_grasps_end_as_they_would(asked: GraspEstimate, end: str, hard: bool) -> None:
    from lab.grasps.dropped_scenes import at_rest
    from lab.grasps.grasp_judge import execute

    world = box_alone()
    attempt = execute(at_rest(world), world, asked)
    assert (attempt.end, attempt.hard, attempt.target_class) == (end, hard, "box")


def test_the_judge_looks_again_from_straight_above_where_nothing_is_likely_to_hold() -> None:
    from lab.grasps.dropped_scenes import drop_scene
    from lab.grasps.grasp_judge import best_grasp

    frames = []

    class Doubting(GraspDetector):
        def detect(self, frame, *more, **options):
            frames.append(frame)
            return super().detect(frame, *more, **options)

    scene, rng = drop_scene(7, 1), np.random.default_rng(1)
    sources = GraspDetector.shipped(ROBOT.gripper).sources
    never = Doubting(ROBOT.gripper, sources, lambda patches: np.zeros(len(patches.numbers)))
    view = random_view(scene.world, rng)
    found = best_grasp(never, scene.world, scene.region, view.wTc, view.noise, rng, looks=2)
    assert found is None
    first, *others = frames
    assert first.oTc.rotation[2, 2] > -0.9999
    assert len(others) == 2
    (obj,) = scene.world.objects
    for frame in others:
        assert frame.oTc.rotation[2, 2] == pytest.approx(-1.0)
        aside = frame.oTc.translation[:2] - obj.pose.translation[:2]
        assert np.linalg.norm(aside) < 0.03
        assert not np.array_equal(frame.depth, first.depth)


def test_dropped_objects_rest_within_the_walls() -> None:
    from lab.grasps.dropped_scenes import drop_scene, is_inside

    scene = drop_scene(2, 6)
    assert scene.group == "large"
    assert len(scene.world.objects) == 6
    for obj in scene.world.objects:
        assert is_inside(obj, scene.region)
        assert obj.reach(np.array([0.0, 0.0, -1.0])) < -FLOOR + 0.15
    hand, world = scene.hand()
    before = [obj.pose for obj in scene.world.objects]
    hand.settle(1.0)
    for obj, copy, pose in zip(scene.world.objects, world.objects, before, strict=True):
        assert obj.pose is pose
        assert np.linalg.norm(copy.pose.translation - pose.translation) < 2e-3


def test_figures_are_written_for_every_detector(tmp_path, monkeypatch):
    monkeypatch.setattr(evaluation, "BASELINES", (NetworkChoice(network="none"),))
    monkeypatch.setattr("lab.grasps.grasp_judge.ATTEMPTS", 0.3)
    few = ("--workers", 1, "--network", "check", "--scenes", 2, "--bins", 1)
    code, _, err = call("grasp", "eval", *few, "--json", tmp_path / "before.json")
    assert code == 0, err
    figures = json.loads((tmp_path / "before.json").read_text())
    assert [row["name"] for row in figures["rows"]] == ["check", "none"]
    assert len(figures["rows"][0]["singles"]) == len(figures["scenes"]) == 2
    assert "machine" in figures


def test_an_object_that_no_grasp_holds_does_not_count_as_lost(tmp_path: Path) -> None:
    trimesh.creation.box((0.12, 0.12, 0.12)).export(tmp_path / "too_wide.stl")
    trimesh.creation.box((0.12, 0.04, 0.04)).export(tmp_path / "brick.stl")
    few = ("--scenes", 2, "--bins", 0, "--workers", 1, "--by-chance", 4)
    code, out, err = call("grasp", "eval", "--meshes", tmp_path, *few)
    assert code == 0, err
    assert "too_wide: in 1 scene none of 4 by chance held" in out
    assert re.search(r"ggcnn +│ 50\.0", out)
    assert re.search(r"ggcnn, where any grasp holds +│ 100\.0", out)


def test_the_same_scenes_are_judged_along_every_tilt(tmp_path: Path) -> None:
    file = tmp_path / "tilts.json"
    few = ("--scenes", 2, "--by-chance", 2, "--workers", 1, "--json", file)
    code, out, err = call("grasp", "eval", "--network", "check", "--tilts", "0,90", *few)
    assert code == 0, err
    rows = json.loads(file.read_text())["rows"]
    assert [row["name"] for row in rows] == ["check, 0°", "check, 90°"]
    assert any(one["end"] == "held" for one in rows[0]["singles"])
    assert rows[1]["hopeless"]  # what lies is lower than the palm
    assert "any grasp holds" in out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--weights", "nowhere.safetensors"), "no such weights file"),
        (("--network", "check", "--weights", "x"), "give one of the two"),
        (("--json", "/nowhere/x.json"), "no folder"),
        (("--meshes", "/nowhere"), "no mesh"),
        (("--tilts", "30,120"), "0 to 90 degrees"),
    ],
)
def test_bad_input_is_one_line(arguments: tuple[str, ...], says: str) -> None:
    code, _, err = call("grasp", "eval", *arguments)
    assert code == 2
    assert says in err
    assert len(err.splitlines()) == 1
