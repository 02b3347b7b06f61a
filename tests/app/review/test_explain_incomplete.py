"""Runs whose log is incomplete: `explain` uses what there is."""

import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import pytest

from app.core.disk import Disk
from app.core.events import EventLog
from app.core.outcome import End, Outcome
from app.review import DamagedRunError, explain
from trees.language import nodes_in_order
from trees.language.composites import Sequence

TASK = """\
task: toy
poses:
  far: {xyz: [-40.0, 0.0, 0.7], rpy_deg: [180, 0, 0]}
tree:
  sequence:
    - wait: {duration_s: 0.1}
    - navigate: {to: far}
"""


def test_a_run_whose_process_was_killed(tmp_path):
    task = tmp_path / "toy.yaml"
    task.write_text(TASK)
    command = [sys.executable, "-m", "frankie_task_cli", "run", task, "--record", tmp_path / "runs"]
    process = subprocess.Popen(
        [*map(str, command), "--speed", "real", "--view", "none"],
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])},
    )
    try:
        deadline = time.monotonic() + 60.0
        log = ""
        while '"now", "time": 1' not in log and time.monotonic() < deadline:
            time.sleep(0.1)
            log = "".join(p.read_text() for p in tmp_path.glob("runs/*/events.jsonl"))
    finally:
        process.kill()
        process.wait()
    (folder,) = (tmp_path / "runs").iterdir()
    with (folder / "events.jsonl").open("a") as file:
        file.write('{"event": "node", "ti')  # a line that the kill cut off
    told = explain(folder)
    assert told.outcome == "unfinished"
    assert told.node.name == "navigate"
    assert told.time >= 1.0
    assert "was killed" in str(told)


def test_a_folder_without_events_is_refused(tmp_path):
    with pytest.raises(DamagedRunError, match=r"events\.jsonl"):
        explain(tmp_path)


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
