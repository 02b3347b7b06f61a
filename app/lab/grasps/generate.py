"""Training data for the grasp networks: what the camera measures, and what would be right there.

Each scene is seen once exactly, from high above, which gives the true heights; the check of the
hand on those says for points all over the objects and every closing direction whether a grasp works
(antipodal within the friction cone, room for the fingers and the palm). Then the wrist camera looks
from several places, with its noise, and each cell takes the answer of the point that it shows.

Shards of a data set depend on the seed and their number alone, so they may be made side by side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from app.lab.grasps.scenes import (
    FLOOR,
    LEARNT,
    ROBOT,
    View,
    random_count,
    random_view,
    random_world,
)
from hw.sim import DepthRenderer, World
from perception.geometry import world_points
from perception.grasp_feasibility import assess
from perception.height_map import HeightMap, height_map
from perception.maps import BINS, CELLS, STRIDE
from perception.preprocess import central_square, prepare
from perception.samples import Labels, Sample, Shard
from robots import Intrinsics

Array = npt.NDArray[np.float64]

SPACING = 0.005
"""Between the points that are judged [m]."""
VIEWS = 4
"""Images of each scene."""
STEEP = 0.25
"""Share of the images that are taken from the side."""
SHARD_SCENES = 64
"""Scenes to a shard."""

_HIGH = 2.5  # from here above the floor the scene is seen exactly [m]
_EXTENT = 0.66  # side of the square that is seen from there [m]
_EXACT_SIZE = 540
_SAME_SURFACE = 0.006  # a cell shows a judged point if their heights differ by less [m]


def write_shards(folder: Path, count: int, seed: int, workers: int) -> Iterator[Path]:
    """Make the shards of a data set that are not there yet; yields each as it is ready.

    Args:
        folder: where they go.
        count: how many shards.
        seed: of everything in them.
        workers: processes to use.
    """
    folder.mkdir(parents=True, exist_ok=True)
    numbers = [n for n in range(count) if not shard_path(folder, seed, n).is_file()]
    write = partial(_write_shard, folder, seed)
    if workers <= 1:
        yield from map(write, numbers)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        yield from pool.map(write, numbers)


def shard_path(folder: Path, seed: int, number: int) -> Path:
    """Where a shard of a data set lies."""
    return folder / f"seed{seed}-{number:04d}.npz"


def _write_shard(folder: Path, seed: int, number: int) -> Path:
    cv2.setNumThreads(1)
    path = shard_path(folder, seed, number)
    scenes = range(number * SHARD_SCENES, (number + 1) * SHARD_SCENES)
    Shard.of([sample for scene in scenes for sample in samples_of(seed, scene)]).save(path)
    return path


def samples_of(seed: int, number: int) -> list[Sample]:
    """`VIEWS` samples of one scene; the same seed and number give the same."""
    rng = np.random.default_rng((seed, number))
    world, _ = random_world(rng, LEARNT, random_count(rng))
    truth = judge(world)
    return [
        see(world, truth, random_view(world, rng, steep=rng.random() < STEEP), rng)
        for _ in range(VIEWS)
    ]


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """What would be right at points all over the objects, on a grid of `SPACING`."""

    origin: Array
    """(2,) x and y of cell (0, 0) [m]."""
    height: npt.NDArray[np.float32]
    """(rows, columns) surface height; NaN where there is no object [m]."""
    quality: npt.NDArray[np.float32]
    """(rows, columns, BINS) for closing directions i π / BINS, from x towards y of the world."""
    width: npt.NDArray[np.float32]
    """(rows, columns, BINS) [m]."""


def exact_view(world: World) -> tuple[HeightMap, Array, npt.NDArray[np.bool_]]:
    """The world from high above without noise.

    Returns:
        Its height map, the (N, N, 3) points seen, and the (N, N) mask of those on objects.
    """
    centre = (_EXACT_SIZE - 1) / 2.0
    focal = _HIGH * _EXACT_SIZE / _EXTENT
    camera = Intrinsics(
        width=_EXACT_SIZE, height=_EXACT_SIZE, fx=focal, fy=focal, cx=centre, cy=centre
    )
    wTc = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, FLOOR + _HIGH]))
    depth, ids = DepthRenderer(camera).render(world.shapes(), wTc, with_ids=True)
    pixels = np.arange(_EXACT_SIZE, dtype=float)
    grid = (pixels[None, :], pixels[:, None])
    points = world_points(depth, camera, wTc, *grid)
    return height_map(depth, camera, wTc, *grid), points, ids >= len(world.fixtures)


def judge(world: World) -> Truth:
    """Judge every closing direction at points all over the objects, on exact heights."""
    scene, points, on_object = exact_view(world)
    size = round(_EXTENT / SPACING) + 1
    origin = np.array([-0.5 * _EXTENT, -0.5 * _EXTENT])
    column, row = np.rint((points[on_object][:, :2] - origin) / SPACING).astype(int).T
    covered = np.zeros((size, size), dtype=bool)
    covered[np.clip(row, 0, size - 1), np.clip(column, 0, size - 1)] = True
    row, column = np.nonzero(covered)
    x, y = origin[0] + SPACING * column, origin[1] + SPACING * row
    surface = scene.at(x, y)
    standing = surface > FLOOR + 0.004
    row, column, surface = row[standing], column[standing], surface[standing]
    x, y = x[standing], y[standing]

    height = np.full((size, size), np.nan, dtype=np.float32)
    quality = np.zeros((size, size, BINS), dtype=np.float32)
    width = np.zeros((size, size, BINS), dtype=np.float32)
    height[row, column] = surface
    for index in range(BINS):
        direction = np.full(len(x), index * np.pi / BINS)
        grasps = assess(scene, x, y, direction, FLOOR)
        centred = np.clip((0.011 - np.abs(grasps.offset)) / 0.008, 0.0, 1.0)
        quality[row, column, index] = grasps.score * centred
        width[row, column, index] = grasps.width
    smooth = 0.5 * quality + 0.25 * (np.roll(quality, 1, axis=2) + np.roll(quality, -1, axis=2))
    return Truth(origin=origin, height=height, quality=np.minimum(quality, smooth), width=width)


def see(world: World, truth: Truth, view: View, rng: np.random.Generator) -> Sample:
    """What one frame of the wrist camera becomes for a network, with its labels.

    Args:
        world: what to look at.
        truth: what is right there.
        view: from where, and with which noise.
        rng: of the noise.
    """
    along_axis = float((FLOOR - view.wTc.translation[2]) / view.wTc.rotation[2, 2])
    camera = ROBOT.camera.intrinsics
    square = central_square((camera.height, camera.width), camera, along_axis)
    part = Intrinsics(
        width=square.size,
        height=square.size,
        fx=camera.fx,
        fy=camera.fy,
        cx=camera.cx - square.u0,
        cy=camera.cy - square.v0,
    )
    exact, ids = DepthRenderer(part).render(world.shapes(), view.wTc, with_ids=True)
    measured = view.noise.apply(exact, replace(ROBOT.camera, intrinsics=part), rng)
    whole = central_square(measured.shape, part, along_axis)
    prepared = prepare(measured, whole, part, view.wTc)

    middle = np.arange(STRIDE // 2, prepared.depth.shape[0], STRIDE)
    grid = np.stack(np.meshgrid(middle, middle), axis=-1).astype(float).reshape(-1, 2)
    u, v = np.clip(np.rint(whole.to_image(grid)), 0, square.size - 1).astype(int).T
    cell = np.flatnonzero(ids[v, u] >= len(world.fixtures))
    u, v = u[cell], v[cell]
    points = world_points(exact[v, u], part, view.wTc, u.astype(float), v.astype(float))
    quality, width = _labels(truth, points, view.wTc, part)
    return Sample(
        image=prepared.network_input,
        labels=Labels(
            cell=cell.astype(np.int16), quality=quality, width=width / np.float32(whole.scale)
        ),
    )


def _labels(
    truth: Truth, points: Array, wTc: SE3, camera: Intrinsics
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """(N, BINS) quality and width [px of the camera] at (N, 3) points, by direction in the image.

    The plane through a point and a direction in the image cuts the horizontal in the closing
    direction that is seen there; the truth is interpolated between the two directions next to it.
    """
    column, row = np.rint((points[:, :2] - truth.origin) / SPACING).astype(int).T
    row = np.clip(row, 0, truth.height.shape[0] - 1)
    column = np.clip(column, 0, truth.height.shape[1] - 1)
    with np.errstate(invalid="ignore"):
        known = np.abs(truth.height[row, column] - points[:, 2]) < _SAME_SURFACE

    angle = np.arange(BINS) * np.pi / BINS
    ray = (points - wTc.translation) @ wTc.rotation
    # A step along the image direction, in the camera's frame; angles count against v.
    step = np.stack([np.cos(angle), -np.sin(angle) * camera.fx / camera.fy, np.zeros(BINS)], axis=1)
    up = wTc.rotation[2]
    # Adding what keeps it horizontal along the ray does not change where it is seen.
    lift = -(step @ up)[None, :] / (ray @ up)[:, None]
    along = (step[None] + lift[..., None] * ray[:, None]) @ wTc.rotation.T
    direction = np.arctan2(along[..., 1], along[..., 0]) % np.pi * (BINS / np.pi)
    below = np.floor(direction).astype(int)
    part = (direction - below).astype(np.float32)

    def at(
        values: npt.NDArray[np.float32], index: npt.NDArray[np.int64]
    ) -> npt.NDArray[np.float32]:
        found: npt.NDArray[np.float32] = values[row[:, None], column[:, None], index % BINS]
        return found

    quality = (1.0 - part) * at(truth.quality, below) + part * at(truth.quality, below + 1)
    width = (1.0 - part) * at(truth.width, below) + part * at(truth.width, below + 1)
    # A metre along the closing direction is so many pixels there.
    scale = camera.fx / ray[:, 2, None] / np.hypot(along[..., 0], along[..., 1])
    return (quality * known[:, None]).astype(np.float32), (width * scale).astype(np.float32)


def shards_of(images: int) -> int:
    """How many shards hold at least so many images."""
    return math.ceil(images / (VIEWS * SHARD_SCENES))


assert CELLS * STRIDE == 300, "labels and images cover the same square"
