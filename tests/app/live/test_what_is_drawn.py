"""What the viewer draws beside the robot: looks of nodes, ghosts, ways, distances, faults."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sample_run as samples
from recordings import poses, record, rows, static, with_component
from sample_run import SUCCESS

from app.live.monitor.camera_panel import STALE
from app.live.monitor.tree_panel import ROW
from app.live.nodes import NodeStatus
from controller import PointCloud, Pose2D
from hw import Fault, FaultKind

STANCE = Pose2D(2.3, 0.1, 0.5)
FAULT = Fault(kind=FaultKind.REFLEX, text="reflex of the arm", clearable=True)


def test_the_leaf_that_runs_is_outlined_until_the_run_ends(tmp_path: Path) -> None:
    run = list(samples.run(60))
    over = tuple(NodeStatus(SUCCESS, "") for _ in samples.TREE)
    run[55:] = [replace(snapshot, nodes=over) for snapshot in run[55:]]
    outlines = with_component(record(tmp_path / "x.rrd", run), "/tree/list/outline", "strips")
    assert [(row["tick"], len(row["strips"])) for row in outlines] == [
        *((0, 1), (30, 1), (50, 1), (55, 0)),
    ]
    pills = static(tmp_path / "x.rrd", "/tree/list/pills", "LineStrips2D:strips")
    assert outlines[0]["strips"] == [pills[2]], "recover runs first"
    assert np.diff([pill[0][1] for pill in pills]) == pytest.approx(ROW)
    edges = static(tmp_path / "x.rrd", "/tree/list/edges", "LineStrips2D:strips")
    assert [edge[-1] for edge in edges] == [pill[0] for pill in pills[1:]]


def test_ghosts_stand_at_the_goals_and_are_gone_without_one(tmp_path: Path) -> None:
    run = [
        replace(
            snapshot,
            report=snapshot.report._replace(stance=STANCE if snapshot.tick >= 20 else None),
        )
        for snapshot in samples.run(80)
    ]
    path = record(tmp_path / "x.rrd", run)
    base = [row["translation"][0] for row in poses(path, "world/ghost/base")]
    assert base[0][2] < -10.0, "out of sight"
    assert base[-1] == pytest.approx([2.3, 0.1, 0.0])
    hand = [row["translation"][0] for row in poses(path, "world/ghost/hand")]
    assert hand[-1] == pytest.approx(run[-1].hand_goal.translation)


def test_the_way_and_the_nearest_distance_are_drawn_while_they_are_there(tmp_path: Path) -> None:
    way = np.array([[0.0, 0.0, 0.0], [1.0, 0.2, 0.1], [2.0, 0.2, 0.0]])
    points = (np.array([1.0, 0.0, 0.3]), np.array([1.0, 0.12, 0.3]))
    run = list(samples.run(60))
    for tick in range(20, 40):
        report = run[tick].report._replace(
            clearance=0.12, way=way, nearest_points=points, stance=STANCE
        )
        run[tick] = replace(run[tick], report=report)
    path = record(tmp_path / "x.rrd", run)
    counts = [(row["tick"], len(row["strips"])) for row in rows(path, "/world/way")]
    assert [count for _, count in counts] == [0, 1, 0]
    drawn = next(row for row in rows(path, "/world/nearest") if row["strips"])
    assert drawn["labels"] == ["12 cm"]
    np.testing.assert_allclose(drawn["strips"][0], points, atol=1e-6)


def test_a_fault_turns_the_robot_red_and_names_itself(tmp_path: Path) -> None:
    run = list(samples.run(60))
    for tick in range(20, 40):
        run[tick] = replace(run[tick], state=replace(run[tick].state, faults=(FAULT,)))
    path = record(tmp_path / "x.rrd", run)
    banner = [
        (row["tick"], row["labels"]) for row in with_component(path, "/world/fault", "labels")
    ]
    assert banner == [(0, []), (20, ["⚠ FAULT: reflex of the arm"]), (40, [])]
    painted = [
        row["tick"]
        for row in rows(path, "/world/robot/base")
        if {"colors", "albedo_factor"} & set(row)
    ]
    assert sorted(set(painted)) == [0, 20, 40]
    errors = [row["tick"] for row in rows(path, "/log") if row["level"] == ["ERROR"]]
    assert errors == [20], "logged once"


def test_a_picture_that_is_old_goes_with_its_points_and_grasps(tmp_path: Path) -> None:
    run = list(samples.run(320))
    for tick in range(200, 320):
        run[tick] = replace(run[tick], frame=None, detection=None)
    path = record(tmp_path / "x.rrd", run)
    for part, component in (("depth", "blob"), ("quality", "buffer"), ("grasps", "strips")):
        *_, seen_last, gone = with_component(path, f"/world/camera/{part}", component)
        assert not len(gone[component])
        assert gone["t"] == pytest.approx(seen_last["t"] + STALE, abs=0.6)


def test_obstacles_that_the_camera_has_seen_are_points(tmp_path: Path) -> None:
    points = np.array([[1.0, 0.0, 0.3], [1.2, 0.1, 0.4]])
    run = [replace(one, seen=PointCloud(points)) for one in samples.run(60)]
    path = record(tmp_path / "x.rrd", run)
    drawn = [row["positions"] for row in rows(path, "/world/seen")]
    np.testing.assert_allclose(drawn[0], points, atol=1e-6)


def test_regions_are_boxes(tmp_path: Path) -> None:
    path = record(tmp_path / "x.rrd", list(samples.run(10)))
    (half,) = static(path, "/world/regions", "Boxes3D:half_sizes")
    np.testing.assert_allclose(half, samples.SCENE.regions[0].size / 2.0, atol=1e-6)
    assert static(path, "/world/regions", "Boxes3D:labels") == ["container"]
