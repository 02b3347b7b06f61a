"""The commands about runs that are over, on runs that were really recorded."""

import json
import os
import shutil

import pytest
from command_line import call

from app.core.launch import run_task
from app.core.run_options import RunOptions
from app.review import find_run, run_folders
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
    names = [row.split()[0] for row in rows]
    assert [find_run(name).name for name in names] == [path.name for path in run_folders(runs)]
    assert "good" in names[0]


def test_objects_are_told_of_a_run_that_has_handled_some(tmp_path):
    for name, told in (("pick", {"attempts": 2}), ("look", {"attempts": 0})):
        folder = tmp_path / f"2999-01-01-000000-{name}"
        folder.mkdir()
        summary = {"outcome": "success", "placed": 0, "objects": 10, "claimed": 0, **told}
        (folder / "summary.json").write_text(json.dumps(summary))
    look, pick = sorted(call("runs", tmp_path)[1].splitlines()[1:])
    assert "0 of 10" in pick
    assert "of 10" not in look


def test_a_run_is_found_by_all_its_names(runs):
    bad = run_folders(runs)[1]
    for name in (str(bad), str(bad / "recording.rrd"), str(bad / "summary.json"), bad.name):
        assert find_run(name, runs) == bad
    assert find_run("last", runs).name.endswith("-killed")
    with pytest.raises(UserError, match="no such run"):
        find_run("nothing", runs)
    with pytest.raises(UserError, match="no such run"):
        find_run("notes", runs)


def test_explain_on_the_command_line(runs):
    code, out, _ = call("explain", run_folders(runs)[1].name, "--runs", runs)
    assert code == 0
    assert out.startswith("bad: failure after")
    assert "empty hand (holding_object) failed at 0.00 s" in out


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
    monkeypatch.setattr(
        "app.live.viewer.viewer.os.execve",
        lambda program, command, environment: started.append(command),
    )
    for name in (run_folders(runs)[0].name, run_folders(runs)[0] / "recording.rrd"):
        assert call("view", name, "--runs", runs)[0] == 0
    for command in started:
        assert os.access(command[0], os.X_OK)
        assert command[command.index("--bind") + 1] == "127.0.0.1"
        assert command[-1].endswith("recording.rrd")
