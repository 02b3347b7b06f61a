"""The 3-D scene: robot, fixtures, objects, goal, grasp, and the trail of the hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from pinocchio import SE3

from app.live.monitor.columns import WORLD, Array, send_poses, timelines
from app.live.monitor.glyphs import Colour
from app.live.monitor.robot_looks import robot_looks
from app.live.monitor.robot_shapes import finger_poses
from app.live.monitor.solids import solids
from app.live.snapshot import SceneView, Snapshot
from app.live.throttle import Throttle
from controller import RobotModel
from perception import GraspEstimate

_POSE_PERIOD = 0.04
"""Shortest time between two sets of poses [s]: looks smooth, and a quarter of the file size."""

_AXES: tuple[Colour, ...] = ((230, 70, 60), (70, 190, 80), (70, 120, 240))
_TRACKED: Colour = (255, 190, 40)
_LOCKED: Colour = (60, 220, 100)
_TRAIL: Colour = (90, 200, 220)
_FINGER_LENGTH = 0.05
_GOAL_LENGTH, _TOOL_LENGTH = 0.12, 0.06

_BASE, _HAND = "world/robot/base", "world/robot/hand"
_LINKS = tuple(f"world/robot/link{i}" for i in range(8))
_FINGERS = ("world/robot/left_finger", "world/robot/right_finger")
_GOAL, _TOOL = "world/goal", "world/tool"


class ScenePanel:
    """Draws the scene.

    Args:
        stream: where to.
        model: kinematics of the robot; not shared.
        scene: the shapes to draw.
    """

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
        self._last_point: Array | None = None

        looks = robot_looks(model.description)
        objects = [solids(view.parts) for view in scene.objects]
        for path, bodies in {
            _BASE: looks.base,
            _HAND: looks.hand,
            **dict(zip(_LINKS, looks.links, strict=True)),
            **dict.fromkeys(_FINGERS, looks.finger),
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
            "world/grasp": [rr.LineStrips3D.from_fields(radii=0.004, show_labels=True)],
        }.items():
            stream.log(path, rr.CoordinateFrame(WORLD), static=True)
            for body in bodies:
                stream.log(path, body, static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the snapshots of a batch."""
        shown = [snapshot for snapshot in batch if self._throttle.due(snapshot.stamp)]
        if not shown:
            return
        send_poses(self._stream, [(snapshot, self._moved(snapshot)) for snapshot in shown])
        self._send_goal(shown)
        self._send_grasp(shown)
        self._send_trail(shown)

    def _moved(self, snapshot: Snapshot) -> dict[str, SE3]:
        """Poses of the frames that moved: most are at rest most of the time."""
        state = snapshot.state
        *links, hand = self._model.link_poses(state.wTb, state.q)
        gripper = self._model.description.gripper
        fingers = [hand * finger for finger in finger_poses(gripper, state.gripper_width)]
        poses = {
            _BASE: state.wTb,
            _HAND: hand,
            _TOOL: snapshot.wTe,
            **dict(zip(_LINKS, links, strict=True)),
            **dict(zip(_FINGERS, fingers, strict=True)),
            **dict(zip(self._objects, snapshot.objects, strict=True)),
        }
        if snapshot.goal is not None:
            poses[_GOAL] = snapshot.goal
        moved = {
            name: pose
            for name, pose in poses.items()
            if name not in self._last or not pose.isApprox(self._last[name], 1e-6)
        }
        self._last |= moved
        return moved

    def _send_goal(self, shown: Sequence[Snapshot]) -> None:
        """The goal's axes, or none while there is no goal."""
        changed = []
        for snapshot in shown:
            if (snapshot.goal is not None) is not self._goal_shown:
                self._goal_shown = snapshot.goal is not None
                changed.append(snapshot)
        if changed:
            counts = [0 if snapshot.goal is None else 3 for snapshot in changed]
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
                strips=[_gripper_outline(grasp.wTg, grasp.width) for grasp, _ in drawn],
                colors=[_LOCKED if locked else _TRACKED for _, locked in drawn],
                labels=[
                    f"{grasp.quality:.2f}{' locked' if locked else ''}" for grasp, locked in drawn
                ],
            )
            counts = [int(snapshot.grasp is not None) for snapshot in changed]
            self._stream.send_columns(
                "world/grasp", indexes=timelines(changed), columns=columns.partition(counts)
            )

    def _send_trail(self, shown: Sequence[Snapshot]) -> None:
        """One short line per row; the view shows those of the last seconds together."""
        points = [s.wTe.translation for s in shown]
        before = [points[0] if self._last_point is None else self._last_point, *points[:-1]]
        self._last_point = points[-1]
        strips = np.stack([before, points], axis=1)
        columns = rr.LineStrips3D.columns(strips=strips)
        self._stream.send_columns("world/trail", indexes=timelines(shown), columns=columns)


def _gripper_outline(wTg: SE3, width: float) -> Array:
    """(4, 3) outline of an open gripper at a grasp, in the world [m]."""
    back, half = -_FINGER_LENGTH, width / 2
    outline = np.array([[0, -half, 0], [0, -half, back], [0, half, back], [0, half, 0]])
    points: Array = outline @ wTg.rotation.T + wTg.translation
    return points
