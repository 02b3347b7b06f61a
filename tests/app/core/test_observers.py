"""Those who watch a run fail on their own: the run goes on, and the summary tells it once."""

import pytest

from app.core import Instruments, RunOptions, run_task
from app.core.outcome import End
from app.core.run import Observers
from app.live import View, ViewOptions

WATCHERS = {
    "the terminal": "app.live.run_display.RunDisplay.update",
    "the controls": "app.live.console.OperatorConsole.show",
    "the recording": "app.live.monitor.recorder.Recorder.record",
}


@pytest.fixture
def options(tmp_path):
    task = tmp_path / "toy.yaml"
    task.write_text("task: toy\ntree: {wait: {duration_s: 0.3}}\n")
    view = ViewOptions(view=View.NONE)
    return RunOptions(tree=task, record=tmp_path / "runs", view=view, scene="single", shown=True)


def test_watchers_that_raise_end_nothing_and_are_told_once(options, monkeypatch):
    calls = []

    def failing(*_: object, **__: object) -> None:
        calls.append(1)
        raise OSError(28, "disk full")

    class Broken(Instruments):
        after = failing

    for method in WATCHERS.values():
        monkeypatch.setattr(method, failing)
    result = run_task(options, instruments=Broken())
    assert result.outcome.end is End.SUCCESS
    assert len(calls) == 4
    told = [warning.partition(" ended early")[0] for warning in result.summary.warnings]
    assert sorted(told) == sorted([*WATCHERS, "the instruments"])


@pytest.mark.parametrize(
    "error", [BrokenPipeError(32, "broken pipe"), KeyboardInterrupt(), SystemExit]
)
def test_one_that_fails_does_not_keep_the_others_from_being_told(error):
    observers, told = Observers(), []

    def fail() -> None:
        raise error

    for _ in range(3):
        observers.tell("one", fail)
        observers.tell("two", lambda: told.append(1))
    assert len(told) == 3
    assert len(observers.failures) == 1
