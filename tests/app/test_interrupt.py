"""Ctrl-C ends the waiting, whichever thread the system gives the signal to."""

import signal
import threading

import pytest

from app.terminal import until_interrupted

pytestmark = [pytest.mark.realtime, pytest.mark.usefixtures("interruptible")]


def test_it_ends_whichever_thread_receives_the_signal() -> None:
    def interrupt() -> None:
        waiting.wait(60.0)
        signal.pthread_kill(threading.get_ident(), signal.SIGINT)

    waiting = threading.Event()
    thread = threading.Thread(target=interrupt)
    thread.start()
    with until_interrupted():
        waiting.set()
    thread.join()


def test_it_ends_at_once_if_the_signal_comes_before_the_waiting() -> None:
    reached = False
    with until_interrupted():
        signal.raise_signal(signal.SIGINT)
        reached = True
    assert not reached
