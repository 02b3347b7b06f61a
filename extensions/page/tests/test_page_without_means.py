"""Stop is heard, and the rest refused, where no thread, file or process can be started."""

import errno
import http.client
import os
import signal
import socket
import subprocess
import threading
from collections.abc import Callable

import pytest
from sample_run import TREE, moment

from app.choices import View
from app.live import Control
from extensions.page.control_page import ControlPage
from extensions.page.desk import TaskDesk
from extensions.page.observer import PageError, RunPage
from extensions.page.run_process import RunProcess
from extensions.page.server import PageServer


def refuse_threads(*_: object) -> None:
    """Fail as under a limit of processes or of memory."""
    raise RuntimeError("can't start new thread")


@pytest.fixture
def control():
    return Control()


@pytest.fixture
def server(control):
    with PageServer() as server:
        server.serve(ControlPage(control, TREE))
        server.page.show(moment(0))
        yield server


def asked(server: PageServer, method: str, path: str, over: socket.socket | None = None) -> int:
    """The status of the answer, on a connection of the caller if it is given."""
    client = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60.0)
    if over is not None:
        over.connect(("127.0.0.1", server.port))
        client.sock = over
    client.request(method, path, headers={"X-Token": server.token})
    try:
        return client.getresponse().status
    finally:
        client.close()


def test_stop_needs_no_thread(server, control, monkeypatch):
    monkeypatch.setattr(threading.Thread, "start", refuse_threads)
    assert asked(server, "POST", "/pause") == 200
    assert control.state.paused
    assert asked(server, "POST", "/stop") == 200
    assert control.stopped


def test_an_error_while_the_log_is_made_leaves_the_server_alive(server, control, monkeypatch):
    monkeypatch.setattr(server.page, "catch_up", lambda: 1 / 0)
    assert asked(server, "GET", "/state") == 200
    assert asked(server, "POST", "/stop") == 200
    assert control.stopped


def test_a_page_that_cannot_have_its_thread_is_refused_in_words(monkeypatch):
    monkeypatch.setattr(threading.Thread, "start", refuse_threads)
    with pytest.raises(PageError, match="can't start new thread; choose"):
        PageServer()
    ours, theirs = socket.socketpair()
    with ours, pytest.raises(PageError, match="cannot be served"):
        RunPage(ControlPage(Control(), TREE), theirs, print)


def test_a_frozen_run_that_takes_no_more_buttons_holds_nothing_up():
    run = RunProcess("toy", ["--help"], print)
    try:
        run._process.send_signal(signal.SIGSTOP)
        taken = [run.act("/pause") for _ in range(5000)]
        assert taken[0]
        assert not taken[-1]
        run.stop()
    finally:
        run._process.kill()
        run.end()


def no_process(*_: object, **__: object) -> None:
    raise OSError(errno.EAGAIN, "Resource temporarily unavailable")


def no_file(*_: object, **__: object) -> None:
    raise OSError(errno.EMFILE, "Too many open files")


@pytest.mark.parametrize(
    ("where", "name", "fails"),
    [
        (subprocess, "Popen", no_process),
        (socket, "socketpair", no_file),
        (threading.Thread, "start", refuse_threads),
    ],
)
def test_a_run_that_cannot_be_started_is_refused_in_words_and_leaves_nothing(
    tmp_path, monkeypatch, where: object, name: str, fails: Callable[..., None]
):
    (tmp_path / "toy.yaml").write_text("task: toy\ntree:\n  wait: {duration_s: 1}\n")
    desk = TaskDesk(tmp_path, armed=False, view=View.NONE, say=print)
    with PageServer(desk=desk) as server:
        desk.server = server
        assert desk.post("/check", b'{"task": "toy.yaml"}') == {"mistakes": []}
        before = len(os.listdir("/proc/self/fd"))
        monkeypatch.setattr(where, name, fails)
        told = desk.post("/start", b'{"task": "toy.yaml"}')
        monkeypatch.undo()
        assert "nothing was started" in told["refused"]
        assert len(os.listdir("/proc/self/fd")) == before
        assert server.state()["phase"] == "idle"
        assert asked(server, "POST", "/stop") == 200
        assert desk.post("/again/0", b"") is None
