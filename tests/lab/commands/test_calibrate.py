"""`frankie-task calibrate`: what it tells, writes and refuses."""

import command_line
import numpy as np
import pytest
import yaml

from config.reader import ConfigError
from drivers.realsense import missing
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
    site.write_text(f"{SITE}{key}: found.yaml\n")
    taken, nominal = (
        robot.camera.eTc if key == "camera_mount" else robot.bTa
        for robot in (load_robot(site), load_robot("frankie"))
    )
    assert taken.isApprox(pose)
    assert np.linalg.norm(pose.translation - nominal.translation) < 0.05


QUALITY = "{views: 16, residual: 0.2, uncertainty: {mm: 1, deg: 0.1}, held_out: {mm: 1, deg: 0.1}}"


@pytest.mark.parametrize(
    ("taken", "quality", "why"),
    [
        ("arm_mount: hand_eye.yaml", "quality", "no `arm_mount`; it is of another calibration"),
        ("camera_mount: hand_ey.yaml", "quality", r"there is no file .*hand_ey\.yaml"),
        ("camera_mount: hand_eye.yaml", "qualty", r"hand_eye\.yaml:"),
    ],
)
def test_a_wrong_file_of_a_calibration_is_refused(tmp_path, site, taken, quality, why):
    text = f"camera_mount: {{xyz: [0.05, 0, -0.09]}}\n{quality}: {QUALITY}\n"
    (tmp_path / "hand_eye.yaml").write_text(text)
    site.write_text(f"{SITE}{taken}\n")
    with pytest.raises(ConfigError, match=why):
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
