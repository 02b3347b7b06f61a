"""Scenes for the grasp network to learn from and be judged on: what lies there, and how it is seen.

Objects lie alone or in clutter, in a container of random size and height or on a bare surface; the
wrist camera looks from a random height and tilt, with the noise of a good or of a bad day.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pinocchio import SE3, exp3

from behaviours.named import Region
from hw.sim import (
    HELDOUT,
    HOUSEHOLD,
    TRAIN,
    Container,
    D435Noise,
    Fixture,
    Objects,
    Scene,
    SceneError,
    SimObject,
    Table,
    World,
    build_world,
)
from robots import load_robot

Array = npt.NDArray[np.float64]

FLOOR = 0.456
"""Height of what the objects stand on [m]."""
ROBOT = load_robot("frankie")
"""The robot that looks at the scenes and grasps in them."""
LEARNT: tuple[str, ...] = (*HOUSEHOLD, *TRAIN)
"""The kinds of object that are learnt from."""
HELD_OUT: tuple[str, ...] = tuple(HELDOUT)
"""The kinds of object that are judged on."""

FIRST_SEED = 1_000_000
"""What is judged on is made from seeds that begin with this number, and never learnt from."""

_HEIGHT = (0.24, 0.65)  # of the camera above the floor [m]
_TILT = (0.0, np.radians(15.0))
_STEEP_HEIGHT = (0.4, 0.9)
_STEEP_TILT = (np.radians(15.0), np.radians(50.0))
_BESIDE = 0.12  # the camera looks this far beside an object at most, along x or y [m]


_AROUND = Fixture(name="around", centre=(0.0, 0.0, FLOOR - 0.011), size=(2.0, 2.0, 0.02))


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """How a scene is seen."""

    wTc: SE3
    """Camera in the world."""
    height: float
    """Of the camera above the floor [m]."""
    tilt: float
    """Of the optical axis from straight down [rad]."""
    trouble: float
    """How noisy it is: 0 on the best day of the camera, 1 on the worst."""
    noise: D435Noise


def random_world(
    rng: np.random.Generator, kinds: Sequence[str], count: int
) -> tuple[World, Region]:
    """Some objects about the origin, in a container or on a bare surface, high up or on a table.

    Args:
        rng: where the randomness comes from.
        kinds: names of `hw.sim.OBJECT_CLASSES`.
        count: how many objects.

    Returns:
        The world, and where in it things are to be grasped: inside the walls.
    """
    while True:
        bare, on_table = rng.random() < 0.3, rng.random() < 0.5
        inner = rng.uniform((0.32, 0.30), (0.56, 0.50))
        scene = Scene(
            container=Container(
                centre=(0.0, 0.0),
                inner_size=(inner[0], inner[1]),
                floor_height=FLOOR,
                wall_height=0.001 if bare else rng.uniform(0.02, 0.08),
            ),
            table=Table(centre=(0.0, 3.0)),
            fixtures=(_AROUND,) if on_table else (),
            objects=Objects(count=count, classes=tuple(kinds), width_mm=(5.0, 70.0)),
        )
        try:
            world = build_world(scene, rng)
        except SceneError:  # these objects do not fit; others will
            continue
        region = Region(
            name="inside",
            wTr=SE3(np.eye(3), np.array([0.0, 0.0, FLOOR + 0.1])),
            size=np.array([*inner, 0.2]),
        )
        return world, region


def random_count(rng: np.random.Generator) -> int:
    """How many objects: one or, more often, up to ten."""
    return 1 if rng.random() < 0.25 else int(rng.integers(2, 11))


def random_view(world: World, rng: np.random.Generator, *, steep: bool = False) -> View:
    """The camera looking at one of the objects, or beside it.

    Args:
        world: what to look at.
        rng: where the randomness comes from.
        steep: from farther away and the side, as no wrist camera does; else from above.
    """
    height = rng.uniform(*(_STEEP_HEIGHT if steep else _HEIGHT))
    target = world.objects[rng.integers(len(world.objects))].pose.translation
    x, y = target[:2] + rng.uniform(-_BESIDE, _BESIDE, 2) * min(height / _HEIGHT[1], 1.0)
    tilt = rng.uniform(*(_STEEP_TILT if steep else _TILT))
    tilt_about, yaw = rng.uniform(-np.pi, np.pi, 2)
    down = exp3(np.array([np.pi, 0.0, 0.0]))
    lean = exp3(tilt * np.array([np.cos(tilt_about), np.sin(tilt_about), 0.0]))
    turn = exp3(np.array([0.0, 0.0, yaw]))
    # The tilted camera stands where the middle of its image still shows the place.
    axis = lean @ np.array([0.0, 0.0, -1.0])
    x, y = np.array([x, y]) + axis[:2] / axis[2] * height
    trouble = rng.random()
    return View(
        wTc=SE3(lean @ turn @ down, np.array([x, y, FLOOR + height])),
        height=height,
        tilt=tilt,
        trouble=trouble,
        noise=noise(trouble),
    )


def noise(trouble: float) -> D435Noise:
    """The camera's noise, from the best day (0) to the worst (1)."""
    return D435Noise(
        disparity_noise=0.04 + 0.10 * trouble,
        edge_loss=0.4 + 0.5 * trouble,
        speckle=0.002 + 0.020 * trouble,
    )


def nearest_object(world: World, place: Array) -> SimObject:
    """The object whose centre of mass is nearest to a (3,) point of the world [m]."""
    return min(world.objects, key=lambda o: float(np.linalg.norm(o.pose.translation - place)))


def kind_of(thing: SimObject) -> str:
    """Kind of a simulated object, whose name is that and a number."""
    return thing.name.rpartition(" ")[0]
