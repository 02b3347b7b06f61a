"""Damaged folders of runs: every command says in a line what is wrong, and nothing is executed."""

import json
import os
import resource
import stat
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

import pytest
from command_line import call
from run_damage import (
    ANY_FILE,
    ARRAY_DAMAGE,
    EVENT_DAMAGE,
    EVENTS,
    STATES,
    STATES_DAMAGE,
    SUMMARY,
    SUMMARY_DAMAGE,
    damaged,
    first_half,
    raw_line,
)

from app.core.files.disk import Disk
from app.core.files.events import EventLog
from app.core.launch import run_task
from app.core.outcome import End, Outcome
from app.core.run_options import RunOptions
from app.review import explain
from trees.language import nodes_in_order
from trees.language.composites import Sequence

TASK = """\
task: toy
description: Go near.
poses:
  near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}
tree:
  sequence:
    - wait: {duration_s: 0.1}
    - navigate: {to: near, timeout_s: 0.3}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run that really failed."""
    root = tmp_path_factory.mktemp("recorded")
    (root / "toy.yaml").write_text(TASK)
    return run_task(RunOptions(tree=root / "toy.yaml", scene="single", record=root)).folder


def refusal(*arguments: object) -> str:
    """The one line with which a command refuses."""
    code, out, err = call(*arguments)
    assert (code, out) == (2, ""), (out, err)
    assert err.count("\n") == 1
    assert len(err) < 600 + sum(len(str(argument)) for argument in arguments)
    assert "; " in err  # what is wrong, and a hint
    return err


def test_explain_refuses_a_log_that_no_run_writes(run, tmp_path):
    for kind, damage in EVENT_DAMAGE.items():
        folder = damaged(run, tmp_path, EVENTS, damage)
        assert f"{folder.name}/{EVENTS}" in refusal("explain", folder), kind


@pytest.mark.parametrize(
    ("damage", "left_out"),
    [
        (raw_line(2, '{"event": "node", "ti'), 1),
        (raw_line(2, "\0" * 500), 1),
        (lambda path: path.write_bytes(path.read_bytes().replace(b"waited", b"w\xffited")), 1),
        (lambda path: path.write_bytes(path.read_bytes()[:-20]), 0),
    ],
)
def test_explain_leaves_out_what_a_kill_or_a_full_disk_cut_off(run, tmp_path, damage, left_out):
    code, out, _ = call("explain", damaged(run, tmp_path, EVENTS, damage))
    assert code == 0
    assert out.startswith("toy: ")
    assert ("lines that cannot be read, left out here: 1" in out) == bool(left_out)


def test_explain_passes_over_what_a_later_version_writes(run, tmp_path):
    def add(path: Path) -> None:
        first, *others = path.read_text().splitlines(keepends=True)
        later = '{"event": "weather", "time": "noon", "sun": true}\n'
        path.write_text(first.replace('"task"', '"more": [1], "task"') + later + "".join(others))

    expected = call("explain", run)[1]
    assert call("explain", damaged(run, tmp_path, EVENTS, add))[1] == expected


def test_explain_does_without_a_summary_and_runs_says_that_it_is_damaged(run, tmp_path):
    for kind, damage in SUMMARY_DAMAGE.items():
        folder = damaged(run, tmp_path, SUMMARY, damage)
        code, out, _ = call("explain", folder)
        assert code == 0, kind
        assert "navigate failed at" in out, kind
        assert out.splitlines()[-1].startswith(f"{SUMMARY}: "), kind
        code, out, err = call("runs", tmp_path)
        (row,) = out.splitlines()[1:]
        assert (code, "damaged" in row) == (0, True), kind
        assert err.startswith(f"{folder}: {SUMMARY}: "), kind
        assert err.count("\n") == 1, kind
    (entry,) = json.loads(call("runs", tmp_path, "--json")[1])
    assert entry["outcome"] == "damaged"
    assert entry["damage"].startswith(f"{SUMMARY}: ")


def test_a_run_without_a_summary_is_unfinished(run, tmp_path):
    damaged(run, tmp_path, SUMMARY, Path.unlink)
    assert "unfinished" in call("runs", tmp_path)[1]


@pytest.mark.parametrize(
    ("file", "damages"), [(STATES, STATES_DAMAGE), ("commands.npy", ARRAY_DAMAGE)]
)
def test_export_refuses_arrays_that_no_run_writes(run, tmp_path, file, damages):
    for kind, damage in damages.items():
        folder = damaged(run, tmp_path, file, damage)
        refusal("export", folder, "--lerobot", tmp_path / "out")
        assert not (tmp_path / "out").exists(), kind
        assert not (folder / "ran").exists(), kind


def test_export_does_without_the_task_file(run, tmp_path):
    for number, (kind, damage) in enumerate(ANY_FILE.items()):
        folder = damaged(run, tmp_path, "task.yaml", damage)
        if kind != "a pipe":
            out = tmp_path / f"out{number}"
            assert call("export", folder, "--lerobot", out)[0] == 0, kind


def test_view_refuses_what_is_no_recording(run, tmp_path, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":0")
    for kind, damage in ANY_FILE.items():
        folder = damaged(run, tmp_path, "recording.rrd", damage)
        assert "recording" in refusal("view", folder), kind


def test_view_opens_what_a_killed_run_leaves(run, tmp_path, monkeypatch):
    started = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(
        "app.live.viewer.open_recording.os.execve",
        lambda program, command, environment: started.append(command),
    )
    assert call("view", damaged(run, tmp_path, "recording.rrd", first_half))[0] == 0
    assert started


@pytest.mark.parametrize("file", ["options.json", "readings.jsonl", "readings.npy"])
def test_replay_refuses_what_no_run_writes(run, tmp_path, file):
    for kind, damage in ANY_FILE.items():
        folder = damaged(run, tmp_path, file, damage)
        if (file, kind) == ("readings.jsonl", "empty"):  # as of a run that was killed at once
            assert "cut off" in call("replay", folder)[1]
        else:
            assert refusal("replay", folder).startswith(f"{folder}/{file}: "), kind


def test_a_full_disk_ends_the_log_and_not_the_run(tmp_path):
    nodes = nodes_in_order(Sequence("sequence", []))
    disk = Disk(tmp_path, lossless=True)
    log = EventLog(disk.file("events.jsonl"), "toy", nodes)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (200, limits[1]))
    try:
        log.end(Outcome(end=End.SUCCESS, reason="done"), 1.0)
        log.end(Outcome(end=End.SUCCESS, reason="done"), 1.0)
        wrong = disk.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert wrong == ["events.jsonl ends early (File too large)"]
    assert explain(tmp_path).history == []  # the rest can still be read


def test_folders_that_are_no_runs(run, tmp_path):
    empty = tmp_path / "2026-01-01-000000-empty"
    empty.mkdir()
    assert EVENTS in refusal("explain", empty)
    assert "recording" in refusal("view", empty)
    refusal("export", empty, "--lerobot", tmp_path / "out")
    assert "unfinished" in call("runs", tmp_path)[1]
    (tmp_path / "only").mkdir()
    (tmp_path / "only" / "recording.rrd").write_bytes(b"RRF2")
    assert call("runs", tmp_path)[0] == 0
    for name in ("x" * 5000, "a\0b", "/dev/null", "/proc/self/mem", "", str(empty / EVENTS)):
        for command in ("explain", "view"):
            refusal(command, name, "--runs", tmp_path / "nowhere")
        assert call("runs", name)[0] == 2


@contextmanager
def forbidden(path: Path):
    """Nobody may read a file or look into a folder, for a while; root neither."""
    mode, user = path.stat().st_mode, os.geteuid()
    path.chmod(0)
    if user == 0:
        os.seteuid(65534)
    try:
        yield
    finally:
        if user == 0:
            os.seteuid(0)
        path.chmod(stat.S_IMODE(mode))


@pytest.mark.skipif(sys.platform == "win32", reason="permissions of another kind")
def test_without_permission(run):
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        root.chmod(0o755)
        folder = damaged(run, root, SUMMARY, lambda path: None)
        for one in folder.iterdir():
            one.chmod(0o644)
        with forbidden(folder / EVENTS):
            assert "Permission denied" in refusal("explain", folder)
        with forbidden(folder / SUMMARY):
            assert "damaged" in call("runs", root)[1]
            assert "Permission denied" in call("explain", folder)[1]
        with forbidden(folder / STATES):
            assert "Permission denied" in refusal("export", folder, "--lerobot", root / "out")
        with forbidden(folder / "recording.rrd"):
            assert "Permission denied" in refusal("view", folder)
        with forbidden(folder):
            refusal("explain", folder)
            refusal("view", folder)
            assert call("runs", root)[0] == 0
        with forbidden(root):
            assert call("runs", root)[0] == 2
