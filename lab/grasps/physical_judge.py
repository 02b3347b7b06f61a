"""The judge by physics: the hand closes on rigid bodies, lifts and shakes what it holds.

It knows nothing of the feasibility check: neither its friction nor its contacts nor its height map.
What it shares with it are the dimensions of the hand and the camera.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from pinocchio import SE3

from behaviours import Region
from hw.sim import SimObject, World
from hw.sim.physics import FloatingHand
from lab.grasps.choice import NetworkChoice
from lab.grasps.chosen import chosen_grasp
from lab.grasps.closed_loop import HELD, execute_grasp
from lab.grasps.physical_results import BIN, NO_GRASP, Attempt, BinResult
from lab.grasps.physical_scenes import PARKED, Dropped, dropped, is_inside
from lab.grasps.scenes import (
    EVALUATION_SEED,
    FLOOR,
    class_of,
    nearest_object,
    random_view,
)
from perception import GraspEstimate

ATTEMPTS = 3
"""At each object of a bin."""
IN_VAIN = 4
"""Attempts in a row after which a bin is given up."""

_ABOVE, _NEAR = 0.35, 0.06  # of the hand over the floor, and the grasp, before it descends [m]
_FAST, _SLOW, _LIFTING = 0.25, 0.1, 0.2  # speeds of the hand [m/s]
_FORCE, _HOLDING = 40.0, 0.3  # of each finger [N], and how long before lifting [s]
_LIFT, _HANGS = 0.2, 0.1  # how far it is lifted, and how far it has to come [m]
_SHAKE = np.array([0.015, 0.015, 0.015, 0.3])  # along x, y, z and about z [m, rad]
_RATE, _SHAKING = 3.0, 1.5  # [Hz, s]
_DRAWS_OF_VIEWS = 3  # the stream of random numbers that views are drawn from


def judge_single(
    seed: int, choices: Sequence[NetworkChoice], meshes: Sequence[Path] = ()
) -> tuple[str, str, list[Attempt]]:
    """The best grasp of every choice on one object, which all see first in the same frame.

    Returns:
        The group and the class of the object, and an attempt by each choice.
    """
    scene = dropped(seed, 1, meshes)
    attempts = []
    for choice in choices:
        rng = np.random.default_rng((EVALUATION_SEED, _DRAWS_OF_VIEWS, seed))
        grasp = _choose(choice, scene.world, scene.region, rng)
        if grasp is None:
            attempts.append(Attempt(end=NO_GRASP))
            continue
        hand, world = scene.hand()
        kinematic = execute_grasp(_copy(world), grasp)
        attempts.append(replace(execute(hand, world, grasp), kinematic=kinematic))
    return scene.group, class_of(scene.world.objects[0]), attempts


def judge_bin(
    seed: int, choices: Sequence[NetworkChoice], meshes: Sequence[Path] = ()
) -> tuple[str, list[BinResult]]:
    """Every choice empties the same bin; it looks anew before each attempt.

    Returns:
        The group of the objects, and what each choice achieved.
    """
    scene = dropped(seed, BIN, meshes)
    return scene.group, [_empty(scene, choice, seed) for choice in choices]


def _empty(scene: Dropped, choice: NetworkChoice, seed: int) -> BinResult:
    rng = np.random.default_rng((EVALUATION_SEED, _DRAWS_OF_VIEWS, seed, BIN))
    hand, world = scene.hand()
    attempts: list[Attempt] = []
    cleared = in_vain = 0
    while world.objects and in_vain < IN_VAIN and len(attempts) < ATTEMPTS * BIN:
        grasp = _choose(choice, world, scene.region, rng)
        attempt = Attempt(end=NO_GRASP) if grasp is None else execute(hand, world, grasp)
        attempts.append(attempt)
        in_vain = 0 if attempt.held else in_vain + 1
        if attempt.held and (held := hand.pinched()):
            cleared += 1
            _take_away(hand, world, held)
        hand.open(hand.opening)
        hand.put(PARKED, hand.opening)
        hand.settle(1.0)
        for obj in [obj for obj in world.objects if not is_inside(obj, scene.region)]:
            _take_away(hand, world, obj)  # pushed out: lost, not cleared
    return BinResult(cleared=cleared, attempts=tuple(attempts))


def _choose(
    choice: NetworkChoice, world: World, region: Region, rng: np.random.Generator
) -> GraspEstimate | None:
    view, looks = random_view(world, rng), choice.ranking.looks
    return chosen_grasp(choice.detector(), world, region, view.wTc, view.noise, rng, looks=looks)


def execute(hand: FloatingHand, world: World, grasp: GraspEstimate) -> Attempt:
    """Come down on a grasp, close, lift and shake."""
    wTg = grasp.wTg
    target = class_of(nearest_object(world, wTg.translation))
    over = max(FLOOR + _ABOVE - wTg.translation[2], _NEAR)
    hand.put(_raised(wTg, over), grasp.opening)
    hand.move(_raised(wTg, _NEAR), _FAST)
    hand.move(wTg, _SLOW)
    hand.close(_FORCE, _HOLDING)
    gripped, force = hand.pinched(), hand.hardest
    before = 0.0 if gripped is None else gripped.pose.translation[2]
    hand.move(_raised(wTg, _LIFT), _LIFTING)
    lifted = hand.pinched()
    hand.shake(_SHAKE, _RATE, _SHAKING)
    held = hand.pinched()
    if gripped is None:
        end = "nothing between the fingers"
    elif lifted is not gripped:
        end = "lost when lifted"
    elif held is not gripped or held.pose.translation[2] < before + _HANGS:
        end = "lost when shaken"
    else:
        end = HELD
    return Attempt(end=end, target_class=target, force=force, quality=grasp.quality)


def _raised(wTe: SE3, height: float) -> SE3:
    return SE3(wTe.rotation, wTe.translation + np.array([0.0, 0.0, height]))


def _take_away(hand: FloatingHand, world: World, obj: SimObject) -> None:
    """Out of the world; in the physics it lies on the floor, far away."""
    world.objects.remove(obj)
    hand.place(obj, SE3(np.eye(3), np.array([50.0 + len(world.objects), 0.0, 1.0])))


def _copy(world: World) -> World:
    objects = [replace(obj) for obj in world.objects]
    return World(world.fixtures, objects, surfaces=world.surfaces)
