"""Keys in a real pseudo-terminal: they control the run, and the terminal is given back."""

import os
import pty
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest

from app.live.operator import Control, keys

FOLDER = Path(__file__).parents[3]


def wait_for(condition) -> None:
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_keys_pause_step_go_on_and_stop_and_the_terminal_is_given_back(monkeypatch):
    person, terminal = pty.openpty()
    monkeypatch.setattr("app.live.operator.keyboard.in_terminal", lambda file: True)
    before = termios.tcgetattr(terminal)
    control = Control()
    with keys(control, terminal) as listening:
        assert listening
        assert not termios.tcgetattr(terminal)[3] & (termios.ECHO | termios.ICANON)
        os.write(person, b" ")
        wait_for(lambda: control.state.paused)
        os.write(person, b"x")  # means nothing
        os.write(person, b"s")
        wait_for(control.take_turn)
        assert not control.take_turn()
        os.write(person, b" ")  # never resumes
        os.write(person, b"s")
        wait_for(control.take_turn)
        assert control.state.paused
        os.write(person, b"r")
        wait_for(lambda: not control.state.paused)
        os.write(person, b"q")
        wait_for(lambda: control.stopped)
    assert termios.tcgetattr(terminal) == before
    with pytest.raises(RuntimeError), keys(control, terminal):
        raise RuntimeError("the run breaks")
    assert termios.tcgetattr(terminal) == before
    os.close(person)
    os.close(terminal)


@pytest.mark.slow
def test_q_in_a_terminal_ends_a_run_as_interrupted_and_restores_the_terminal(tmp_path):
    """The whole command, in a terminal of its own."""
    task = tmp_path / "toy.yaml"
    task.write_text("task: toy\ntree:\n  wait: {duration_s: 80000}\n")
    person, terminal = pty.openpty()
    before = termios.tcgetattr(terminal)
    code = (
        "import fcntl, os, sys, termios\n"
        "os.setsid()\n"
        "fcntl.ioctl(0, termios.TIOCSCTTY, 0)\n"
        "from app.commands import main\n"
        "main()\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, "run", task, "--record", tmp_path, "--speed", "real"],
        stdin=terminal,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(FOLDER)},
        pass_fds=(terminal,),
    )
    try:
        deadline = time.monotonic() + 60.0
        while not list(tmp_path.glob("*/events.jsonl")) and time.monotonic() < deadline:
            time.sleep(0.1)
        os.write(person, b"q")
        _, err = process.communicate(timeout=60.0)
    finally:
        process.kill()
    assert process.returncode == 130
    assert "space: pause" in err
    assert termios.tcgetattr(terminal) == before
    os.close(person)
    os.close(terminal)
