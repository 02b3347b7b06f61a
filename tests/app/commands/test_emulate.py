"""`frankie-task emulate`: a process that the driver can connect to."""

import signal
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from app.commands import app
from hw import HardwareError, WallClock
from hw.emulators.frankie import FrankieEmulator
from hw.omron import ArclSettings, OmronBase, OmronSettings


def call(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["emulate", "omron", *arguments])
    return result.exit_code, result.stdout, result.stderr


def test_an_emulated_base_in_a_process_of_its_own():
    arguments = "emulate omron --port 0 --arcl-port 0 --user me --password it --fault pieces"
    command = [sys.executable, "-m", "frankie_task_cli", *arguments.split()]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        ports = [int(process.stdout.readline().split(":")[1].split(",")[0]) for _ in range(2)]
        text = ArclSettings(password="adept", port=ports[1])
        account = {"host": "127.0.0.1", "port": ports[0], "user": "me", "arcl": text}
        base = OmronBase(OmronSettings(**account, password="it"), WallClock())
        base.connect()
        assert base.read().faults == ()
        base.close()
        with pytest.raises(HardwareError, match="password"):
            OmronBase(OmronSettings(**account), WallClock()).connect()
        process.send_signal(signal.SIGINT)
        assert process.wait(10.0) == 0
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def test_faults_are_listed_and_unknown_ones_refused():
    code, out, _ = call("--fault", "list")
    assert code == 0
    assert "frozen: " in out
    code, _, err = call("--port", "0", "--arcl-port", "0", "--fault", "frosen")
    assert code == 2
    assert "did you mean `frozen`" in err
    assert len(err.splitlines()) == 1


def test_ways_of_real_ones_are_listed_with_their_sources_and_unknown_ones_refused():
    code, out, _ = call("--as-reported", "list")
    assert code == 0
    assert "throttle-ignored: the third argument of ratioDrive counts as 100 [" in out
    assert all(line.endswith("]") for line in out.splitlines())
    listed = CliRunner().invoke(app, ["emulate", "frankie", "--as-reported", "list"]).stdout
    assert out in listed
    for part in ("omron", "frankie"):
        result = CliRunner().invoke(app, ["emulate", part, "--as-reported", "timeout-off,trottle"])
        assert result.exit_code == 2
        assert len(result.stderr.splitlines()) == 1
        assert "has no way called `trottle`" in result.stderr


def test_a_whole_robot_takes_the_ways_of_its_parts():
    emulator = FrankieEmulator(
        "emulated", world="kinematic", scene="single", seed=0, as_reported=["throttle-ignored"]
    )
    assert not emulator.base.controller.heeds_throttle
