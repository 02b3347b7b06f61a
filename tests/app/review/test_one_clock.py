"""A run that was paused is told by one clock: the task's, with the pause beside it."""

import io
import json
import re

import numpy as np
import pytest
from rich.console import Console

from app.core import ScheduledFault
from app.core.launch import run_task
from app.core.run_options import RunOptions
from app.live import ControlOptions
from app.review import explain, read_log, read_run, runs_table
from app.task_time import in_words, task_time

TASK = """
task: toy
tree:
  sequence:
    - name: before
      wait: {duration_s: 0.5}
    - name: after
      wait: {duration_s: 0.5}
"""


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """A run that is paused for a second, in the middle of its second node."""
    folder = tmp_path_factory.mktemp("paused")
    (folder / "toy.yaml").write_text(TASK)
    options = RunOptions(
        tree=folder / "toy.yaml",
        scene="single",
        record=folder,
        recording=False,
        control=ControlOptions(acknowledge_after=1.0),
        faults=(ScheduledFault(fault="stale pose", at_s=0.7, for_s=0.1),),
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
    assert f"toy: success after {words} (" in str(explain(folder))
    out = io.StringIO()
    Console(file=out, width=120).print(runs_table([read_run(folder)]))
    assert words in out.getvalue()


def test_what_happened_is_told_by_that_clock_too(told):
    text = str(explain(told.folder))
    assert re.search(r"0\.\d\d s  ‖ paused ", text)
    assert re.search(r"0\.\d\d s  ▶ went on after a pause of \d+ s", text)
    assert re.search(r" 1\.[012]\d s  ✔ after: waited", text)


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
