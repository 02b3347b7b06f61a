"""Runs on a computer that starts no more threads: the robot rests, and what is missing is told."""

import os
from types import SimpleNamespace

import pytest
from controlled_run import ControlledRun, leaf
from full_computer import full_computer
from rich.console import Console

from app.core.files.disk import Disk
from app.core.interrupts import leave
from app.core.outcome import End
from app.live import RunDisplay, RunInfo


def test_a_session_without_a_watchdog_does_not_begin(monkeypatch):
    run = ControlledRun(leaf(ticks=5))
    with full_computer(monkeypatch):
        outcome = run.run()
    assert outcome.end is End.HARDWARE
    assert "starts no more threads" in outcome.reason
    assert not run.harness.gate.applied.base_twist.any()


def test_the_second_signal_ends_the_process(monkeypatch):
    ended = []
    monkeypatch.setattr(os, "_exit", ended.append)
    with full_computer(monkeypatch):
        leave(lambda: None, 130, None)
    assert ended == [130]


def test_files_that_nobody_writes_are_told(monkeypatch, tmp_path):
    with full_computer(monkeypatch):
        disk = Disk(tmp_path, lossless=True)
    disk.file("log.txt").add(b"lost")
    (told,) = disk.close()
    assert "new thread" in told


def test_a_terminal_that_shows_nothing_spares_the_run(monkeypatch):
    info = RunInfo(task="t", description="", where="here", objects=0)
    nothing = SimpleNamespace(
        state=SimpleNamespace(faults=()), paused="", too_slow="", changed=False
    )
    with full_computer(monkeypatch):
        display = RunDisplay(info, (), console=Console(file=open(os.devnull, "w")))  # noqa: SIM115
    with display, pytest.raises(RuntimeError, match="new thread"):
        display.show(nothing)
