"""Judge of grasps by physics: the hand closes on rigid bodies, lifts and shakes what it holds.

It shares with the feasibility check neither friction nor contacts nor height map, only the
dimensions of the hand and the camera.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pinocchio import SE3, exp3

from behaviours import DOUBTFUL, LOOK_HEIGHT, LOOKS, Region, straight_down
from extensions.physics.floating_hand import FloatingHand
from hw.sim import D435Noise, Hand, SimObject, World
from lab.grasps.choice import NetworkChoice
from lab.grasps.dropped_scenes import PARKED, UPRIGHT, DroppedScene, drop_scene, is_inside
from lab.grasps.results import BIN, HELD, NO_GRASP, Attempt, BinResult
from lab.grasps.scenes import (
    EVALUATION_SEED,
    FLOOR,
    ROBOT,
    Array,
    class_of,
    nearest_object,
    noisy_frame,
    random_view,
)
from perception import GraspDetector, GraspEstimate, segment_objects

ATTEMPTS = 3  # attempts at each object of a bin
MAX_FAILURES = 4  # failed attempts in a row after which a bin is given up

_ABOVE, _NEAR = 0.35, 0.06  # of the hand over the floor, and the grasp, before it descends [m]
_FAST, _SLOW, _LIFTING = 0.25, 0.1, 0.2  # speeds of the hand [m/s]
_FORCE, _HOLDING = 40.0, 0.3  # of each finger [N], and time before lifting [s]
_LIFT, _MIN_LIFTED = 0.2, 0.1  # motion of the hand, and smallest one of the object [m]
_SHAKE = np.array([0.015, 0.015, 0.015, 0.3])  # amplitude along x, y, z and about z [m, rad]
_RATE, _SHAKING = 3.0, 1.5  # [Hz, s]
_VIEW_STREAM, _GRASP_STREAM = 3, 6  # of random numbers
_UP = np.array([0.0, 0.0, 1.0])
_DOWN = np.diag([1.0, -1.0, -1.0])
_HALF_TURN = SE3(np.diag([-1.0, -1.0, 1.0]), np.zeros(3))
_DRAWS = 100  # of a random grasp


def judge_single(
    choices: Sequence[NetworkChoice], meshes: Sequence[Path], seed: int
) -> tuple[str, str, list[Attempt]]:
    """Execute the best grasp of every choice on one object; all see the same first frame.

    Returns the group and the class of the object, and an attempt by each choice.
    """
    scene = drop_scene(seed, 1, meshes)
    attempts = []
    for choice in choices:
        rng = np.random.default_rng((EVALUATION_SEED, _VIEW_STREAM, seed))
        grasp = _random_view_grasp(choice, scene.world, scene.region, rng)
        attempts.append(Attempt(end=NO_GRASP) if grasp is None else execute(*scene.hand(), grasp))
    return scene.group, class_of(scene.world.objects[0]), attempts


def judge_bin(
    choices: Sequence[NetworkChoice], meshes: Sequence[Path], seed: int
) -> list[BinResult]:
    """Let every choice empty the same bin, with a new frame before each attempt."""
    scene = drop_scene(seed, BIN, meshes)
    return [_empty(scene, choice, seed) for choice in choices]


def _empty(scene: DroppedScene, choice: NetworkChoice, seed: int) -> BinResult:
    rng = np.random.default_rng((EVALUATION_SEED, _VIEW_STREAM, seed, BIN))
    hand, world = scene.hand()
    attempts: list[Attempt] = []
    cleared = failures = 0
    while world.objects and failures < MAX_FAILURES and len(attempts) < ATTEMPTS * BIN:
        grasp = _random_view_grasp(choice, world, scene.region, rng)
        attempt = Attempt(end=NO_GRASP) if grasp is None else execute(hand, world, grasp)
        attempts.append(attempt)
        failures = 0 if attempt.held else failures + 1
        if attempt.held and (held := hand.pinched()):
            cleared += 1
            _remove(hand, world, held)
        hand.open(hand.opening)
        hand.put(PARKED, hand.opening)
        hand.settle(1.0)
        for obj in [obj for obj in world.objects if not is_inside(obj, scene.region)]:
            _remove(hand, world, obj)  # pushed out: lost, not cleared
    return BinResult(cleared=cleared, attempts=tuple(attempts))


def _random_view_grasp(
    choice: NetworkChoice, world: World, region: Region, rng: np.random.Generator
) -> GraspEstimate | None:
    view = random_view(world, rng)
    return best_grasp(choice.detector(), world, region, view.wTc, view.noise, rng, looks=LOOKS)


def best_grasp(
    detector: GraspDetector,
    world: World,
    region: Region,
    wTc: SE3,
    noise: D435Noise,
    rng: np.random.Generator,
    *,
    looks: int,
    wRa: Array | None = None,
) -> GraspEstimate | None:
    """The best grasp in a scene; None if there is none.

    `wTc` is the camera of the first frame. While there is no grasp or only a doubtful one, up to
    `looks` further frames come from straight above, as in the behaviour `grasp`; or, for an
    approach `wRa` (see `GraspDetector`), from the same direction as the first.
    """
    for remaining in reversed(range(looks + 1)):
        frame = noisy_frame(world.shapes(), wTc, noise, rng)
        grasps = detector.detect(frame, region, oRa=wRa).grasps
        if not remaining or (grasps and grasps[0].quality >= DOUBTFUL):
            break
        if grasps:
            point = grasps[0].oTg.translation
        elif objects := segment_objects(frame, region):
            point = max(objects, key=lambda one: one.area).position
        else:
            break
        if wRa is None:
            wTc = straight_down(point, LOOK_HEIGHT, like=wTc)
        else:
            wTc = SE3(wTc.rotation, point - LOOK_HEIGHT * wTc.rotation[:, 2])
    return grasps[0] if grasps else None


def execute(hand: FloatingHand, world: World, grasp: GraspEstimate) -> Attempt:
    """Approach to a grasp, close, lift and shake."""
    wTg = grasp.oTg
    target = class_of(nearest_object(world, wTg.translation))
    over = max(FLOOR + _ABOVE - wTg.translation[2], 2.0 * _NEAR)
    hand.put(_before(wTg, over), grasp.opening)
    hand.move(_before(wTg, _NEAR), _FAST)
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
    elif held is not gripped or held.pose.translation[2] < before + _MIN_LIFTED:
        end = "lost when shaken"
    else:
        end = HELD
    return Attempt(end=end, target_class=target, force=force, quality=grasp.quality)


def random_grasp_holds(tries: int, meshes: Sequence[Path], seed: int) -> bool:
    """Whether any of many random grasps from straight above holds the object of a scene."""
    return holds_by_chance(drop_scene(seed, 1, meshes), tries, seed)


def holds_by_chance(scene: DroppedScene, tries: int, seed: int, wRa: Array = UPRIGHT) -> bool:
    """Whether any of many random grasps along -z of a holds the object of a scene.

    The hand comes wide open, anywhere over the box around the object in a, in any closing
    direction, and to any depth down to where the finger tips meet the floor of that box. Only
    tries count for which the hand, its camera above, meets no furniture, and to find each
    `_DRAWS` are drawn at most.
    """
    (obj,) = scene.world.objects
    high, low = (np.array([side * obj.reach(side * axis) for axis in wRa.T]) for side in (1, -1))
    low[2] += ROBOT.gripper.tip
    rng = np.random.default_rng((EVALUATION_SEED, _GRASP_STREAM, seed))
    furniture = World(scene.world.fixtures, [], surfaces=scene.world.surfaces)
    for _ in range(tries):
        for _ in range(_DRAWS):
            centre, direction = rng.uniform(low, np.maximum(high, low)), rng.uniform(0.0, np.pi)
            wTg = SE3(wRa @ exp3(direction * _UP) @ _DOWN, wRa @ centre)
            if wTg.rotation[2, 0] < 0.0:
                wTg = wTg * _HALF_TURN
            if furniture.collision(Hand(ROBOT.gripper, wTg), ROBOT.gripper.opening) is None:
                break
        else:
            return False
        grasp = GraspEstimate(
            oTg=wTg,
            width=0.0,
            opening=ROBOT.gripper.opening,
            quality=0.0,
            stamp=0.0,
            pixel=(0.0, 0.0),
            angle=0.0,
        )
        if execute(*scene.hand(wRa), grasp).held:
            return True
    return False


def _before(wTe: SE3, distance: float) -> SE3:
    """The pose from which a hand comes along its approach."""
    return SE3(wTe.rotation, wTe.translation - distance * wTe.rotation[:, 2])


def _raised(wTe: SE3, height: float) -> SE3:
    return SE3(wTe.rotation, wTe.translation + np.array([0.0, 0.0, height]))


def _remove(hand: FloatingHand, world: World, obj: SimObject) -> None:
    """Remove an object from the world; in the physics it lies far away."""
    world.objects.remove(obj)
    hand.place(obj, SE3(np.eye(3), np.array([50.0 + len(world.objects), 0.0, 1.0])))
