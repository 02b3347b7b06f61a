"""Rerun archetypes of the robot: the meshes of its parts if they are installed, else primitives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr

from app.live.monitor.meshes import Mesh, meshes
from app.live.monitor.robot_shapes import arm_parts, base_parts, finger_parts, hand_parts
from app.live.monitor.solids import solids
from robots import RobotDescription

_FINGER_ROOT = 0.0584
"""Origin of the finger's mesh on the flange, along z [m]."""


@dataclass(frozen=True, kw_only=True)
class RobotLooks:
    """Rerun archetypes for every body, each in its own frame."""

    base: list[Any]
    links: list[list[Any]]
    """The arm's foot and seven links."""
    hand: list[Any]
    finger: list[Any]


def robot_looks(robot: RobotDescription) -> RobotLooks:
    """What a robot looks like."""
    installed = meshes()
    base, links = solids(base_parts(robot.base)), [solids(parts) for parts in arm_parts(robot.arm)]
    palm, camera = (solids((part,)) for part in hand_parts(robot))
    finger = solids(finger_parts(robot.gripper))
    if installed and robot.base.looks == "omron":
        base = [_mesh(installed["omron"])]
    if installed and robot.arm.looks == "panda":
        links = [[_mesh(installed[f"link{i}"])] for i in range(len(links))]
    if installed and robot.gripper.looks == "franka_hand":
        root = np.array([0.0, 0.0, robot.gripper.hTe.translation[2] - _FINGER_ROOT])
        palm, finger = [_mesh(installed["hand"])], [_mesh(installed["finger"], root)]
    return RobotLooks(base=base, links=links, hand=[*palm, *camera], finger=finger)


def _mesh(mesh: Mesh, origin: Any = 0.0) -> rr.Mesh3D:
    """A mesh whose frame lies at `origin` (3,) [m] of its own."""
    return rr.Mesh3D(
        vertex_positions=mesh.vertices - np.float32(origin),
        vertex_normals=mesh.normals,
        vertex_colors=mesh.colours,
        triangle_indices=mesh.triangles,
    )
