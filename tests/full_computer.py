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
        for name in ("start_new_thread", "start_joinable_thread"):  # before Python 3.13, and since
            patch.setattr(_thread, name, no_thread, raising=False)
            patch.setattr(threading, f"_{name}", no_thread, raising=False)
        patch.setattr(subprocess, "Popen", no_process)
        yield
