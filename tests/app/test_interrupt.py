"""Ctrl-C ends the waiting, whichever thread the system gives the signal to."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ELSEWHERE = """
import signal, threading, time
from app.interrupt import until_interrupted

def interrupt():
    time.sleep(0.3)
    signal.pthread_kill(threading.get_ident(), signal.SIGINT)

threading.Thread(target=interrupt).start()
until_interrupted()
print("over")
"""


def test_a_signal_that_another_thread_receives_ends_it() -> None:
    folder = Path(__file__).parents[2]
    command = [sys.executable, "-c", ELSEWHERE]
    ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=30.0)
    assert ended.stdout == "over\n", ended.stderr
