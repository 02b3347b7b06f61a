"""The first metre of a base, and what `doctor` says of the settings that the base keeps."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.commands import app
from hw.emulators.omron import OmronEmulator, Options
from hw.emulators.omron.controller import Teleop
from hw.hardware import NotArmedError, Verdict, first_metre, parts
from hw.hardware.arming import speed_note, speed_percent
from robots import RealRobot, load_real_robot
from robots.load import SHIPPED

DELIVERED = {"dead_translation: 0 ": "dead_translation: 10 "}
"""Dead zones as a base is delivered."""


@pytest.fixture(autouse=True)
def brief(monkeypatch):
    monkeypatch.setattr("hw.hardware.parts._LOOKS", 5)


def file_of(emulator: OmronEmulator, folder: Path, **changes: str) -> Path:
    """The template, for an emulated base that it takes for a real one."""
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
    return path


def robot_of(emulator: OmronEmulator, folder: Path, **changes: str) -> RealRobot:
    real = load_real_robot(file_of(emulator, folder, **changes))
    assert real is not None
    return real


def emulator_of(*ways: str, **teleop: float) -> OmronEmulator:
    return OmronEmulator(Options(teleop=Teleop(**({"timeout": 0.3} | teleop))), as_reported=ways)


def peak(emulator: OmronEmulator) -> float:
    return max((abs(one.v) for one in emulator.moved), default=0.0)


def gone(emulator: OmronEmulator) -> float:
    x, _, _ = emulator.controller.drive.pose()
    return x


def drive(real: RealRobot, confirm=lambda _: True) -> dict[str, tuple[Verdict, str]]:
    found = first_metre(real, armed=True, confirm=confirm)
    return {one.about: (one.verdict, one.text) for one in found}


@pytest.mark.parametrize(
    ("ways", "verdict", "words"),
    [((), Verdict.GOOD, "it is heeded"), (("throttle-ignored",), Verdict.OPEN, "not heeded")],
)
def test_a_first_metre_tells_whether_the_throttle_is_heeded(tmp_path, ways, verdict, words):
    questions: list[str] = []
    with emulator_of(*ways) as emulator:
        real = robot_of(emulator, tmp_path, **DELIVERED)
        found = drive(real, lambda text: not questions.append(text))
        assert 0.3 < gone(emulator) < 1.0
        assert peak(emulator) < 0.14
    assert found["speed"][0] is Verdict.GOOD
    assert found["throttle"][0] is verdict
    assert words in found["throttle"][1]
    assert len(questions) == 2
    assert "emergency stop" in questions[0]


def test_a_speed_that_is_not_as_told_ends_it(tmp_path):
    with emulator_of("full-scale-is-top") as emulator:
        found = drive(robot_of(emulator, tmp_path))
        assert gone(emulator) < 0.5
    assert found["speed"][0] is Verdict.BAD
    assert "full_scale" in found["speed"][1]
    assert "throttle" not in found


def test_nothing_moves_that_nobody_confirms_or_arms(tmp_path):
    with emulator_of() as emulator:
        real = robot_of(emulator, tmp_path)
        found = drive(real, lambda _: False)
        assert found["speed"] == (Verdict.OPEN, "not done: nobody confirmed it")
        with pytest.raises(NotArmedError):
            list(first_metre(real, armed=False, confirm=lambda _: True))
        for options in ((), ("--arm-the-robot",)):
            command = ["doctor", "--robot", str(real.path), "--first-metre", *options]
            result = CliRunner().invoke(app, command, input="y\ny\n")
            assert result.exit_code == 2
            assert len(result.stderr.splitlines()) == 1
        assert peak(emulator) == 0.0


@pytest.mark.parametrize(
    ("ways", "teleop", "verdict", "words"),
    [
        ((), {"timeout": 0.14}, Verdict.GOOD, "drives on for 0.07 m"),
        (("no-config",), {"timeout": 0.14}, Verdict.GOOD, "`Timeout` is 0.14 s"),
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
        findings = list(parts.base(robot_of(emulator, tmp_path)))
        assert any(one.verdict is verdict and words in one.text for one in findings), findings
        assert peak(emulator) == 0.0
        assert not emulator.heard


@pytest.mark.parametrize(
    ("changes", "pulses", "percent"),
    [
        (DELIVERED, "slower than 0.11 m/s or 2.6 deg/s its base goes in pulses", 21.0),
        ({}, "slower than 2.6 deg/s its base goes in pulses", 10.0),
        ({"dead_rotation: 5 ": "dead_rotation: 0 "}, "", 10.0),
        (DELIVERED | {"dead_rotation: 5 ": "throttle: true\n      dead_rotation: 5 "}, "", 10.0),
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
    result = CliRunner().invoke(app, ["run", "pick_one", "--robot", str(path), "--view", "none"])
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1
    assert "at 10 % of its speeds its base would stand still" in result.stderr
    assert "the least `speed_percent` is 18" in result.stderr
