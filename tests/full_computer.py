"""A computer without room."""

import _thread
import errno
import subprocess
import threading
from contextlib import contextmanager


@contextmanager
def full_computer(monkeypatch):
    """No thread starts, and no process."""

    def no_thread(*_, **__):
        raise RuntimeError("can't start new thread")

    def no_process(*_, **__):
        raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")

    with monkeypatch.context() as patch:
        patch.setattr(threading, "_start_new_thread", no_thread)
        patch.setattr(_thread, "start_new_thread", no_thread)
        patch.setattr(subprocess, "Popen", no_process)
        yield
