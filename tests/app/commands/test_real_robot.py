"""`frankie-task run` on a robot file with hardware."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.commands import app
from robots.load import SHIPPED


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    path = tmp_path / "ours.yaml"
    text = (SHIPPED / "frankie_site.yaml").read_text()
    path.write_text(text.replace("10.10.10.10", "127.9.9.9").replace("172.16.0.2", "127.9.9.9"))
    return path


def call(*arguments: object):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_a_real_robot_does_not_move_unless_it_is_armed(file: Path, tmp_path: Path) -> None:
    result = call("run", "pick_one", "--robot", file, "--record", tmp_path / "runs")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "--arm-the-robot" in result.stderr
    assert not (tmp_path / "runs").exists()


def test_a_robot_that_is_not_there_is_told_in_a_line(file: Path, tmp_path: Path) -> None:
    result = call(
        "run", "pick_one", "--robot", file, "--arm-the-robot", "--record", tmp_path / "runs"
    )
    assert result.exit_code == 3
    assert "127.9.9.9" in result.stderr
    assert "Traceback" not in result.stderr


def test_only_the_file_of_an_emulated_robot_can_be_emulated(file: Path) -> None:
    for robot in ("frankie", file):
        result = call("emulate", "frankie", "--robot", robot)
        assert result.exit_code == 2
        assert "emulated: PORT" in result.stderr


def test_the_emulated_robot_takes_words_until_they_end(tmp_path: Path) -> None:
    path = tmp_path / "emulated.yaml"
    path.write_text((SHIPPED / "emulated.yaml").read_text().replace("127.0.60.1", "127.9.8.7"))
    words = "tell\narm reflex\nfly\n"
    result = CliRunner().invoke(
        app, ["emulate", "frankie", "--robot", str(path), "--scene", "single"], input=words
    )
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert "container" in next(line for line in lines if '"supports"' in line)
    assert any("cartesian_reflex" in line for line in lines)
    assert any("no such thing as `fly`" in line for line in lines)
