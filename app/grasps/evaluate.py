"""How often the first choice of grasp works, on scenes that were never trained on.

The camera comes down on the tracked grasp as it does on the robot, until the grasp is locked. Then
the hand goes straight down and closes: the grasp works if nothing is touched on the way and the
fingers hold. The object is taken away, and the next one is tried until the container is empty.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
from pinocchio import SE3

from behaviours.names import Region
from hw import DepthFrame
from hw.sim import D435Noise, DepthRenderer, World, hand_shapes, load_scene
from hw.sim.robot import CAMERA, TOOL_TO_CAMERA
from perception import Detection, GraspDetector, GraspEstimate, GraspTracker, Workspace

FIRST_SEED = 1_000_000
"""Seeds from here on are not trained on."""
_STANDOFF = 0.12
_FRAMES = 40
_APPROACH = 0.2  # share of the remaining way in one frame
_MAX_FAILURES = 8

_CONTAINER = Region(
    name="container",
    wTr=SE3(np.eye(3), np.array([3.0, 0.0, 0.556])),
    size=np.array([0.44, 0.36, 0.20]),
)
_ABOVE = SE3(np.diag([1.0, -1.0, -1.0]), np.array([2.935, 0.0, 0.85]))


def evaluate(detector: GraspDetector, scene: str, seeds: range) -> Counter[str]:
    """Empty one container for every seed; how often each attempt ended in which way.

    Raises:
        SceneError: there is no such scene, or it is not a good one.
    """
    ends: Counter[str] = Counter()
    for seed in seeds:
        ends.update(empty_container(load_scene(scene, seed), detector, seed))
    return ends


def empty_container(world: World, detector: GraspDetector, seed: int) -> list[str]:
    """Grasp until nothing is left or too many grasps have failed; how each attempt ended."""
    rng = np.random.default_rng(seed)
    tracker = GraspTracker()
    ends: list[str] = []
    while world.objects and sum(end != "held" for end in ends) < _MAX_FAILURES:
        grasp = come_near(world, detector, tracker, rng)
        if grasp is None:
            ends.append(f"no grasp: {tracker.reason}")
            tracker.forget()
            continue
        end = execute(world, grasp)
        ends.append(end)
        if world.held is not None:
            world.objects.remove(world.held)
            world.held = None
            tracker.forget()
        else:
            tracker.reject(grasp.wTg)
    return ends


def come_near(
    world: World, detector: GraspDetector, tracker: GraspTracker, rng: np.random.Generator
) -> GraspEstimate | None:
    """Follow one grasp from above the container until it is locked; None if there is none."""
    tracker.reset()
    wTe = _ABOVE
    grasp = None
    for _ in range(_FRAMES):
        wTc = wTe * TOOL_TO_CAMERA
        detection = look(world, wTe, detector, _CONTAINER, rng)
        grasp = tracker.update(detection, wTc)
        if tracker.locked:
            break
        if grasp is not None:
            goal = grasp.wTg * SE3(np.eye(3), np.array([0.0, 0.0, -_STANDOFF]))
            wTe = SE3.Interpolate(wTe, goal, _APPROACH)
    return grasp


def look(
    world: World,
    wTe: SE3,
    detector: GraspDetector,
    workspace: Workspace | None,
    rng: np.random.Generator,
) -> Detection:
    """What is found in one noisy frame from the wrist."""
    wTc = wTe * TOOL_TO_CAMERA
    depth = DepthRenderer(CAMERA).render([*world.shapes(), *hand_shapes(wTe, 0.08)], wTc)
    depth = D435Noise().apply(depth, CAMERA, rng)
    frame = DepthFrame(depth=depth, intrinsics=CAMERA, wTc=wTc, stamp=0.0)
    return detector.detect(frame, workspace)


def execute(world: World, grasp: GraspEstimate) -> str:
    """Go down, close, and say how it ended: `held`, or what went wrong."""
    for height in np.linspace(_STANDOFF, 0.0, 25):
        wTe = grasp.wTg * SE3(np.eye(3), np.array([0.0, 0.0, -height]))
        if hit := world.collision(wTe, grasp.opening):
            return f"touched {'a wall' if 'wall' in hit else 'an object'} on the way down"
    return world.close_fingers(grasp.wTg, grasp.opening, 20.0).reason.value
