"""3-D scene of the recording: robot, fixtures, objects, camera, goals, grasps, and trails."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from pinocchio import SE3
from pinocchio.utils import rotate

from app.live.feed import Throttle
from app.live.monitor.columns import WORLD, Array, send_poses, timelines
from app.live.monitor.glyphs import Colour
from app.live.monitor.overlays import FaultPanel, IntentPanel, ghost_base, ghost_hand
from app.live.monitor.robot_visual import finger_poses, robot_visual
from app.live.monitor.solids import solids
from app.live.snapshot import SceneView, Snapshot
from controller import Pose2D, RobotModel
from perception import GraspEstimate
from robots import Intrinsics

_POSE_PERIOD = 0.04
"""Shortest time between two sets of poses [s]."""

_AXES: tuple[Colour, ...] = ((230, 70, 60), (70, 190, 80), (70, 120, 240))
_TRACKED: Colour = (255, 190, 40)
_LOCKED: Colour = (60, 220, 100)
_TRAIL: Colour = (90, 200, 220)
_BASE_TRAIL: Colour = (120, 130, 150)
_FRUSTUM: Colour = (170, 150, 230)
_FRUSTUM_DEPTH = 0.25
"""Of the drawn camera frustum [m]."""
_FINGER_LENGTH = 0.05
_GOAL_LENGTH, _TOOL_LENGTH = 0.12, 0.06

_BASE, _HAND = "world/robot/base", "world/robot/hand"
_LINKS = tuple(f"world/robot/link{i}" for i in range(8))
_FINGERS = ("world/robot/left_finger", "world/robot/right_finger")
_GOAL, _TOOL = "world/goal", "world/tool"
_GHOST_HAND, _GHOST_BASE = "world/ghost/hand", "world/ghost/base"
_EYE, _IMAGE_AT = "world/frustum", "world/camera"
_AWAY = SE3(np.eye(3), np.array([0.0, 0.0, -100.0]))
"""Position of a ghost without a goal: below the floor."""


class ScenePanel:
    """Draws the scene."""

    def __init__(self, stream: rr.RecordingStream, model: RobotModel, scene: SceneView) -> None:
        self._stream = stream
        self._model = model
        self._objects = [
            f"world/objects/{index}_{''.join(c if c.isalnum() else '_' for c in view.name)}"
            for index, view in enumerate(scene.objects)
        ]
        self._throttle = Throttle(_POSE_PERIOD)
        self._last: dict[str, SE3] = {}
        self._goal_shown: bool | None = None
        self._grasp: tuple[GraspEstimate | None, bool] | None = None
        self._last_points: dict[str, Array] = {}
        self._intent = IntentPanel(stream, scene)

        looks = robot_visual(model.description)
        objects = [solids(view.parts) for view in scene.objects]
        robot = {
            _BASE: looks.base,
            _HAND: looks.hand,
            **dict(zip(_LINKS, looks.links, strict=True)),
            **dict.fromkeys(_FINGERS, looks.finger),
        }
        self._faults = FaultPanel(stream, robot)
        for path, bodies in {
            **robot,
            _GHOST_HAND: ghost_hand(model.description),
            _GHOST_BASE: ghost_base(model.description),
            _EYE: [_frustum(model.description.camera.intrinsics)],
            **dict(zip(self._objects, objects, strict=True)),
            _GOAL: [rr.Arrows3D.from_fields(colors=_AXES, radii=0.006)],
            _TOOL: [rr.Arrows3D(vectors=_TOOL_LENGTH * np.eye(3), colors=_AXES, radii=0.003)],
        }.items():
            stream.log(path, rr.CoordinateFrame(path), static=True)
            for body in bodies:
                stream.log(path, body, static=True)
        for path, bodies in {
            WORLD: [rr.ViewCoordinates.RIGHT_HAND_Z_UP],
            "world/fixtures": solids(scene.fixtures),
            "world/trail": [
                rr.LineStrips3D.from_fields(colors=[_TRAIL], radii=rr.Radius.ui_points(1.5))
            ],
            "world/base_trail": [
                rr.LineStrips3D.from_fields(colors=[_BASE_TRAIL], radii=rr.Radius.ui_points(1.5))
            ],
            "world/grasp": [rr.LineStrips3D.from_fields(radii=0.004, show_labels=True)],
        }.items():
            stream.log(path, rr.CoordinateFrame(WORLD), static=True)
            for body in bodies:
                stream.log(path, body, static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the snapshots of a batch."""
        self._faults.write(batch)
        shown = [snapshot for snapshot in batch if self._throttle.due(snapshot.stamp)]
        if not shown:
            return
        send_poses(self._stream, [(snapshot, self._moved(snapshot)) for snapshot in shown])
        self._send_goal(shown)
        self._send_grasp(shown)
        self._send_trail("world/trail", shown, [s.wTe.translation for s in shown])
        ground = [np.append(s.state.wTb.translation[:2], 0.012) for s in shown]
        self._send_trail("world/base_trail", shown, ground)
        self._intent.write(shown)

    def _moved(self, snapshot: Snapshot) -> dict[str, SE3]:
        """Poses of the frames that moved."""
        state = snapshot.state
        *links, hand = self._model.link_poses(state.wTb, state.q)
        gripper = self._model.description.gripper
        fingers = [hand * finger for finger in finger_poses(gripper, state.gripper_width)]
        poses = {
            _BASE: state.wTb,
            _HAND: hand,
            _TOOL: snapshot.wTe,
            _EYE: snapshot.wTe * self._model.description.camera.eTc,
            _GHOST_HAND: _AWAY if snapshot.hand_goal is None else snapshot.hand_goal,
            _GHOST_BASE: _AWAY if snapshot.base_goal is None else _on_floor(snapshot.base_goal),
            **dict(zip(_LINKS, links, strict=True)),
            **dict(zip(_FINGERS, fingers, strict=True)),
            **dict(zip(self._objects, snapshot.objects, strict=True)),
        }
        if snapshot.hand_goal is not None:
            poses[_GOAL] = snapshot.hand_goal
        if _IMAGE_AT not in self._last:  # until there is an image, where one would be taken
            poses[_IMAGE_AT] = poses[_EYE]
        moved = {
            name: pose
            for name, pose in poses.items()
            if name not in self._last or not pose.isApprox(self._last[name], 1e-6)
        }
        self._last |= moved
        return moved

    def _send_goal(self, shown: Sequence[Snapshot]) -> None:
        """The goal's axes; none while there is no goal."""
        changed = []
        for snapshot in shown:
            if (snapshot.hand_goal is not None) is not self._goal_shown:
                self._goal_shown = snapshot.hand_goal is not None
                changed.append(snapshot)
        if changed:
            counts = [0 if snapshot.hand_goal is None else 3 for snapshot in changed]
            vectors = np.tile(_GOAL_LENGTH * np.eye(3), (sum(counts) // 3, 1))
            columns = rr.Arrows3D.columns(vectors=vectors).partition(counts)
            self._stream.send_columns(_GOAL, indexes=timelines(changed), columns=columns)

    def _send_grasp(self, shown: Sequence[Snapshot]) -> None:
        """The outline of the open gripper at the tracked grasp, with its quality."""
        changed = []
        for snapshot in shown:
            if (snapshot.grasp, snapshot.locked) != self._grasp:
                self._grasp = (snapshot.grasp, snapshot.locked)
                changed.append(snapshot)
        if changed:
            drawn = [(s.grasp, s.locked) for s in changed if s.grasp is not None]
            columns = rr.LineStrips3D.columns(
                strips=[gripper_outline(grasp.wTg, grasp.width) for grasp, _ in drawn],
                colors=[_LOCKED if locked else _TRACKED for _, locked in drawn],
                labels=[
                    f"{grasp.quality:.2f}{' locked' if locked else ''}" for grasp, locked in drawn
                ],
            )
            counts = [int(snapshot.grasp is not None) for snapshot in changed]
            self._stream.send_columns(
                "world/grasp", indexes=timelines(changed), columns=columns.partition(counts)
            )

    def _send_trail(self, path: str, shown: Sequence[Snapshot], points: Sequence[Array]) -> None:
        """One short line per row; the view shows those of the last seconds together."""
        before = [self._last_points.get(path, points[0]), *points[:-1]]
        self._last_points[path] = points[-1]
        strips = np.stack([before, points], axis=1)
        columns = rr.LineStrips3D.columns(strips=strips)
        self._stream.send_columns(path, indexes=timelines(shown), columns=columns)


def _on_floor(pose: Pose2D) -> SE3:
    return SE3(rotate("z", pose.heading), np.array([pose.x, pose.y, 0.0]))


def _frustum(lens: Intrinsics) -> rr.LineStrips3D:
    """The camera's field of view, as lines in its frame."""
    left, right = -lens.cx, lens.width - lens.cx
    top, bottom = -lens.cy, lens.height - lens.cy
    pixels = np.array([(left, top), (right, top), (right, bottom), (left, bottom)])
    corners = np.column_stack([pixels / [lens.fx, lens.fy], np.ones(4)])
    corners *= _FRUSTUM_DEPTH
    rays = [np.array([np.zeros(3), corner]) for corner in corners]
    strips = [*rays, corners[[0, 1, 2, 3, 0]]]
    return rr.LineStrips3D(strips, colors=[_FRUSTUM], radii=rr.Radius.ui_points(1.0))


def gripper_outline(wTg: SE3, width: float) -> Array:
    """(4, 3) outline of an open gripper at a grasp, in the world [m]."""
    back, half = -_FINGER_LENGTH, width / 2
    outline = np.array([[0, -half, 0], [0, -half, back], [0, half, back], [0, half, 0]])
    points: Array = outline @ wTg.rotation.T + wTg.translation
    return points
