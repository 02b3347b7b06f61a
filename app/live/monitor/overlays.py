"""Overlays of the 3-D scene: ghosts of the goals, regions, and faults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, sin
from typing import Any

import numpy as np
import rerun as rr

from app.live.monitor.columns import WORLD, Array, log_static, set_time
from app.live.monitor.glyphs import Colour, printable
from app.live.monitor.robot_visual import base_parts, finger_poses, hand_parts
from app.live.monitor.solids import solids
from app.live.snapshot import RegionView, Snapshot
from robots import RobotDescription

GHOST: Colour = (120, 190, 255)
_REGION: Colour = (110, 150, 120)
_RED: Colour = (225, 45, 40)
_PLAIN: Colour = (255, 255, 255)
_BANNER = "world/fault"
_ABOVE = np.array([0.0, 0.0, 1.45])
"""Position of the banner above the base [m]."""


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
        body.colors = [(*GHOST, 90)]
    return both[0], both[1]


def region_boxes(regions: Sequence[RegionView]) -> rr.Boxes3D:
    """The regions of a task, in the world."""
    return rr.Boxes3D(
        half_sizes=[region.size / 2.0 for region in regions],
        centers=[region.pose.translation for region in regions],
        quaternions=[_upright(region.pose.rotation) for region in regions],
        labels=[printable(region.name) for region in regions],
        show_labels=True,
        colors=[_REGION],
        radii=rr.Radius.ui_points(1.0),
        fill_mode="MajorWireframe",
    )


def _upright(rotation: Array) -> rr.Quaternion:
    yaw = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
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
                place = snapshot.state.wTb.translation + _ABOVE
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
