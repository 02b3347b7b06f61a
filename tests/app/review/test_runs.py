"""The commands about runs that are over, on runs that were really recorded."""

import json
import os
import re
import shutil

import numpy as np
import pytest
from command_line import call
from recorded_runs import faulty

from app.core.launch import run_task
from app.review import explain, find_run, read_log, run_folders
from app.run_options import RunOptions
from app.task_time import in_words, task_time
from config import UserError

GOOD = "task: good\ntree:\n  wait: {duration_s: 0.05}\n"
BAD = "task: bad\ntree:\n  name: empty hand\n  holding_object:\n"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two runs, one that failed, and what a killed process leaves."""
    root = tmp_path_factory.mktemp("recorded")
    for text in (GOOD, BAD):
        (root / "task.yaml").write_text(text)
        run_task(RunOptions(tree=root / "task.yaml", scene="single", record=root / "runs"))
    killed = root / "runs" / "2999-01-01-000000-killed"
    shutil.copytree(run_folders(root / "runs")[-1], killed)
    (killed / "summary.json").unlink()
    (root / "runs" / "notes").mkdir()
    return root / "runs"


def test_the_list_tells_task_outcome_and_node_oldest_first(runs):
    code, out, _ = call("runs", runs)
    assert code == 0
    rows = out.splitlines()[1:]
    assert [row.split()[1] for row in rows] == ["success", "failure", "unfinished"]
    assert "empty hand" in rows[1]
    assert " of " not in out, "tasks that handle nothing have placed nothing of nothing"


@pytest.mark.parametrize("here", [True, False])
def test_other_commands_take_the_names_that_the_list_prints(runs, monkeypatch, here):
    if here:
        monkeypatch.chdir(runs.parent)
    rows = call("runs", *([] if here else [runs]))[1].splitlines()[1:]
    found = [find_run(row.split()[0]) for row in rows]
    assert [path.name for path in found] == [path.name for path in run_folders(runs)]


def test_objects_are_told_of_a_run_that_has_handled_some(tmp_path):
    for name, attempts in (("pick", 2), ("look", 0)):
        folder = tmp_path / f"2999-01-01-000000-{name}"
        folder.mkdir()
        summary = {"outcome": "success", "placed": 0, "objects": 10, "claimed": 0}
        (folder / "summary.json").write_text(json.dumps(summary | {"attempts": attempts}))
    look, pick = sorted(call("runs", tmp_path)[1].splitlines()[1:])
    assert "0 of 10" in pick
    assert "of 10" not in look


def test_a_run_is_found_by_all_its_names(runs):
    bad = run_folders(runs)[1]
    for name in (str(bad), str(bad / "recording.rrd"), str(bad / "summary.json"), bad.name):
        assert find_run(name, runs) == bad
    assert find_run("last", runs).name.endswith("-killed")
    for name in ("nothing", "notes"):
        with pytest.raises(UserError, match="no such run"):
            find_run(name, runs)


@pytest.mark.parametrize("command", ["explain", "view", "export"])
def test_an_unknown_run_is_one_line_with_exit_code_2(runs, tmp_path, command):
    more = ["--lerobot", tmp_path / "out"] if command == "export" else []
    code, out, err = call(command, "nothing", "--runs", runs, *more)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert "`last`" in err


def test_a_window_needs_a_screen(runs, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    folder = run_folders(runs)[0]
    code, _, err = call("view", folder, "--runs", runs)
    assert (code, "--web" in err) == (2, True)


def test_view_opens_the_recording_on_loopback_alone(runs, monkeypatch):
    """What is started is the real viewer's command line; only the start is recorded."""
    started = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(os, "execve", lambda program, command, _: started.append(command))
    for name in (run_folders(runs)[0].name, run_folders(runs)[0] / "recording.rrd"):
        assert call("view", name, "--runs", runs)[0] == 0
        assert os.access(started[-1][0], os.X_OK)
        assert started[-1][started[-1].index("--bind") + 1] == "127.0.0.1"
        assert started[-1][-1].endswith("recording.rrd")


PAUSED = """
task: toy
tree:
  sequence: [{name: before, wait: {duration_s: 0.5}}, {name: after, wait: {duration_s: 0.5}}]
"""


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """A run that is paused for a second, in the middle of its second node."""
    folder = tmp_path_factory.mktemp("paused")
    (folder / "toy.yaml").write_text(PAUSED)
    options = RunOptions(
        tree=folder / "toy.yaml",
        scene="single",
        record=folder,
        recording=False,
        acknowledge_after=1.0,
        **faulty("stale pose@0.7 for 0.1"),
    )
    return run_task(options)


def test_every_place_says_the_same_time_and_the_same_pause(told):
    folder, summary = told.folder, told.summary
    assert 0.9 < summary.duration_s < 1.3
    assert summary.paused_s >= 1.0
    assert [in_words(s) for s in (59.9, 60.0, 3661.0)] == ["59 s", "1 min 0 s", "1 h 1 min 1 s"]
    words = task_time(summary.duration_s, summary.paused_s)
    assert re.fullmatch(r"1\.\d s, paused \d+ s", words)
    assert f"toy succeeded after {words}: " in summary.achieved
    assert words in call("runs", folder.parent)[1]
    text = str(explain(folder))
    assert f"toy: success after {words} (" in text
    assert re.search(r"0\.\d\d s  ‖ PAUSED ", text)
    assert re.search(r"0\.\d\d s  ▶ resumed", text)
    assert re.search(r" 1\.[012]\d s  ✔ after.*: waited", text)


def test_a_time_that_people_are_told_is_found_again_in_the_recording(told):
    log = read_log(told.folder)
    ((begin, end),) = log.pauses
    stamps = np.load(told.folder / "states.npy")[:, 0]
    for told_at, stamp in ((0.2, 0.2), (begin - log.began, begin), (1.0, 1.0 + end - begin)):
        assert log.session_time(told_at) - log.began == pytest.approx(stamp - log.began, abs=0.1)
        assert log.task_time(log.session_time(told_at)) == pytest.approx(told_at)
    assert stamps[0] <= log.session_time(1.0) <= stamps[-1] + 0.1
    events = (told.folder / "events.jsonl").read_text().splitlines()
    assert json.loads(events[-1])["time"] > 1.9, "the file keeps the session's clock, for programs"
