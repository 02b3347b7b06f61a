"""A run tells once who failed of those that watch it, and what the robot has hit."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import robots
from app.core import Instruments, RunOptions, run_task
from app.core.outcome import End
from app.core.run import Watchers

WATCHERS = {
    "the terminal": "app.live.run_display.RunDisplay.show",
    "the controls": "app.live.operator_console.OperatorConsole.show",
    "the recording": "app.live.monitor.recorder.Recorder.record",
}


def test_watchers_that_raise_end_nothing_and_are_told_once(tmp_path, monkeypatch):
    task, calls = tmp_path / "toy.yaml", []
    task.write_text("task: toy\ntree: {wait: {duration_s: 0.3}}\n")

    def failing(*_: object, **__: object) -> None:
        calls.append(1)
        raise OSError(28, "disk full")

    class Broken(Instruments):
        after = failing

    for method in WATCHERS.values():
        monkeypatch.setattr(method, failing)
    options = RunOptions(tree=task, record=tmp_path / "runs", scene="single", shown=True)
    result = run_task(options, instruments=Broken())
    assert result.outcome.end is End.SUCCESS
    assert len(calls) == 4
    told = [warning.partition(" ended early")[0] for warning in result.summary.warnings]
    assert sorted(told) == sorted([*WATCHERS, "the instruments"])


@pytest.mark.parametrize(
    "error", [BrokenPipeError(32, "broken pipe"), KeyboardInterrupt(), SystemExit]
)
def test_one_that_fails_does_not_keep_the_others_from_being_told(error):
    watchers, told = Watchers(), []

    def fail() -> None:
        raise error

    for _ in range(3):
        watchers.tell("one", fail)
        watchers.tell("two", lambda: told.append(1))
    assert len(told) == 3
    assert len(watchers.failures) == 1


SCENE = """\
container: {centre: [3.0, 0.0]}
table: {centre: [0.0, 1.6]}
objects: {count: 0}
walkers:
  - {name: Ada, radius: 0.2, way: [[-0.5, -1.5], [-0.5, 1.5]], speed: 1.0}
"""


def test_contacts_are_counted_by_name_and_shown(tmp_path):
    task, scene = tmp_path / "stand.yaml", tmp_path / "scene.yaml"
    task.write_text("task: stand\ntree: {wait: {duration_s: 2}}\n")
    for text, hits in ((SCENE, 1), (SCENE.partition("walkers:")[0], 0)):
        scene.write_text(text)
        options = RunOptions(tree=task, scene=str(scene), record=tmp_path, recording=False)
        summary = run_task(options).summary
        console = Console(record=True, width=120)
        summary.show(console)
        assert summary.contacts == sum(summary.contacts_by_name.values())
        assert summary.contacts_by_name.get("the base hit Ada", 0) == hits
        assert ("the base hit Ada" in console.export_text()) == bool(hits)


def test_the_ready_posture_is_that_of_the_robot(tmp_path: Path) -> None:
    task, mine = tmp_path / "fold.yaml", tmp_path / "mine"
    task.write_text("task: fold\ntree: {recover: {arm: ready}}\n")
    shutil.copytree(Path(robots.__file__).parent, mine)
    arm = mine / "parts" / "panda.yaml"
    usual, other = "[0.0, -0.3, 0.0, -2.2,", "[0.0, -0.5, 0.0, -2.4,"
    assert usual in arm.read_text()
    arm.write_text(arm.read_text().replace(usual, other))
    robot = str(mine / "frankie.yaml")
    result = run_task(RunOptions(tree=task, robot=robot, scene="single", record=tmp_path / "runs"))
    assert result.outcome.end.exit_code == 0
    q = np.load(result.folder / "states.npy")[-1, 7:14]
    np.testing.assert_allclose(q[[1, 3]], [-0.5, -2.4], atol=0.02)
    assert result.summary.robot == "frankie"
