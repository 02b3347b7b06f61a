"""`frankie-task calibrate`: what it tells, writes and refuses."""

import command_line
import numpy as np
import pytest
import yaml

from config import ConfigError
from hw.realsense import missing
from robots import load_robot
from robots.schema_geometry import PoseFile

SITE = """
robot: frankie
hardware:
  base: {driver: omron, address: 127.9.9.9, user: me}
  arm: {driver: panda, address: 127.9.9.9}
  gripper: {driver: franka_hand}
  camera: {driver: realsense}
"""


@pytest.fixture
def site(tmp_path):
    path = tmp_path / "site.yaml"
    path.write_text(SITE)
    return path


def call(*arguments: object):
    return command_line.call("calibrate", *arguments)


@pytest.mark.parametrize(
    ("command", "key"), [("hand-eye", "camera_mount"), ("base-arm", "arm_mount")]
)
def test_a_simulated_calibration_is_taken_by_the_robot_file(tmp_path, site, command, key):
    out = tmp_path / "found.yaml"
    code, said, _ = call(command, "--simulate", "--views", "16", "--out", str(out))
    assert code == 0
    assert "wrong by 0." in said
    assert f"{out} written" in said
    file = yaml.safe_load(out.read_text())
    pose = PoseFile(**file[key]).pose()
    assert file["quality"]["views"] == 16
    assert file["quality"]["uncertainty"]["mm"] < 3.0
    text, frankie = site.read_text(), load_robot("frankie")
    site.write_text(f"{text}{key}: found.yaml\n")
    robot = load_robot(site)
    taken = robot.camera.eTc if key == "camera_mount" else robot.bTa
    assert taken.isApprox(pose)
    nominal = frankie.camera.eTc if key == "camera_mount" else frankie.bTa
    assert np.linalg.norm(pose.translation - nominal.translation) < 0.05


def test_a_wrong_file_of_a_calibration_is_refused(tmp_path, site):
    out = tmp_path / "hand_eye.yaml"
    assert call("hand-eye", "--simulate", "--views", "16", "--out", str(out))[0] == 0
    text = site.read_text()
    site.write_text(text + "arm_mount: hand_eye.yaml\n")
    with pytest.raises(ConfigError, match="has no `arm_mount`; it is of another calibration"):
        load_robot(site)
    site.write_text(text + "camera_mount: hand_ey.yaml\n")
    with pytest.raises(ConfigError, match=r"there is no file .*hand_ey\.yaml"):
        load_robot(site)
    out.write_text(out.read_text().replace("quality", "qualty"))
    site.write_text(text + "camera_mount: hand_eye.yaml\n")
    with pytest.raises(ConfigError, match=r"hand_eye\.yaml:"):
        load_robot(site)


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("hand-eye",), "`frankie` is a description"),
        (("hand-eye", "--robot", "FILE"), "--arm-the-robot"),
        (("hand-eye", "--simulate", "--robot", "frankee"), "did you mean `frankie`"),
    ],
)
def test_what_is_missing_is_said_in_a_line(site, arguments, why):
    told = [str(site) if one == "FILE" else one for one in arguments]
    code, _, error = call(*told)
    assert (code, why in error, len(error.splitlines())) == (2, True, 1)


@pytest.mark.skipif(bool(missing()), reason=missing())
@pytest.mark.parametrize("command", ["hand-eye", "base-arm"])
def test_a_robot_that_cannot_be_reached_is_a_hardware_fault_in_a_line(site, command):
    arming = ["--arm-the-robot"] if command == "hand-eye" else []
    code, _, error = call(command, "--robot", str(site), *arming)
    assert (code, len(error.splitlines())) == (3, 1)
    assert "no camera is plugged in" in error
