"""Overlays of the 3-D scene: ghosts of the goals, base path, obstacles, regions, faults."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import cos, sin
from typing import Any

import numpy as np
import rerun as rr

from app.live.feed import Throttle
from app.live.monitor.columns import WORLD, Array, set_time, timelines
from app.live.monitor.glyphs import Colour, printable
from app.live.monitor.robot_visual import base_parts, finger_parts, finger_poses, hand_parts
from app.live.monitor.solids import solids
from app.live.snapshot import SceneView, Snapshot
from robots import RobotDescription

GHOST: Colour = (120, 190, 255)
_WAY: Colour = (120, 190, 255)
_FELT: Colour = (255, 150, 40)
_REGION: Colour = (110, 150, 120)
_SEEN: Colour = (235, 110, 90)
_FLOOR = 0.012
"""Height of lines on the floor, above its surface [m]."""
_FAR = 0.5
"""Larger distances are not drawn [m]."""
_SEEN_POINTS = 1000
_SEEN_PERIOD = 1.0
"""Shortest time between two drawings of depth obstacles [s]."""


def ghost_hand(robot: RobotDescription) -> list[Any]:
    """The open hand as a transparent shape, in the frame of a tool pose."""
    gripper = robot.gripper
    eTh = gripper.hTe.inverse()
    palm, _ = hand_parts(robot)
    fingers = [
        part.moved(pose)
        for pose in finger_poses(gripper, gripper.opening)
        for part in finger_parts(gripper)
    ]
    parts = [part.moved(eTh) for part in (palm, *fingers)]
    return _coloured(solids(parts, "TransparentFillMajorWireframe"))


def ghost_base(robot: RobotDescription) -> list[Any]:
    """The base as a transparent shape, in its own frame."""
    return _coloured(solids(base_parts(robot.base)[:1], "TransparentFillMajorWireframe"))


def _coloured(bodies: list[Any]) -> list[Any]:
    for body in bodies:
        body.colors = [(*GHOST, 90)]
    return bodies


class IntentPanel:
    """Draws base path, smallest distance, regions, and depth obstacles."""

    def __init__(self, stream: rr.RecordingStream, scene: SceneView) -> None:
        self._stream = stream
        self._last: dict[str, object] = {}
        self._seen = Throttle(_SEEN_PERIOD)
        lines = rr.LineStrips3D.from_fields
        looks: dict[str, list[Any]] = {
            "world/way": [lines(colors=[_WAY], radii=rr.Radius.ui_points(2.0))],
            "world/felt": [lines(colors=[_FELT], radii=rr.Radius.ui_points(2.5), show_labels=True)],
            "world/seen": [rr.Points3D.from_fields(colors=[_SEEN], radii=0.008)],
        }
        if scene.regions:
            looks["world/regions"] = [
                rr.Boxes3D(
                    half_sizes=[region.size / 2.0 for region in scene.regions],
                    centers=[region.pose.translation for region in scene.regions],
                    quaternions=[_upright(region.pose.rotation) for region in scene.regions],
                    labels=[printable(region.name) for region in scene.regions],
                    show_labels=True,
                    colors=[_REGION],
                    radii=rr.Radius.ui_points(1.0),
                    fill_mode="MajorWireframe",
                )
            ]
        for path, bodies in looks.items():
            stream.log(path, rr.CoordinateFrame(WORLD), static=True)
            for body in bodies:
                stream.log(path, body, static=True)

    def write(self, shown: Sequence[Snapshot]) -> None:
        """Add snapshots, each of which is drawn if it has changed."""
        self._send("world/way", shown, lambda s: s.way, _way)
        self._send("world/felt", shown, lambda s: s.report.nearest_points, _felt)
        some = [snapshot for snapshot in shown if self._seen.due(snapshot.stamp)]
        self._send("world/seen", some, lambda s: s.seen, _seen)

    def _send(
        self,
        path: str,
        shown: Sequence[Snapshot],
        source: Callable[[Snapshot], object],
        drawn: Callable[[Snapshot], tuple[int, Any]],
    ) -> None:
        """Send the snapshots in which `source` has changed."""
        for snapshot in shown:
            now = source(snapshot)
            if path in self._last and now is self._last[path]:
                continue
            self._last[path] = now
            count, columns = drawn(snapshot)
            self._stream.send_columns(
                path, indexes=timelines([snapshot]), columns=columns.partition([count])
            )


def _way(snapshot: Snapshot) -> tuple[int, Any]:
    """Base path on the floor."""
    if snapshot.way is None or len(snapshot.way) < 2:
        return 0, rr.LineStrips3D.columns(strips=[])
    points = np.column_stack([snapshot.way[:, :2], np.full(len(snapshot.way), _FLOOR)])
    return 1, rr.LineStrips3D.columns(strips=[points])


def _felt(snapshot: Snapshot) -> tuple[int, Any]:
    """A line over the smallest distance that the controller keeps, with its length."""
    distance = snapshot.report.clearance
    if snapshot.report.nearest_points is None or not distance < _FAR:
        return 0, rr.LineStrips3D.columns(strips=[], labels=[])
    label = f"{100.0 * distance:.0f} cm"
    return 1, rr.LineStrips3D.columns(
        strips=[np.stack(snapshot.report.nearest_points)], labels=[label]
    )


def _seen(snapshot: Snapshot) -> tuple[int, Any]:
    points: Array = np.zeros((0, 3)) if snapshot.seen is None else snapshot.seen.points
    some = points[:: max(1, -(-len(points) // _SEEN_POINTS))]
    return len(some), rr.Points3D.columns(positions=some)


def _upright(rotation: Array) -> rr.Quaternion:
    yaw = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    return rr.Quaternion(xyzw=(0.0, 0.0, sin(yaw / 2.0), cos(yaw / 2.0)))


_RED: Colour = (225, 45, 40)
_PLAIN: Colour = (255, 255, 255)
_BANNER = "world/fault"
_ABOVE = np.array([0.0, 0.0, 1.45])
"""Position of the banner above the base [m]."""


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
        stream.log(_BANNER, rr.CoordinateFrame(WORLD), static=True)
        look = rr.Points3D.from_fields(colors=[_RED], radii=0.02, show_labels=True)
        stream.log(_BANNER, look, static=True)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the faults of a batch."""
        for snapshot in batch:
            faults = tuple(fault.text for fault in snapshot.state.faults)
            if faults != self._shown:
                set_time(self._stream, snapshot)
                if self._shown is None or bool(faults) is not bool(self._shown):
                    self._paint(bool(faults))
                self._hang(snapshot, faults)
                self._shown = faults

    def _paint(self, is_red: bool) -> None:
        for path, kind, colours in self._looks:
            if kind is rr.Mesh3D:
                look = rr.Mesh3D.from_fields(albedo_factor=_RED if is_red else _PLAIN)
            else:
                look = kind.from_fields(colors=[_RED] if is_red else colours)
            self._stream.log(path, look)

    def _hang(self, snapshot: Snapshot, faults: Sequence[str]) -> None:
        places = [snapshot.state.wTb.translation + _ABOVE] if faults else []
        labels = [f"⚠ FAULT: {printable('; '.join(faults))}"] if faults else []
        self._stream.log(_BANNER, rr.Points3D.from_fields(positions=places, labels=labels))
