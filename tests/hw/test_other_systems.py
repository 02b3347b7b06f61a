"""The product where the operating system is not Linux: what only Linux has is taken away.

macOS itself is not at hand; a `sitecustomize` removes the calls from every process of the program,
its drivers and emulators included.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from program import program

from hw import claims
from hw.claims import Claim, holder_of

ROOT = Path(__file__).parents[2]

WITHOUT = """
import os, pathlib, socket
for name in ("sched_setscheduler", "sched_getaffinity", "sched_setaffinity", "memfd_create",
             "pidfd_open", "SCHED_FIFO", "SCHED_OTHER", "SCHED_RESET_ON_FORK", "sched_param"):
    delattr(os, name)
for name in ("SO_PEERCRED", "SO_BINDTODEVICE", "TCP_QUICKACK"):
    delattr(socket, name)
bind, read_text = socket.socket.bind, pathlib.Path.read_text
def bind_by_name(self, address):
    if isinstance(address, bytes) and address[:1] == b"\\0":
        raise OSError("no abstract name space")
    return bind(self, address)
def read_no_proc(self, *args, **kwargs):
    if str(self).startswith(("/proc", "/sys")):
        raise FileNotFoundError(str(self))
    return read_text(self, *args, **kwargs)
socket.socket.bind, pathlib.Path.read_text = bind_by_name, read_no_proc
"""


@pytest.fixture
def frankie_task(tmp_path):
    """Runs the command line without what only Linux has."""
    (tmp_path / "sitecustomize.py").write_text(WITHOUT)
    path = os.pathsep.join([str(tmp_path), str(ROOT), *filter(None, sys.path)])

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "frankie_task_cli", *words],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
            check=False,
        )

    return run


def test_the_doctor_says_that_there_is_no_real_time_priority(frankie_task):
    done = frankie_task("doctor", "--json")
    told = {row["text"]: row["verdict"] for row in map(json.loads, done.stdout.splitlines())}
    (text,) = (one for one in told if "real-time priority" in one)
    assert (told[text], text.split(" on ")[0]) == ("open", "no real-time priority")
    assert "Traceback" not in done.stderr


@pytest.mark.slow
@pytest.mark.realtime
def test_a_robot_of_real_drivers_moves_every_part(frankie_task, tmp_path):
    steps = "[recover: {arm: ready}, drive: {forward_m: 0.2}, open_gripper]"
    (tmp_path / "t.yaml").write_text(f"task: t\nscene: single\ntree: {{sequence: {steps}}}\n")
    done = frankie_task("run", "t.yaml", "--robot", "emulated", "--view", "none")
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_claim_by_file_has_one_holder_and_ends_with_it(monkeypatch, tmp_path):
    monkeypatch.setattr(claims, "_ABSTRACT", False)
    monkeypatch.setattr(claims, "_FILES", tmp_path)
    source = (
        "import sys, time; from pathlib import Path; from hw import claims\n"
        "claims._ABSTRACT, claims._FILES = False, Path(sys.argv[1])\n"
        "held = claims.Claim('arm').take(); print('held', flush=True); time.sleep(60)\n"
    )
    assert holder_of("arm") is None
    with program(source, tmp_path) as other:
        assert other.stdout.readline() == "held\n"
        assert Claim("arm").take() is None
        assert holder_of("arm") == other.pid
        other.kill()
        other.wait()
        assert holder_of("arm") is None
        ours = Claim("arm").take()
    assert (holder_of("arm"), Claim("arm").take()) == (os.getpid(), None)
    ours.release()
    assert Claim("arm").take() is not None
