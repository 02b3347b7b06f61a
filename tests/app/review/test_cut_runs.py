"""Files of a run that were cut, as by a full disk: the rest is used, and what is lost is told."""

import os
import shutil

import pytest
from command_line import call

from app.core import losses
from app.live.viewer import viewer
from app.live.viewer.viewer import converted
from app.review import chunks
from hw.registry import WorldError, simulator


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    home = tmp_path_factory.mktemp("recorded")
    (home / "go.yaml").write_text("task: go\nscene: single\ntree: {drive: {forward_m: 0.3}}\n")
    options = ("--view", "none", "--replayable", "--record", home / "runs")
    code, _, err = call("run", home / "go.yaml", *options)
    assert code == 0, err
    (folder,) = (home / "runs").iterdir()
    assert list(losses(folder)) == []
    return folder


@pytest.fixture
def run(recorded, tmp_path):
    return shutil.copytree(recorded, tmp_path / "run")


def cut(path, size):
    os.truncate(path, path.stat().st_size - size)


@pytest.mark.parametrize("size", [1, 15, 1000])
def test_a_recording_loses_its_last_message(run, tmp_path, size):
    cut(run / "recording.rrd", size)
    code, _, err = call("export", run, "--mcap", tmp_path / "run.mcap")
    assert code == 0, err
    assert "recording.rrd: the last message is cut off" in err
    assert (tmp_path / "run.mcap").stat().st_size > 10_000


@pytest.mark.parametrize("name", ["readings.jsonl", "readings.npy"])
def test_readings_lose_their_end(run, name):
    cut(run / name, 30)
    code, out, err = call("replay", run)
    assert code == 0, out + err
    assert "are identical, bit for bit; the recording was cut off there" in out
    assert name in err


def test_the_motion_and_the_events_lose_their_end(run, tmp_path):
    for name in ("states.npy", "commands.npy", "events.jsonl"):
        cut(run / name, 50)
    code, _, err = call("export", run, "--mcap", tmp_path / "run.mcap")
    assert code == 0, err
    assert "states.npy: the end is cut off: 1 rows are missing" in err
    assert "events.jsonl: the last line is cut off" in call("explain", run)[2]


def test_a_file_without_its_end_is_shown_and_an_empty_one_is_named(run, tmp_path, monkeypatch):
    whole, bag = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    assert call("export", run, "--mcap", whole)[0] == 0
    for kept in (whole.stat().st_size - 8, whole.stat().st_size * 3 // 4):
        bag.write_bytes(whole.read_bytes()[:kept])
        made = converted(bag, tmp_path / "made.rrd")
        assert any(chunk.entity_path == "/tf" for chunk in chunks(made, "/**"))
    monkeypatch.setattr(viewer, "has_screen", lambda: True)
    monkeypatch.setattr(os, "execve", lambda program, words, _: opened.append(words[-1]))
    opened, told = [], []
    viewer.open_in_viewer(bag, web=False, say=told.append)
    assert told == [f"{bag}: the end is missing; what is whole is shown"]
    assert opened[0].endswith(".rrd")
    bag.write_bytes(b"\x89MCAP0\r\nnothing")
    assert "cannot be read" in call("view", bag, "--web")[2]
    bag.write_bytes(b"")
    code, _, err = call("view", bag, "--web")
    assert (code, "is no MCAP file, or an empty one" in err) == (2, True)


def test_physics_of_another_engine_is_refused_in_one_line(monkeypatch):
    mujoco = pytest.importorskip("mujoco")
    monkeypatch.setattr(mujoco, "__version__", "3.17.0")
    with pytest.raises(WorldError, match=r"3\.17\.0 of mujoco-core 4\.0\.\d") as refused:
        simulator("physics")
    assert "\n" not in str(refused.value)
