"""Listening sockets of a run: those of its options, on loopback only, as SECURITY.md says."""

import os
import re
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
TASK = "task: toy\ntree: {wait: {duration_s: 60}}\n"


def family(pid: int) -> list[int]:
    """A process and those that it has started."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [pid, *(one for child in children for one in family(int(child)))]


def listening(pid: int) -> set[str]:
    """Addresses and ports on which a process and its children listen, as `127.0.0.1:9097`."""
    inodes = set()
    for one in family(pid):
        for link in Path(f"/proc/{one}/fd").iterdir():
            try:
                inodes.add(link.readlink().name)
            except OSError:  # closed meanwhile
                continue
    found = set()
    for version in ("tcp", "tcp6"):
        for row in Path(f"/proc/{pid}/net/{version}").read_text().splitlines()[1:]:
            _, local, _, state, *_ = fields = row.split()
            if state == "0A" and f"socket:[{fields[9]}]" in inodes:
                address, port = local.split(":")
                is_loopback = address == "0100007F"
                found.add(f"{'127.0.0.1' if is_loopback else address}:{int(port, 16)}")
    return found


@pytest.mark.slow
@pytest.mark.parametrize("served", [True, False], ids=["everything", "nothing"])
def test_only_what_was_asked_for_listens_and_on_loopback_alone(tmp_path, served):
    task = tmp_path / "toy.yaml"
    task.write_text(TASK)
    runs = tmp_path / "runs"
    options = ["--view", "none"]
    if served:
        options = ["--view", "web", "--with", "page"]
    program = (sys.executable, "-m", "frankie_task_cli", "run", str(task), "--scene", "single")
    process = subprocess.Popen(
        [*program, "--speed", "real", "--record", str(runs), *options],
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    try:
        deadline = time.monotonic() + 60.0
        while not any("RUNNING" in log.read_text() for log in runs.glob("*/events.jsonl")):
            assert time.monotonic() < deadline
            time.sleep(0.1)
        said = ""
        while served and "watch at" not in said:
            said += process.stderr.readline()
        time.sleep(0.5)
        sockets = listening(process.pid)
        if served:
            page = re.search(r"control at http://127\.0\.0\.1:(\d+)/#(\S{22})", said)
            viewer = re.search(r"watch at (http://127\.0\.0\.1:(\d+)/\S+3A(\d+)%2Fproxy\S*)", said)
            assert page, said
            assert viewer, said
            ports = (page[1], viewer[2], viewer[3])
            assert sockets == {f"127.0.0.1:{number}" for number in ports}
            assert b"rerun" in urllib.request.urlopen(viewer[1], timeout=20.0).read().lower()
        else:
            assert sockets == set()
    finally:
        process.terminate()
        process.communicate(timeout=60.0)
    assert process.returncode == 130
    if served:
        with pytest.raises(urllib.error.URLError):
            urllib.request.urlopen(viewer[1], timeout=5.0)
        kept = "".join(
            path.read_text(errors="replace")
            for path in runs.rglob("*")
            if path.is_file() and path.suffix != ".rrd"
        )
        assert page[2] not in kept
