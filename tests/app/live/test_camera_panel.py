"""What is recorded of the wrist camera, read back: images, grasps, pose, and when."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import sample_run as samples
from recordings import poses, record, rows

from app.live import Snapshot

LATENCY = 0.047
"""Between capture and arrival of a frame [s]; not a multiple of the sample run's period."""


@pytest.fixture(scope="module")
def snapshots() -> list[Snapshot]:
    return list(samples.run(300))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory, snapshots: list[Snapshot]) -> Path:
    return record(tmp_path_factory.mktemp("run") / "recording.rrd", snapshots)


def test_depth_is_kept_to_the_millimetre_with_what_was_found(
    recording: Path, snapshots: list[Snapshot]
) -> None:
    images = rows(recording, "/world/camera/depth")
    assert [row["tick"] for row in images] == list(range(170, 300, 20))
    for row in images:
        frame = snapshots[row["tick"]].frame
        assert frame is not None
        kept = cv2.imdecode(np.array(row["blob"][0], np.uint8), cv2.IMREAD_UNCHANGED)
        assert (kept == np.rint(np.nan_to_num(frame.depth) * 1000)).all()
        assert kept[0, 0] == 0
        assert kept.max() > 500
    heat, outlines = (rows(recording, f"/world/camera/{name}") for name in ("quality", "grasps"))
    assert [row["tick"] for row in heat] == [row["tick"] for row in outlines]
    assert [row["tick"] for row in heat] == [row["tick"] for row in images]
    for row, outline in zip(heat, outlines, strict=True):
        found = snapshots[row["tick"]].detection
        steps = np.array(row["buffer"][0], np.uint8).reshape(120, 160)
        if found is None:
            assert not steps.any()
            assert outline["strips"] == []
        else:
            v, u = np.unravel_index(steps.argmax(), steps.shape)
            assert (u, v) == pytest.approx(found.grasps[0].pixel, abs=1.5)
            middle = np.mean(outline["strips"][0][:4], axis=0)
            assert middle == pytest.approx(found.grasps[0].pixel, abs=1e-3)


def test_an_image_that_arrives_late_is_recorded_at_its_time_of_capture(tmp_path: Path) -> None:
    """The robot moves on meanwhile: camera, image and grasps stay where and when they were."""
    run = list(samples.run(300))
    late = []
    for snapshot in run:
        if snapshot.frame is not None:
            moved = snapshot.frame.wTc.copy()
            moved.translation -= [0.02, 0.0, 0.0]
            captured = snapshot.frame.stamp - LATENCY
            frame = replace(snapshot.frame, wTc=moved, stamp=captured)
            snapshot = replace(snapshot, frame=frame)
        late.append(snapshot)
    path = record(tmp_path / "late.rrd", late)
    images = rows(path, "/world/camera/depth")
    assert [row["tick"] for row in images] == list(range(170, 300, 20)), "when they arrived"
    for entity in ("depth", "quality", "grasps"):
        for row in rows(path, f"/world/camera/{entity}"):
            assert row["t"] == pytest.approx(late[row["tick"]].stamp - LATENCY, abs=1e-6)
    before, *camera = poses(path, "world/camera")
    assert before["tick"] == 0, "where an image would be taken"
    assert [row["tick"] for row in camera] == [row["tick"] for row in images]
    for row in camera:
        frame = late[row["tick"]].frame
        assert frame is not None
        assert row["t"] == pytest.approx(frame.stamp, abs=1e-6)
        np.testing.assert_allclose(row["translation"][0], frame.wTc.translation, atol=1e-5)
    hand = poses(path, "world/robot/hand")
    assert all(row["t"] == pytest.approx(late[row["tick"]].stamp, abs=1e-6) for row in hand)
