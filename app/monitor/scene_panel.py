"""The scene in 3-D: robot, fixtures, objects, the goal, the grasp and the way taken."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from pinocchio import SE3

from app.monitor.columns import Array, axes_columns, pose_columns, timelines
from app.monitor.every import Every
from app.monitor.glyphs import Colour
from app.monitor.robot_shapes import FINGER, HAND, LINKS, base_parts, finger_poses
from app.monitor.snapshot import SceneView, Snapshot
from app.monitor.solids import solids
from controller import RobotModel

_POSE_PERIOD = 0.03
"""Poses are kept no oftener than this [s]: smooth to the eye, a third of the file."""

_AXES: tuple[Colour, ...] = ((230, 70, 60), (70, 190, 80), (70, 120, 240))
_TRACKED: Colour = (255, 190, 40)
_LOCKED: Colour = (60, 220, 100)
_TRAIL: Colour = (90, 200, 220)
_FINGER_LENGTH = 0.05

_BASE, _HAND = "world/robot/base", "world/robot/hand"
_LINKS = tuple(f"world/robot/link{i}" for i in range(len(LINKS)))
_FINGERS = (f"{_HAND}/left_finger", f"{_HAND}/right_finger")


class ScenePanel:
    """Draws the scene.

    Args:
        stream: where to.
        model: kinematics of the robot; the panel's alone.
        scene: what the world looks like.
    """

    def __init__(self, stream: rr.RecordingStream, model: RobotModel, scene: SceneView) -> None:
        self._stream = stream
        self._model = model
        self._objects = [
            f"world/objects/{index}_{''.join(c if c.isalnum() else '_' for c in view.name)}"
            for index, view in enumerate(scene.objects)
        ]
        self._object_poses: list[SE3 | None] = [None] * len(scene.objects)
        self._poses = Every(_POSE_PERIOD)
        self._last_point: Array | None = None

        foot = float(model.description.bTa.translation[2])
        bodies = {
            "world/fixtures": scene.fixtures,
            _BASE: base_parts(foot),
            _HAND: HAND,
            **dict(zip(_LINKS, LINKS, strict=True)),
            **dict.fromkeys(_FINGERS, FINGER),
            **{path: view.parts for path, view in zip(self._objects, scene.objects, strict=True)},
        }
        stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for path, parts in bodies.items():
            for solid in solids(parts):
                stream.log(path, solid, static=True)
        for path, radius in (("world/goal", 0.006), ("world/tool", 0.003)):
            arrows = rr.Arrows3D.from_fields(colors=_AXES, radii=radius)
            stream.log(path, arrows, static=True)
        trail = rr.LineStrips3D.from_fields(colors=[_TRAIL], radii=rr.Radius.ui_points(1.5))
        stream.log("world/trail", trail, static=True)
        stream.log("world/grasp", rr.LineStrips3D.from_fields(radii=0.004), static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add what a batch shows."""
        shown = [snapshot for snapshot in batch if self._poses.due(snapshot.stamp)]
        if not shown:
            return
        times = timelines(shown)
        self._send_robot(shown, times)
        self._send_frames(shown, times)
        self._send_trail(shown, times)
        self._send_objects(shown)

    def _send_robot(self, shown: Sequence[Snapshot], times: list[rr.TimeColumn]) -> None:
        arms = [self._model.link_poses(s.state.wTb, s.state.q) for s in shown]
        fingers = [finger_poses(s.state.gripper_width) for s in shown]
        poses = {
            _BASE: [s.state.wTb for s in shown],
            **dict(zip((*_LINKS, _HAND), zip(*arms, strict=True), strict=True)),
            **dict(zip(_FINGERS, zip(*fingers, strict=True), strict=True)),
        }
        for path, rows in poses.items():
            self._stream.send_columns(path, indexes=times, columns=pose_columns(rows))

    def _send_frames(self, shown: Sequence[Snapshot], times: list[rr.TimeColumn]) -> None:
        send = self._stream.send_columns
        send("world/goal", indexes=times, columns=axes_columns([s.goal for s in shown], 0.12))
        send("world/tool", indexes=times, columns=axes_columns([s.wTe for s in shown], 0.06))
        grasps = [s.grasp for s in shown]
        strips = [_jaws(grasp.wTg, grasp.width) for grasp in grasps if grasp is not None]
        colours = [_LOCKED if s.locked else _TRACKED for s in shown if s.grasp is not None]
        columns = rr.LineStrips3D.columns(strips=strips, colors=colours)
        counts = [int(grasp is not None) for grasp in grasps]
        send("world/grasp", indexes=times, columns=columns.partition(counts))

    def _send_trail(self, shown: Sequence[Snapshot], times: list[rr.TimeColumn]) -> None:
        """One short line a row; the view shows those of the last seconds together."""
        points = [s.wTe.translation for s in shown]
        before = [points[0] if self._last_point is None else self._last_point, *points[:-1]]
        self._last_point = points[-1]
        strips = np.stack([before, points], axis=1)
        columns = rr.LineStrips3D.columns(strips=strips)
        self._stream.send_columns("world/trail", indexes=times, columns=columns)

    def _send_objects(self, shown: Sequence[Snapshot]) -> None:
        """Only what moved: most objects rest most of the time."""
        for index, path in enumerate(self._objects):
            moved = []
            for snapshot in shown:
                pose, last = snapshot.objects[index], self._object_poses[index]
                if last is None or not pose.isApprox(last, 1e-6):
                    self._object_poses[index] = pose
                    moved.append(snapshot)
            if moved:
                columns = pose_columns([snapshot.objects[index] for snapshot in moved])
                self._stream.send_columns(path, indexes=timelines(moved), columns=columns)


def _jaws(wTg: SE3, width: float) -> Array:
    """(4, 3) the outline of an open gripper at a grasp, in the world [m]."""
    back, half = -_FINGER_LENGTH, width / 2
    outline = np.array([[0, -half, 0], [0, -half, back], [0, half, back], [0, half, 0]])
    points: Array = outline @ wTg.rotation.T + wTg.translation
    return points
