"""`frankie-task emulate`: processes that the drivers can connect to."""

import json
import os
import signal
import subprocess
import sys

import pytest
from command_line import call

from drivers.omron import ArclOptions, OmronBase, OmronOptions
from extensions.emulators.frankie import FrankieEmulator
from hw import HardwareError, WallClock
from robots.load import SHIPPED

ADDRESS = f"127.{os.getpid() % 200 + 20}.77.1"


def refused(*words: object) -> str:
    """The line with which a command refuses."""
    code, _, err = call("emulate", *words)
    assert code == 2
    assert len(err.splitlines()) == 1
    return err


@pytest.mark.realtime
@pytest.mark.slow
@pytest.mark.usefixtures("interruptible")
def test_an_emulated_base_in_a_process_of_its_own():
    words = "omron --port 0 --arcl-port 0 --user me --password it"
    with subprocess.Popen(
        [sys.executable, "-m", "frankie_task_cli", "emulate", *words.split()],
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        ports = [int(process.stdout.readline().split(":")[1].split(",")[0]) for _ in range(2)]
        text = ArclOptions(password="adept", port=ports[1])
        account = {"address": "127.0.0.1", "port": ports[0], "user": "me", "arcl": text}
        base = OmronBase(OmronOptions(**account, password="it"), WallClock())
        base.connect()
        assert base.read().faults == ()
        base.close()
        with pytest.raises(HardwareError, match="password"):
            OmronBase(OmronOptions(**account), WallClock()).connect()
        process.send_signal(signal.SIGINT)
        assert process.wait(60.0) == 0


def test_an_emulated_arm_lists_and_does_what_is_typed():
    typed = "reflex joint_reflex\nfreze\n"
    code, out, _ = call("emulate", "panda", "--host", ADDRESS, typed=typed)
    assert code == 0
    assert "unplug: [SECONDS]" in out
    begin, reflex, unknown = map(json.loads, out.splitlines()[-3:])
    assert begin == {"did": "begin"}
    assert reflex["mode"] == "REFLEX"
    assert reflex["errors"] == ["joint_reflex"]
    assert "did you mean `freeze`" in unknown["error"]


def test_the_emulated_robot_takes_words_until_they_end(tmp_path):
    path = tmp_path / "emulated.yaml"
    path.write_text((SHIPPED / "emulated.yaml").read_text().replace("127.0.60.1", "127.9.8.7"))
    typed = "supports\narm reflex\nfly\n"
    code, out, _ = call("emulate", "frankie", "--robot", path, "--scene", "single", typed=typed)
    assert code == 0
    lines = out.splitlines()
    assert "container" in next(line for line in lines if '"supports"' in line)
    assert any("cartesian_reflex" in line for line in lines)
    assert any("no such thing as `fly`" in line for line in lines)


def test_wrong_options_are_refused():
    assert "did you mean `single`" in refused("realsense", "--port", "0", "--scene", "singel")
    assert "192.0.2.1" in refused("panda", "--host", "192.0.2.1")
    for robot in ("frankie", SHIPPED / "frankie_site.yaml"):
        assert "emulated: PORT" in refused("frankie", "--robot", robot)


def test_reported_ways_are_listed_with_their_sources_and_unknown_ones_refused():
    code, out, _ = call("emulate", "omron", "--as-reported", "list")
    assert code == 0
    assert "timeout-off: it drives on for ever without commands [" in out
    assert all(line.endswith("]") for line in out.splitlines())
    assert out in call("emulate", "frankie", "--as-reported", "list")[1]
    for part in ("omron", "frankie"):
        line = refused(part, "--as-reported", "timeout-off,trottle")
        assert "has no reported behaviour called `trottle`" in line
    emulator = FrankieEmulator(
        "emulated", world="kinematic", scene="single", seed=0, as_reported=["timeout-off"]
    )
    assert emulator.base.options.teleop.timeout == 0.0
