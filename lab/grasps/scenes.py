"""Random scenes to train and evaluate the grasp networks on, and random views of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pinocchio import SE3, exp3

from behaviours import Region
from config.arrays import Array
from hw import DepthFrame
from hw.sim import (
    Container,
    D435Noise,
    DepthRenderer,
    Fixture,
    Objects,
    Scene,
    SceneError,
    SimObject,
    Table,
    Visible,
    World,
    build_world,
)
from hw.sim.objects import HOUSEHOLD
from lab.grasps.objects import HELDOUT, TRAIN
from robots import load_robot

ROBOT = load_robot("frankie")
FLOOR = 0.456  # height of the support surface [m]
OBJECT_WIDTHS = (5.0, 70.0)  # range of the smallest width by which the objects can be grasped [mm]
TRAINING_CLASSES: tuple[str, ...] = (*HOUSEHOLD, *TRAIN)
HELDOUT_CLASSES: tuple[str, ...] = tuple(HELDOUT)
"""Classes of the objects in evaluation scenes; none is in training scenes."""
EVALUATION_SEED = 1_000_000
"""First number of the seeds of evaluation scenes; training scenes have smaller ones."""

_HEIGHT = (0.24, 0.65)  # of the camera above the floor [m]
_TILT = (0.0, np.radians(15.0))  # of the optical axis from straight down [rad]
_STEEP_HEIGHT = (0.4, 0.9)  # the same for steep views [m]
_STEEP_TILT = (np.radians(15.0), np.radians(50.0))
_OFF_TARGET = 0.12  # largest offset of the view from an object, along x and along y [m]
_BARE = 0.3  # share of the scenes without a container wall
_ON_TABLE = 0.5  # share of the scenes with a large surface around
_SINGLE = 0.25  # share of the training scenes with one object
_CLUTTER = (2, 11)  # number of objects in the others, the upper bound excluded

_AROUND = Fixture(name="around", centre=(0.0, 0.0, FLOOR - 0.011), size=(2.0, 2.0, 0.02))


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """A camera that looks at a scene."""

    wTc: SE3  # camera in the world
    noise: D435Noise


def random_world(
    rng: np.random.Generator, classes: Sequence[str], count: int
) -> tuple[World, Region]:
    """Objects of some classes around the origin; see `world_with`."""
    return world_with(Objects(count=count, kinds=tuple(classes), width_mm=OBJECT_WIDTHS), rng)


def world_with(
    objects: Objects, rng: np.random.Generator, *, bare: bool = False
) -> tuple[World, Region]:
    """Objects around the origin, in a container or on a bare surface, on a pedestal or a table.

    If `bare`, never in a container. Returns the world and the region in which to grasp: inside the
    walls.
    """
    while True:
        open_sides, on_table = rng.random() < _BARE or bare, rng.random() < _ON_TABLE
        inner = rng.uniform((0.32, 0.30), (0.56, 0.50))
        scene = Scene(
            container=Container(
                centre=(0.0, 0.0),
                inner_size=(inner[0], inner[1]),
                floor_height=FLOOR,
                wall_height=0.001 if open_sides else rng.uniform(0.02, 0.08),
            ),
            table=Table(centre=(0.0, 3.0)),
            fixtures=(_AROUND,) if on_table else (),
            objects=objects,
        )
        try:
            world = build_world(scene, rng)
        except SceneError:  # these objects do not fit: draw others
            continue
        region = Region(
            name="inside",
            mTr=SE3(np.eye(3), np.array([0.0, 0.0, FLOOR + 0.1])),
            size=np.array([*inner, 0.2]),
        )
        return world, region


def training_count(rng: np.random.Generator) -> int:
    """A random number of objects in a training scene: one, or more often two to ten."""
    return 1 if rng.random() < _SINGLE else int(rng.integers(*_CLUTTER))


def random_view(world: World, rng: np.random.Generator, *, steep: bool = False) -> View:
    """A view of one of the objects or of the surface next to it.

    Steep views are from farther away and at 15 to 50 degrees, others at less than 15 degrees.
    """
    height = rng.uniform(*(_STEEP_HEIGHT if steep else _HEIGHT))
    target = world.objects[rng.integers(len(world.objects))].pose.translation
    x, y = target[:2] + rng.uniform(-_OFF_TARGET, _OFF_TARGET, 2) * min(height / _HEIGHT[1], 1.0)
    tilt = rng.uniform(*(_STEEP_TILT if steep else _TILT))
    tilt_about, yaw = rng.uniform(-np.pi, np.pi, 2)
    down = exp3(np.array([np.pi, 0.0, 0.0]))
    lean = exp3(tilt * np.array([np.cos(tilt_about), np.sin(tilt_about), 0.0]))
    turn = exp3(np.array([0.0, 0.0, yaw]))
    # A tilted camera stands back, so that its optical axis meets the target.
    axis = lean @ np.array([0.0, 0.0, -1.0])
    x, y = np.array([x, y]) + axis[:2] / axis[2] * height
    wTc = SE3(lean @ turn @ down, np.array([x, y, FLOOR + height]))
    return View(wTc=wTc, noise=camera_noise(rng.random()))


def noisy_frame(
    shapes: Sequence[Visible], wTc: SE3, noise: D435Noise, rng: np.random.Generator
) -> DepthFrame:
    """What the robot's camera sees of shapes from a pose."""
    camera = ROBOT.camera
    depth = DepthRenderer(camera.intrinsics).render(shapes, wTc)
    noisy = noise.apply(depth, camera, rng)
    return DepthFrame(depth=noisy, intrinsics=camera.intrinsics, oTc=wTc, stamp=0.0)


def camera_noise(level: float) -> D435Noise:
    """The camera's noise, from the least (0) to the most (1)."""
    return D435Noise(
        disparity_noise=0.04 + 0.10 * level,
        edge_loss=0.4 + 0.5 * level,
        speckle=0.002 + 0.020 * level,
    )


def nearest_object(world: World, point: Array) -> SimObject:
    """The object whose frame is nearest to a (3,) point of the world [m]."""
    return min(world.objects, key=lambda o: float(np.linalg.norm(o.pose.translation - point)))


def class_of(obj: SimObject) -> str:
    """Class of a simulated object, whose name is the class and a number."""
    return obj.name.rpartition(" ")[0]
