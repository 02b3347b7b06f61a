"""What draws the robot: its meshes where they are installed, else primitives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr

from app.live.monitor.meshes import Mesh, meshes
from app.live.monitor.robot_shapes import CAMERA, FINGER, FINGER_MIDDLE, HAND, LINKS, base_parts
from app.live.monitor.solids import solids
from robots import RobotDescription


@dataclass(frozen=True, kw_only=True)
class RobotLooks:
    """Rerun archetypes for every body, each in its own frame."""

    base: list[Any]
    links: list[list[Any]]
    """The arm's foot and seven links."""
    hand: list[Any]
    finger: list[Any]


def robot_looks(description: RobotDescription) -> RobotLooks:
    """What a robot looks like."""
    real = meshes()
    foot = float(description.bTa.translation[2])
    base = solids(base_parts(foot))
    if real is None:
        return RobotLooks(
            base=base,
            links=[solids(parts) for parts in LINKS],
            hand=solids((*HAND, CAMERA)),
            finger=solids(FINGER),
        )
    return RobotLooks(
        base=[_mesh(real["omron"])] if description.base.looks == "omron" else base,
        links=[[_mesh(real[f"link{i}"])] for i in range(len(LINKS))],
        hand=[_mesh(real["hand"]), *solids((CAMERA,))],
        finger=[_mesh(real["finger"], np.array(FINGER_MIDDLE))],
    )


def _mesh(mesh: Mesh, origin: Any = 0.0) -> rr.Mesh3D:
    """A mesh whose frame lies at `origin` (3,) [m] of its own."""
    return rr.Mesh3D(
        vertex_positions=mesh.vertices - np.float32(origin),
        vertex_normals=mesh.normals,
        vertex_colors=mesh.colours,
        triangle_indices=mesh.triangles,
    )
