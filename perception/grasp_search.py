"""From candidates in an image to grasps in the world, best first."""

from __future__ import annotations

import numpy as np

from perception.antipodal import antipodal_pairs
from perception.arrays import Array, Mask
from perception.candidates import Proposals, RandomPoints
from perception.frame import Frame, Workspace
from perception.geometry import Camera, closing_direction, grasp_pose, world_points
from perception.grasp import GraspEstimate
from perception.lever_arm import LeverArms
from perception.network_io import INPUT_SIZE
from perception.preprocess import Prepared
from perception.refine import ALL_DIRECTIONS, TURN_COST, RefinedGrasps, refine
from perception.surroundings import Surroundings
from robots import GripperDescription

MIN_OBJECT_HEIGHT = 0.008
"""Surfaces lower than this above the floor are not grasped [m]."""
LEAST_QUALITY = 0.05
"""Worse grasps are none: half of them fail, and a third of them hit something."""
RANDOM_POINTS = 24
"""Points where grasps are looked for when the candidates give none, in all directions."""
_ANGLE_STEP = 0.005  # to either side of a grasp, to see its direction in the image [m]


class GraspSearch:
    """Assesses candidates on the heights that one frame shows.

    Args:
        frame: with the camera's model and pose.
        prepared: its crop.
        around: its heights.
        workspace: where to grasp; None is everywhere.
        floor: height of the support surface [m].
        gripper: the hand.
    """

    def __init__(
        self,
        frame: Frame,
        prepared: Prepared,
        around: Surroundings,
        workspace: Workspace | None,
        floor: float,
        gripper: GripperDescription,
    ) -> None:
        self._frame, self._prepared, self._scene = frame, prepared, around.scene
        self._workspace, self._floor, self._gripper = workspace, floor, gripper
        lowest = floor + MIN_OBJECT_HEIGHT
        self._levers = LeverArms(around.scene, lowest, workspace, around.border)

    def among(self, proposals: Proposals) -> tuple[GraspEstimate, ...]:
        """The feasible grasps at the candidates, in all directions if the wanted ones have none."""
        candidates = proposals.candidates
        if len(candidates.quality) == 0:
            return ()
        x, y, direction = self._in_world(candidates.pixel, candidates.angle)
        for directions in sorted({proposals.directions, ALL_DIRECTIONS}):
            cost = proposals.turn_cost
            found = self._refine(x, y, direction, candidates.quality, directions, cost)
            if grasps := self._estimates(found):
                return grasps
        return ()

    def elsewhere(self, allowed: Mask) -> tuple[GraspEstimate, ...]:
        """The feasible grasps at points by chance and between edges that face each other.

        Args:
            allowed: (INPUT_SIZE, INPUT_SIZE) where a grasp may be.
        """
        chance = RandomPoints(RANDOM_POINTS).propose(np.empty(0, np.float32), allowed).candidates
        x, y, direction = self._in_world(chance.pixel, chance.angle)
        turns = np.arange(ALL_DIRECTIONS) * np.pi / ALL_DIRECTIONS
        pair_x, pair_y, pair_direction = antipodal_pairs(self._scene, self._floor, self._gripper)
        x = np.concatenate([np.repeat(x, ALL_DIRECTIONS), pair_x])
        y = np.concatenate([np.repeat(y, ALL_DIRECTIONS), pair_y])
        direction = np.concatenate([np.add.outer(direction, turns).ravel(), pair_direction])
        return self._estimates(self._refine(x, y, direction, np.ones(len(x)), 1, TURN_COST))

    def _in_world(self, at: Array, angle: Array) -> tuple[Array, Array, Array]:
        """x, y [m] and closing directions [rad] of (N, 2) input pixels and (N,) angles in it."""
        frame, prepared = self._frame, self._prepared
        pixel = prepared.crop.to_image(at)
        column, row = np.clip(np.rint(at).astype(np.int64), 0, INPUT_SIZE - 1).T
        depth = prepared.depth[row, column]
        points = world_points(depth, frame.intrinsics, frame.wTc, pixel[:, 0], pixel[:, 1])
        height = points[:, 2]
        turned = closing_direction(frame.intrinsics, frame.wTc, pixel, angle, height)
        return points[:, 0], points[:, 1], turned

    def _refine(
        self, x: Array, y: Array, direction: Array, quality: Array, directions: int, cost: float
    ) -> RefinedGrasps:
        return refine(
            self._scene,
            x,
            y,
            direction,
            quality,
            self._floor,
            self._gripper,
            directions=directions,
            turn_cost=cost,
            levers=self._levers,
        )

    def _estimates(self, found: RefinedGrasps) -> tuple[GraspEstimate, ...]:
        frame = self._frame
        camera = Camera(intrinsics=frame.intrinsics, wTc=frame.wTc)
        centre = np.stack([found.x, found.y, found.top], axis=1)
        along = _ANGLE_STEP * np.stack(
            [np.cos(found.direction), np.sin(found.direction), np.zeros(len(found.x))], axis=1
        )
        pixel = camera.project(centre)
        line = camera.project(centre + along) - camera.project(centre - along)
        whole = self._levers.shows_all(found.x, found.y)
        good = found.score >= LEAST_QUALITY
        if self._workspace is not None and len(centre):
            good &= self._workspace.contains(centre)
        return tuple(
            GraspEstimate(
                wTg=grasp_pose(found.x[i], found.y[i], found.z[i], found.direction[i], frame.wTc),
                width=float(found.width[i]),
                opening=float(found.opening[i]),
                quality=float(found.score[i]),
                whole=bool(whole[i]),
                stamp=frame.stamp,
                pixel=(float(pixel[i, 0]), float(pixel[i, 1])),
                angle=float(np.arctan2(line[i, 1], line[i, 0])),
            )
            for i in np.flatnonzero(good)
        )
