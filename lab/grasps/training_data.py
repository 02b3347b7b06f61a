"""Training data of the grasp networks: noisy depth images with exact, dense labels.

Each scene is rendered once without noise from high above, which gives its exact height map. The
grasp feasibility of points all over the objects, in every closing direction, labels it. Each cell
of a noisy image of the wrist camera takes the labels of the point that it shows. A shard depends
only on the seed of its data set and its number.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from pinocchio import SE3

from config.arrays import Array, Image, Indices, Mask
from hw.sim import DepthRenderer, World
from lab.grasps.scenes import (
    FLOOR,
    ROBOT,
    TRAINING_CLASSES,
    View,
    random_view,
    random_world,
    training_count,
)
from lab.grasps.training_samples import Labels, Sample, Shard
from lab.shared import run_all
from perception import (
    ANGLE_BINS,
    OUTPUT_STRIDE,
    DepthCloud,
    HeightMap,
    assess,
    build_height_map,
    prepare,
    scaled_crop,
    world_points,
)
from robots import Intrinsics

SPACING = 0.005  # between labelled points [m]
VIEWS = 4  # images per scene
STEEP_VIEWS = 0.25  # share of the images that are steep views
SHARD_SCENES = 64  # scenes per shard

_CAMERA_HEIGHT = 2.5  # of the exact view, above the floor [m]
_EXTENT = 0.66  # side of the square of the floor in the exact view [m]
_EXACT_SIZE = 540  # side of the exact view [px]
_MIN_HEIGHT = 0.004  # of a labelled point above the floor [m]
_CENTRED, _OFF_CENTRE = 0.003, 0.011  # offsets with full quality and with none [m]
_SAME_SURFACE = 0.006  # a cell shows a labelled point if their heights differ by less [m]


def write_shards(folder: Path, count: int, seed: int, workers: int | None) -> Iterator[Path]:
    """Write the missing ones of `count` shards, and yield their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    numbers = [n for n in range(count) if not shard_path(folder, seed, n).is_file()]
    for _, path in run_all(partial(_write_shard, folder, seed), numbers, workers=workers, batch=1):
        yield path


def shard_path(folder: Path, seed: int, number: int) -> Path:
    """Path of a shard."""
    return folder / f"seed{seed}-{number:04d}.npz"


def _write_shard(folder: Path, seed: int, number: int) -> Path:
    cv2.setNumThreads(1)
    path = shard_path(folder, seed, number)
    scenes = range(number * SHARD_SCENES, (number + 1) * SHARD_SCENES)
    Shard.of([sample for scene in scenes for sample in samples_of(seed, scene)]).save(path)
    return path


def samples_of(seed: int, number: int) -> list[Sample]:
    """`VIEWS` samples of one scene, determined by seed and number."""
    rng = np.random.default_rng((seed, number))
    world, _ = random_world(rng, TRAINING_CLASSES, training_count(rng))
    labels = label_world(world)
    return [
        render_sample(world, labels, random_view(world, rng, steep=rng.random() < STEEP_VIEWS), rng)
        for _ in range(VIEWS)
    ]


@dataclass(frozen=True, kw_only=True, eq=False)
class WorldLabels:
    """Labels at points all over the objects, on a grid of `SPACING`."""

    origin: Array  # (2,) x and y of cell (0, 0) [m]
    height: Image  # (rows, columns) surface [m]; NaN where there is no object
    quality: Image
    """(rows, columns, ANGLE_BINS), direction i π / ANGLE_BINS from x towards y of the world."""
    width: Image  # (rows, columns, ANGLE_BINS) [m]


def exact_view(world: World) -> tuple[HeightMap, Array, Mask]:
    """Render the world from high above without noise.

    Returns its height map, the (N, N, 3) visible points, and the (N, N) mask of those on objects.
    """
    centre = (_EXACT_SIZE - 1) / 2.0
    focal = _CAMERA_HEIGHT * _EXACT_SIZE / _EXTENT
    camera = Intrinsics(
        width=_EXACT_SIZE, height=_EXACT_SIZE, fx=focal, fy=focal, cx=centre, cy=centre
    )
    wTc = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, FLOOR + _CAMERA_HEIGHT]))
    depth, ids = DepthRenderer(camera).render_with_ids(world.shapes(), wTc)
    pixels = np.arange(_EXACT_SIZE, dtype=float)
    grid = (pixels[None, :], pixels[:, None])
    points = world_points(depth, camera, wTc, *grid)
    cloud = DepthCloud(depth=depth, intrinsics=camera, oTc=wTc)
    return build_height_map(cloud), points, ids >= len(world.fixtures)


def label_world(world: World) -> WorldLabels:
    """Label every closing direction at points all over the objects, on exact heights."""
    scene, points, on_object = exact_view(world)
    size = round(_EXTENT / SPACING) + 1
    origin = np.array([-0.5 * _EXTENT, -0.5 * _EXTENT])
    column, row = np.rint((points[on_object][:, :2] - origin) / SPACING).astype(int).T
    covered = np.zeros((size, size), dtype=bool)
    covered[np.clip(row, 0, size - 1), np.clip(column, 0, size - 1)] = True
    row, column = np.nonzero(covered)
    x, y = origin[0] + SPACING * column, origin[1] + SPACING * row
    surface = scene.at(x, y)
    standing = surface > FLOOR + _MIN_HEIGHT
    row, column, surface = row[standing], column[standing], surface[standing]
    x, y = x[standing], y[standing]

    height = np.full((size, size), np.nan, dtype=np.float32)
    quality = np.zeros((size, size, ANGLE_BINS), dtype=np.float32)
    width = np.zeros((size, size, ANGLE_BINS), dtype=np.float32)
    height[row, column] = surface
    for index in range(ANGLE_BINS):
        direction = np.full(len(x), index * np.pi / ANGLE_BINS)
        grasps = assess(scene, x, y, direction, FLOOR, ROBOT.gripper)
        off_centre = _OFF_CENTRE - np.abs(grasps.offset)
        centred = np.clip(off_centre / (_OFF_CENTRE - _CENTRED), 0.0, 1.0)
        quality[row, column, index] = grasps.score * centred
        width[row, column, index] = grasps.width
    smooth = 0.5 * quality + 0.25 * (np.roll(quality, 1, axis=2) + np.roll(quality, -1, axis=2))
    return WorldLabels(
        origin=origin, height=height, quality=np.minimum(quality, smooth), width=width
    )


def render_sample(
    world: World, labels: WorldLabels, view: View, rng: np.random.Generator
) -> Sample:
    """Render one noisy image of the wrist camera, and label its cells."""
    along_axis = float((FLOOR - view.wTc.translation[2]) / view.wTc.rotation[2, 2])
    camera = ROBOT.camera.intrinsics
    crop = scaled_crop((camera.height, camera.width), camera, along_axis)
    part = Intrinsics(
        width=crop.size,
        height=crop.size,
        fx=camera.fx,
        fy=camera.fy,
        cx=camera.cx - crop.u0,
        cy=camera.cy - crop.v0,
    )
    exact, ids = DepthRenderer(part).render_with_ids(world.shapes(), view.wTc)
    measured = view.noise.apply(exact, replace(ROBOT.camera, intrinsics=part), rng)
    whole = scaled_crop(measured.shape, part, along_axis)
    prepared = prepare(DepthCloud(depth=measured, intrinsics=part, oTc=view.wTc), whole)

    middle = np.arange(OUTPUT_STRIDE // 2, prepared.depth.shape[0], OUTPUT_STRIDE)
    grid = np.stack(np.meshgrid(middle, middle), axis=-1).astype(float).reshape(-1, 2)
    u, v = np.clip(np.rint(whole.to_image(grid)), 0, crop.size - 1).astype(int).T
    cell = np.flatnonzero(ids[v, u] >= len(world.fixtures))
    u, v = u[cell], v[cell]
    points = world_points(exact[v, u], part, view.wTc, u.astype(float), v.astype(float))
    quality, width = _labels_at(labels, points, view.wTc, part)
    return Sample(
        image=prepared.network_input,
        labels=Labels(
            cell=cell.astype(np.int16), quality=quality, width=width / np.float32(whole.scale)
        ),
    )


def _labels_at(
    labels: WorldLabels, points: Array, wTc: SE3, camera: Intrinsics
) -> tuple[Image, Image]:
    """(N, ANGLE_BINS) quality and width [px of the camera] at (N, 3) points.

    Column i is for the closing direction that appears at the angle i π / ANGLE_BINS in the image,
    where the horizontal plane meets the plane through camera, point and image direction. Labels are
    interpolated between the two adjacent directions in the world.
    """
    column, row = np.rint((points[:, :2] - labels.origin) / SPACING).astype(int).T
    row = np.clip(row, 0, labels.height.shape[0] - 1)
    column = np.clip(column, 0, labels.height.shape[1] - 1)
    with np.errstate(invalid="ignore"):
        known = np.abs(labels.height[row, column] - points[:, 2]) < _SAME_SURFACE

    angle = np.arange(ANGLE_BINS) * np.pi / ANGLE_BINS
    ray = (points - wTc.translation) @ wTc.rotation
    # A step along the image direction, in the camera's frame; angles are measured against v.
    step = np.stack(
        [np.cos(angle), -np.sin(angle) * camera.fx / camera.fy, np.zeros(ANGLE_BINS)], axis=1
    )
    up = wTc.rotation[2]
    # Moving its end along the ray makes the step horizontal without changing its image.
    lift = -(step @ up)[None, :] / (ray @ up)[:, None]
    along = (step[None] + lift[..., None] * ray[:, None]) @ wTc.rotation.T
    direction = np.arctan2(along[..., 1], along[..., 0]) % np.pi * (ANGLE_BINS / np.pi)
    below = np.floor(direction).astype(int)
    part = (direction - below).astype(np.float32)

    def at(values: Image, index: Indices) -> Image:
        found: Image = values[row[:, None], column[:, None], index % ANGLE_BINS]
        return found

    quality = (1.0 - part) * at(labels.quality, below) + part * at(labels.quality, below + 1)
    width = (1.0 - part) * at(labels.width, below) + part * at(labels.width, below + 1)
    # Pixels per metre along the closing direction.
    scale = camera.fx / ray[:, 2, None] / np.hypot(along[..., 0], along[..., 1])
    return (quality * known[:, None]).astype(np.float32), (width * scale).astype(np.float32)


def shard_count(images: int) -> int:
    """Number of shards with at least this many images."""
    return math.ceil(images / (VIEWS * SHARD_SCENES))
