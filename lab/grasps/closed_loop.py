"""Closed-loop evaluation: how often a grasp holds when the camera approaches it frame by frame.

The wrist camera approaches the tracked grasp until it is locked; then the hand descends and closes.
The grasp holds if the hand touches nothing on the way and the contacts carry the object, which is
then removed. An object is given up after three attempts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from behaviours import Region
from hw import DepthFrame
from hw.sim import D435Noise, Hand, Objects, World, build_world, read_scene
from lab.grasps.scenes import (
    EVALUATION_SEED,
    HELDOUT_CLASSES,
    OBJECT_WIDTHS,
    ROBOT,
    camera_noise,
    class_of,
    nearest_object,
    noisy_frame,
)
from perception import GraspDetector, GraspEstimate, GraspTracker, SceneMemory

ATTEMPTS = 3
"""At each object."""
OBJECTS = 8
"""In a container."""
HELD = "held"
"""End of a successful attempt."""

_STANDOFF = 0.12  # of the tool above the grasp while the camera approaches [m]
_FRAMES = 40  # of an approach at most
_APPROACH = 0.2  # share of the remaining distance per frame
_DESCENT_STEPS = 25  # poses at which collisions are checked
_FORCE = 20.0  # of the closing fingers [N]

CONTAINER = Region(
    name="container",
    wTr=SE3(np.eye(3), np.array([3.0, 0.0, 0.556])),
    size=np.array([0.44, 0.36, 0.20]),
)
"""The inside of the container of the scene `household`."""
_START = SE3(np.diag([1.0, -1.0, -1.0]), np.array([2.935, 0.0, 0.85]))  # wTe, above it


@dataclass(frozen=True, kw_only=True)
class Pick:
    """The attempts at one object."""

    object_class: str
    """Of the object that was held, or the one nearest to the last grasp."""
    ends: tuple[str, ...]
    """The end of each attempt; the last is `HELD` if the object was picked."""

    @property
    def held(self) -> bool:
        """Whether the object was picked."""
        return self.ends[-1] == HELD


def heldout_container(seed: int) -> World:
    """A container with objects of held-out classes."""
    scene = read_scene("household").model_copy(
        update={"objects": Objects(count=OBJECTS, kinds=HELDOUT_CLASSES, width_mm=OBJECT_WIDTHS)}
    )
    return build_world(scene, np.random.default_rng((EVALUATION_SEED, seed)))


def empty_container(world: World, detector: GraspDetector, seed: int) -> list[Pick]:
    """Pick until nothing is left; an object that was not picked in `ATTEMPTS` is removed."""
    rng = np.random.default_rng((EVALUATION_SEED, seed, 1))
    noise = camera_noise(rng.random())
    tracker = GraspTracker()
    picks: list[Pick] = []
    while world.objects:
        ends: list[str] = []
        target = world.objects[0]
        while len(ends) < ATTEMPTS and HELD not in ends:
            grasp = approach_grasp(world, detector, tracker, noise, rng)
            if grasp is None:
                ends.append(f"no grasp: {tracker.reason}")
                tracker.forget()
                continue
            target = nearest_object(world, grasp.wTg.translation)
            ends.append(execute_grasp(world, grasp))
            tracker.reject(grasp.wTg)
        removed = world.held or target
        world.held = None
        world.objects.remove(removed)
        tracker.forget()
        picks.append(Pick(object_class=class_of(removed), ends=tuple(ends)))
    return picks


def approach_grasp(
    world: World,
    detector: GraspDetector,
    tracker: GraspTracker,
    noise: D435Noise,
    rng: np.random.Generator,
) -> GraspEstimate | None:
    """Approach the tracked grasp from above the container until it is locked.

    Returns:
        The grasp; None if there is none, and the tracker says why.
    """
    tracker.reset()
    memory = SceneMemory()
    wTe = _START
    grasp = None
    for _ in range(_FRAMES):
        frame = wrist_frame(world, wTe, noise, rng)
        grasp = tracker.update(detector.detect(frame, CONTAINER, memory), frame.wTc)
        if tracker.locked:
            break
        if grasp is not None:
            goal = grasp.wTg * SE3(np.eye(3), np.array([0.0, 0.0, -_STANDOFF]))
            wTe = SE3.Interpolate(wTe, goal, _APPROACH)
    return grasp


def wrist_frame(world: World, wTe: SE3, noise: D435Noise, rng: np.random.Generator) -> DepthFrame:
    """A noisy frame of the wrist camera, with the open hand in it."""
    hand = Hand(ROBOT.gripper, wTe).shapes(ROBOT.gripper.opening)
    return noisy_frame([*world.shapes(), *hand], wTe * ROBOT.camera.eTc, noise, rng)


def execute_grasp(world: World, grasp: GraspEstimate) -> str:
    """Descend and close.

    Returns:
        `HELD`, or the reason of the failure.
    """
    for height in np.linspace(_STANDOFF, 0.0, _DESCENT_STEPS):
        wTe = grasp.wTg * SE3(np.eye(3), np.array([0.0, 0.0, -height]))
        if hit := world.collision(Hand(ROBOT.gripper, wTe), grasp.opening):
            return f"touched {'a wall' if 'wall' in hit else 'an object'} on the way down"
    return world.close_fingers(Hand(ROBOT.gripper, grasp.wTg), grasp.opening, _FORCE).reason.value
