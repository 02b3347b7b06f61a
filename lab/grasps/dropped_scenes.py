"""Scenes for the judge: objects that were dropped and have come to rest.

A third of the scenes are shapes made of primitives, a third bodies with curved and hollow surfaces,
a third the same bodies stretched and heavy. No network is trained on any of them. A folder of
meshes replaces them all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pinocchio import SE3, Quaternion, exp3

from behaviours import Region
from config.reader import ConfigError
from extensions.physics.floating_hand import FloatingHand
from hw.sim import Objects, SimObject, World
from hw.sim.objects import MODELLED
from lab.grasps.objects import RANDOM_BODIES
from lab.grasps.scenes import (
    EVALUATION_SEED,
    FLOOR,
    HELDOUT_CLASSES,
    OBJECT_WIDTHS,
    ROBOT,
    TRAINING_CLASSES,
    world_with,
)
from perception import WALL_MARGIN
from robots import Array, Box, Capsule, Cylinder, Geom, Hull, Sphere, hull_of

GROUPS = {"shapes": HELDOUT_CLASSES, "modelled": tuple(MODELLED), "large": tuple(MODELLED)}
"""Classes of objects; in a bin only two are large."""
PARKED = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, FLOOR + 1.5]))
"""Pose of the hand while the camera captures; it is not in the image."""
UPRIGHT = np.eye(3)  # rotation of the frame a, along whose -z a hand points straight down

_CLASSES = {
    **GROUPS,
    "heavy": HELDOUT_CLASSES,
    "trained": TRAINING_CLASSES,
    "trained, drawn out": TRAINING_CLASSES,
    "bodies": tuple(RANDOM_BODIES),
    "bodies, drawn out": tuple(RANDOM_BODIES),
    "trained, as they are": TRAINING_CLASSES,
    "bodies, as they are": tuple(RANDOM_BODIES),
}
_HEAVIER = ("trained", "heavy")  # groups with the masses of large objects
_VARIED = ("trained, drawn out", "bodies", "bodies, drawn out")  # most are stretched, all heavier
_STRETCHED = 0.7  # share of them that are stretched
_LENGTH = (0.18, 0.30)  # of large objects [m]
_MASS = (0.1, 0.8)  # of large objects [kg]
_CLEARANCE = 0.01  # of a dropped object above what is below it [m]
_FALLING, _RESTING = 3.0, 0.3  # longest time to come to rest, and to do so again [s]
_TRIES = 50


@dataclass(frozen=True, kw_only=True, eq=False)
class DroppedScene:
    """Objects at rest, and the region in which to grasp."""

    group: str  # one of `GROUPS`, or `meshes`
    world: World
    region: Region

    def hand(self, wRa: Array = UPRIGHT) -> tuple[FloatingHand, World]:
        """A hand along -z of a in a copy of the world: these objects stay where they are."""
        objects = [replace(obj) for obj in self.world.objects]
        world = World(self.world.fixtures, objects, surfaces=self.world.surfaces)
        return at_rest(world, wRa), world


def drop_scene(
    seed: int,
    count: int,
    meshes: Sequence[Path] = (),
    group: str | None = None,
    *,
    bare: bool = False,
    standing: bool = False,
) -> DroppedScene:
    """The scene of a seed: objects fallen in any orientation, all within the walls.

    They are of a `group`, None for one of `GROUPS` in turn, or from `meshes`; if `bare`, there are
    no walls; `standing` ones were put down with their longest side upright. Raises SceneError: a
    mesh cannot be read.
    """
    if group is None:
        group = "meshes" if meshes else tuple(GROUPS)[seed % len(GROUPS)]
    for attempt in range(_TRIES):
        rng = np.random.default_rng((EVALUATION_SEED, 2, seed, count, attempt))
        world, region = world_with(_objects(group, count, meshes, seed, rng), rng, bare=bare)
        if group in _VARIED:
            varied = [_varied(obj, rng) for obj in world.objects]
            world = World(world.fixtures, varied, surfaces=world.surfaces)
        if group == "large":
            large = [_stretched(obj, rng) for obj in world.objects[:2]]
            world = World(world.fixtures, [*large, *world.objects[2:]])
        if group in _HEAVIER:
            heavier = [_heavier(obj, rng) for obj in world.objects]
            world = World(world.fixtures, heavier, surfaces=world.surfaces)
        _stack(world.objects, region, rng, standing)
        hand = FloatingHand(ROBOT, world, PARKED)
        if hand.settle(_FALLING) and all(is_inside(obj, region) for obj in world.objects):
            return DroppedScene(group=group, world=world, region=region)
    raise ConfigError(f"the objects of scene {seed} come to rest nowhere within the walls")


def is_inside(obj: SimObject, region: Region) -> bool:
    """Whether an object is far enough from the walls to be grasped."""
    where = obj.pose.translation
    room = np.array([WALL_MARGIN + 0.012, WALL_MARGIN + 0.012, 0.0])
    return bool(region.contains(np.array([where + side * room for side in (-1.0, 1.0)])).all())


def at_rest(world: World, wRa: Array = UPRIGHT) -> FloatingHand:
    """A parked hand along -z of a in a world of objects at rest."""
    hand = FloatingHand(ROBOT, world, SE3(wRa @ PARKED.rotation, PARKED.translation))
    hand.settle(_RESTING)
    return hand


def _objects(
    group: str, count: int, meshes: Sequence[Path], seed: int, rng: np.random.Generator
) -> Objects:
    if not meshes:
        return Objects(count=count, kinds=_CLASSES[group], width_mm=OBJECT_WIDTHS)
    # In single scenes every mesh has its turn.
    turns = [meshes[seed % len(meshes)]]
    if count > 1:
        turns = [meshes[number] for number in rng.integers(0, len(meshes), count)]
    return Objects.model_validate({"items": [{"mesh": str(path)} for path in turns]})


def _varied(obj: SimObject, rng: np.random.Generator) -> SimObject:
    return _stretched(obj, rng) if rng.random() < _STRETCHED else _heavier(obj, rng)


def _heavier(obj: SimObject, rng: np.random.Generator) -> SimObject:
    """The object with another mass."""
    return replace(obj, mass=float(rng.uniform(*_MASS)))


def _stretched(obj: SimObject, rng: np.random.Generator) -> SimObject:
    """The object with its longest side stretched and another mass."""
    parts = [(part, _corners(part)) for part in obj.parts]
    corners = np.concatenate([of_part for _, of_part in parts])
    extent = np.ptp(corners, axis=0)
    stretch = np.ones(3)
    longest = int(extent.argmax())
    stretch[longest] = max(1.0, rng.uniform(*_LENGTH) / extent[longest])
    return replace(
        obj,
        parts=tuple(hull_of(of * stretch, part.name, part.colour) for part, of in parts),
        mass=float(rng.uniform(*_MASS)),
    )


def _corners(part: Geom) -> Array:
    """(N, 3) points whose convex hull approximates a part, in the frame of its object [m]."""
    shape = part.shape
    if isinstance(shape, Hull):
        corners = shape.vertices
    elif isinstance(shape, Box):
        corners = _CUBE * np.array(shape.half)
    elif isinstance(shape, Sphere):
        corners = _BALL * shape.radius
    elif isinstance(shape, Cylinder):
        angle = np.arange(_SIDES) * (2.0 * np.pi / _SIDES)
        ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * shape.radius
        ends = (-shape.half_length, shape.half_length)
        corners = np.concatenate([np.insert(ring, 2, z, axis=1) for z in ends])
    else:
        assert isinstance(shape, Capsule)
        end = np.array([0.0, 0.0, shape.half_length])
        corners = np.concatenate([_BALL * shape.radius + side * end for side in (1.0, -1.0)])
    placed: Array = corners @ part.pose.rotation.T + part.pose.translation
    return placed


def _sphere_points(count: int) -> Array:
    """(N, 3) points spread evenly over the unit sphere, along a spiral."""
    at = np.arange(count) + 0.5
    polar, azimuth = np.arccos(1.0 - 2.0 * at / count), np.pi * (1.0 + np.sqrt(5.0)) * at
    return np.stack(
        [np.cos(azimuth) * np.sin(polar), np.sin(azimuth) * np.sin(polar), np.cos(polar)], axis=1
    )


_CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
_BALL, _SIDES = _sphere_points(60), 20


def _stack(
    objects: Sequence[SimObject], region: Region, rng: np.random.Generator, standing: bool
) -> None:
    """Place the objects one above the other, randomly turned, over the middle of the region."""
    height = FLOOR
    for obj in objects:
        turn = _upright(obj, rng) if standing else _random_rotation(rng)
        spread = np.maximum(region.size[:2] / 2.0 - obj.radius - 0.03, 0.0)
        xy = region.oTr.translation[:2] + rng.uniform(-spread, spread)
        obj.pose = SE3(turn, np.zeros(3))
        low = obj.reach(np.array([0.0, 0.0, -1.0]))
        high = obj.reach(np.array([0.0, 0.0, 1.0]))
        obj.pose = SE3(turn, np.array([*xy, height + _CLEARANCE + low]))
        height += _CLEARANCE + low + high


def _upright(obj: SimObject, rng: np.random.Generator) -> Array:
    """(3, 3) with the longest side upright, randomly turned about it."""
    obj.pose = SE3.Identity()
    extent = [obj.reach(axis) + obj.reach(-axis) for axis in np.eye(3)]
    longest = np.roll(np.eye(3), 2 - int(np.argmax(extent)), axis=0)
    turn: Array = exp3(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)])) @ longest
    return turn


def _random_rotation(rng: np.random.Generator) -> Array:
    """(3, 3) uniformly distributed."""
    x, y, z, w = rng.standard_normal(4)
    turn: Array = Quaternion(w, x, y, z).normalized().toRotationMatrix()
    return turn
