"""The file of a real robot: what it changes of its description, and what is wrong with it."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from config import ConfigError
from robots import load_real_robot, load_robot
from robots.load import SHIPPED

FRANKIE = load_robot("frankie")


MISTAKES = yaml.safe_load(Path(__file__).with_name("mistakes.yaml").read_text("utf-8"))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A copy of the template."""
    path = tmp_path / "ours.yaml"
    path.write_text((SHIPPED / "frankie_site.yaml").read_text())
    return path


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize("name", ["emulated", "frankie_site"])
def test_the_shipped_files_are_good(name: str) -> None:
    real = load_real_robot(name)
    assert real is not None
    assert Path(real.body).name == "frankie.yaml"
    assert load_robot(name).name == name


def test_shipped_files_are_found_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By name, and as the path that they have in a checkout."""
    monkeypatch.chdir(tmp_path)
    for robot in ("emulated", "robots/emulated.yaml", Path("robots/frankie.yaml")):
        assert load_robot(robot).name == Path(robot).stem
    with pytest.raises(ConfigError, match="did you mean `emulated`"):
        load_real_robot("robots/emulatd.yaml")


def test_the_template_is_slow_brakes_as_its_base_does_and_is_not_emulated(file: Path) -> None:
    robot, real = load_robot(file), load_real_robot(file)
    assert real is not None
    assert real.hardware.emulated is None
    assert robot.limits.base_twist[0] <= 0.5
    assert robot.limits.base_acceleration[0] == 0.5
    np.testing.assert_array_equal(robot.limits.qd, FRANKIE.limits.qd)


def test_what_differs_on_this_robot_takes_the_place_of_the_description(file: Path) -> None:
    file.write_text(
        file.read_text()
        + "arm_mount: {xyz: [0.16, 0.01, 0.40]}\n"
        + "camera_mount: {xyz: [0.05, 0.0, -0.09], rpy_deg: [0, 0, 91]}\n"
        + "arm_lag: 0.05\n"
    )
    robot = load_robot(file)
    np.testing.assert_allclose(robot.bTa.translation, [0.16, 0.01, 0.40])
    np.testing.assert_allclose(robot.camera.eTc.translation, [0.05, 0.0, -0.09])
    assert robot.arm.lag == 0.05
    assert robot.base.lag == 0.25
    np.testing.assert_allclose(FRANKIE.bTa.translation, [0.15, 0.0, 0.38])


QUALITY = """\
quality:
  views: 12
  residual: 0.2
  uncertainty: {mm: 0.3, deg: 0.02}
  held_out: {mm: 0.4, deg: 0.03}
"""


def test_mounts_and_full_scale_may_stand_in_files_of_their_own(file: Path) -> None:
    file.with_name("hand_eye.yaml").write_text("camera_mount: {xyz: [0.05, 0, -0.09]}\n" + QUALITY)
    file.with_name("site.yaml").write_text("forward: 0.67\ndead_translation: 0\n")
    text = file.read_text() + "camera_mount: hand_eye.yaml\n"
    begin, end = text.index("    full_scale:"), text.index("    pose_delay")
    file.write_text(text[:begin] + "    full_scale: site.yaml\n" + text[end:])
    real = load_real_robot(file)
    assert real is not None
    assert real.hardware.base.scale.forward == 0.67
    assert real.calibrated == ("camera_mount",)
    np.testing.assert_allclose(load_robot(file).camera.eTc.translation, [0.05, 0.0, -0.09])
    file.with_name("site.yaml").unlink()
    with pytest.raises(ConfigError, match="doctor --write-site"):
        load_robot(file)


@pytest.mark.parametrize("row", MISTAKES["sites"], ids=lambda row: row["tells"])
def test_a_mistake_is_told_with_its_place(file: Path, row: dict[str, str]) -> None:
    edit(file, row["old"], row["new"])
    with pytest.raises(ConfigError) as error:
        load_robot(file)
    assert row["tells"] in str(error.value)
