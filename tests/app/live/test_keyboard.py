"""Keys in a real pseudo-terminal: they control the run, and the terminal is given back."""

import os
import pty
import termios

import pytest
from waiting import until

from app.live.operator import Control, keys


def test_keys_pause_step_go_on_and_stop_and_the_terminal_is_given_back(monkeypatch):
    person, terminal = pty.openpty()
    monkeypatch.setattr("app.live.operator.keyboard.in_terminal", lambda file: True)
    before = termios.tcgetattr(terminal)
    control = Control()
    with keys(control, terminal) as listening:
        assert listening
        assert not termios.tcgetattr(terminal)[3] & (termios.ECHO | termios.ICANON)
        os.write(person, b" ")
        until(lambda: control.state.paused)
        os.write(person, b"x")  # means nothing
        os.write(person, b"s")
        until(control.take_turn)
        assert not control.take_turn()
        os.write(person, b" ")  # never resumes
        os.write(person, b"s")
        until(control.take_turn)
        assert control.state.paused
        os.write(person, b"r")
        until(lambda: not control.state.paused)
        os.write(person, b"q")
        until(lambda: control.stopped)
    assert termios.tcgetattr(terminal) == before
    with pytest.raises(RuntimeError), keys(control, terminal):
        raise RuntimeError("the run breaks")
    assert termios.tcgetattr(terminal) == before
    os.close(person)
    os.close(terminal)
