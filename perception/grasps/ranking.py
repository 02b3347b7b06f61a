"""Ranking of grasps: feasible grasps at the candidates of an image, best first, in odometry.

All is computed as from straight above: in odometry, or in the frame a of `view`.
"""

import numpy as np
from pinocchio import SE3

from config.arrays import Array, Mask
from perception.detected_grasp import GraspEstimate
from perception.frame import ObjectRegion
from perception.geometry import grasp_pose, world_points
from perception.grasps.candidates import Proposals
from perception.grasps.feasibility import Assessment, assess
from perception.grasps.height_map import HeightMap
from perception.grasps.network_input import INPUT_SIZE, Prepared
from perception.grasps.object_centroids import ObjectCentroids
from perception.grasps.patches import HoldProbability, grasp_patches
from perception.grasps.refinement import level_direction, refine, uprightness
from perception.grasps.view import MIN_OBJECT_HEIGHT, View
from robots import GripperDescription, half_extents

LEAST_HOLD = 0.25  # grasps less likely to hold than this are discarded
LOSS_BY_DEPTH = 1.0  # a tilted hand reaches over what stands before others: that goes first [1/m]
LOSS_BY_SLANT = 0.4  # loss of closing directions that are not level, see `uprightness`
ROOMY = 0.045  # objects wider than this leave an inaccurate hand little room [m] ...
LOSS_BY_WIDTH = 1.5  # ... and lose this against equally likely ones [1/m]: 3 % at 65 mm
MARGIN = 0.0035  # errors of arm and camera; where fingers this much wider do not fit, ... [m]
LOSS_BY_TIGHTNESS = 0.1  # ... a grasp is less likely by this share: they may hit a neighbour
LOSS_BY_LEVER = 0.3  # loss with the distance from the middle of the object [1/m]
_CLEARANCE = 0.005  # between palm or wrist and what a tilted hand passes [m]
_ANGLE_STEP = 0.005  # to either side of a grasp, for its direction in the image [m]


class GraspRanking:
    """Assesses and ranks candidates on the heights of one frame.

    Args:
        view: what is searched.
        prepared: the part of it with the candidates.
        scene: its heights.
        border: (B, 3) see `LocalHeights`.
        gripper: the hand.
        hold: how likely grasps hold, which is then their quality; None ranks by check and network.
        raised: (M, 3) in odometry, what may be in the way of a tilted hand; None from above.
    """

    def __init__(
        self,
        view: View,
        prepared: Prepared,
        scene: HeightMap,
        border: Array,
        gripper: GripperDescription,
        hold: HoldProbability | None,
        raised: Array | None = None,
    ) -> None:
        self._view, self._prepared, self._scene = view, prepared, scene
        self._gripper, self._hold = gripper, hold
        self._raised = raised
        self._floor, self._workspace = view.floor, view.workspace
        self.unlikely = False  # whether the hand fits somewhere, but is not likely to hold
        lowest = view.floor + MIN_OBJECT_HEIGHT
        self._centroids = ObjectCentroids(scene, lowest, view.workspace, border)
        self._up: Array | None = None  # see `grasp_pose`
        if scene.oRa is not None:
            camera = gripper.camera
            side = 1.0 if camera is None else np.sign(camera.pose.translation[0])
            self._up = side * scene.oRa[2]

    def among(self, proposals: Proposals) -> tuple[GraspEstimate, ...]:
        """The feasible grasps at candidates."""
        candidates = proposals.candidates
        if len(candidates.quality) == 0:
            return ()
        x, y, direction = self._in_world(candidates.pixel, candidates.angle)
        turn_cost, oRa = proposals.turn_cost, self._scene.oRa
        if oRa is not None:  # the network knows nothing of what is level
            direction, turn_cost = np.full(len(direction), level_direction(oRa)), 0.0
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

    def _judged(self, found: Assessment) -> Assessment:
        """Those inside the workspace, ranked by how likely they hold if that is known."""
        if self._workspace is not None:
            centres = np.stack([found.x, found.y, found.top], axis=1)
            found = found.only(self._workspace.contains(self._scene.in_world(centres)))
        if self._raised is not None:
            found = found.only(self._has_way(found))
        if self._hold is None or not len(found.score):
            return found
        camera = self._view.along.oTc.translation
        likely = self._hold(grasp_patches(self._scene, found, self._centroids, camera, self._floor))
        at = found.x, found.y, found.direction
        tight = assess(self._scene, *at, self._floor, self._gripper, MARGIN).score == 0.0
        likely = likely * np.where(tight, 1.0 - LOSS_BY_TIGHTNESS, 1.0)
        self.unlikely = self.unlikely or bool((likely < LEAST_HOLD).all())
        loss = LOSS_BY_LEVER * self._centroids.at(found.x, found.y).lever
        if self._scene.oRa is not None:
            loss += LOSS_BY_SLANT * (1.0 - uprightness(found.direction, self._scene.oRa))
            loss += LOSS_BY_DEPTH * (found.x - found.x.min())
        loss += LOSS_BY_WIDTH * np.maximum(found.width - ROOMY, 0.0)
        ranked = found.ranked(likely, likely - loss)
        return ranked.only(ranked.score >= LEAST_HOLD)

    def _has_way(self, found: Assessment) -> Mask:
        """Whether nothing that stands out is where palm and wrist come, or on their way there."""
        oRa = self._scene.oRa
        assert oRa is not None
        assert self._raised is not None
        raised, ahead = self._raised @ oRa, oRa[2, :2] / np.linalg.norm(oRa[2, :2])
        palm, wrist = self._gripper.palm, self._gripper.wrist
        across, along, high = half_extents(palm.shape)
        height = -palm.pose.translation[2] - high
        free = np.ones(len(found.score), dtype=np.bool_)
        for i, direction in enumerate(found.direction):
            from_grasp = raised - (found.x[i], found.y[i], found.z[i])
            x, y, z = from_grasp[from_grasp[:, 2] > height + _CLEARANCE].T
            c, s = np.cos(direction), np.sin(direction)
            hit = np.abs(c * x + s * y) < along + _CLEARANCE
            hit &= np.abs(c * y - s * x) < across + _CLEARANCE
            for part in wrist:
                middle = part.pose.translation
                half = np.array(half_extents(part.shape)) + _CLEARANCE
                beside = np.abs(ahead[0] * x + ahead[1] * y - middle[0]) < half[0]
                beside &= np.abs(ahead[0] * y - ahead[1] * x - middle[1]) < half[1]
                hit |= beside & (z > middle[2] - half[2])
            free[i] = not hit.any()
        return free

    def _in_world(self, at: Array, angle: Array) -> tuple[Array, Array, Array]:
        """x, y [m] and closing directions [rad] of (N, 2) input pixels and (N,) angles in it."""
        camera, prepared = self._view.along, self._prepared
        u, v = prepared.crop.to_image(at).T
        column, row = np.clip(np.rint(at).astype(np.int64), 0, INPUT_SIZE - 1).T
        depth = prepared.depth[row, column]
        x, y, height = world_points(depth, camera.intrinsics, camera.oTc, u, v).T
        return x, y, camera.closing_direction(np.stack([u, v], axis=1), angle, height)

    def _owned(self, found: Assessment) -> Mask:
        """Which grasps close on the workspace's objects alone."""
        assert isinstance(self._workspace, ObjectRegion)
        centres, direction = np.stack([found.x, found.y, found.z], axis=1), found.direction
        across = np.stack([np.cos(direction), np.sin(direction), np.zeros(len(direction))], axis=1)
        across *= 0.5 * found.width[:, None]
        along = np.stack([-np.sin(direction), np.cos(direction), np.zeros(len(direction))], axis=1)
        along *= half_extents(self._gripper.pad.shape)[0]
        contacts = np.stack([centres - across, centres + across], axis=1)
        pads = np.concatenate([contacts - along[:, None], contacts + along[:, None]], axis=1)
        return self._workspace.owns(*map(self._scene.in_world, (centres, contacts, pads)))

    def _outline(self, aTg: SE3) -> Array:
        """(K, 3) corners in g, at z = 0, of the object that a grasp is on [m]."""
        here = aTg.translation[:2]
        corners: Array = (self._centroids.outline(*here) - here) @ aTg.rotation[:2]
        return corners

    def _estimates(self, found: Assessment) -> tuple[GraspEstimate, ...]:
        camera, oRa = self._view.along, self._scene.oRa
        centre = np.stack([found.x, found.y, found.top], axis=1)
        along = _ANGLE_STEP * np.stack(
            [np.cos(found.direction), np.sin(found.direction), np.zeros(len(found.x))], axis=1
        )
        pixel = camera.project(centre)
        line = camera.project(centre + along) - camera.project(centre - along)
        angle = np.arctan2(line[:, 1], line[:, 0])
        objects = self._centroids.at(found.x, found.y)
        middle = np.stack([found.x + objects.to_x, found.y + objects.to_y], axis=1)
        grasps = []
        for i in range(len(centre)):
            at = found.x[i], found.y[i], found.z[i], found.direction[i]
            aTg = grasp_pose(*at, camera.oTc, self._up)
            grasps.append(
                GraspEstimate(
                    oTg=aTg if oRa is None else SE3(oRa, np.zeros(3)) * aTg,
                    width=float(found.width[i]),
                    opening=float(found.opening[i]),
                    quality=float(found.score[i]),
                    whole=bool(objects.whole[i]),
                    depth=float(found.top[i] - found.z[i]),
                    lever=float(objects.lever[i]),
                    volume=float(objects.volume[i]),
                    middle=(float(middle[i, 0]), float(middle[i, 1]))
                    if objects.clear[i] and oRa is None
                    else None,
                    outline=self._outline(aTg) if objects.clear[i] else None,
                    stamp=self._view.stamp,
                    pixel=(float(pixel[i, 0]), float(pixel[i, 1])),
                    angle=float(angle[i]),
                )
            )
        return tuple(grasps)
