"""A LeRobot dataset of really recorded runs, read back as its layout demands."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from command_line import call

from app.core import RunOptions, run_task
from app.export import ExportError, export_lerobot

TASK = """\
task: {name}
description: {text}
poses:
  near: {{xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
tree:
  timeout_s: {seconds}
  navigate: {{to: near}}
"""


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    root = tmp_path_factory.mktemp("recorded")
    found = []
    for name, text, seconds in (
        ("a", "Go near.", 0.3),
        ("b", "Go on.", 0.2),
        ("c", "Go near.", 0.2),
    ):
        (root / "task.yaml").write_text(TASK.format(name=name, text=text, seconds=seconds))
        options = RunOptions(
            tree=root / "task.yaml", scene="single", record=root / "runs", recording=False
        )
        found.append(run_task(options).folder)
    return found


@pytest.fixture(scope="module")
def dataset(folders, tmp_path_factory):
    out = tmp_path_factory.mktemp("export") / "dataset"
    frames = export_lerobot(folders, out, fps=50).frames
    return out, frames


def rows(path):
    return pq.read_table(path).to_pylist()


def test_frames_are_the_recorded_motion_at_the_rate_that_was_asked_for(folders, dataset):
    out, frames = dataset
    data = rows(out / "data/chunk-000/file-000.parquet")
    assert len(data) == frames
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


def test_tasks_are_the_index_of_a_pandas_table(dataset):
    pandas = pytest.importorskip("pandas")
    tasks = pandas.read_parquet(dataset[0] / "meta/tasks.parquet")
    assert list(tasks.index) == ["Go near.", "Go on."]
    assert list(tasks["task_index"]) == [0, 1]


def test_what_cannot_be_exported_is_refused(folders, dataset, tmp_path):
    with pytest.raises(ExportError, match="exists already"):
        export_lerobot(folders, dataset[0])
    with pytest.raises(ExportError, match=r"--fps 30: .*100 ticks.*25, 50, 100"):
        export_lerobot(folders, tmp_path / "out", fps=30)
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(ExportError, match="no recorded motion"):
        export_lerobot([empty], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_command_line_exports(folders, tmp_path):
    out = tmp_path / "out"
    code, said, _ = call("export", *folders[:2], "--lerobot", out)
    assert (code, "2 episodes" in said) == (0, True)
    assert (out / "meta/info.json").is_file()
