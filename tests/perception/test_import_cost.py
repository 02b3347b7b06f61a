"""What importing the rooms of perception costs."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize("room", ["perception", "lab.grasps"])
def test_importing_a_room_does_not_import_torch(room: str) -> None:
    code = f"import sys, {room}; print('torch' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.strip() == "False", result.stderr
