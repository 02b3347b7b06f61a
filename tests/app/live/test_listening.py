"""What listens while a task runs: what SECURITY.md says, on loopback, and nothing else."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
from groot_client import free_pair

ROOT = Path(__file__).parents[3]
TASK = "task: toy\ntree: {wait: {duration_s: 60}}\n"


def listening(pid: int) -> set[str]:
    """Addresses and ports on which a process listens, as `127.0.0.1:9097`."""
    inodes = set()
    for link in Path(f"/proc/{pid}/fd").iterdir():
        try:
            inodes.add(link.readlink().name)
        except OSError:  # closed meanwhile
            continue
    found = set()
    for family in ("tcp", "tcp6"):
        for row in Path(f"/proc/{pid}/net/{family}").read_text().splitlines()[1:]:
            _, local, _, state, *_ = fields = row.split()
            if state == "0A" and f"socket:[{fields[9]}]" in inodes:
                address, port = local.split(":")
                is_loopback = address == "0100007F"
                found.add(f"{'127.0.0.1' if is_loopback else address}:{int(port, 16)}")
    return found


@pytest.mark.parametrize("served", [True, False], ids=["page and Groot2", "no options"])
def test_only_what_was_asked_for_listens_and_on_loopback_alone(tmp_path, served):
    pytest.importorskip("zmq")
    task = tmp_path / "toy.yaml"
    task.write_text(TASK)
    port = free_pair()
    options = ["--control", "--groot2", "--groot2-port", str(port)] if served else []
    runs = tmp_path / "runs"
    fixed = ["--scene", "single", "--speed", "real", "--view", "none"]
    program = (sys.executable, "-m", "frankie_task_cli", "run")
    process = subprocess.Popen(
        [*program, str(task), *fixed, "--record", str(runs), *options],
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    try:
        deadline = time.monotonic() + 60.0
        while not any("RUNNING" in log.read_text() for log in runs.glob("*/events.jsonl")):
            assert time.monotonic() < deadline
            time.sleep(0.1)
        expected = set()
        if served:
            line = next(line for line in process.stderr if "control at" in line)
            page = re.search(r"http://127\.0\.0\.1:(\d+)/#(\S{22})", line)
            expected = {f"127.0.0.1:{page[1]}", f"127.0.0.1:{port}", f"127.0.0.1:{port + 1}"}
        time.sleep(0.5)
        assert listening(process.pid) == expected
    finally:
        process.terminate()
        process.communicate(timeout=30.0)
    assert process.returncode == 130
    if served:
        kept = "".join(
            path.read_text(errors="replace") for path in runs.glob("*/*") if path.suffix != ".rrd"
        )
        assert page[2] not in kept
