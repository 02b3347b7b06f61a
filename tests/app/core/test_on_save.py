"""`run --watch`: a save brings the robot to rest and starts the task anew."""

from __future__ import annotations

import os
import signal
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from app.core import End, Result, RunOptions, run_on_save, saved_since

FAR = "{xyz: [-40.0, 0.0, 0.7], rpy_deg: [180, 0, 0]}"
DRIVE = f"task: drive\nposes: {{far: {FAR}}}\ntree: {{navigate: {{to: far}}}}\n"
WAIT = "task: pause\ntree: {subtree: {file: part.yaml}}\n"
PART = "task: part\ntree: {wait: {duration_s: 0.05}}\n"


@pytest.mark.parametrize(
    "change",
    [
        lambda path: path.write_text("longer than before"),
        lambda path: path.unlink(),
        lambda path: os.utime(path, (1, 1)),
        lambda path: path.with_suffix(".new").rename(path),
    ],
    ids=["written", "removed", "touched", "replaced"],
)
def test_every_way_to_save_is_noticed(tmp_path, change):
    path = tmp_path / "t.yaml"
    path.write_text("text")
    path.with_suffix(".new").write_text("text of an editor that renames")
    saved = saved_since([path, tmp_path / "other.yaml"])
    assert not saved()
    change(path)
    assert saved()


def test_a_file_that_appears_is_noticed(tmp_path):
    saved = saved_since([tmp_path / "t.yaml"])
    (tmp_path / "t.yaml").write_text("text")
    assert saved()


class Author:
    """Saves the next version whenever the last one has been dealt with, and stops at the end."""

    def __init__(self, folder: Path) -> None:
        self.task, self.part, self.runs = folder / "t.yaml", folder / "part.yaml", folder / "runs"
        self.said: list[str] = []
        self.results: list[Result] = []

    def show(self, result: Result) -> str:
        self.results.append(result)
        if len(self.results) == 2:
            self.part.write_text(PART.replace("0.05", "0.06"))  # a file that the task includes
        return ""

    def say(self, text: str) -> None:
        self.said.append(text)
        if "open_gripper" in text:
            self.task.write_text(WAIT)
        elif len(self.results) == 3 and "Ctrl-C" in text:
            signal.raise_signal(signal.SIGINT)


@pytest.mark.usefixtures("interruptible")
def test_saves_restart_the_task_and_a_broken_one_is_waited_out(tmp_path, monkeypatch):
    author = Author(tmp_path)
    asked = count()

    def saved_on_the_way(paths):
        """Looks at the files as ever; a second into the first run, one has been saved."""
        saved = saved_since(paths)

        def look() -> bool:
            if next(asked) == 100:
                author.task.write_text("task: broken\ntree: {open_griper: }\n")
            return saved()

        return look

    monkeypatch.setattr("app.core.launch.saved_since", saved_on_the_way)
    author.task.write_text(DRIVE)
    author.part.write_text(PART)
    options = RunOptions(tree=author.task, scene="single", record=author.runs)
    last = run_on_save(options, finished=author.show, say=author.say)

    drive, pause, again = author.results
    assert drive.outcome.end is End.INTERRUPTED
    commands = np.load(drive.folder / "commands.npy")[:, 1:]
    assert np.abs(commands).max() > 0.05
    assert np.abs(commands[-1]).max() < 1e-3  # at rest before anything else happens
    starting, mistakes, *_ = author.said
    assert starting == f"{author.task}: saved, starts anew"
    assert mistakes.startswith(f"{author.task}:2:8: ")
    assert pause.outcome.end is again.outcome.end is End.SUCCESS
    assert again.summary.duration_s > pause.summary.duration_s
    assert last is again
    log = (again.folder / "tree.btlog").read_bytes()
    assert log.startswith(b"BTCPP4-FileLogger2\x01")
    assert b'name="wait"' in log
    assert log[-1] == 2  # the wait has succeeded
