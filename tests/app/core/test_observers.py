"""Those who watch a run fail on their own: the run goes on, and the summary tells it once."""

import pytest

from app.core import Instruments, RunOptions, run_task
from app.core.observers import Observers
from app.core.outcome import End
from app.live import View, ViewOptions

WATCHERS = {
    "the terminal": "app.live.run_display.RunDisplay.update",
    "the controls": "app.live.console.OperatorConsole.show",
    "the recording": "app.live.monitor.recorder.Recorder.record",
    "what watches the run": "app.core.snapshots.Snapshots.of",
}


@pytest.fixture
def options(tmp_path):
    task = tmp_path / "toy.yaml"
    task.write_text("task: toy\ntree: {wait: {duration_s: 0.3}}\n")
    view = ViewOptions(view=View.NONE)
    return RunOptions(tree=task, record=tmp_path / "runs", view=view, scene="single", shown=True)


@pytest.mark.parametrize("name", WATCHERS)
def test_a_watcher_that_raises_ends_nothing_and_is_told_once(options, monkeypatch, name):
    calls = []

    def failing(*_: object, **__: object) -> None:
        calls.append(1)
        raise OSError(28, "disk full")

    monkeypatch.setattr(WATCHERS[name], failing)
    result = run_task(options)
    assert result.outcome.end is End.SUCCESS
    assert len(calls) == 1
    assert [w for w in result.summary.warnings if w.startswith(f"{name} ended early")]
    assert len(result.summary.warnings) == 1


def test_instruments_of_a_bench_are_watchers_too(options):
    class Broken(Instruments):
        def after(self, tick) -> None:
            raise RuntimeError("a mistake in the bench")

    result = run_task(options, instruments=Broken())
    assert result.outcome.end is End.SUCCESS
    assert result.summary.warnings == [
        "the instruments ended early (RuntimeError: a mistake in the bench)"
    ]


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
