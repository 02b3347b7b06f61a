"""Robots from a person's own files: what is wrong is told with its place, what is right works."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from pinocchio import SE3

from config import ConfigError
from controller import RobotModel, SelfCollision
from hw import SimClock
from hw.sim import World, kinematic_robot
from robots import Geom, Plane, load_robot
from robots.load import SHIPPED


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


@pytest.mark.parametrize(
    ("file", "old", "new", "told"),
    [
        ("frankie.yaml", "lag: 0.10", "lagg: 0.10", "8:3: base.lagg: unknown key; did"),
        ("frankie.yaml", "reverse: 0.25", "", "9:3: base.limits.reverse: is missing"),
        ("frankie.yaml", "[1.0, 0.0, 1.05]", "[1.0, 0.5, 1.05]", "a differential drive has no"),
        ("frankie.yaml", "arm: panda", "arm: pandda", "17:6: arm: no part is called `pandda`; did"),
        ("frankie.yaml", "[0, -1, 0]", "[0, -2, 0]", "rotation: the rows of a rotation matrix"),
        ("frankie.yaml", "  rotation:", "  rpy_deg: [0, 0, 0]\n  rotation:", "give either"),
        ("frankie.yaml", "laser: ld60_laser", "", "`laser` and `laser_mount` belong together"),
        ("parts/ld60_laser.yaml", "range: 15.0", "range: -1", "max_range: expected a number of"),
        ("parts/panda.yaml", "0.0, -2.2, 0.0", "0.0, 2.2, 0.0", "16:8: ready: joint 4 is"),
        ("parts/panda.yaml", "-1.7628, 1.7628", "1.7628, -1.7628", "7:66: joints.1.position: the"),
        ("parts/panda.yaml", "link3, link5", "link3, link9", "no link is called `link9`; did"),
        ("parts/panda.yaml", "0.00015, 8.2299e-6]", "0.1, 0.0]", "inertia.0: no body has these"),
        ("parts/franka_hand.yaml", "[0.0, 0.0040,", "[0.0, 0.0050,", "pad: the inner face"),
        ("parts/franka_hand.yaml", "radius: 0.14", "radius: 0.12", "ball: palm and fingers"),
        ("parts/d435.yaml", "[0.175, 3.0]", "[3.0, 0.175]", "depth_range: the lower bound"),
    ],
)
def test_a_mistake_is_told_with_its_place(
    folder: Path, file: str, old: str, new: str, told: str
) -> None:
    edit(folder / file, old, new)
    with pytest.raises(ConfigError) as error:
        load_robot(folder / "frankie.yaml")
    assert str(error.value).startswith(f"{folder / file}:")
    assert told in str(error.value)


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
