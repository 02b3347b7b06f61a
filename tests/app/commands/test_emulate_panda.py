"""`frankie-task emulate panda`: a robot that is not there, and what is done to it."""

import json
import os
import subprocess
import sys

ADDRESS = f"127.{os.getpid() % 200 + 20}.77.1"


def emulate(*arguments: str, words: str = "") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "frankie_task_cli", "emulate", "panda", *arguments]
    return subprocess.run(
        command, input=words, capture_output=True, text=True, timeout=60.0, check=False
    )


def test_words_are_listed_done_and_answered():
    result = emulate("--host", ADDRESS, words="reflex joint_reflex\nfreze\n")
    assert result.returncode == 0
    assert "unplug: [SECONDS]" in result.stdout
    begin, reflex, unknown = map(json.loads, result.stdout.splitlines()[-3:])
    assert begin == {"did": "begin"}
    assert reflex["mode"] == "REFLEX"
    assert reflex["errors"] == ["joint_reflex"]
    assert "did you mean `freeze`" in unknown["error"]


def test_an_address_that_is_not_of_this_computer_is_refused():
    result = emulate("--host", "192.0.2.1")
    assert result.returncode == 2
    assert "192.0.2.1" in result.stderr
    assert len(result.stderr.splitlines()) == 1
