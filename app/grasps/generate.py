"""Training scenes for the grasp network: what the camera measures, and what would be right there.

Objects lie in a container or on a bare surface. They are seen once exactly, from high above, which
gives the true heights; the check of the hand on those says for points all over the objects and
every closing direction whether a grasp works. Then the wrist camera looks from several places, with
its noise, and each pixel takes the answer of the point that it shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pinocchio import SE3, exp3

from hw import Intrinsics
from hw.sim import D435Noise, DepthRenderer, SceneError, World
from hw.sim.layout import build_world
from hw.sim.robot import CAMERA
from hw.sim.scene import Container, Objects, Scene, Table
from perception.check import assess
from perception.height_map import HeightMap, height_map, world_points
from perception.preprocess import central_square, prepare
from perception.training import LABEL_STRIDE, Labels, Sample

Array = npt.NDArray[np.float64]

DIRECTIONS = 16
"""Closing directions that are judged at each point."""
SPACING = 0.005
"""Between the points that are judged [m]."""
VIEWS = 3
"""Images of each scene."""

_FLOOR = 0.456
_HIGH = 2.5  # from here above the floor the scene is seen exactly [m]
_EXTENT = 0.66  # side of the square that is seen from there [m]
_EXACT_SIZE = 540
_HEIGHT = (0.22, 0.65)  # of the camera above the floor [m]
_BESIDE = 0.12  # the camera is this far beside an object at most, along x or y [m]
_TILT = np.radians(10.0)
_SAME_SURFACE = 0.006  # a pixel shows a judged point if their heights differ by less [m]
_X_PREFERENCE = 0.1  # by how much the closing direction along u is preferred to that along v


def generate(scenes: int, seed: int, first: int = 0) -> list[Sample]:
    """`VIEWS` samples of each of `scenes` scenes.

    Args:
        scenes: how many scenes.
        seed: the same seed and numbers give the same samples.
        first: number of the first scene, so that several calls continue one another.
    """
    samples = []
    for number in range(first, first + scenes):
        rng = np.random.default_rng((seed, number))
        world = random_world(rng)
        truth = judge(world, _FLOOR)
        samples += [
            view(world, truth, random_camera(world, rng), _FLOOR, rng) for _ in range(VIEWS)
        ]
    return samples


def random_world(rng: np.random.Generator) -> World:
    """One to twelve objects in a container of random size and height, or on a bare surface."""
    while True:
        bare = rng.random() < 0.25
        inner = rng.uniform((0.30, 0.28), (0.48, 0.44))
        count = 1 if rng.random() < 0.2 else int(rng.integers(2, 13))
        scene = Scene(
            container=Container(
                centre=(0.0, 0.0),
                inner_size=(inner[0], inner[1]),
                floor_height=_FLOOR,
                wall_height=0.001 if bare else rng.uniform(0.02, 0.08),
            ),
            table=Table(centre=(0.0, 3.0)),
            objects=Objects(count=count),
        )
        try:
            return build_world(scene, rng)
        except SceneError:  # these objects do not fit; others will
            continue


def random_camera(world: World, rng: np.random.Generator) -> SE3:
    """Camera in the world, wTc, looking down from somewhere above one of the objects."""
    height = rng.uniform(*_HEIGHT)
    target = world.objects[rng.integers(len(world.objects))].pose.translation
    x, y = target[:2] + rng.uniform(-_BESIDE, _BESIDE, 2)
    yaw = rng.uniform(-np.pi, np.pi)
    tilt_about = rng.uniform(-np.pi, np.pi)
    tilt = _TILT * rng.random()
    down = exp3(np.array([np.pi, 0.0, 0.0]))
    lean = exp3(tilt * np.array([np.cos(tilt_about), np.sin(tilt_about), 0.0]))
    turn = exp3(np.array([0.0, 0.0, yaw]))
    return SE3(lean @ turn @ down, np.array([x, y, _FLOOR + height]))


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """What would be right at points all over the objects, on a grid of `SPACING`."""

    origin: Array
    """(2,) x and y of cell (0, 0) [m]."""
    height: npt.NDArray[np.float32]
    """(rows, columns) surface height; NaN where there is no object [m]."""
    quality: npt.NDArray[np.float32]
    """(rows, columns, DIRECTIONS)."""
    width: npt.NDArray[np.float32]
    """(rows, columns, DIRECTIONS) [m]."""


def exact_view(world: World) -> tuple[HeightMap, npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """The world from high above without noise.

    Returns:
        Its height map, the (N, N, 3) points seen, and the (N, N) mask of those on objects.
    """
    centre = (_EXACT_SIZE - 1) / 2.0
    focal = _HIGH * _EXACT_SIZE / _EXTENT
    camera = Intrinsics(
        width=_EXACT_SIZE, height=_EXACT_SIZE, fx=focal, fy=focal, cx=centre, cy=centre
    )
    wTc = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, _FLOOR + _HIGH]))
    depth, ids = DepthRenderer(camera).render(world.shapes(), wTc, with_ids=True)
    pixels = np.arange(_EXACT_SIZE, dtype=float)
    points = world_points(depth, camera, wTc, pixels[None, :], pixels[:, None])
    return height_map(points, wTc), points, ids >= len(world.fixtures)


def judge(world: World, floor: float) -> Truth:
    """Judge every closing direction at points all over the objects, on exact heights.

    Args:
        world: what to judge; around the origin.
        floor: height of what the objects stand on [m].
    """
    scene, points, on_object = exact_view(world)
    size = round(_EXTENT / SPACING) + 1
    origin = np.array([-0.5 * _EXTENT, -0.5 * _EXTENT])
    column, row = np.rint((points[on_object][:, :2] - origin) / SPACING).astype(int).T
    covered = np.zeros((size, size), dtype=bool)
    covered[np.clip(row, 0, size - 1), np.clip(column, 0, size - 1)] = True
    row, column = np.nonzero(covered)
    x, y = origin[0] + SPACING * column, origin[1] + SPACING * row
    surface = scene.at(x, y)
    standing = surface > floor + 0.004
    row, column, surface = row[standing], column[standing], surface[standing]
    x, y = x[standing], y[standing]

    height = np.full((size, size), np.nan, dtype=np.float32)
    quality = np.zeros((size, size, DIRECTIONS), dtype=np.float32)
    width = np.zeros((size, size, DIRECTIONS), dtype=np.float32)
    height[row, column] = surface
    for index in range(DIRECTIONS):
        direction = np.full(len(x), index * np.pi / DIRECTIONS)
        grasps = assess(scene, x, y, direction, floor)
        centred = np.clip((0.011 - np.abs(grasps.offset)) / 0.008, 0.0, 1.0)
        quality[row, column, index] = grasps.score * centred
        width[row, column, index] = grasps.width
    smooth = 0.5 * quality + 0.25 * (np.roll(quality, 1, axis=2) + np.roll(quality, -1, axis=2))
    return Truth(origin=origin, height=height, quality=np.minimum(quality, smooth), width=width)


def view(
    world: World,
    truth: Truth,
    wTc: SE3,
    floor: float,
    rng: np.random.Generator,
    noise: D435Noise | None = None,
) -> Sample:
    """What one frame of the wrist camera becomes for the network, with its labels.

    Args:
        world: what to look at.
        truth: what is right there.
        wTc: camera in the world.
        floor: height of what the objects stand on [m].
        rng: of the camera's noise.
        noise: of the camera; None for that of a D435.
    """
    along_axis = (floor - wTc.translation[2]) / wTc.rotation[2, 2]
    square = central_square((CAMERA.height, CAMERA.width), CAMERA, along_axis)
    part = Intrinsics(
        width=square.size,
        height=square.size,
        fx=CAMERA.fx,
        fy=CAMERA.fy,
        cx=CAMERA.cx - square.u0,
        cy=CAMERA.cy - square.v0,
    )
    exact, ids = DepthRenderer(part).render(world.shapes(), wTc, with_ids=True)
    measured = (noise or D435Noise()).apply(exact, part, rng)
    whole = central_square(measured.shape, part, along_axis)
    assert whole.size == square.size
    prepared = prepare(measured, whole)

    middle = np.arange(LABEL_STRIDE // 2, prepared.depth.shape[0], LABEL_STRIDE)
    grid = np.stack(np.meshgrid(middle, middle), axis=-1).astype(float)
    pixel = whole.to_image(grid)
    u, v = np.clip(np.rint(pixel), 0, square.size - 1).astype(int).transpose(2, 0, 1)
    points = world_points(exact[v, u], part, wTc, u.astype(float), v.astype(float))
    on_object = ids[v, u] >= len(world.fixtures)
    return Sample(
        image=prepared.network_input,
        labels=_labels(truth, points, on_object, wTc, part, whole.scale),
    )


def _labels(
    truth: Truth,
    points: Array,
    on_object: npt.NDArray[np.bool_],
    wTc: SE3,
    camera: Intrinsics,
    scale: float,
) -> Labels:
    """Best direction at each pixel, and what it looks like in the image."""
    column, row = np.rint((points[..., :2] - truth.origin) / SPACING).astype(int).transpose(2, 0, 1)
    row = np.clip(row, 0, truth.height.shape[0] - 1)
    column = np.clip(column, 0, truth.height.shape[1] - 1)
    with np.errstate(invalid="ignore"):
        same = np.abs(truth.height[row, column] - points[..., 2]) < _SAME_SURFACE
    quality = truth.quality[row, column] * (same & on_object)[..., None]

    direction = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
    horizontal = np.stack([np.cos(direction), np.sin(direction), np.zeros(DIRECTIONS)], axis=1)
    along = horizontal @ wTc.rotation  # closing directions in the camera's frame
    ray = (points - wTc.translation) @ wTc.rotation
    x, y, z = (ray[..., i, None] for i in range(3))
    du = (along[:, 0] * z - x * along[:, 2]) / z**2 * camera.fx / scale
    dv = (along[:, 1] * z - y * along[:, 2]) / z**2 * camera.fy / scale
    angle = np.arctan2(-dv, du)  # the network counts against v
    # Where directions are equally good the image has to decide, or their average is learnt.
    best = (quality * (1.0 + _X_PREFERENCE * np.cos(2.0 * angle))).argmax(axis=2)[..., None]

    def of_best(values: npt.NDArray[np.floating]) -> npt.NDArray[np.float32]:
        return np.take_along_axis(values, best, axis=2)[..., 0].astype(np.float32)

    return Labels(
        quality=of_best(quality),
        angle=of_best(angle) % np.pi,
        width=of_best(truth.width[row, column] * np.hypot(du, dv)),
        on_object=on_object,
    )
