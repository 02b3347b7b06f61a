"""`explain --html`: one file, with everything in it, that asks nobody for anything."""

import re
from html.parser import HTMLParser

import pytest
from typer.testing import CliRunner

from app.commands import app
from app.core import RunOptions, ScheduledFault, run_task

TASK = """\
task: fetch <b>bold</b>
poses:
  above: {xyz: [2.935, 0.0, 0.85], rpy_deg: [180, 0, 0]}
regions:
  container: {centre: [3.0, 0.0, 0.556], size: [0.44, 0.36, 0.20]}
tree:
  retry: 2
  sequence:
    - navigate: {to: above}
    - grasp: {within: container}
"""


class Page(HTMLParser):
    """Notes tags and whatever a browser would load."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.loaded: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.loaded += [value for name, value in attrs if name in ("src", "href", "data")]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    task = folder / "fetch.yaml"
    task.write_text(TASK.replace("fetch <b>bold</b>", "fetch"))
    faults = (ScheduledFault(fault="gripper dead", at_s=0.5),)
    options = RunOptions(tree=task, scene="single", record=folder / "runs", faults=faults)
    return run_task(options).folder


def written(run, tmp_path) -> str:
    out = tmp_path / "why.html"
    result = CliRunner().invoke(app, ["explain", str(run), "--html", str(out)])
    assert result.exit_code == 0, result.output
    return out.read_text()


def test_the_page_has_cause_attempts_pictures_and_tree_and_asks_nobody(run, tmp_path):
    text = written(run, tmp_path)
    assert "The gripper does not work: grasp failed at " in text
    assert "What took the time" in text
    assert text.count("data:image/png;base64,") >= 2
    assert "<polyline points=" in text
    assert re.search(r'class="FAILURE here"> +✗ grasp  x2  the fingers did not move', text)
    page = Page(text)
    assert "script" not in page.tags
    assert all(one.startswith("data:") for one in page.loaded)
    assert not re.search(r"https?://|@import|url\(", text)


def test_only_what_failed_is_circled(run, tmp_path):
    failed = written(run, tmp_path)
    assert "circles: something failed" in failed
    task = tmp_path / "well.yaml"
    task.write_text("task: well\ntree: {drive: {forward_m: 0.2}}\n")
    options = RunOptions(tree=task, scene="single", record=tmp_path / "runs")
    well = written(run_task(options).folder, tmp_path)
    assert "<polyline points=" in well
    assert "<circle" not in well
    assert "something failed" not in well


def test_what_a_run_says_is_only_text_in_the_page(run, tmp_path):
    events = run / "events.jsonl"
    before = events.read_text()
    events.write_text(before.replace("the fingers did not move", "<img src=x onerror=alert(1)>"))
    try:
        text = written(run, tmp_path)
    finally:
        events.write_text(before)
    assert "&lt;img src=x onerror" in text
    assert all(one.startswith("data:") for one in Page(text).loaded)


def test_a_run_without_recording_has_a_page_without_pictures(run, tmp_path):
    recording = run / "recording.rrd"
    kept = recording.rename(run / "kept")
    try:
        text = written(run, tmp_path)
    finally:
        kept.rename(recording)
    assert "data:image/png" not in text
    assert "The gripper does not work" in text


def test_a_page_that_cannot_be_written_is_one_line(run, tmp_path):
    out = tmp_path / "missing" / "why.html"
    result = CliRunner().invoke(app, ["explain", str(run), "--html", str(out)])
    assert result.exit_code == 2
    assert "cannot be written" in result.output
