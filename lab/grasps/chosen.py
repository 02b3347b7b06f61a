"""The grasp that the hand goes down on, seen from a view and, if need be, from above."""

from __future__ import annotations

import numpy as np
from pinocchio import SE3

from behaviours import DOUBTFUL, LOOK_HEIGHT, Region, straight_down
from hw.sim import D435Noise, World
from lab.grasps.scenes import noisy_frame
from perception import GraspDetector, GraspEstimate, segment_objects


def chosen_grasp(
    detector: GraspDetector,
    world: World,
    region: Region,
    wTc: SE3,
    noise: D435Noise,
    rng: np.random.Generator,
    *,
    looks: int,
) -> GraspEstimate | None:
    """The best grasp in a scene; None if there is none.

    Args:
        detector: what finds grasps.
        world: the scene.
        region: where to grasp.
        wTc: the camera, when it looks first.
        noise: of the camera.
        rng: of the noise.
        looks: how often it looks again from straight above where it sees no grasp, or only a
            doubtful one, as the behaviour `grasp` does.
    """
    for left in reversed(range(looks + 1)):
        frame = noisy_frame(world.shapes(), wTc, noise, rng)
        grasps = detector.detect(frame, region).grasps
        if not left or (grasps and grasps[0].quality >= DOUBTFUL):
            break
        if grasps:
            point = grasps[0].wTg.translation
        elif things := segment_objects(frame, region):
            point = max(things, key=lambda one: one.area).position
        else:
            break
        wTc = straight_down(point, LOOK_HEIGHT, like=wTc)
    return grasps[0] if grasps else None
