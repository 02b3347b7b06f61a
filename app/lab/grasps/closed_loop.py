"""How often a grasp succeeds when the camera comes down on it, as it does on the robot.

The wrist camera approaches the tracked grasp frame by frame until it is locked; then the hand goes
straight down and closes. The grasp holds if nothing is touched on the way and the contacts carry
the object, which is then taken away. Three attempts are made before an object is given up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from app.lab.grasps.scenes import FIRST_SEED, HELD_OUT, ROBOT, kind_of, nearest_object, noise
from behaviours.named import Region
from hw import DepthFrame
from hw.sim import D435Noise, DepthRenderer, Hand, Objects, World, build_world, read_scene
from perception import Detection, GraspDetector, GraspEstimate, GraspTracker, Workspace

ATTEMPTS = 3
"""Made for each object."""
OBJECTS = 8
"""In a container."""
HELD = "held"
"""How an attempt ended well."""

_STANDOFF = 0.12
_FRAMES = 40
_APPROACH = 0.2  # share of the remaining way in one frame

CONTAINER = Region(
    name="container",
    wTr=SE3(np.eye(3), np.array([3.0, 0.0, 0.556])),
    size=np.array([0.44, 0.36, 0.20]),
)
"""Where things lie in the scene `household`."""
_ABOVE = SE3(np.diag([1.0, -1.0, -1.0]), np.array([2.935, 0.0, 0.85]))


@dataclass(frozen=True, kw_only=True)
class Pick:
    """What became of one object, or of the search for the next one."""

    kind: str
    """Of the object that was held in the end, or that the last grasp was nearest to."""
    ends: tuple[str, ...]
    """How each attempt ended; the last is `HELD` if the object was picked."""

    @property
    def held(self) -> bool:
        """Whether it was picked."""
        return self.ends[-1] == HELD


def unseen_container(seed: int) -> World:
    """A container of objects of kinds that nothing was learnt from."""
    scene = read_scene("household").model_copy(
        update={"objects": Objects(count=OBJECTS, classes=HELD_OUT, width_mm=(5.0, 70.0))}
    )
    return build_world(scene, np.random.default_rng((FIRST_SEED, seed)))


def empty_container(world: World, detector: GraspDetector, seed: int) -> list[Pick]:
    """Grasp until nothing is left; what cannot be picked is taken away after `ATTEMPTS`."""
    rng = np.random.default_rng((FIRST_SEED, seed, 1))
    camera = noise(rng.random())
    tracker = GraspTracker()
    picks: list[Pick] = []
    while world.objects:
        ends: list[str] = []
        last = world.objects[0]
        while len(ends) < ATTEMPTS and HELD not in ends:
            grasp = come_near(world, detector, tracker, camera, rng)
            if grasp is None:
                ends.append(f"no grasp: {tracker.reason}")
                tracker.forget()
                continue
            last = nearest_object(world, grasp.wTg.translation)
            ends.append(execute(world, grasp))
            tracker.reject(grasp.wTg)
        gone = world.held or last
        world.held = None
        world.objects.remove(gone)
        tracker.forget()
        picks.append(Pick(kind=kind_of(gone), ends=tuple(ends)))
    return picks


def come_near(
    world: World,
    detector: GraspDetector,
    tracker: GraspTracker,
    camera: D435Noise,
    rng: np.random.Generator,
) -> GraspEstimate | None:
    """Follow one grasp from above the container until it is locked; None if there is none."""
    tracker.reset()
    wTe = _ABOVE
    grasp = None
    for _ in range(_FRAMES):
        detection = look(world, wTe, detector, CONTAINER, camera, rng)
        grasp = tracker.update(detection, wTe * ROBOT.camera.eTc)
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
    camera: D435Noise,
    rng: np.random.Generator,
) -> Detection:
    """What is found in one noisy frame from the wrist."""
    wTc = wTe * ROBOT.camera.eTc
    hand = Hand(ROBOT.gripper, wTe).shapes(ROBOT.gripper.opening)
    depth = DepthRenderer(ROBOT.camera.intrinsics).render([*world.shapes(), *hand], wTc)
    depth = camera.apply(depth, ROBOT.camera, rng)
    frame = DepthFrame(depth=depth, intrinsics=ROBOT.camera.intrinsics, wTc=wTc, stamp=0.0)
    return detector.detect(frame, workspace)


def execute(world: World, grasp: GraspEstimate) -> str:
    """Go down, close, and say how it ended: `HELD`, or what went wrong."""
    for height in np.linspace(_STANDOFF, 0.0, 25):
        wTe = grasp.wTg * SE3(np.eye(3), np.array([0.0, 0.0, -height]))
        if hit := world.collision(Hand(ROBOT.gripper, wTe), grasp.opening):
            return f"touched {'a wall' if 'wall' in hit else 'an object'} on the way down"
    return world.close_fingers(Hand(ROBOT.gripper, grasp.wTg), grasp.opening, 20.0).reason.value
