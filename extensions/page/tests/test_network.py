"""Nobody but this machine is called: by a run that is watched, by `view`, by the pages."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which
from urllib.request import urlopen

import pytest
import sample_run as samples
from browsers import FOLDER, WAITING
from recordings import record

from app.web import viewer_environment, viewer_program
from lab.film.headless_viewer import has_vulkan

_ADDRESS = re.compile(r'(?:inet_addr\("|inet_pton\(AF_INET6, ")([^"]+)"')
_HERE = ("127.", "::1", "::ffff:127.", "0.0.0.0", "::")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.usefixtures("interruptible"),
    pytest.mark.skipif(
        which("strace") is None, reason="no strace on this machine; on Debian: apt install strace"
    ),
]


def called(trace: Path) -> set[str]:
    """Addresses off this machine that a traced process and its children tried to reach."""
    found = set()
    for line in trace.read_text(errors="replace").splitlines():
        if re.search(r"\b(connect|sendto|sendmsg|sendmmsg)\(", line):
            found |= set(_ADDRESS.findall(line))
    return {address for address in found if not address.startswith(_HERE)}


def traced(trace: Path, *command: object) -> list[str]:
    calls = "trace=connect,sendto,sendmsg,sendmmsg"
    return [str(part) for part in ("strace", "-f", "-qq", "-e", calls, "-o", trace, *command)]


@contextmanager
def running(command: list[str]) -> Iterator[subprocess.Popen[str]]:
    """A process until the end of the context, then Ctrl-C for it and what it traces."""
    environment = os.environ | {"PYTHONPATH": str(FOLDER)}
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, env=environment, start_new_session=True
    ) as process:
        try:
            yield process
        finally:
            os.killpg(process.pid, signal.SIGINT)
            try:
                process.communicate(timeout=60.0)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                raise


def address_in(process: subprocess.Popen[str], word: str) -> str:
    for line in process.stderr:
        if found := re.search(rf"{word} (http://127\.0\.0\.1:\S+?)[;\s]", line + " "):
            return found[1]
    raise AssertionError(f"nothing said: {word}")


def test_the_trace_sees_a_call_that_goes_out(tmp_path: Path) -> None:
    out = "import socket; s = socket.socket(2, 2); s.connect(('203.0.113.7', 9))"
    subprocess.run(traced(tmp_path / "trace", sys.executable, "-c", out), check=False)
    assert called(tmp_path / "trace") == {"203.0.113.7"}


def test_a_run_with_viewer_and_page_calls_nobody(tmp_path: Path) -> None:
    (tmp_path / "toy.yaml").write_text(WAITING)
    options = ["--view", "web", "--with", "page", "--speed", "real", "--record", tmp_path]
    command = [sys.executable, "-m", "frankie_task_cli", "run", tmp_path / "toy.yaml", *options]
    with running(traced(tmp_path / "trace", *command)) as process:
        control = address_in(process, "control at").partition("#")[0]
        page = address_in(process, "watch at").partition("?")[0]
        for name in ("", "re_viewer.js"):
            assert urlopen(page + name, timeout=30.0).status == 200
        assert urlopen(control, timeout=30.0).status == 200
        time.sleep(1.0)
    assert called(tmp_path / "trace") == set()


@pytest.mark.skipif(not has_vulkan(), reason="the viewer needs Vulkan")
def test_the_native_viewer_calls_nobody(tmp_path: Path) -> None:
    recording = record(tmp_path / "recording.rrd", list(samples.run(20)))
    options = ["--headless", "--bind", "127.0.0.1", "--port", "0", "--window-size", "800x600"]
    command = traced(tmp_path / "trace", viewer_program(), *options, recording)
    environment = viewer_environment() | {"XDG_RUNTIME_DIR": str(tmp_path)}
    with subprocess.Popen(command, env=environment, start_new_session=True) as process:
        time.sleep(4.0)
        os.killpg(process.pid, signal.SIGTERM)
        process.wait(timeout=30.0)
    assert called(tmp_path / "trace") == set()
