"""`frankie-task emulate realsense`: a process that feeds the driver with images."""

import signal
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from app.commands import app
from hw import WallClock
from hw.realsense import RealSenseCamera, RealSenseSettings, missing
from robots import load_robot


def emulate(*arguments: str):
    result = CliRunner().invoke(app, ["emulate", "realsense", *arguments])
    return result.exit_code, result.output


@pytest.mark.skipif(bool(missing()), reason=missing())
def test_an_emulated_camera_in_a_process_of_its_own():
    arguments = "emulate realsense --port 0 --scene single --fault drops"
    process = subprocess.Popen(
        [sys.executable, "-m", "frankie_task_cli", *arguments.split()],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        address = process.stdout.readline().split()[2].rstrip(",")
        description = load_robot("frankie").camera
        camera = RealSenseCamera(description, WallClock(), RealSenseSettings(emulator=address))
        camera.connect()
        try:
            depth = camera.latest().depth
            assert np.isfinite(depth).mean() > 0.5
            assert 0.3 < np.nanmedian(depth) < 1.5  # the floor or the table below the hand
        finally:
            camera.close()
        process.send_signal(signal.SIGINT)
        assert process.wait(5.0) == 0
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def test_faults_are_listed_and_suggested():
    code, output = emulate("--fault", "list")
    assert code == 0
    assert "unplugged: the cable is not plugged in" in output
    code, output = emulate("--port", "0", "--fault", "jiter")
    assert (code, "did you mean `jitter`" in output) == (2, True)
    code, output = emulate("--port", "0", "--scene", "singel")
    assert (code, "did you mean `single`" in output) == (2, True)
