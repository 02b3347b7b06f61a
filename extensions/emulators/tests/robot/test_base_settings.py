"""What `doctor` says of the settings that the base keeps, and of robots that go slowly."""

import json
from pathlib import Path

import pytest
from command_line import call

from extensions.emulators.omron import OmronEmulator, Options
from extensions.emulators.omron.onboard_controller import Teleop
from hw import WallClock, parts_of
from hw.hardware import Verdict
from hw.hardware.arming import speed_note, speed_percent
from hw.hardware.part_diagnostics import findings_of
from robots import RealRobot, at_pace, load_real_robot, load_robot
from robots.load import SHIPPED

DELIVERED = {"dead_translation: 0 ": "dead_translation: 10 "}
"""Dead zones as a base is delivered."""


@pytest.fixture(autouse=True)
def brief(monkeypatch):
    monkeypatch.setattr("hw.findings.LOOKS", 5)


def robot_of(emulator: OmronEmulator, folder: Path, **changes: str) -> RealRobot:
    """That of the template, for an emulated base that it takes for a real one."""
    text = (SHIPPED / "frankie_site.yaml").read_text()
    changes = {
        "10.10.10.10\n": f"127.0.0.1\n    port: {emulator.port}\n",
        "password: adept": f"password: adept, port: {emulator.arcl_port}",
        **changes,
    }
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path = folder / "ours.yaml"
    path.write_text(text)
    return load_real_robot(path)


def emulator_of(*ways: str, **teleop: float) -> OmronEmulator:
    return OmronEmulator(Options(teleop=Teleop(**({"timeout": 0.3} | teleop))), as_reported=ways)


def peak(emulator: OmronEmulator) -> float:
    return max((abs(one.v) for one in emulator.moved), default=0.0)


@pytest.mark.parametrize(
    ("ways", "teleop", "verdict", "words"),
    [
        ((), {"timeout": 0.14}, Verdict.GOOD, "drives on for 0.07 m"),
        (("timeout-as-delivered",), {}, Verdict.BAD, "for 1.00 m at 0.5 m/s; set `Timeout`"),
        (("timeout-off",), {}, Verdict.BAD, "never stops; set `Timeout` to 0.14 s"),
        (("timeout-short",), {}, Verdict.BAD, "stops between two commands"),
        (("full-scale-is-top",), {}, Verdict.BAD, "FullThrottleForwards is 0"),
    ],
)
def test_the_doctor_judges_what_the_base_keeps_and_moves_nothing(
    tmp_path, ways, teleop, verdict, words
):
    with emulator_of(*ways, **teleop) as emulator:
        real, clock = robot_of(emulator, tmp_path), WallClock()
        base = parts_of(real, load_robot(real.path), clock)["base"]
        findings = list(findings_of("base", base, real, clock))
        assert any(one.verdict is verdict and words in one.text for one in findings), findings
        assert peak(emulator) == 0.0
        assert not emulator.heard


@pytest.mark.parametrize(
    ("changes", "pulses", "percent"),
    [
        (DELIVERED, "slower than 0.11 m/s or 2.6 deg/s its base goes in pulses", 21.0),
        ({}, "slower than 2.6 deg/s its base goes in pulses", 10.0),
        ({"dead_rotation: 5 ": "dead_rotation: 0 "}, "", 10.0),
    ],
)
def test_a_start_says_from_which_speed_on_the_base_goes_in_pulses(
    tmp_path, changes, pulses, percent
):
    with emulator_of() as emulator:
        real = robot_of(emulator, tmp_path, **changes)
    note = speed_note(real)
    assert pulses in note
    assert bool(pulses) is ("pulses" in note)
    assert speed_percent(real) == percent


def test_a_speed_at_which_the_base_cannot_go_is_refused_before_anything_starts(tmp_path):
    path = tmp_path / "slow.yaml"
    text = (SHIPPED / "emulated.yaml").read_text()
    path.write_text(text.replace("speed_percent: 100", "speed_percent: 10"))
    code, _, err = call("run", "pick_one", "--robot", path, "--view", "none")
    assert code == 2
    assert len(err.splitlines()) == 1
    assert "at 10 % of its speeds its base would stand still" in err
    assert "the least `speed_percent` is 18" in err


TASK = """\
task: not_far
poses:
  near: {xyz: [1.3, 0.0, 0.7], rpy_deg: [180, 0, 0]}
tree:
  navigate: {to: near, timeout_s: 2}
"""


def test_timeouts_grow_as_a_robot_gets_slower(tmp_path, monkeypatch):
    slow = at_pace(load_robot(SHIPPED / "emulated.yaml"), 0.2)
    monkeypatch.setattr("hw.sim.simulated_world.load_robot", lambda _: slow)
    task = tmp_path / "task.yaml"
    task.write_text(TASK)
    options = ["--scene", "single", "--view", "none", "--json", "--record", str(tmp_path)]
    told = json.loads(call("run", task, *options)[1])
    assert told["outcome"] == "success", told["reason"]
    assert told["duration_s"] > 4.0, "longer than the timeout at full speed"
