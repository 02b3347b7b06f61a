"""Runs that handle objects, exported: an episode an object, failures labelled, and a video."""

import json

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from app.core import RunOptions, ScheduledFault, run_task
from app.export import export_lerobot
from app.export.depth_video import pictured

pytestmark = pytest.mark.slow
DEPTH = "observation.images.depth"
TASK = """\
task: two_tries
description: Lift one object and put it back.
poses:
  above: {xyz: [2.935, 0.0, 0.85], rpy_deg: [180, 0, 0]}
regions:
  container: {centre: [3.0, 0.0, 0.556], size: [0.44, 0.36, 0.20]}
tree:
  sequence:
    - navigate: {to: above}
    - retry: 3
      sequence:
        - open_gripper
        - grasp: {within: container}
        - retreat_check
    - place: {on: container}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a run that succeeds at its second attempt, kept with all images."""
    root = tmp_path_factory.mktemp("recorded")
    (root / "task.yaml").write_text(TASK)
    dead = ScheduledFault(fault="gripper dead", at_s=0.5, for_s=6.5)
    return run_task(
        RunOptions(
            tree=root / "task.yaml",
            faults=(dead,),
            replayable=True,
            recording=False,
            scene="single",
            record=root / "runs",
        )
    ).folder


@pytest.fixture(scope="module")
def dataset(run, tmp_path_factory):
    out = tmp_path_factory.mktemp("export") / "dataset"
    return out, export_lerobot([run], out, fps=25)


@pytest.fixture(scope="module")
def episodes(dataset):
    return pq.read_table(dataset[0] / "meta/episodes/chunk-000/file-000.parquet").to_pylist()


@pytest.fixture(scope="module")
def frames(dataset):
    return pq.read_table(dataset[0] / "data/chunk-000/file-000.parquet").to_pylist()


def test_every_attempt_and_every_object_is_an_episode(dataset, episodes):
    assert [one["success"] for one in episodes] == [False, True]
    assert episodes[0]["ended"] == "the fingers did not move"
    assert episodes[1]["ended"].startswith("placed on container")
    assert (dataset[1].episodes, dataset[1].failed) == (2, 1)


def test_the_last_frame_of_an_episode_has_its_success(episodes, frames):
    for one in episodes:
        part = frames[one["dataset_from_index"] : one["dataset_to_index"]]
        assert [row["next.done"] for row in part] == [False] * (len(part) - 1) + [True]
        assert [row["next.success"] for row in part[:-1]] == [False] * (len(part) - 1)
        assert part[-1]["next.success"] is one["success"]


def test_the_video_has_a_picture_for_every_frame(dataset, episodes, frames):
    info = json.loads((dataset[0] / "meta/info.json").read_text())
    feature = info["features"][DEPTH]
    assert (feature["dtype"], feature["info"]["video.is_depth_map"]) == ("video", True)
    path = dataset[0] / info["video_path"].format(video_key=DEPTH, chunk_index=0, file_index=0)
    video = cv2.VideoCapture(str(path))
    assert video.get(cv2.CAP_PROP_FPS) == info["fps"] == 25
    count = 0
    while (read := video.read())[0]:
        assert read[1].shape == tuple(feature["shape"])
        count += 1
    assert count == len(frames)
    for one in episodes:
        assert one[f"videos/{DEPTH}/from_timestamp"] == one["dataset_from_index"] / 25
        assert one[f"videos/{DEPTH}/to_timestamp"] == one["dataset_to_index"] / 25
    statistics = json.loads((dataset[0] / "meta/stats.json").read_text())[DEPTH]
    assert np.shape(statistics["mean"]) == (3, 1, 1)
    assert statistics["count"] == [len(frames)]


def test_a_picture_shows_the_depth_that_was_measured_then(dataset, episodes, frames, run):
    [one] = [one for one in episodes if one["success"]]
    middle = (one["dataset_from_index"] + one["dataset_to_index"]) // 2
    video = cv2.VideoCapture(str(dataset[0] / f"videos/{DEPTH}/chunk-000/file-000.mp4"))
    video.set(cv2.CAP_PROP_POS_FRAMES, middle)
    shown = video.read()[1][:, :, 0].astype(float)
    states = np.load(run / "states.npy")
    after = frames[middle]["timestamp"] + _begin(states, one, frames)
    kept = list(pa.ipc.open_stream(pa.memory_map(str(run / "frames.arrow"))))
    newest = [batch for batch in kept if batch["stamp"][0].as_py() <= after + 1e-6][-1]
    depth = newest["depth"].flatten().to_numpy().reshape(newest["shape"].flatten().to_numpy())
    expected = pictured(depth).astype(float)
    assert np.median(np.abs(shown - expected)) <= 6.0  # 3 cm: the video is compressed with loss


def _begin(states, one, frames) -> float:
    """When an episode began in its run [s]: the time of the state that it begins with."""
    q = np.array(frames[one["dataset_from_index"]]["observation.state"][3:10])
    return float(states[np.abs(states[:, 7:14] - q).max(axis=1).argmin(), 0])
