"""Stop is heard, and the rest refused, where no thread, file or process can be started."""

import errno
import http.client
import os
import resource
import signal
import socket
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from sample_run import TREE, moment

from app.choices import View
from app.live.operator import Control, ControlPage, PageError, PagePipe, PageServer, RunProcess
from app.live.web import http_server
from app.serve import TaskDesk
from config import UserError


def refuse_threads(*_: object) -> None:
    """Fail as under a limit of processes or of memory."""
    raise RuntimeError("can't start new thread")


@pytest.fixture
def control():
    return Control()


@pytest.fixture
def server(control):
    with PageServer() as server:
        server.serve(ControlPage(control, TREE, inject=print, clear=print))
        server.page.show(moment(0), changed=True)
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


def test_stop_needs_no_thread_and_the_room_of_a_refused_request_is_free_again(
    server, control, monkeypatch
):
    monkeypatch.setattr(http_server, "start_new_thread", refuse_threads)
    for _ in range(http_server.MOST_CONNECTIONS + 10):
        assert asked(server, "GET", "/state") == 503
    assert asked(server, "POST", "/pause") == 200
    assert control.state.paused
    assert asked(server, "POST", "/stop") == 200
    assert control.stopped
    monkeypatch.undo()
    assert asked(server, "GET", "/state") == 200


def test_stop_is_heard_when_all_threads_of_the_page_are_busy(server, control):
    for room in server._rooms.values():
        while room is not server._rooms["urgent"] and room.acquire(blocking=False):
            pass
    assert asked(server, "GET", "/state") == 503
    assert asked(server, "POST", "/resume") == 503
    assert asked(server, "POST", "/stop") == 200
    assert control.stopped


def test_an_error_while_the_log_is_made_leaves_the_server_alive(server, control, monkeypatch):
    monkeypatch.setattr(server.page, "catch_up", lambda: 1 / 0)
    assert asked(server, "GET", "/state") == 200
    assert asked(server, "POST", "/stop") == 200
    assert control.stopped


@contextmanager
def no_file_left() -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most, fillers = max(map(int, os.listdir("/proc/self/fd"))), [os.open(os.devnull, os.O_RDONLY)]
    while fillers[-1] <= most:
        fillers.append(os.open(os.devnull, os.O_RDONLY))
    limit = fillers[-1] + 1
    resource.setrlimit(resource.RLIMIT_NOFILE, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        for one in fillers:
            os.close(one)


def test_stop_needs_no_file_even_beside_others_who_ask(server, control):
    silent, reader, stopper, later = (socket.socket() for _ in range(4))
    with no_file_left():
        with pytest.raises(OSError, match="Too many open files"):
            os.dup(0)
        silent.connect(("127.0.0.1", server.port))
        assert asked(server, "GET", "/events", over=reader) == 503
        assert asked(server, "POST", "/stop", over=stopper) == 200
    assert control.stopped
    assert asked(server, "GET", "/state", over=later) == 200
    silent.close()


def test_a_page_that_cannot_have_its_thread_is_refused_in_words(monkeypatch):
    monkeypatch.setattr(threading.Thread, "start", refuse_threads)
    with pytest.raises(PageError, match="can't start new thread; choose"):
        PageServer()
    ours, theirs = socket.socketpair()
    with (
        ours,
        pytest.raises(UserError, match="cannot be served"),
        PagePipe(theirs.detach()) as pipe,
    ):
        pipe.serve(ControlPage(Control(), TREE, inject=print, clear=print))


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
