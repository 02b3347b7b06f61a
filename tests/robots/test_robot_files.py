"""Robots from a person's own files: what is wrong is told with its place, what is right works."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from pinocchio import SE3

from config.reader import ConfigError
from controller import RobotModel, SelfCollision
from hw import SimClock
from hw.sim import World, kinematic_robot
from robots import Geom, Plane, load_real_robot, load_robot
from robots.load import SHIPPED

MISTAKES = yaml.safe_load(Path(__file__).with_name("mistakes.yaml").read_text("utf-8"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the shipped files."""
    shutil.copytree(SHIPPED, tmp_path / "robots", ignore=shutil.ignore_patterns("*.py"))
    return tmp_path / "robots"


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.mark.parametrize("row", MISTAKES["parts"], ids=lambda row: row["tells"])
def test_a_mistake_is_told_with_its_place(folder: Path, row: dict[str, str]) -> None:
    edit(folder / row["file"], row["old"], row["new"])
    with pytest.raises(ConfigError) as error:
        load_robot(folder / "frankie.yaml")
    assert str(error.value).startswith(f"{folder / row['file']}:")
    assert row["tells"] in str(error.value)


@pytest.fixture
def third(folder: Path) -> Path:
    """A small robot with a longer hand on another arm: the shipped files, copied and changed."""
    robot = folder / "pico.yaml"
    shutil.copy(folder / "omni.yaml", robot)
    shutil.copy(folder / "parts" / "panda.yaml", folder / "arm.yaml")
    shutil.copy(folder / "parts" / "franka_hand.yaml", folder / "parts" / "long_hand.yaml")
    edit(robot, "arm: panda", "arm: arm.yaml")
    edit(robot, "gripper: franka_hand", "gripper: long_hand")
    edit(robot, "[0.70, 0.50, 0.28]", "[0.50, 0.40, 0.30]")
    edit(robot, "reverse: 1.0", "reverse: 0.25")
    edit(robot, "xyz: [0.0, 0.0, 0.28]", "xyz: [0.1, 0.0, 0.30]")
    edit(folder / "arm.yaml", "visual: panda", "")
    edit(folder / "arm.yaml", "[0.0, -0.316, 0.0]", "[0.0, -0.416, 0.0]")
    edit(folder / "parts" / "long_hand.yaml", "0.1034", "0.1534")
    return robot


def test_a_third_robot_is_a_matter_of_files(third: Path) -> None:
    robot, shipped = load_robot(third), load_robot("omni")
    assert robot.name == "pico"
    model, usual = RobotModel(robot), RobotModel(shipped)
    q = np.zeros(7)
    longer = model.bTe(q).translation - usual.bTe(q).translation
    # Upper arm 0.1 m longer upwards, hand 0.05 m longer downwards, foot 0.1 m ahead, 0.02 m higher.
    np.testing.assert_allclose(longer, [0.1, 0.0, 0.07], atol=1e-12)
    lower, upper = model.velocity_limits
    assert (lower[0], upper[0]) == (-0.25, 1.0)
    np.testing.assert_array_equal(lower[1:], -upper[1:])
    assert SelfCollision(model).clearance(robot.arm.ready) > 0.0


def test_a_third_robot_looks_from_its_own_wrist(third: Path) -> None:
    robot, clock = load_robot(third), SimClock()
    world = World([Geom(Plane(), SE3.Identity(), "floor")], [])
    sim = kinematic_robot(robot, world, clock)
    assert sim.read().gripper_width == robot.gripper.opening
    frame = sim.camera.latest(1.0)
    expected = RobotModel(robot).bTe(robot.arm.ready) * robot.camera.eTc
    assert frame.oTc.isApprox(expected, 1e-12)


UNKNOWN = "no robot is called|cannot be read"


@pytest.mark.parametrize(
    ("name", "why"),
    [
        *((name, UNKNOWN) for name in ("x" * 5000, "a\0b", "/dev/zero", "/proc/self/mem", "/", "")),
        ("frankee", r"`frankee`; did you mean `frankie`\?"),
    ],
)
def test_a_robot_that_is_no_file_is_refused(name, why):
    with pytest.raises(ConfigError, match=why):
        load_robot(name)


def test_a_urdf_and_a_missing_file_are_told_apart(tmp_path):
    urdf = tmp_path / "ur5.urdf"
    with pytest.raises(ConfigError, match=r"the robot file .*ur5\.urdf is not found"):
        load_robot(urdf)
    urdf.write_text("<robot/>")
    with pytest.raises(ConfigError, match=r"`frankie-task robot import .*ur5\.urdf -o FOLDER`"):
        load_robot(urdf)


def test_a_part_that_is_no_file_is_refused(folder):
    path = folder / "frankie.yaml"
    good = path.read_text()
    for part in ("x" * 5000, '"a\\0b"', "/dev/zero", "..", "/etc/passwd"):
        path.write_text(good.replace("arm: panda", f"arm: {part}"))
        with pytest.raises(ConfigError) as error:
            load_robot(path)
        assert "\n" not in str(error.value) or part == "/etc/passwd"


FRANKIE = load_robot("frankie")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A copy of the template."""
    path = tmp_path / "ours.yaml"
    path.write_text((SHIPPED / "frankie_site.yaml").read_text())
    return path


@pytest.mark.parametrize("name", ["emulated", "frankie_site"])
def test_the_shipped_files_are_good(name: str) -> None:
    real = load_real_robot(name)
    assert Path(real.body).name == "frankie.yaml"
    assert load_robot(name).name == name


def test_shipped_files_are_found_from_anywhere(tmp_path, monkeypatch):
    """By name, and as the path that they have in a checkout."""
    monkeypatch.chdir(tmp_path)
    for robot in ("emulated", "robots/emulated.yaml", Path("robots/frankie.yaml")):
        assert load_robot(robot).name == Path(robot).stem
    with pytest.raises(ConfigError, match="did you mean `emulated`"):
        load_real_robot("robots/emulatd.yaml")


def test_the_template_is_slow_brakes_as_its_base_does_and_is_not_emulated(file: Path) -> None:
    robot, real = load_robot(file), load_real_robot(file)
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
    assert real.hardware.base.site.forward == 0.67
    assert real.calibrated == ("camera_mount",)
    np.testing.assert_allclose(load_robot(file).camera.eTc.translation, [0.05, 0.0, -0.09])
    file.with_name("site.yaml").unlink()
    with pytest.raises(ConfigError, match="doctor --write-site"):
        load_robot(file)


@pytest.mark.parametrize("row", MISTAKES["sites"], ids=lambda row: row["tells"])
def test_a_mistake_in_the_file_of_a_real_robot_is_told(file: Path, row: dict[str, str]) -> None:
    edit(file, row["old"], row["new"])
    with pytest.raises(ConfigError) as error:
        load_robot(file)
    assert row["tells"] in str(error.value)
