"""`frankie-task grasp eval --tilts`: success by the tilt of the approach from straight down.

The same objects, lying or standing on a surface without walls, are seen and grasped along every
tilt, from one side. Importing this does not import MuJoCo.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pinocchio import SE3, exp3

from hw.sim import World
from lab.grasps.choice import NetworkChoice, all_results, require
from lab.grasps.results import NO_GRASP, Attempt, GraspEvaluation, Row
from lab.grasps.scenes import EVALUATION_SEED, FLOOR, Array, camera_noise, class_of
from robots import Box, Geom

if TYPE_CHECKING:
    from lab.grasps.dropped_scenes import DroppedScene

_DISTANCE = (0.4, 0.5)  # of the camera from the object [m]
_LOWEST = 0.1  # height of the camera over the floor: it is above the hand [m]
_ROOM = 1.8  # distance of the walls of the room from its middle [m]
_STREAM = 8  # of random numbers


class _Judged(NamedTuple):
    """A scene, and for every tilt the attempt and whether no random grasp held either."""

    name: str
    attempts: list[Attempt]
    hopeless: list[bool]


def evaluate_tilts(
    choice: NetworkChoice,
    tilts_deg: Sequence[float],
    *,
    scenes: int,
    by_chance: int = 0,
    workers: int | None,
) -> GraspEvaluation:
    """Every scene of one object along approaches of every tilt; a row for each.

    Raises ConfigError: MuJoCo is missing.
    """
    require("mujoco", "grasp eval --tilts")
    judged = all_results(
        "scenes",
        partial(_scene, choice, tilts_deg, by_chance),
        range(scenes),
        workers,
        lambda one: all(attempt.held for attempt in one.attempts),
    )
    rows = tuple(
        Row(
            name=f"{choice.name}, {tilt_deg:g}°",
            singles=tuple(one.attempts[number] for one in judged),
            bins=(),
            hopeless=tuple(n for n, one in enumerate(judged) if one.hopeless[number]),
        )
        for number, tilt_deg in enumerate(tilts_deg)
    )
    return GraspEvaluation(scenes=tuple(one.name for one in judged), rows=rows, by_chance=by_chance)


def _scene(choice: NetworkChoice, tilts_deg: Sequence[float], by_chance: int, seed: int) -> _Judged:
    from behaviours import LOOKS
    from lab.grasps.grasp_judge import best_grasp, execute, holds_by_chance

    scene = bare_scene(seed, 1)
    (obj,) = scene.world.objects
    attempts, hopeless = [], []
    for tilt_deg in tilts_deg:
        rng = np.random.default_rng((EVALUATION_SEED, _STREAM, seed))
        wRa = approach(np.radians(tilt_deg), rng.uniform(-np.pi, np.pi))
        wTc = looking_along(wRa, obj.pose.translation, rng)
        noise = camera_noise(rng.random())
        grasp = best_grasp(
            choice.detector(), scene.world, scene.region, wTc, noise, rng, looks=LOOKS, wRa=wRa
        )
        attempt = Attempt(end=NO_GRASP)
        if grasp is not None:
            attempt = execute(*scene.hand(wRa), grasp)
        attempts.append(attempt)
        is_tried = by_chance > 0 and not attempt.held
        hopeless.append(is_tried and not holds_by_chance(scene, by_chance, seed, wRa))
    return _Judged(f"{scene.group}, {class_of(obj)}", attempts, hopeless)


def bare_scene(seed: int, count: int, group: str | None = None) -> DroppedScene:
    """Objects at rest on a surface without walls, in a room; in every other scene they stand."""
    from lab.grasps.dropped_scenes import drop_scene

    scene = drop_scene(seed, count, group=group, bare=True, standing=seed % 2 == 1)
    return replace(scene, world=_in_a_room(scene.world))


def _in_a_room(world: World) -> World:
    """The world with walls, which are behind everything in a level view."""
    walls = [
        Geom(Box((_ROOM, _ROOM, _ROOM)), SE3(np.eye(3), 2.0 * _ROOM * side), "wall")
        for side in (*np.eye(3)[:2], *-np.eye(3)[:2])
    ]
    return World([*world.fixtures, *walls], world.objects, surfaces=world.surfaces)


def approach(tilt: float, about: float) -> Array:
    """WRa (3, 3) of an approach at a tilt from straight down, leant about a level axis [rad]."""
    wRa: Array = exp3(tilt * np.array([np.cos(about), np.sin(about), 0.0]))
    return wRa


def looking_along(wRa: Array, target: Array, rng: np.random.Generator) -> SE3:
    """WTc of a camera that looks at a (3,) point along -z of a, or from a little above."""
    at = target + rng.uniform(*_DISTANCE) * wRa[:, 2]
    at[2] = max(at[2], FLOOR + _LOWEST)
    yaw = rng.uniform(-np.pi, np.pi)
    x, z = wRa @ np.array([np.cos(yaw), np.sin(yaw), 0.0]), target - at
    z /= np.linalg.norm(z)
    y = np.cross(z, x)
    y /= np.linalg.norm(y)
    return SE3(np.stack([np.cross(y, z), y, z], axis=1), at)
