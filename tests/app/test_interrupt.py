"""Ctrl-C ends the waiting, whichever thread the system gives the signal to."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ELSEWHERE = """
import signal, threading, time
from app.terminal import until_interrupted

def interrupt():
    time.sleep(0.3)
    signal.pthread_kill(threading.get_ident(), signal.SIGINT)

threading.Thread(target=interrupt).start()
with until_interrupted():
    pass
print("over")
"""
AT_ONCE = """
import signal
from app.terminal import until_interrupted

with until_interrupted():
    signal.raise_signal(signal.SIGINT)
    print("not reached")
print("over")
"""


@pytest.mark.parametrize("script", [ELSEWHERE, AT_ONCE])
def test_it_ends_whoever_receives_the_signal_and_whenever(script: str) -> None:
    folder = Path(__file__).parents[2]
    command = [sys.executable, "-c", script]
    ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=30.0)
    assert ended.stdout == "over\n", ended.stderr
