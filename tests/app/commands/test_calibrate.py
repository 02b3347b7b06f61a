"""`frankie-task calibrate`: what it tells, writes and refuses."""

import cv2
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from app.commands import app
from app.lab.calibration import Board, find_corners
from robots import load_robot
from robots.schema_geometry import PoseFile


def call(*arguments: str):
    result = CliRunner().invoke(app, ["calibrate", *arguments])
    return result.exit_code, result.stdout, result.stderr


@pytest.mark.parametrize(
    ("command", "key"), [("hand-eye", "camera_mount"), ("base-arm", "arm_mount")]
)
def test_a_simulated_calibration_is_written_as_the_robot_file_takes_it(tmp_path, command, key):
    out = tmp_path / "found.yaml"
    code, said, _ = call(command, "--simulate", "--views", "16", "--out", str(out))
    assert code == 0
    assert "wrong by 0." in said
    assert f"{out} written" in said
    file = yaml.safe_load(out.read_text())
    frankie = load_robot("frankie")
    nominal = frankie.camera.eTc if key == "camera_mount" else frankie.bTa
    pose = PoseFile(**file[key]).pose()
    assert np.linalg.norm(pose.translation - nominal.translation) < 0.05
    assert file["quality"]["views"] == 16
    assert file["quality"]["uncertainty"]["mm"] < 3.0


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    out = tmp_path / "nowhere" / "found.yaml"
    code, _, error = call("base-arm", "--simulate", "--views", "16", "--out", str(out))
    assert (code, f"{out}: No such file" in error) == (2, True)


def test_the_printed_board_is_the_one_that_is_looked_for(tmp_path):
    out = tmp_path / "board.png"
    code, said, _ = call("board", str(out), "--columns", "6", "--rows", "4", "--square", "30")
    assert code == 0
    assert "180 x 120 mm at 300 dpi" in said
    picture = cv2.imread(str(out), cv2.IMREAD_GRAYSCALE)
    small = cv2.resize(picture, None, fx=0.2, fy=0.2, interpolation=cv2.INTER_AREA)
    seen = find_corners(np.pad(small, 40, constant_values=255), Board(6, 4, 0.03, 0.0225))
    assert len(seen.image) == 15
    assert call("board", str(tmp_path / "no" / "board.png"))[0] == 2


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("hand-eye",), "--panda ADDRESS"),
        (("hand-eye", "--panda", "127.9.9.9"), "--arm-the-robot"),
        (("base-arm", "--panda", "127.9.9.9"), "--omron ADDRESS"),
        (("hand-eye", "--simulate", "--robot", "frankee"), "did you mean `frankie`"),
    ],
)
def test_what_is_missing_is_said_in_a_line(arguments, why):
    code, _, error = call(*arguments)
    assert (code, why in error, len(error.splitlines())) == (2, True, 1)


def test_a_robot_that_cannot_be_reached_is_a_hardware_fault():
    code, _, error = call("hand-eye", "--panda", "127.9.9.9", "--arm-the-robot")
    assert (code, len(error.splitlines())) == (3, 1)
