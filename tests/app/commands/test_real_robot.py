"""`frankie-task run` on a robot file with hardware."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import call

from robots.load import SHIPPED


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    path = tmp_path / "ours.yaml"
    text = (SHIPPED / "frankie_site.yaml").read_text()
    path.write_text(text.replace("10.10.10.10", "127.9.9.9").replace("172.16.0.2", "127.9.9.9"))
    return path


def test_a_real_robot_does_not_move_unless_it_is_armed(file: Path, tmp_path: Path) -> None:
    code, _, err = call("run", "pick_one", "--robot", file, "--record", tmp_path / "runs")
    assert code == 2
    assert err.splitlines()[-1].count("--arm-the-robot") == 1
    assert not (tmp_path / "runs").exists()


def test_a_robot_that_is_not_there_is_told_in_a_line(file: Path, tmp_path: Path) -> None:
    options = ("--robot", file, "--arm-the-robot", "--record", tmp_path / "runs")
    code, _, err = call("run", "pick_one", *options)
    assert code == 3
    assert "127.9.9.9" in err


def test_only_the_file_of_an_emulated_robot_can_be_emulated(file: Path) -> None:
    for robot in ("frankie", file):
        code, _, err = call("emulate", "frankie", "--robot", robot)
        assert code == 2
        assert "emulated: PORT" in err


def test_the_emulated_robot_takes_words_until_they_end(tmp_path: Path) -> None:
    path = tmp_path / "emulated.yaml"
    path.write_text((SHIPPED / "emulated.yaml").read_text().replace("127.0.60.1", "127.9.8.7"))
    typed = "tell\narm reflex\nfly\n"
    code, out, _ = call("emulate", "frankie", "--robot", path, "--scene", "single", typed=typed)
    assert code == 0
    lines = out.splitlines()
    assert "container" in next(line for line in lines if '"supports"' in line)
    assert any("cartesian_reflex" in line for line in lines)
    assert any("no such thing as `fly`" in line for line in lines)
