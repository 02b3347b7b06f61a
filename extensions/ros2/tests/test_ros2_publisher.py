"""A run that is published in ROS 2, heard by another process with types of its own."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import call

from extensions.ros2.messages import missing

pytestmark = [pytest.mark.realtime, pytest.mark.skipif(bool(missing()), reason=missing())]
LISTENER = Path(__file__).with_name("listener.py")
STEPS = "{wait: {duration_s: 2}}, {snapshot: {file: one}}, {wait: {duration_s: 1}}"


def test_another_process_hears_joints_frames_and_the_tree(tmp_path, monkeypatch):
    domain = str(150 + os.getpid() % 80)
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    (tmp_path / "task.yaml").write_text(f"task: a\ntree: {{sequence: [{STEPS}]}}")
    command = [sys.executable, str(LISTENER), domain]
    words = ("--speed", "real", "--record", tmp_path, "--view", "none", "--with", "ros2")
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as listener:
        assert listener.stdout.readline() == "ready\n"
        code, said, _ = call("run", tmp_path / "task.yaml", *words)
        joints, frames, sizes, tree = json.loads(listener.communicate(timeout=60.0)[0])
    assert (code, "ended early" in said, "panda_joint7" in joints) == (0, False, True)
    assert (frames["base_link"], frames["panda_hand_tcp"]) == ("odom", "panda_hand")
    assert (sizes, tree.count("SUCCESS")) == ([[480, 640]], 4)
