"""What the viewer draws beside the robot: looks of nodes, ghosts, ways, distances, faults."""

from dataclasses import replace
from math import tan
from pathlib import Path

import numpy as np
import pytest
import sample_run as samples
from recordings import poses, record, rows, static, with_component
from sample_run import SUCCESS

from app.live import SceneView
from app.live.monitor.blueprint import FIELD, Eye, eye_for, task_points
from app.live.monitor.camera_panel import STALE
from app.live.monitor.tree_panel import ROW
from app.live.nodes import NodeStatus
from config.planar import Pose2D
from controller import PointCloud
from hw import Fault, FaultKind
from robots import Box, Geom

STANCE = Pose2D(2.3, 0.1, 0.5)
WAY = np.array([[0.0, 0.0, 0.0], [1.0, 0.2, 0.1], [2.0, 0.2, 0.0]])
NEAREST = (np.array([1.0, 0.0, 0.3]), np.array([1.0, 0.12, 0.3]))
SEEN = np.array([[1.0, 0.0, 0.3], [1.2, 0.1, 0.4]])
FAULT = Fault(kind=FaultKind.REFLEX, text="reflex of the arm", clearable=True)


def test_the_leaf_that_runs_is_outlined_until_the_run_ends(tmp_path: Path) -> None:
    run = list(samples.run(60))
    over = tuple(NodeStatus(SUCCESS, "") for _ in samples.TREE)
    run[55:] = [replace(snapshot, nodes=over) for snapshot in run[55:]]
    outlines = with_component(record(tmp_path / "x.rrd", run), "/tree/list/outline", "strips")
    assert [(row["tick"], len(row["strips"])) for row in outlines] == [
        *((0, 1), (30, 1), (50, 1), (55, 0))
    ]
    pills = static(tmp_path / "x.rrd", "/tree/list/pills", "LineStrips2D:strips")
    assert outlines[0]["strips"] == [pills[2]], "recover runs first"
    assert np.diff([pill[0][1] for pill in pills]) == pytest.approx(ROW)
    edges = static(tmp_path / "x.rrd", "/tree/list/edges", "LineStrips2D:strips")
    assert [edge[-1] for edge in edges] == [pill[0] for pill in pills[1:]]


@pytest.fixture(scope="module")
def eventful(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with a fault, a way and a near thing for a while, and with a stance after that too."""
    run = [replace(one, seen=PointCloud(SEEN)) for one in samples.run(80)]
    for tick in range(20, 80):
        report = run[tick].report._replace(stance=STANCE)
        if tick < 40:
            report = report._replace(clearance=0.12, way=WAY, nearest_points=NEAREST)
            run[tick] = replace(run[tick], state=replace(run[tick].state, faults=(FAULT,)))
        run[tick] = replace(run[tick], report=report)
    return record(tmp_path_factory.mktemp("run") / "x.rrd", run)


def test_ghosts_stand_at_the_goals_and_are_gone_without_one(eventful: Path) -> None:
    base = [row["translation"][0] for row in poses(eventful, "world/ghost/base")]
    assert base[0][2] < -10.0, "out of sight"
    assert base[-1] == pytest.approx([2.3, 0.1, 0.0])
    hand = [row["translation"][0] for row in poses(eventful, "world/ghost/hand")]
    assert hand[-1] == pytest.approx(samples.snapshot(79).hand_goal.translation)


def test_the_way_and_the_nearest_distance_are_drawn_while_they_are_there(eventful: Path) -> None:
    assert [len(row["strips"]) for row in rows(eventful, "/world/way")] == [0, 1, 0]
    drawn = next(row for row in rows(eventful, "/world/nearest") if row["strips"])
    assert drawn["labels"] == ["12 cm"]
    np.testing.assert_allclose(drawn["strips"][0], NEAREST, atol=1e-6)


def test_a_fault_turns_the_robot_red_and_names_itself(eventful: Path) -> None:
    told = with_component(eventful, "/world/fault", "labels")
    banner = [(row["tick"], row["labels"]) for row in told]
    assert banner == [(0, []), (20, ["⚠ FAULT: reflex of the arm"]), (40, [])]
    base = rows(eventful, "/world/robot/base")
    painted = {row["tick"] for row in base if {"colors", "albedo_factor"} & set(row)}
    assert painted == {0, 20, 40}
    errors = [row["tick"] for row in rows(eventful, "/log") if row["level"] == ["ERROR"]]
    assert errors == [20], "logged once"


def test_obstacles_that_the_camera_has_seen_are_points_and_regions_boxes(eventful: Path) -> None:
    drawn = [row["positions"] for row in rows(eventful, "/world/seen")]
    np.testing.assert_allclose(drawn[0], SEEN, atol=1e-6)
    (half,) = static(eventful, "/world/regions", "Boxes3D:half_sizes")
    np.testing.assert_allclose(half, samples.SCENE.regions[0].size / 2.0, atol=1e-6)
    assert static(eventful, "/world/regions", "Boxes3D:labels") == ["container"]


def test_a_picture_that_is_old_goes_with_its_points_and_grasps(tmp_path: Path) -> None:
    run = list(samples.run(320))
    for tick in range(200, 320):
        run[tick] = replace(run[tick], frame=None, detection=None)
    path = record(tmp_path / "x.rrd", run)
    for part, component in (("depth", "blob"), ("quality", "buffer"), ("grasps", "strips")):
        *_, seen_last, gone = with_component(path, f"/world/camera/{part}", component)
        assert not len(gone[component])
        assert gone["t"] == pytest.approx(seen_last["t"] + STALE, abs=0.6)


def projected(eye: Eye, points: np.ndarray) -> np.ndarray:
    """(N, 2) places in a picture of 1.5 by 1, whose middle is 0."""
    ahead = (eye.target - eye.position) / np.linalg.norm(eye.target - eye.position)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    x, y, z = np.array([right, np.cross(right, ahead), ahead]) @ (points - eye.position).T
    assert (z > 0.0).all()
    return np.column_stack([x / z, y / z]) / (2.0 * tan(FIELD / 2.0))


@pytest.mark.parametrize("far", [0.0, 0.5, 40.0])
def test_all_of_a_task_is_in_the_picture_and_fills_it(far: float) -> None:
    box = Geom(Box((0.3, 0.3, 0.3)), samples._at(far, -far, 0.3), "box")
    points = task_points(SceneView(fixtures=(box,)) if far else samples.SCENE)
    places = projected(eye_for(points), points)
    assert (np.abs(places) < [0.75, 0.5]).all()
    share = (places.max(axis=0) - places.min(axis=0)) / [1.5, 1.0]
    assert far or share.max() > 0.9, "not farther away than needed"
