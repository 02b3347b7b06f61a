"""A LeRobot dataset of really recorded runs, read back as its layout demands."""

import json

import cv2
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from command_line import call

from app.core import ObstacleSource, RunOptions, run_task
from extensions.export.depth_video import FAR, NEAR, pictured
from extensions.export.episodes import ExportError, parts_of
from extensions.export.lerobot import export_lerobot

TASK = """\
task: {name}
description: {text}
poses:
  near: {{xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
tree:
  timeout_s: {seconds}
  navigate: {{to: near}}
"""


def rows(path):
    return pq.read_table(path).to_pylist()


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    root = tmp_path_factory.mktemp("recorded")
    task, found = root / "task.yaml", []
    for name, text, seconds in (
        ("a", "Go near.", 0.3),
        ("b", "Go on.", 9.0),
        ("c", "Go near.", 0.2),
    ):
        task.write_text(TASK.format(name=name, text=text, seconds=seconds))
        options = RunOptions(tree=task, scene="single", record=root / "runs", recording=False)
        found.append(run_task(options).folder)
    return found


@pytest.fixture(scope="module")
def dataset(folders, tmp_path_factory):
    out = tmp_path_factory.mktemp("export") / "dataset"
    code, said, _ = call("export", *folders, "--lerobot", out, "--fps", 50)
    assert (code, "3 episodes" in said) == (0, True)
    return out, len(rows(out / "data/chunk-000/file-000.parquet"))


def test_frames_are_the_recorded_motion_at_the_rate_that_was_asked_for(folders, dataset):
    data = rows(dataset[0] / "data/chunk-000/file-000.parquet")
    first = [row for row in data if row["episode_index"] == 0]
    states, commands = np.load(folders[0] / "states.npy"), np.load(folders[0] / "commands.npy")
    assert len(first) == len(states[::2])
    np.testing.assert_allclose([r["timestamp"] for r in first], 0.02 * np.arange(len(first)), 1e-6)
    found = np.array([r["observation.state"] for r in first])
    np.testing.assert_allclose(found[:, 3:10], states[::2, 7:14], atol=1e-6)
    np.testing.assert_allclose(found[:, 10], 0.08, atol=1e-6)
    actions = np.array([r["action"] for r in first])
    np.testing.assert_allclose(actions[:, :10], commands[::2, 1:], atol=1e-6)
    assert np.abs(actions).max() > 0.05


def test_episodes_and_tasks_point_into_the_data(dataset):
    out, frames = dataset
    data = rows(out / "data/chunk-000/file-000.parquet")
    episodes = rows(out / "meta/episodes/chunk-000/file-000.parquet")
    assert [row["index"] for row in data] == list(range(frames))
    assert [episode["tasks"] for episode in episodes] == [["Go near."], ["Go on."], ["Go near."]]
    begin = 0
    for number, episode in enumerate(episodes):
        assert (episode["dataset_from_index"], episode["episode_index"]) == (begin, number)
        begin = episode["dataset_to_index"]
        part = data[episode["dataset_from_index"] : begin]
        assert {row["episode_index"] for row in part} == {number}
        assert [row["frame_index"] for row in part] == list(range(episode["length"]))
        assert {row["task_index"] for row in part} == {0 if number != 1 else 1}
        assert [row["next.done"] for row in part] == [False] * (len(part) - 1) + [True]
        assert [row["next.success"] for row in part] == [False] * (len(part) - 1) + [number == 1]
        assert (episode["success"], episode["ended"] == "success") == (number == 1, number == 1)
    assert begin == frames


def test_the_description_fits_the_files(dataset):
    out, frames = dataset
    info = json.loads((out / "meta/info.json").read_text())
    assert info["codebase_version"] == "v3.0"
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"]) == (3, frames, 2)
    assert (out / info["data_path"].format(chunk_index=0, file_index=0)).is_file()
    schema = pq.read_schema(out / "data/chunk-000/file-000.parquet")
    assert set(schema.names) == set(info["features"])
    for key, feature in info["features"].items():
        kind = schema.field(key).type
        if feature["shape"] == [1]:
            assert str(kind) in (feature["dtype"], {"float32": "float"}.get(feature["dtype"]))
        else:
            assert kind.list_size == feature["shape"][0] == len(feature["names"])
    stats = json.loads((out / "meta/stats.json").read_text())
    assert set(stats) == set(info["features"])
    assert stats["timestamp"]["count"] == [frames]
    assert len(stats["action"]["mean"]) == 11
    tasks = pd.read_parquet(out / "meta/tasks.parquet")
    assert dict(tasks["task_index"]) == {"Go near.": 0, "Go on.": 1}


def test_what_cannot_be_exported_is_refused(folders, dataset, tmp_path):
    with pytest.raises(ExportError, match="exists already"):
        export_lerobot(folders, dataset[0])
    with pytest.raises(ExportError, match=r"--fps 30: .*100 ticks.*25, 50, 100"):
        export_lerobot(folders, tmp_path / "out", fps=30)
    assert not (tmp_path / "out").exists()


def test_kept_images_become_a_video_with_a_picture_for_every_frame(tmp_path):
    (tmp_path / "task.yaml").write_text(TASK.format(name="a", text="Go near.", seconds=1.0))
    looks = {"obstacles": ObstacleSource.BOTH, "replayable": True, "recording": False}
    options = RunOptions(
        tree=tmp_path / "task.yaml", scene="single", record=tmp_path / "runs", **looks
    )
    run = run_task(options)
    done = export_lerobot([run.folder], tmp_path / "out")
    assert done.has_video
    info = json.loads((tmp_path / "out/meta/info.json").read_text())
    key = "observation.images.depth"
    [episode] = rows(tmp_path / "out/meta/episodes/chunk-000/file-000.parquet")
    assert episode[f"videos/{key}/to_timestamp"] == done.frames / 50
    path = info["video_path"].format(video_key=key, chunk_index=0, file_index=0)
    video, count = cv2.VideoCapture(str(tmp_path / "out" / path)), 0
    assert video.get(cv2.CAP_PROP_FPS) == info["fps"] == 50
    while (read := video.read())[0]:
        assert read[1].shape == tuple(info["features"][key]["shape"])
        count, shown = count + 1, read[1][:, :, 0].astype(float)
    assert count == done.frames
    *_, newest = pa.ipc.open_stream(pa.memory_map(str(run.folder / "frames.arrow")))
    depth = newest["depth"].flatten().to_numpy().reshape(newest["shape"].flatten().to_numpy())
    assert np.median(np.abs(shown - pictured(depth))) <= 6.0  # 3 cm: compressed with loss
    statistics = json.loads((tmp_path / "out/meta/stats.json").read_text())[key]
    assert statistics["max"][0][0][0] > 0.2


NODES = [
    {"path": "s", "name": "s", "kind": "sequence"},
    {"path": "s/grasp", "name": "grasp", "kind": "grasp"},
    {"path": "s/place", "name": "place", "kind": "place"},
]
CHANGES = [
    (1, "RUNNING", ""), (1, "FAILURE", "nothing"), (1, "RUNNING", ""), (1, "SUCCESS", ""),
    (2, "RUNNING", ""), (2, "SUCCESS", "placed"), (1, "RUNNING", ""),
]  # fmt: skip
"""One a second: node, status and message."""


def test_a_run_is_cut_where_an_object_was_placed_or_an_attempt_failed(tmp_path):
    events = [{"event": "begin", "time": 0.0, "nodes": NODES}]
    for time, change in enumerate(CHANGES, 1):
        told = zip(("node", "status", "message"), change, strict=True)
        events.append({"event": "node", "time": float(time), **dict(told)})
    (tmp_path / "events.jsonl").write_text("".join(json.dumps(one) + "\n" for one in events))
    parts = [(p.begin, p.end, p.success, p.why) for p in parts_of(tmp_path, 8.0)]
    assert parts == [
        (0.0, 2.0, False, "nothing"),
        (2.0, 6.0, True, "placed"),
        (6.0, 8.0, False, "the run ended: unfinished"),
    ]


def test_depth_becomes_eight_bits():
    depth = np.array([[0.0, np.nan, NEAR, FAR, 9.0, (NEAR + FAR) / 2]], np.float32)
    assert pictured(depth).tolist() == [[0, 0, 1, 255, 255, 128]]
