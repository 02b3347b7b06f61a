"""Robots from a person's own files: what is wrong is told with its place, what is right works."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from pinocchio import SE3

from config import ConfigError
from controller import RobotModel, SelfCollision
from hw import SimClock
from hw.sim import World, kinematic_robot
from robots import Geom, Plane, load_robot
from robots.load import SHIPPED

MISTAKES = yaml.safe_load(Path(__file__).with_name("mistakes.yaml").read_text("utf-8"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the shipped files."""
    shutil.copytree(SHIPPED / "parts", tmp_path / "parts")
    for path in SHIPPED.glob("*.yaml"):
        shutil.copy(path, tmp_path)
    return tmp_path


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_an_unknown_robot_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(ConfigError, match=r"`frankee`; did you mean `frankie`\?"):
        load_robot("frankee")


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
    assert frame is not None
    assert frame.wTc.isApprox(expected, 1e-12)
