"""3-D scene of the recording: robot, furniture, objects, goals, path, distances and grasps."""

from collections.abc import Mapping, Sequence
from math import cos, sin
from typing import Any

import numpy as np
import rerun as rr
from pinocchio import SE3

from app.live.feed import Throttle
from app.live.monitor.columns import WORLD, Changes, log_static, send_poses, set_time
from app.live.monitor.glyphs import Colour, printable
from app.live.monitor.robot_visual import robot_visual, solids
from app.live.robot_parts import base_parts, finger_poses, hand_parts
from app.live.run_snapshot import SceneView, Snapshot
from behaviours import Region
from config.arrays import Array
from config.planar import yaw_of
from controller import RobotModel, se3_of
from robots import RobotDescription

_POSE_PERIOD = 0.04  # shortest time between two sets of poses [s]
_SEEN_PERIOD, _SEEN_POINTS = 1.0, 1000
"""Shortest time between two drawings of depth obstacles [s], and their most points."""

_GHOST: Colour = (120, 190, 255)
_REGION: Colour = (110, 150, 120)
_RED: Colour = (225, 45, 40)
_PLAIN: Colour = (255, 255, 255)
_TRACKED: Colour = (255, 190, 40)
_LOCKED: Colour = (60, 220, 100)
_NEAREST: Colour = (255, 150, 40)
_SEEN: Colour = (235, 110, 90)
_FINGER_LENGTH = 0.05
_FLOOR = 0.012  # height of lines on the floor, above its surface [m]
_FAR = 0.5  # larger distances are not drawn [m]

_BASE, _HAND = "world/robot/base", "world/robot/hand"
_LINK = "world/robot/link{}"
_FINGERS = ("world/robot/left_finger", "world/robot/right_finger")
_CAMERA = "world/camera"
_GHOST_HAND, _GHOST_BASE = "world/ghost/hand", "world/ghost/base"
_BANNER, _ABOVE = "world/fault", np.array([0.0, 0.0, 1.45])
"""The banner of a fault, and its position above the base [m]."""
_AWAY = SE3(np.eye(3), np.array([0.0, 0.0, -100.0]))  # a ghost without a goal: below the floor


class ScenePanel:
    """Draws the scene."""

    def __init__(self, stream: rr.RecordingStream, model: RobotModel, scene: SceneView) -> None:
        self._stream = stream
        self._model = model
        self._objects = [
            f"world/objects/{index}_{''.join(c if c.isalnum() else '_' for c in name)}"
            for index, (name, _) in enumerate(scene.objects)
        ]
        self._throttle, self._seen = Throttle(_POSE_PERIOD), Throttle(_SEEN_PERIOD)
        self._last: dict[str, SE3] = {}
        self._changes = Changes(stream)

        looks = robot_visual(model.description)
        robot = {
            _BASE: looks.base,
            _HAND: looks.hand,
            **{_LINK.format(number): link for number, link in enumerate(looks.links)},
            **dict.fromkeys(_FINGERS, looks.finger),
        }
        self._faults = FaultPanel(stream, robot)
        hand, base = ghosts(model.description)
        moving = {**robot, _GHOST_HAND: hand, _GHOST_BASE: base}
        for path, (_, parts) in zip(self._objects, scene.objects, strict=True):
            moving[path] = solids(parts)
        log_static(stream, moving)
        at_rest: dict[str, list[Any]] = {
            WORLD: [rr.ViewCoordinates.RIGHT_HAND_Z_UP],
            "world/fixtures": solids(scene.fixtures),
            "world/regions": [region_boxes(scene.regions)],
            "world/grasp": [rr.LineStrips3D.from_fields(radii=0.004, show_labels=True)],
            "world/way": [_line(_GHOST, 2.0)],
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
        lines, nearest = rr.LineStrips3D, lambda s: (s.report.nearest_points,)
        send("world/grasp", lines, shown, lambda s: (s.grasp, s.locked), _grasp)
        send("world/way", lines, shown, lambda s: (s.way,), _way)
        send("world/nearest", lines, shown, nearest, _nearest)
        some = [snapshot for snapshot in shown if self._seen.due(snapshot.stamp)]
        send("world/seen", rr.Points3D, some, lambda s: (s.seen,), _seen)

    def _moved(self, snapshot: Snapshot) -> dict[str, SE3]:
        """Poses of the frames that moved."""
        state, robot = snapshot.state, self._model.description
        mTb = snapshot.mTb
        *links, hand = self._model.link_poses(mTb, state.q)
        fingers = [hand * pose for pose in finger_poses(robot.gripper, state.gripper_width)]
        poses = {
            _BASE: mTb,
            _HAND: hand,
            _GHOST_HAND: _AWAY if snapshot.hand_goal is None else snapshot.hand_goal,
            _GHOST_BASE: _AWAY if snapshot.base_goal is None else se3_of(snapshot.base_goal),
            **{_LINK.format(number): pose for number, pose in enumerate(links)},
            **dict(zip(_FINGERS, fingers, strict=True)),
            **dict(zip(self._objects, snapshot.objects, strict=True)),
        }
        if _CAMERA not in self._last:  # until there is an image, where one would be taken
            poses[_CAMERA] = snapshot.mTe * robot.camera.eTc
        moved = {
            name: pose
            for name, pose in poses.items()
            if name not in self._last or not pose.isApprox(self._last[name], 1e-6)
        }
        self._last |= moved
        return moved


def _line(colour: Colour, width: float, **more: Any) -> rr.LineStrips3D:
    return rr.LineStrips3D.from_fields(colors=[colour], radii=rr.Radius.ui_points(width), **more)


def _grasp(snapshot: Snapshot) -> dict[str, Any]:
    """The outline of the open gripper at the tracked grasp, with its quality."""
    grasp, locked = snapshot.grasp, snapshot.locked
    if grasp is None:
        return {"strips": [], "colors": [], "labels": []}
    mTg = snapshot.mTo * grasp.oTg
    back, half = -_FINGER_LENGTH, grasp.width / 2
    outline = np.array([[0, -half, 0], [0, -half, back], [0, half, back], [0, half, 0]])
    return {
        "strips": [outline @ mTg.rotation.T + mTg.translation],
        "colors": [_LOCKED if locked else _TRACKED],
        "labels": [f"{grasp.quality:.2f}{' locked' if locked else ''}"],
    }


def _way(snapshot: Snapshot) -> dict[str, Any]:
    """Base path on the floor."""
    if snapshot.way is None or len(snapshot.way) < 2:
        return {"strips": []}
    points = np.column_stack([snapshot.way[:, :2], np.full(len(snapshot.way), _FLOOR)])
    return {"strips": [points]}


def _nearest(snapshot: Snapshot) -> dict[str, Any]:
    """A line over the smallest distance that the controller keeps, with its length."""
    points, distance = snapshot.report.nearest_points, snapshot.report.clearance
    if points is None or not distance < _FAR:
        return {"strips": [], "labels": []}
    return {"strips": [np.stack(points)], "labels": [f"{100.0 * distance:.0f} cm"]}


def _seen(snapshot: Snapshot) -> dict[str, Any]:
    points: Array = np.zeros((0, 3)) if snapshot.seen is None else snapshot.seen.points
    return {"positions": points[:: max(1, -(-len(points) // _SEEN_POINTS))]}


def ghosts(robot: RobotDescription) -> tuple[list[Any], list[Any]]:
    """Transparent shapes of the open hand, in the frame of a tool pose, and of the base."""
    gripper = robot.gripper
    palm, _ = hand_parts(robot)
    fingers = [
        part.moved(pose)
        for pose in finger_poses(gripper, gripper.opening)
        for part in (gripper.finger, gripper.pad)
    ]
    hand = [part.moved(gripper.hTe.inverse()) for part in (palm, *fingers)]
    both = [
        solids(parts, "TransparentFillMajorWireframe")
        for parts in (hand, base_parts(robot.base)[:1])
    ]
    for body in (*both[0], *both[1]):
        body.colors = [(*_GHOST, 90)]
    return both[0], both[1]


def region_boxes(regions: Sequence[Region]) -> rr.Boxes3D:
    """The regions of a task, in the world."""
    return rr.Boxes3D(
        half_sizes=[region.size / 2.0 for region in regions],
        centers=[region.mTr.translation for region in regions],
        quaternions=[_upright(region.mTr.rotation) for region in regions],
        labels=[printable(region.name) for region in regions],
        show_labels=True,
        colors=[_REGION],
        radii=rr.Radius.ui_points(1.0),
        fill_mode="MajorWireframe",
    )


def _upright(rotation: Array) -> rr.Quaternion:
    yaw = yaw_of(rotation)
    return rr.Quaternion(xyzw=(0.0, 0.0, sin(yaw / 2.0), cos(yaw / 2.0)))


class FaultPanel:
    """Draws faults: the robot in red, and a banner over it.

    `bodies` are the archetypes of the robot by entity; their colours are moved to this panel.
    """

    def __init__(self, stream: rr.RecordingStream, bodies: Mapping[str, Sequence[Any]]) -> None:
        self._stream = stream
        self._shown: tuple[str, ...] | None = None
        self._looks: list[tuple[str, type[Any], Any]] = []
        colours: dict[int, Any] = {}  # both fingers are drawn from the same
        for path, some in bodies.items():
            for body in some:
                if not isinstance(body, rr.Mesh3D) and id(body) not in colours:
                    colours[id(body)] = body.colors.pa_array.to_numpy(zero_copy_only=False)
                    body.colors = None  # a colour that never changes could not turn red
                self._looks.append((path, type(body), colours.get(id(body))))
        look = rr.Points3D.from_fields(colors=[_RED], radii=0.02, show_labels=True)
        log_static(stream, {_BANNER: [look]}, WORLD)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the faults of a batch."""
        for snapshot in batch:
            faults = tuple(fault.text for fault in snapshot.state.faults)
            if faults != self._shown:
                set_time(self._stream, snapshot)
                if self._shown is None or bool(faults) is not bool(self._shown):
                    self._paint(bool(faults))
                self._shown = faults
                place = snapshot.mTb.translation + _ABOVE
                label = f"⚠ FAULT: {printable('; '.join(faults))}"
                banner = rr.Points3D.from_fields(
                    positions=[place] if faults else [], labels=[label] if faults else []
                )
                self._stream.log(_BANNER, banner)

    def _paint(self, is_red: bool) -> None:
        for path, kind, colours in self._looks:
            if kind is rr.Mesh3D:
                look = rr.Mesh3D.from_fields(albedo_factor=_RED if is_red else _PLAIN)
            else:
                look = kind.from_fields(colors=[_RED] if is_red else colours)
            self._stream.log(path, look)
