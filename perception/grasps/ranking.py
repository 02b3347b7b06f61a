"""Ranking of grasps: feasible grasps at the candidates of an image, best first, in the world.

All is computed as from straight above: in the world, or in the frame a of `approach`.
"""

import numpy as np
from pinocchio import SE3

from perception.frame import Array, Frame, Mask, ObjectRegion, Workspace
from perception.geometry import Camera, closing_direction, grasp_pose, world_points
from perception.grasp import GraspEstimate
from perception.grasps.approach import level_direction, uprightness
from perception.grasps.candidates import Proposals
from perception.grasps.feasibility import Assessment, assess
from perception.grasps.height_map import LocalHeights
from perception.grasps.network_input import INPUT_SIZE, Prepared
from perception.grasps.object_centroids import ObjectCentroids
from perception.grasps.patches import HoldProbability, grasp_patches
from perception.grasps.refinement import RefinedGrasps, refine
from robots import GripperDescription, half_extents

MIN_OBJECT_HEIGHT = 0.008  # surfaces lower than this above the floor are not grasped [m]
LEAST_HOLD = 0.25  # grasps less likely to hold than this are discarded
LOSS_BY_DEPTH = 1.0  # a tilted hand reaches over what stands before others: that goes first [1/m]
LOSS_BY_SLANT = 0.4  # loss of closing directions that are not level, see `uprightness`
ROOMY = 0.045  # objects wider than this leave an inaccurate hand little room [m] ...
LOSS_BY_WIDTH = 1.5  # ... and lose this against equally likely ones [1/m]: 3 % at 65 mm
MARGIN = 0.0035  # errors of arm and camera; where fingers this much wider do not fit, ... [m]
LOSS_BY_TIGHTNESS = 0.1  # ... a grasp is less likely by this share: they may hit a neighbour
LOSS_BY_LEVER = 0.3  # loss with the distance from the middle of the object [1/m]
_ANGLE_STEP = 0.005  # to either side of a grasp, for its direction in the image [m]


class GraspRanking:
    """Assesses and ranks candidates on the heights of one frame.

    Args:
        frame: with the camera's model and pose.
        prepared: its crop.
        around: its heights.
        workspace: where to grasp; None is everywhere.
        floor: height of the support surface in the world [m].
        gripper: the hand.
        hold: how likely grasps hold, which is then their quality; None ranks by check and network.
    """

    def __init__(
        self,
        frame: Frame,
        prepared: Prepared,
        around: LocalHeights,
        workspace: Workspace | None,
        floor: float,
        gripper: GripperDescription,
        hold: HoldProbability | None = None,
    ) -> None:
        self._frame, self._prepared, self._scene = frame, prepared, around.scene
        self._hold = hold
        self._workspace, self._floor, self._gripper = workspace, floor, gripper
        self.unlikely = False  # whether the hand fits somewhere, but is not likely to hold
        lowest = floor + MIN_OBJECT_HEIGHT
        self._centroids = ObjectCentroids(around.scene, lowest, workspace, around.border)
        self._up: Array | None = None  # see `grasp_pose`
        if around.scene.wRa is not None:
            camera = gripper.camera
            side = 1.0 if camera is None else np.sign(camera.pose.translation[0])
            self._up = side * around.scene.wRa[2]

    def among(self, proposals: Proposals) -> tuple[GraspEstimate, ...]:
        """The feasible grasps at candidates."""
        candidates = proposals.candidates
        if len(candidates.quality) == 0:
            return ()
        x, y, direction = self._in_world(candidates.pixel, candidates.angle)
        turn_cost, wRa = proposals.turn_cost, self._scene.wRa
        if wRa is not None:  # the network knows nothing of what is level
            direction, turn_cost = np.full(len(direction), level_direction(wRa)), 0.0
        found = refine(
            self._scene,
            x,
            y,
            direction,
            candidates.quality,
            self._floor,
            self._gripper,
            directions=proposals.directions,
            turn_cost=turn_cost,
            count=proposals.most,
            centroids=self._centroids,
            owned=self._owned if isinstance(self._workspace, ObjectRegion) else None,
        )
        return self._estimates(self._judged(found))

    def _judged(self, found: RefinedGrasps) -> RefinedGrasps:
        """Those inside the workspace, ranked by how likely they hold if that is known."""
        if self._workspace is not None:
            centres = np.stack([found.x, found.y, found.top], axis=1)
            found = found.only(self._workspace.contains(centres))
        if self._hold is None or not len(found.score):
            return found
        camera = self._frame.wTc.translation
        likely = self._hold(grasp_patches(self._scene, found, self._centroids, camera, self._floor))
        at = found.x, found.y, found.direction
        tight = assess(self._scene, *at, self._floor, self._gripper, MARGIN).score == 0.0
        likely = likely * np.where(tight, 1.0 - LOSS_BY_TIGHTNESS, 1.0)
        self.unlikely = self.unlikely or bool((likely < LEAST_HOLD).all())
        loss = LOSS_BY_LEVER * self._centroids.at(found.x, found.y)
        if self._scene.wRa is not None:
            loss += LOSS_BY_SLANT * (1.0 - uprightness(found.direction, self._scene.wRa))
            loss += LOSS_BY_DEPTH * (found.x - found.x.min())
        loss += LOSS_BY_WIDTH * np.maximum(found.width - ROOMY, 0.0)
        ranked = found.ranked(likely, likely - loss)
        return ranked.only(ranked.score >= LEAST_HOLD)

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

    def _owned(self, found: Assessment, direction: Array) -> Mask:
        """Which grasps close on the workspace's objects alone."""
        assert isinstance(self._workspace, ObjectRegion)
        centres = np.stack([found.x, found.y, found.z], axis=1)
        across = np.stack([np.cos(direction), np.sin(direction), np.zeros(len(direction))], axis=1)
        across *= 0.5 * found.width[:, None]
        along = np.stack([-np.sin(direction), np.cos(direction), np.zeros(len(direction))], axis=1)
        along *= half_extents(self._gripper.pad.shape)[0]
        contacts = np.stack([centres - across, centres + across], axis=1)
        pads = np.concatenate([contacts - along[:, None], contacts + along[:, None]], axis=1)
        return self._workspace.owns(centres, contacts, pads)

    def _outline(self, aTg: SE3) -> Array:
        """(K, 3) corners in g, at z = 0, of the object that a grasp is on [m]."""
        here = aTg.translation[:2]
        corners: Array = (self._centroids.outline(*here) - here) @ aTg.rotation[:2]
        return corners

    def _estimates(self, found: RefinedGrasps) -> tuple[GraspEstimate, ...]:
        frame = self._frame
        camera = Camera(intrinsics=frame.intrinsics, wTc=frame.wTc)
        centre = np.stack([found.x, found.y, found.top], axis=1)
        along = _ANGLE_STEP * np.stack(
            [np.cos(found.direction), np.sin(found.direction), np.zeros(len(found.x))], axis=1
        )
        pixel = camera.project(centre)
        line = camera.project(centre + along) - camera.project(centre - along)
        whole = self._centroids.shows_all(found.x, found.y)
        is_middle = self._centroids.shows_middle(found.x, found.y)
        lever = self._centroids.at(found.x, found.y)
        to_x, to_y = self._centroids.to_middle(found.x, found.y)
        volume = self._centroids.volume(found.x, found.y)
        wRa, up = self._scene.wRa, self._up
        aTg = [
            grasp_pose(found.x[i], found.y[i], found.z[i], found.direction[i], frame.wTc, up)
            for i in range(len(centre))
        ]
        wTg = aTg if wRa is None else [SE3(wRa, np.zeros(3)) * pose for pose in aTg]
        return tuple(
            GraspEstimate(
                wTg=wTg[i],
                width=float(found.width[i]),
                opening=float(found.opening[i]),
                quality=float(found.score[i]),
                whole=bool(whole[i]),
                depth=float(found.top[i] - found.z[i]),
                lever=float(lever[i]),
                volume=float(volume[i]),
                middle=(float(found.x[i] + to_x[i]), float(found.y[i] + to_y[i]))
                if is_middle[i] and wRa is None
                else None,
                outline=self._outline(aTg[i]) if is_middle[i] else None,
                stamp=frame.stamp,
                pixel=(float(pixel[i, 0]), float(pixel[i, 1])),
                angle=float(np.arctan2(line[i, 1], line[i, 0])),
            )
            for i in range(len(centre))
        )
