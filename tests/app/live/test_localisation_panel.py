"""What is shown of the localisation, where it is not exact: in the recording and on the page."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sample_run as samples
from command_line import call
from recordings import poses, record, rows
from rerun.chunk import RrdReader

from app.live import PoseEstimate, Snapshot
from config.planar import in_space, on_floor
from hw import LaserScan
from perception.registration import Displacement, Registration
from robots import load_robot

MTO = np.array([0.03, -0.02, 0.01])
OFF = np.array([0.03, -0.04, np.deg2rad(2.0)])
COVARIANCE = np.diag([0.01**2, 0.02**2, np.deg2rad(0.5) ** 2])
SCAN = LaserScan(
    stamp=0.0,
    ranges=np.array([1.0, np.nan]),
    points=np.array([[1.0, 0.0, 0.2], [np.nan] * 3]),
    oTb=in_space(np.array([0.5, 0.0, np.pi / 2.0])),
)
MOVED = Displacement(
    piece="table",
    centre=np.array([0.0, 1.6]),
    by=np.array([0.06, 0.08, np.deg2rad(2.0)]),
    covariance=np.eye(3),
)
REGISTRATION = Registration(
    pose=np.zeros(3),
    covariance=COVARIANCE,
    prior=np.zeros(3),
    mahalanobis=1.0,
    information=np.eye(3),
    limit=np.eye(3),
    points=np.array([[2.75, 0.1, 0.3], [2.75, 0.2, 0.3]]),
    residuals=np.zeros(2),
    alone=frozenset(),
    confirmed=True,
    explained=1.0,
    displaced=(MOVED,),
    uncertain=(),
    missed=np.zeros((2, 0), int),
)


def estimated(snapshot: Snapshot, covariance: np.ndarray = COVARIANCE) -> Snapshot:
    """The same of a robot that believes to be `OFF` from where it is."""
    mTo, mTb = in_space(MTO), snapshot.state.oTb
    true = mTb * in_space(OFF).inverse()
    estimate = PoseEstimate(on_floor(mTb), covariance, mTo, REGISTRATION, SCAN, true)
    state = replace(snapshot.state, oTb=mTo.inverse() * mTb)
    return replace(snapshot, state=state, estimate=estimate)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = [estimated(snapshot) for snapshot in samples.run(60)]
    scene = replace(samples.SCENE, estimated=True)
    return record(tmp_path_factory.mktemp("run") / "recording.rrd", run, scene=scene)


def test_the_base_is_drawn_where_it_truly_is(recording: Path) -> None:
    true = poses(recording, "world/localisation/true_base")
    believed = {row["tick"]: row for row in poses(recording, "world/robot/base")}
    assert len(true) >= 12
    apart = np.subtract(true[0]["translation"][0], believed[0]["translation"][0])
    assert np.linalg.norm(apart) == pytest.approx(0.05, abs=1e-6)


def test_the_outline_of_the_base_is_grown_by_two_sigma(recording: Path) -> None:
    last = rows(recording, "/world/localisation/outline")[-1]
    assert last["labels"] == ["±40 mm"]
    points = np.array(last["strips"][0])[:, :2]
    points -= samples.snapshot(last["tick"]).state.oTb.translation[:2]
    half = np.array(load_robot("frankie").base.size[:2]) / 2.0
    turned = np.deg2rad(0.5) * half[::-1]  # of a corner, by the error of the heading
    grown = 2.0 * np.hypot([0.01, 0.02], turned)
    np.testing.assert_allclose(points.max(axis=0), half + grown, atol=1e-6)
    np.testing.assert_allclose(points.min(axis=0), -half - grown, atol=1e-6)


def test_the_scan_and_the_matched_points_are_on_the_map_once_each(recording: Path) -> None:
    (scan,) = rows(recording, "/world/localisation/scan")
    on_map = in_space(MTO).act(np.array([0.5, 1.0, 0.2]))
    np.testing.assert_allclose(scan["positions"], [on_map], atol=1e-6)
    (matched,) = rows(recording, "/world/localisation/matched")
    np.testing.assert_allclose(matched["positions"], REGISTRATION.points, atol=1e-6)


def test_displaced_furniture_is_marked_on_its_top(recording: Path) -> None:
    (moved,) = rows(recording, "/world/localisation/displaced")
    assert moved["labels"] == ["table moved by 100 mm, 2.0°"]
    np.testing.assert_allclose(moved["origins"], [[0.0, 1.6, 0.5]], atol=1e-6)
    np.testing.assert_allclose(moved["vectors"], [[0.06, 0.08, 0.0]], atol=1e-6)


def test_uncertainty_and_true_error_are_plotted(recording: Path) -> None:
    position = rows(recording, "/signals/pose_position")[-1]["scalars"]
    heading = rows(recording, "/signals/pose_heading")[-1]["scalars"]
    assert position == pytest.approx([40.0, 50.0])
    assert heading == pytest.approx([1.0, 2.0])


def shown(path: Path) -> set[str]:
    """What is in a recording of the localisation."""
    entities = {chunk.entity_path for chunk in RrdReader(path).stream().to_chunks()}
    return {one for one in entities if "localisation" in one or "pose_" in one}


def test_nothing_of_it_is_shown_where_the_localisation_is_exact(tmp_path: Path) -> None:
    assert shown(record(tmp_path / "x.rrd", list(samples.run(10)))) == set()


def test_a_run_that_is_wrong_about_where_it_is_shows_it(tmp_path: Path) -> None:
    task = tmp_path / "t.yaml"
    task.write_text("task: t\ntree:\n  wait: {duration_s: 0.2}\n")
    options = ("--localisation", "poor", "--scene", "single")
    code, _, _ = call("run", task, "--view", "none", "--record", tmp_path / "runs", *options)
    assert code == 0
    (path,) = tmp_path.glob("runs/*/recording.rrd")
    parts = {f"/world/localisation/{part}" for part in ("outline", "scan", "matched")}
    assert shown(path) >= parts | {"/signals/pose_position", "/signals/pose_heading"}
    assert rows(path, "/world/localisation/matched")[-1]["positions"]
    two_sigma, error = rows(path, "/signals/pose_position")[-1]["scalars"]
    assert 0.0 < two_sigma < 200.0
    assert 0.0 < error < 200.0
