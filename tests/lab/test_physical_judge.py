"""The judge by physics: what it holds, what it refuses, and its figures."""

import json
import re
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import trimesh
from pinocchio import SE3
from typer.testing import CliRunner

from app.commands import app
from hw.sim import SimObject, World
from lab.grasps.choice import NetworkChoice
from lab.grasps.scenes import FLOOR, ROBOT, random_view
from lab.shared import paired_difference
from perception import Detection, GraspDetector, GraspEstimate, GraspPatches, Workspace
from perception.frame import Frame
from robots import Box, Geom

pytest.importorskip("mujoco", reason="needs the extra `physics`")

RUN = CliRunner()
HALF = (0.06, 0.02, 0.02)


def box_alone() -> World:
    """A long box along x on a table."""
    table = Geom(Box((0.5, 0.5, 0.05)), SE3(np.eye(3), np.array([0, 0, FLOOR - 0.05])), "table")
    here = SE3(np.eye(3), np.array([0.0, 0.0, FLOOR + HALF[2]]))
    parts = (Geom(Box(HALF), SE3.Identity(), "box"),)
    return World([table], [SimObject(name="box 1", parts=parts, mass=0.2, pose=here)])


def grasp(y: float = 0.0, z: float = 0.02, opening: float = 0.06) -> GraspEstimate:
    wTg = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, y, FLOOR + z]))
    return GraspEstimate(
        wTg=wTg, width=0.04, quality=1.0, stamp=0.0, pixel=(0, 0), angle=0.0, opening=opening
    )


@pytest.mark.parametrize(
    ("asked", "end", "hard"),
    [
        (grasp(), "held", False),
        (grasp(z=0.07), "nothing between the fingers", False),
        (grasp(y=0.12), "nothing between the fingers", False),
        (grasp(y=0.03, z=0.011), "nothing between the fingers", True),  # a finger into the box
    ],
)
def test_grasps_end_as_they_would(asked: GraspEstimate, end: str, hard: bool) -> None:
    from lab.grasps.physical_judge import execute
    from lab.grasps.physical_scenes import at_rest

    world = box_alone()
    attempt = execute(at_rest(world), world, asked)
    assert attempt.end == end
    assert attempt.hard is hard
    assert attempt.target_class == "box"


def test_a_scene_is_judged_the_same_every_time_and_no_detector_disturbs_the_next() -> None:
    from lab.grasps.physical_judge import judge_single

    none, check = (NetworkChoice(network=name) for name in ("none", "check"))
    both = judge_single(7, [none, check])
    assert judge_single(7, [none, check]) == both
    assert judge_single(7, [check])[2] == both[2][1:]


def test_the_judge_looks_again_from_straight_above_where_nothing_is_likely_to_hold() -> None:
    from lab.grasps.chosen import chosen_grasp
    from lab.grasps.physical_scenes import dropped

    frames = []

    class Doubting(GraspDetector):
        def detect(self, frame: Frame, workspace: Workspace | None = None) -> Detection:
            frames.append(frame)
            return super().detect(frame, workspace)

    def never(patches: GraspPatches) -> npt.NDArray[np.float64]:
        return np.zeros(len(patches.numbers))

    scene = dropped(7, 1)
    detector = Doubting(gripper=ROBOT.gripper, hold=never)
    rng = np.random.default_rng(1)
    view = random_view(scene.world, rng)
    seen = chosen_grasp(detector, scene.world, scene.region, view.wTc, view.noise, rng, looks=2)
    assert seen is None
    first, *others = frames
    assert first.wTc.rotation[2, 2] > -0.9999
    assert len(others) == 2
    (obj,) = scene.world.objects
    for frame in others:
        assert frame.wTc.rotation[2, 2] == pytest.approx(-1.0)
        aside = frame.wTc.translation[:2] - obj.pose.translation[:2]
        assert np.linalg.norm(aside) < 0.03
        assert not np.array_equal(frame.depth, first.depth)


def test_dropped_objects_rest_within_the_walls() -> None:
    from lab.grasps.physical_scenes import dropped, is_inside

    scene = dropped(2, 6)
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


def test_a_paired_difference_knows_what_chance_can_do() -> None:
    rng = np.random.default_rng(1)
    one = (rng.random(400) < 0.9).astype(float)
    assert paired_difference(one, one) == (0.0, 0.0, 0.0)
    worse = one.copy()
    worse[np.flatnonzero(one)[:40]] = 0.0
    mean, low, high = paired_difference(one, worse)
    assert mean == pytest.approx(0.1)
    # Of 40 in 400 by the binomial distribution.
    assert (low, high) == pytest.approx((0.1 - 0.0294, 0.1 + 0.0294), abs=0.004)
    mean, low, high = paired_difference(one, (rng.random(400) < 0.9).astype(float))
    assert low < 0.0 < high
    per_attempt = paired_difference(one, one, (np.full(400, 1.0), np.full(400, 2.0)))
    assert per_attempt[0] == pytest.approx(one.mean() / 2.0)


def test_figures_are_written_and_compared_later(tmp_path: Path) -> None:
    file = tmp_path / "before.json"
    arguments = ["grasp", "eval", "--judge", "physics", "--workers", "1", "--network", "check"]
    few = [*arguments, "--scenes", "3", "--bins", "1"]
    result = RUN.invoke(app, [*few, "--json", str(file)])
    assert result.exit_code == 0, result.output
    assert "the kinematic judge agrees on" in result.output
    figures = json.loads(file.read_text())
    assert [row["name"] for row in figures["rows"]] == [
        "check",
        "check, likelihood ranking",
        "none",
        "none, first ranking",
    ]
    assert len(figures["rows"][0]["singles"]) == len(figures["scenes"]) == 3
    again = RUN.invoke(app, [*few, "--against", str(file)], env={"COLUMNS": "200"})
    assert again.exit_code == 0, again.output
    assert "check, before" in again.output
    assert "+0.0 (+0.0 to +0.0), 0 won, 0 lost" in again.output
    other = RUN.invoke(app, [*arguments, "--scenes", "2", "--bins", "0", "--against", str(file)])
    assert other.exit_code == 2
    assert "other scenes" in other.output


def test_what_no_grasp_holds_is_told_apart_from_what_a_row_has_lost(tmp_path: Path) -> None:
    trimesh.creation.box((0.12, 0.12, 0.12)).export(tmp_path / "too_wide.stl")
    trimesh.creation.box((0.12, 0.04, 0.04)).export(tmp_path / "brick.stl")
    few = ["--scenes", "2", "--bins", "0", "--workers", "1", "--by-chance", "4"]
    arguments = ["grasp", "eval", "--judge", "physics", "--meshes", str(tmp_path), *few]
    result = RUN.invoke(app, arguments, env={"COLUMNS": "200"})
    assert result.exit_code == 0, result.output
    assert "too_wide: in 1 scenes none of 4 grasps by chance held" in result.output
    assert re.search(r"bins +│ 50\.0", result.output)
    assert re.search(r"bins, where any grasp holds +│ 100\.0", result.output)


def test_grasps_by_chance_find_what_can_be_held() -> None:
    from lab.grasps.by_chance import holds_by_chance

    assert holds_by_chance(40, (), 301)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--judge", "physics", "--plot", "x.png"), "kinematic judge"),
        (("--judge", "physics", "--meshes", "/nowhere"), "no mesh"),
        (("--judge", "physics", "--against", "/nowhere.json"), "not figures of"),
        (("--meshes", "."), "belong to --judge physics"),
        (("--ranked", "first"), "belong to --judge physics"),
    ],
)
def test_bad_input_is_one_line(arguments: tuple[str, ...], says: str) -> None:
    result = RUN.invoke(app, ["grasp", "eval", *arguments])
    assert result.exit_code == 2
    assert says in result.output
    assert len(result.output.strip().splitlines()) == 1
