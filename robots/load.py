"""Loads robots by name or file.

A robot file describes the base and names the files of arm, gripper, camera and laser: next to it,
in a folder `parts` next to it, or shipped. The file of a real robot names a description instead,
with what differs from it and the addresses of the hardware.
"""

import json
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from os.path import isfile
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config import Diagnostics, YamlMap, read_yaml, suggest
from config.reader import ConfigError, StrictModel, read_config
from robots.description import (
    ArmDescription,
    BaseDescription,
    CameraDescription,
    GripperDescription,
    Intrinsics,
    LaserDescription,
    Limits,
    RobotDescription,
)
from robots.schema import (
    ArmFile,
    BaseFile,
    CameraFile,
    GripperFile,
    LaserFile,
    LinkCapsuleFile,
    LinkHullFile,
    RobotFile,
)
from robots.schema_geometry import CapsuleFile, HullFile, PoseFile
from robots.schema_hardware import HardwareFile, RealRobotFile, read_real_robot
from robots.shapes import Box, Colour, Geom, half_extents

SHIPPED = Path(__file__).parent

_AXES = {
    "differential": np.array([[0.0, 1.0], [0.0, 0.0], [1.0, 0.0]]),
    "omnidirectional": np.eye(3),
}
"""(3, n_base) degrees of freedom of each drive: (ω, v) as in Haviland 2022, and (vx, vy, ω)."""

_PARTS: dict[str, type[StrictModel]] = {
    "arm": ArmFile,
    "gripper": GripperFile,
    "camera": CameraFile,
    "laser": LaserFile,
}

_METAL: Colour = (225, 225, 228)
_RUBBER: Colour = (40, 40, 44)
_BLACK: Colour = (38, 40, 45)


@dataclass(frozen=True, kw_only=True)
class RealRobot:
    """The file of a real robot without its description."""

    path: Path
    body: str  # the file of its description
    hardware: HardwareFile
    map: str | None  # scene file with the surroundings, if there is one
    calibrated: tuple[str, ...]  # which of `arm_mount` and `camera_mount` are calibrated


def robot_names() -> list[str]:
    """Names of the shipped descriptions."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml") if not _is_real(path))


def load_robot(robot: str | Path) -> RobotDescription:
    """The description of a robot, by name or file; equal files give one object; ConfigError."""
    path = _path(robot)
    if not _is_real(path):
        return _load(path)
    file = read_real_robot(path)
    return _as_it_is(_load(Path(file.robot).resolve()), file, path.stem)


def load_real_robot(robot: str | Path) -> RealRobot | None:
    """The hardware of a robot, by name or file; None for a description; may be ConfigError."""
    path = _path(robot)
    if not _is_real(path):
        return None
    file = read_real_robot(path)
    beside = path.parent / (file.map or "")
    site = str(beside) if file.map and isfile(beside) else file.map
    mounts = {"arm_mount": file.arm_mount, "camera_mount": file.camera_mount}
    return RealRobot(
        path=path,
        body=file.robot,
        hardware=file.hardware,
        map=site,
        calibrated=tuple(name for name, mount in mounts.items() if mount is not None),
    )


def robot_texts(robot: str | Path) -> dict[str, str]:
    """Files, by path, that describe a robot as it is, with the calibration of a real one."""
    path = _path(robot)
    real = read_real_robot(path) if _is_real(path) else None
    found = path if real is None else Path(real.robot).resolve()
    file = read_config(found, RobotFile, context=(found.parent, SHIPPED))
    given = {kind: getattr(file, kind) for kind in _PARTS if getattr(file, kind)}
    parts = {kind: _dumped(read_config(Path(given[kind]), _PARTS[kind])) for kind in given}
    body = _dumped(file) | {kind: kind for kind in parts}
    if real is not None:
        own = _dumped(real)
        body |= {key: own[key] for key in ("arm_mount", "camera_mount") if key in own}
        ours = {"limits": own.get("base_limits"), "lag": own.get("base_lag")}
        body["base"] |= {key: value for key, value in ours.items() if value is not None}
        parts["arm"]["lag"] = own.get("arm_lag", parts["arm"]["lag"])
    files = {f"{path.stem}.yaml": body} | {f"parts/{kind}.yaml": parts[kind] for kind in parts}
    return {name: json.dumps(content, indent=1) + "\n" for name, content in files.items()}


def _dumped(file: StrictModel) -> dict[str, Any]:
    return file.model_dump(mode="json", exclude_none=True)


def _path(robot: str | Path) -> Path:
    """Path of a file, or of a shipped robot by its name or as `robots/NAME.yaml` from anywhere."""
    path = Path(robot)
    shipped = SHIPPED / path.name if path.parent == Path(SHIPPED.name) else path
    if path.suffix in (".urdf", ".xacro") and isfile(path):
        command = f"`frankie-task robot import {robot} -o FOLDER`"
        raise ConfigError(f"{robot} is no robot file; {command} makes one of it")
    for place in (SHIPPED / f"{robot}.yaml", path, path / f"{path.name}.yaml", shipped):
        if isfile(place):
            return place.resolve()
    hint = suggest(path.stem, (one.stem for one in SHIPPED.glob("*.yaml")))
    what = f"no robot is called `{robot}`; {hint} (or give a robot file)"
    raise ConfigError(f"the robot file {robot} is not found; {hint}" if path.suffix else what)


def _is_real(path: Path) -> bool:
    """Whether a file is that of a real robot; its mistakes are reported later."""
    read = read_yaml(Diagnostics(path))
    return read is not None and isinstance(read[1], YamlMap) and "hardware" in read[1].entries


def _as_it_is(described: RobotDescription, file: RealRobotFile, name: str) -> RobotDescription:
    limits, base, arm, camera = described.limits, described.base, described.arm, described.camera
    if (ours := file.base_limits) is not None:
        limits = replace(
            limits,
            base_twist=np.array(ours.speed),
            base_reverse=ours.reverse,
            base_acceleration=np.array(ours.acceleration),
            base_emergency=np.array(ours.emergency),
        )
    if file.base_lag is not None:
        base = replace(base, lag=file.base_lag)
    if file.arm_lag is not None:
        arm = replace(arm, lag=file.arm_lag)
    if isinstance(file.camera_mount, PoseFile):
        camera = replace(camera, eTc=file.camera_mount.pose())
    gripper = _mounted(described.gripper, camera, arm)
    bTa = file.arm_mount.pose() if isinstance(file.arm_mount, PoseFile) else described.bTa
    return replace(
        described,
        name=name,
        limits=limits,
        base=base,
        arm=arm,
        gripper=gripper,
        camera=camera,
        bTa=bTa,
    )


@cache
def _load(path: Path) -> RobotDescription:
    file = read_config(path, RobotFile, context=(path.parent, SHIPPED))
    arm_file = read_config(Path(file.arm), ArmFile)
    arm = _arm(arm_file)
    camera = _camera(read_config(Path(file.camera), CameraFile), file.camera_mount)
    return RobotDescription(
        name=path.stem,
        base=BaseDescription(
            axes=_AXES[file.base.drive],
            size=file.base.size,
            lag=file.base.lag,
            mass=file.base.mass,
            visual=file.base.visual,
        ),
        bTa=file.arm_mount.pose(),
        arm=arm,
        gripper=_mounted(_gripper(read_config(Path(file.gripper), GripperFile)), camera, arm),
        camera=camera,
        limits=_limits(arm_file, file.base),
        laser=_laser(file),
    )


def _arm(file: ArmFile) -> ArmDescription:
    shapes: list[LinkCapsuleFile | LinkHullFile] = [*file.collision, *file.hulls]
    names = [joint.name for joint in file.joints if joint.name]
    return ArmDescription(
        joints=tuple(joint.pose() for joint in file.joints),
        slides=np.array([joint.kind == "prismatic" for joint in file.joints]),
        lTh=file.flange.pose(),
        ready=np.array(file.ready),
        lag=file.lag,
        collision=tuple(
            tuple(part.geom(f"link{link}") for part in shapes if part.link == link)
            for link in range(len(file.joints) + 1)
        ),
        may_touch=tuple(pair for ours, theirs in file.may_touch for pair in product(ours, theirs)),
        inertias=tuple(part.inertia() for part in file.inertia),
        torque=np.array([joint.torque for joint in file.joints]),
        visual=file.visual,
        names=tuple(names) if len(names) == len(file.joints) else (),
        links=tuple((link.name, link.pose()) for link in file.links),
    )


def _gripper(file: GripperFile) -> GripperDescription:
    shapes: list[CapsuleFile | HullFile] = [*file.collision, *file.hulls]
    return GripperDescription(
        hTe=file.grasp_centre.pose(),
        opening=file.opening,
        speed=file.speed,
        palm=file.palm.geom("palm", _METAL),
        finger=file.finger.geom("finger", _METAL),
        pad=file.pad.geom("pad", _RUBBER),
        tip=file.pad.xyz[2] + file.pad.size[2] / 2.0,
        ball=file.ball.geom("hand"),
        collision=tuple(part.geom("hand") for part in shapes),
        inertia=file.inertia.inertia(),
        finger_mass=file.finger_mass,
        grasps=file.grasps,
        visual=file.visual,
    )


def _mounted(
    gripper: GripperDescription, camera: CameraDescription, arm: ArmDescription
) -> GripperDescription:
    """A gripper with what is mounted beside and behind it."""
    links, aTl = [], SE3.Identity()
    for origin, q, slides in zip(arm.joints, arm.ready, arm.slides, strict=True):
        move = np.array([0.0, 0.0, q])
        aTl = aTl * origin * (SE3(np.eye(3), move) if slides else SE3(pin.exp3(move), np.zeros(3)))
        links.append(aTl)
    aTe = aTl * arm.lTh * gripper.hTe
    ahead = pin.exp3(np.array([0.0, 0.0, np.arctan2(aTe.translation[1], aTe.translation[0])]))
    upright = SE3(ahead, aTe.translation).inverse()
    wrist = [
        _box(upright * link * part.pose, part)
        for link, parts in zip(links[-2:], arm.collision[-2:], strict=True)
        for part in parts
    ]
    return replace(
        gripper, camera=_box(camera.eTc * camera.body.pose, camera.body), wrist=tuple(wrist)
    )


def _box(pose: SE3, part: Geom) -> Geom:
    """The box along the axes of a frame around a part at a pose in it."""
    half = np.abs(pose.rotation) @ np.array(half_extents(part.shape))
    return Geom(Box(tuple(half.tolist())), SE3(np.eye(3), pose.translation), part.name)


def _camera(file: CameraFile, mount: PoseFile) -> CameraDescription:
    near, far = file.depth_range
    return CameraDescription(
        eTc=mount.pose(),
        intrinsics=Intrinsics(**file.intrinsics.model_dump()),
        rate=file.rate,
        min_range=near,
        max_range=far,
        baseline=file.baseline,
        body=file.body.geom("camera", _BLACK),
        mass=file.mass,
    )


def _laser(file: RobotFile) -> LaserDescription | None:
    if file.laser is None or file.laser_mount is None:
        return None
    laser, mount = read_config(Path(file.laser), LaserFile), file.laser_mount
    gaps = round(laser.field_of_view_deg / laser.resolution_deg)
    half = np.deg2rad(gaps * laser.resolution_deg / 2.0)
    return LaserDescription(
        bTs=SE3(pin.utils.rotate("z", np.deg2rad(mount.yaw_deg)), np.array(mount.xyz)),
        angles=np.linspace(-half, half, gaps + 1),
        max_range=laser.max_range,
        rate=laser.rate,
        noise=laser.noise,
    )


def _limits(arm: ArmFile, base: BaseFile) -> Limits:
    return Limits(
        q_min=np.array([joint.limits[0] for joint in arm.joints]),
        q_max=np.array([joint.limits[1] for joint in arm.joints]),
        qd=np.array([joint.speed for joint in arm.joints]),
        qdd=np.array([joint.acceleration for joint in arm.joints]),
        base_twist=np.array(base.limits.speed),
        base_reverse=base.limits.reverse,
        base_acceleration=np.array(base.limits.acceleration),
        base_emergency=np.array(base.limits.emergency),
    )
