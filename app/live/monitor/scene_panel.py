"""3-D scene of the recording: robot, furniture, objects, goals, path, distances and grasps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun as rr
from pinocchio import SE3
from pinocchio.utils import rotate

from app.live.feed import Throttle
from app.live.monitor.columns import WORLD, Array, Changes, log_static, send_poses, timelines
from app.live.monitor.glyphs import Colour
from app.live.monitor.overlays import GHOST, FaultPanel, ghosts, region_boxes
from app.live.monitor.robot_visual import finger_poses, robot_visual
from app.live.monitor.solids import solids
from app.live.snapshot import SceneView, Snapshot
from controller import Pose2D, RobotModel

_POSE_PERIOD = 0.04
"""Shortest time between two sets of poses [s]."""
_SEEN_PERIOD, _SEEN_POINTS = 1.0, 1000
"""Shortest time between two drawings of depth obstacles [s], and their most points."""

_AXES: tuple[Colour, ...] = ((230, 70, 60), (70, 190, 80), (70, 120, 240))
_TRACKED: Colour = (255, 190, 40)
_LOCKED: Colour = (60, 220, 100)
_TRAIL: Colour = (90, 200, 220)
_BASE_TRAIL: Colour = (120, 130, 150)
_NEAREST: Colour = (255, 150, 40)
_SEEN: Colour = (235, 110, 90)
_FINGER_LENGTH = 0.05
_TOOL_LENGTH = 0.06
_FLOOR = 0.012
"""Height of lines on the floor, above its surface [m]."""
_FAR = 0.5
"""Larger distances are not drawn [m]."""

_BASE, _HAND = "world/robot/base", "world/robot/hand"
_LINKS = tuple(f"world/robot/link{i}" for i in range(8))
_FINGERS = ("world/robot/left_finger", "world/robot/right_finger")
_TOOL, _CAMERA = "world/tool", "world/camera"
_GHOST_HAND, _GHOST_BASE = "world/ghost/hand", "world/ghost/base"
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
        self._throttle, self._seen = Throttle(_POSE_PERIOD), Throttle(_SEEN_PERIOD)
        self._last: dict[str, SE3] = {}
        self._last_points: dict[str, Array] = {}
        self._changes = Changes(stream)

        looks = robot_visual(model.description)
        robot = {
            _BASE: looks.base,
            _HAND: looks.hand,
            **dict(zip(_LINKS, looks.links, strict=True)),
            **dict.fromkeys(_FINGERS, looks.finger),
        }
        self._faults = FaultPanel(stream, robot)
        hand, base = ghosts(model.description)
        moving = {
            **robot,
            _GHOST_HAND: hand,
            _GHOST_BASE: base,
            _TOOL: [rr.Arrows3D(vectors=_TOOL_LENGTH * np.eye(3), colors=_AXES, radii=0.003)],
        }
        for path, view in zip(self._objects, scene.objects, strict=True):
            moving[path] = solids(view.parts)
        log_static(stream, moving)
        at_rest: dict[str, list[Any]] = {
            WORLD: [rr.ViewCoordinates.RIGHT_HAND_Z_UP],
            "world/fixtures": solids(scene.fixtures),
            "world/regions": [region_boxes(scene.regions)],
            "world/grasp": [rr.LineStrips3D.from_fields(radii=0.004, show_labels=True)],
            "world/trail": [_line(_TRAIL, 1.5)],
            "world/base_trail": [_line(_BASE_TRAIL, 1.5)],
            "world/way": [_line(GHOST, 2.0)],
            "world/nearest": [_line(_NEAREST, 2.5, show_labels=True)],
            "world/seen": [rr.Points3D.from_fields(colors=[_SEEN], radii=0.008)],
        }
        log_static(stream, at_rest, WORLD)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the snapshots of a batch."""
        self._faults.write(batch)
        shown = [snapshot for snapshot in batch if self._throttle.due(snapshot.stamp)]
        if not shown:
            return
        send_poses(self._stream, [(snapshot, self._moved(snapshot)) for snapshot in shown])
        send = self._changes.send
        send("world/grasp", shown, lambda s: (s.grasp, s.locked), _grasp)
        send("world/way", shown, lambda s: (s.way,), _way)
        send("world/nearest", shown, lambda s: (s.report.nearest_points,), _nearest)
        some = [snapshot for snapshot in shown if self._seen.due(snapshot.stamp)]
        send("world/seen", some, lambda s: (s.seen,), _seen)
        self._send_trail("world/trail", shown, [s.wTe.translation for s in shown])
        ground = [np.append(s.state.wTb.translation[:2], _FLOOR) for s in shown]
        self._send_trail("world/base_trail", shown, ground)

    def _moved(self, snapshot: Snapshot) -> dict[str, SE3]:
        """Poses of the frames that moved."""
        state, robot = snapshot.state, self._model.description
        *links, hand = self._model.link_poses(state.wTb, state.q)
        fingers = [hand * pose for pose in finger_poses(robot.gripper, state.gripper_width)]
        poses = {
            _BASE: state.wTb,
            _HAND: hand,
            _TOOL: snapshot.wTe,
            _GHOST_HAND: _AWAY if snapshot.hand_goal is None else snapshot.hand_goal,
            _GHOST_BASE: _AWAY if snapshot.base_goal is None else _on_floor(snapshot.base_goal),
            **dict(zip(_LINKS, links, strict=True)),
            **dict(zip(_FINGERS, fingers, strict=True)),
            **dict(zip(self._objects, snapshot.objects, strict=True)),
        }
        if _CAMERA not in self._last:  # until there is an image, where one would be taken
            poses[_CAMERA] = snapshot.wTe * robot.camera.eTc
        moved = {
            name: pose
            for name, pose in poses.items()
            if name not in self._last or not pose.isApprox(self._last[name], 1e-6)
        }
        self._last |= moved
        return moved

    def _send_trail(self, path: str, shown: Sequence[Snapshot], points: Sequence[Array]) -> None:
        """One short line per row; the view shows those of the last seconds together."""
        before = [self._last_points.get(path, points[0]), *points[:-1]]
        self._last_points[path] = points[-1]
        columns = rr.LineStrips3D.columns(strips=np.stack([before, points], axis=1))
        self._stream.send_columns(path, indexes=timelines(shown), columns=columns)


def _line(colour: Colour, width: float, **more: Any) -> rr.LineStrips3D:
    return rr.LineStrips3D.from_fields(colors=[colour], radii=rr.Radius.ui_points(width), **more)


def _on_floor(pose: Pose2D) -> SE3:
    return SE3(rotate("z", pose.heading), np.array([pose.x, pose.y, 0.0]))


def _grasp(snapshot: Snapshot) -> tuple[int, Any]:
    """The outline of the open gripper at the tracked grasp, with its quality."""
    grasp, locked = snapshot.grasp, snapshot.locked
    if grasp is None:
        return 0, rr.LineStrips3D.columns(strips=[], colors=[], labels=[])
    back, half = -_FINGER_LENGTH, grasp.width / 2
    outline = np.array([[0, -half, 0], [0, -half, back], [0, half, back], [0, half, 0]])
    return 1, rr.LineStrips3D.columns(
        strips=[outline @ grasp.wTg.rotation.T + grasp.wTg.translation],
        colors=[_LOCKED if locked else _TRACKED],
        labels=[f"{grasp.quality:.2f}{' locked' if locked else ''}"],
    )


def _way(snapshot: Snapshot) -> tuple[int, Any]:
    """Base path on the floor."""
    if snapshot.way is None or len(snapshot.way) < 2:
        return 0, rr.LineStrips3D.columns(strips=[])
    points = np.column_stack([snapshot.way[:, :2], np.full(len(snapshot.way), _FLOOR)])
    return 1, rr.LineStrips3D.columns(strips=[points])


def _nearest(snapshot: Snapshot) -> tuple[int, Any]:
    """A line over the smallest distance that the controller keeps, with its length."""
    points, distance = snapshot.report.nearest_points, snapshot.report.clearance
    if points is None or not distance < _FAR:
        return 0, rr.LineStrips3D.columns(strips=[], labels=[])
    label = f"{100.0 * distance:.0f} cm"
    return 1, rr.LineStrips3D.columns(strips=[np.stack(points)], labels=[label])


def _seen(snapshot: Snapshot) -> tuple[int, Any]:
    points: Array = np.zeros((0, 3)) if snapshot.seen is None else snapshot.seen.points
    some = points[:: max(1, -(-len(points) // _SEEN_POINTS))]
    return len(some), rr.Points3D.columns(positions=some)
