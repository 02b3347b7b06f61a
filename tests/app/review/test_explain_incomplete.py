"""Runs whose log is incomplete: `explain` uses what there is."""

import resource

import pytest

from app.core.disk import Disk
from app.core.events import EventLog
from app.core.outcome import End, Outcome
from app.review import DamagedRunError, explain
from trees.language import nodes_in_order
from trees.language.composites import Sequence


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
