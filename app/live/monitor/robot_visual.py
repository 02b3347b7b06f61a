"""Rerun archetypes of shapes, and of a robot: its meshes if they are installed, else its shapes."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
from pinocchio import SE3, Quaternion

from app.live.monitor.meshes import Mesh, meshes
from app.live.robot_parts import arm_parts, base_parts, hand_parts
from app.live.viewer.viewer import ViewError, has_screen
from controller import RobotModel
from robots import Box, Capsule, Cylinder, Geom, Hull, RobotDescription, Sphere

_FINGER_ROOT = 0.0584  # origin of the finger's mesh on the flange, along z [m]


@dataclass(frozen=True, kw_only=True)
class RobotVisual:
    """Rerun archetypes for every body, each in its own frame."""

    base: list[Any]
    links: list[list[Any]]
    hand: list[Any]
    finger: list[Any]


def robot_visual(robot: RobotDescription) -> RobotVisual:
    """What a robot looks like."""
    installed = meshes()
    base, links = solids(base_parts(robot.base)), [solids(parts) for parts in arm_parts(robot.arm)]
    palm, camera = (solids((part,)) for part in hand_parts(robot))
    finger = solids((robot.gripper.finger, robot.gripper.pad))
    if installed and robot.base.visual == "omron":
        base = [_mesh(installed["omron"])]
    if installed and robot.arm.visual == "panda":
        links = [[_mesh(installed[f"link{i}"])] for i in range(len(links))]
    if installed and robot.gripper.visual == "franka_hand":
        root = np.array([0.0, 0.0, robot.gripper.hTe.translation[2] - _FINGER_ROOT])
        palm, finger = [_mesh(installed["hand"])], [_mesh(installed["finger"], root)]
    return RobotVisual(base=base, links=links, hand=[*palm, *camera], finger=finger)


def draw(robot: RobotDescription, save: Path | None) -> None:
    """Draw a robot as the controller sees it, ready, in the viewer or into a .rrd file.

    Raises ViewError: there is no screen for the viewer.
    """
    if save is None and not has_screen():
        hint = "--save robot.rrd writes what `frankie-task view --web robot.rrd` shows"
        raise ViewError(f"there is no screen here; {hint}")
    stream = rr.RecordingStream("frankie-task robot")
    stream.spawn() if save is None else stream.save(save)
    *links, hand = RobotModel(robot).link_poses(SE3.Identity(), robot.arm.ready)
    bodies = {f"link{k}": (pose, arm_parts(robot.arm)[k]) for k, pose in enumerate(links)}
    bodies |= {"base": (SE3.Identity(), base_parts(robot.base))}
    bodies |= {"hand": (hand, (*hand_parts(robot), *robot.gripper.collision))}
    for name, (pose, parts) in bodies.items():
        solid = solids([part.moved(pose) for part in parts])
        for number, one in enumerate(solid):
            stream.log(f"{name}/{number}", one, static=True)


def _mesh(mesh: Mesh, origin: Any = 0.0) -> rr.Mesh3D:
    """A mesh whose frame lies at `origin` (3,) [m] of its own."""
    return rr.Mesh3D(
        vertex_positions=mesh.vertices - np.float32(origin),
        vertex_normals=mesh.normals,
        vertex_colors=mesh.colours,
        triangle_indices=mesh.triangles,
    )


def solids(parts: Sequence[Geom], fill: str = "solid") -> list[Any]:
    """Archetypes of shapes in the frame of their poses, with Rerun's fill mode; no planes."""
    bodies: list[Any] = []
    for kind in (Box, Sphere, Cylinder, Capsule):
        some: list[Any] = [(p.shape, p.pose, p.colour) for p in parts if isinstance(p.shape, kind)]
        if not some:
            continue
        looks: dict[str, Any] = {
            "quaternions": [Quaternion(pose.rotation).coeffs() for _, pose, _ in some],
            "colors": [colour for _, _, colour in some],
            "fill_mode": fill,
        }
        centres = [pose.translation for _, pose, _ in some]
        if kind is Box:
            sizes = [box.half for box, _, _ in some]
            bodies.append(rr.Boxes3D(half_sizes=sizes, centers=centres, **looks))
            continue
        radii = [shape.radius for shape, _, _ in some]
        if kind is Sphere:
            bodies.append(rr.Ellipsoids3D(radii=radii, centers=centres, **looks))
            continue
        looks |= {"radii": radii, "lengths": [2 * shape.half_length for shape, _, _ in some]}
        if kind is Cylinder:
            bodies.append(rr.Cylinders3D(centers=centres, **looks))
        else:
            ends = [pose.act(np.array([0.0, 0.0, -one.half_length])) for one, pose, _ in some]
            bodies.append(rr.Capsules3D(translations=ends, **looks))
    if hulls := [part for part in parts if isinstance(part.shape, Hull)]:
        bodies.append(_one_mesh(hulls))
    return bodies


def _one_mesh(hulls: Sequence[Geom]) -> Any:
    shapes: list[Any] = [(part.shape, part.pose, part.colour) for part in hulls]
    corners = [
        (hull.vertices @ pose.rotation.T + pose.translation)[hull.triangles.ravel()]
        for hull, pose, _ in shapes
    ]
    faces = np.concatenate(corners).reshape(-1, 3, 3)
    a, b, c = faces.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    colours = [np.tile(colour, (hull.triangles.size, 1)) for hull, _, colour in shapes]
    return rr.Mesh3D(
        vertex_positions=faces.reshape(-1, 3),
        vertex_normals=np.repeat(normals, 3, axis=0),
        vertex_colors=np.concatenate(colours),
    )
