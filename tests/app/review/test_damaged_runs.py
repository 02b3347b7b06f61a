"""Damaged folders of runs: nothing is executed.

What is whole is used, and what is lost is told; else each command says in a line what is wrong.
"""

import json
import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from bomb import Bomb
from command_line import call

from app.core import RunOptions, losses, run_task
from app.live.viewer.viewer import converted, open_in_viewer
from app.review import chunks

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


def cut(size: int) -> Damage:
    return lambda path: os.truncate(path, path.stat().st_size - size)


def first_half(path: Path) -> None:
    os.truncate(path, path.stat().st_size // 2)


def a_pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def a_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def lines(change: Callable[[list[str]], object]) -> Damage:
    """Changes the lines of the log."""

    def damage(path: Path) -> None:
        kept = path.read_text().splitlines()
        change(kept)
        path.write_text("\n".join([*kept, ""]), errors="surrogateescape")

    return damage


def line(number: int, **fields: object) -> Damage:
    """Changes fields of one line of the log."""

    def change(kept: list[str]) -> None:
        kept[number] = json.dumps(json.loads(kept[number]) | fields)

    return lines(change)


def array(make: Callable[[np.ndarray], np.ndarray]) -> Damage:
    return lambda path: np.save(path, make(np.load(path)))


def pickled(path: Path) -> None:
    np.save(path, np.array([Bomb(path.parent / "ran")] * 3, dtype=object), allow_pickle=True)


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
    "begin in the middle": lines(lambda kept: kept.insert(3, kept.pop(0))),
    "end in the middle": lines(lambda kept: kept.insert(3, kept.pop())),
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
    options = RunOptions(tree=root / "toy.yaml", scene="single", record=root, replayable=True)
    folder = run_task(options).folder
    assert list(losses(folder)) == []
    return folder


@pytest.fixture
def opened(monkeypatch):
    """What the viewer was started for; only the start is recorded."""
    started: list[str] = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(os, "execve", lambda program, words, _: started.append(words[-1]))
    return started


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


REFUSED = [
    ("explain", EVENTS, EVENT_DAMAGE),
    ("view", "recording.rrd", ANY_FILE),
    ("replay", "options.json", ANY_FILE),
    ("replay", "readings.npy", ANY_FILE),
    # An empty one is that of a run that was killed at once.
    ("replay", "readings.jsonl", {kind: ANY_FILE[kind] for kind in ANY_FILE if kind != "empty"}),
    ("export", STATES, ARRAY_DAMAGE),
]


@pytest.mark.parametrize(("command", "file", "damages"), REFUSED)
def test_what_no_run_writes_is_refused(run, tmp_path, opened, command, file, damages):
    more = ("--lerobot", tmp_path / "out") if command == "export" else ()
    for kind, damage in damages.items():
        folder = damaged(run, tmp_path, file, damage)
        told = refusal(command, folder, *more)
        assert command == "export" or file.partition(".")[0] in told, kind
        assert not (folder / "ran").exists(), kind
    assert not (tmp_path / "out").exists()
    assert opened == []


@pytest.mark.parametrize("kept", ['{"event": "node", "ti', "\0" * 500, "\ufffd\udc80"])
def test_explain_leaves_out_what_a_kill_or_a_full_disk_cut_off(run, tmp_path, kept):
    damage = lines(lambda log: log.__setitem__(2, kept))
    code, out, _ = call("explain", damaged(run, tmp_path, EVENTS, damage))
    assert code == 0
    assert "lines that cannot be read, left out here: 1" in out


def test_explain_passes_over_what_a_later_version_writes(run, tmp_path):
    def later(log: list[str]) -> None:
        log[0] = log[0].replace('"task"', '"more": [1], "task"')
        log.insert(1, '{"event": "weather", "time": "noon", "sun": true}')

    expected = call("explain", run)[1]
    assert call("explain", damaged(run, tmp_path, EVENTS, lines(later)))[1] == expected


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


def test_export_does_without_the_task_file(run, tmp_path):
    for number, (kind, damage) in enumerate(ANY_FILE.items()):
        folder = damaged(run, tmp_path, "task.yaml", damage)
        (folder / "frames.arrow").unlink()  # of which a video would be made
        if kind != "a pipe":
            out = tmp_path / f"out{number}"
            assert call("export", folder, "--lerobot", out)[0] == 0, kind


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


@pytest.mark.parametrize("size", [1, 15, 1000])
def test_a_recording_loses_its_last_message(run, tmp_path, size):
    folder = damaged(run, tmp_path, "recording.rrd", cut(size))
    code, _, err = call("mcap", folder, tmp_path / "run.mcap")
    assert code == 0, err
    assert "recording.rrd: the last message is cut off" in err
    assert (tmp_path / "run.mcap").stat().st_size > 10_000


@pytest.mark.parametrize("name", ["readings.jsonl", "readings.npy"])
def test_readings_lose_their_end(run, tmp_path, name):
    code, out, err = call("replay", damaged(run, tmp_path, name, cut(30)))
    assert code == 0, out + err
    assert "are identical, bit for bit; the recording was cut off there" in out
    assert name in err


def test_the_motion_and_the_events_lose_their_end(run, tmp_path):
    folder = damaged(run, tmp_path, STATES, cut(50))
    for name in ("commands.npy", EVENTS):
        cut(50)(folder / name)
    code, _, err = call("mcap", folder, tmp_path / "run.mcap")
    assert code == 0, err
    assert "states.npy: the end is cut off: 1 rows are missing" in err
    assert "events.jsonl: the last line is cut off" in call("explain", folder)[2]


def test_a_file_without_its_end_is_shown_and_an_empty_one_is_named(run, tmp_path, opened):
    whole, bag = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    assert call("mcap", run, whole)[0] == 0
    for kept in (whole.stat().st_size - 8, whole.stat().st_size * 3 // 4):
        bag.write_bytes(whole.read_bytes()[:kept])
        made = converted(bag, tmp_path / "made.rrd")
        assert any(chunk.entity_path == "/tf" for chunk in chunks(made, "/**"))
    told: list[str] = []
    open_in_viewer(bag, web=False, say=told.append)
    assert call("view", damaged(run, tmp_path, "recording.rrd", first_half))[0] == 0
    assert told == [f"{bag}: the end is missing; what is whole is shown"]
    assert [path.endswith(".rrd") for path in opened] == [True, True]
    for content, said in ((b"\x89MCAP0\r\nnothing", "cannot be read"), (b"", "or an empty one")):
        bag.write_bytes(content)
        code, _, err = call("view", bag, "--web")
        assert (code, said in err) == (2, True)
