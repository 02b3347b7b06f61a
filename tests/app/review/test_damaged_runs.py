"""Damaged folders of runs: every command says in a line what is wrong, and nothing is executed."""

import json
import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from bomb import Bomb
from command_line import call

from app.core import RunOptions, run_task

Damage = Callable[[Path], object]
EVENTS, SUMMARY, STATES = "events.jsonl", "summary.json", "states.npy"
TASK = """\
task: toy
tree:
  sequence:
    - wait: {duration_s: 0.1}
    - drive: {forward_m: 9, timeout_s: 0.3}
"""


def replaced(content: bytes | str) -> Damage:
    data = content.encode() if isinstance(content, str) else content
    return lambda path: path.write_bytes(data)


def a_pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def a_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def line(number: int, **fields: object) -> Damage:
    """Changes fields of one line of the log."""

    def damage(path: Path) -> None:
        lines = path.read_text().splitlines()
        lines[number] = json.dumps(json.loads(lines[number]) | fields)
        path.write_text("\n".join(lines) + "\n")

    return damage


def moved(number: int, to: int) -> Damage:
    def damage(path: Path) -> None:
        lines = path.read_text().splitlines()
        lines.insert(to, lines.pop(number))
        path.write_text("\n".join(lines) + "\n")

    return damage


def array(make: Callable[[np.ndarray], np.ndarray]) -> Damage:
    return lambda path: np.save(path, make(np.load(path)))


def pickled(path: Path) -> None:
    np.save(path, np.array([Bomb(path.parent / "ran")] * 3, dtype=object), allow_pickle=True)


def first_half(path: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])


ANY_FILE: Mapping[str, Damage] = {
    "missing": Path.unlink,
    "empty": replaced(""),
    "random bytes": replaced(np.random.default_rng(0).bytes(5000)),
    "a folder": a_folder,
    "a pipe": a_pipe,
    "nested deep": replaced("[" * 100_000),
    "another program's": replaced('{"version": 3, "event": {"begin": []}}\n'),
}
EVENT_DAMAGE: Mapping[str, Damage] = {
    **ANY_FILE,
    "begin in the middle": moved(0, 3),
    "end in the middle": moved(-1, 3),
    "a node out of range": line(2, event="node", node=99, status="RUNNING", message=""),
    "a message that is a list": line(2, event="now", node=0, message=["a"]),
    "a time that is no number": line(3, time=float("nan")),
    "a value with 400 digits": line(-1, values={"goal distance [m]": 10**400}),
    "an unknown end": line(-1, outcome="glory"),
}
SUMMARY_DAMAGE: Mapping[str, Damage] = {
    **{name: damage for name, damage in ANY_FILE.items() if name != "missing"},
    "truncated": first_half,
    "no outcome": replaced("{}"),
    "a duration that is endless": replaced('{"outcome": "success", "duration_s": 1e999}'),
}
ARRAY_DAMAGE: Mapping[str, Damage] = {
    **{name: damage for name, damage in ANY_FILE.items() if "nested" not in name},
    "pickled code": pickled,
    "three columns": array(lambda a: a[:, :3]),
    "one tick": array(lambda a: a[:1]),
    "single precision": array(lambda a: a.astype(np.float32)),
    "not a number": array(lambda a: np.full_like(a, np.nan)),
    "a header of a petabyte": replaced(
        b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, "
        b"'shape': (9999999999999, 22), }".ljust(127)
        + b"\n"
    ),
    "stamps that stand still": array(lambda a: np.zeros_like(a)),
}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run that really failed."""
    root = tmp_path_factory.mktemp("recorded")
    (root / "toy.yaml").write_text(TASK)
    return run_task(RunOptions(tree=root / "toy.yaml", scene="single", record=root)).folder


def damaged(folder: Path, to: Path, file: str, damage: Damage) -> Path:
    """A copy of a run with one of its files damaged."""
    copy = to / folder.name
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(folder, copy)
    damage(copy / file)
    return copy


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


@pytest.mark.parametrize("cut", ['{"event": "node", "ti', "\0" * 500, "\ufffd\udc80"])
def test_explain_leaves_out_what_a_kill_or_a_full_disk_cut_off(run, tmp_path, cut):
    def damage(path: Path) -> None:
        lines = path.read_bytes().split(b"\n")
        lines[2] = cut.encode(errors="surrogateescape")
        path.write_bytes(b"\n".join(lines))

    code, out, _ = call("explain", damaged(run, tmp_path, EVENTS, damage))
    assert code == 0
    assert "lines that cannot be read, left out here: 1" in out


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
        assert "drive failed at" in out, kind
        assert out.splitlines()[-1].startswith(f"{SUMMARY}: "), kind
        code, out, err = call("runs", tmp_path)
        assert (code, "damaged" in out.splitlines()[1]) == (0, True), kind
        assert err.startswith(f"{folder}: {SUMMARY}: "), kind
        assert err.count("\n") == 1, kind


def test_export_refuses_arrays_that_no_run_writes(run, tmp_path):
    for kind, damage in ARRAY_DAMAGE.items():
        folder = damaged(run, tmp_path, STATES, damage)
        refusal("export", folder, "--lerobot", tmp_path / "out")
        assert not (tmp_path / "out").exists(), kind
        assert not (folder / "ran").exists(), kind


def test_export_does_without_the_task_file(run, tmp_path):
    for number, (kind, damage) in enumerate(ANY_FILE.items()):
        folder = damaged(run, tmp_path, "task.yaml", damage)
        if kind != "a pipe":
            out = tmp_path / f"out{number}"
            assert call("export", folder, "--lerobot", out)[0] == 0, kind


def test_view_opens_what_a_killed_run_leaves_and_refuses_what_is_no_recording(
    run, tmp_path, monkeypatch
):
    started = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(
        "app.live.viewer.viewer.os.execve",
        lambda program, command, environment: started.append(command),
    )
    for kind, damage in ANY_FILE.items():
        folder = damaged(run, tmp_path, "recording.rrd", damage)
        assert "recording" in refusal("view", folder), kind
    assert call("view", damaged(run, tmp_path, "recording.rrd", first_half))[0] == 0
    assert len(started) == 1


@pytest.mark.parametrize("file", ["options.json", "readings.jsonl", "readings.npy"])
def test_replay_refuses_what_no_run_writes(run, tmp_path, file):
    for kind, damage in ANY_FILE.items():
        folder = damaged(run, tmp_path, file, damage)
        if (file, kind) != ("readings.jsonl", "empty"):  # as of a run that was killed at once
            assert refusal("replay", folder).startswith(f"{folder}/{file}: "), kind


def test_folders_that_are_no_runs(tmp_path):
    empty = tmp_path / "2026-01-01-000000-empty"
    empty.mkdir()
    assert EVENTS in refusal("explain", empty)
    assert "recording" in refusal("view", empty)
    refusal("export", empty, "--lerobot", tmp_path / "out")
    assert "unfinished" in call("runs", tmp_path)[1]
    for name in ("x" * 5000, "a\0b", "/dev/null", "/proc/self/mem", "", str(empty / EVENTS)):
        refusal("explain", name, "--runs", tmp_path / "nowhere")
        assert call("runs", name)[0] == 2
