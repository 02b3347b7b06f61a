"""Schemas of the files of robots and their parts."""

from __future__ import annotations

from math import inf, isclose
from os.path import isfile
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from config import counted, suggest
from config.reader import StrictModel
from robots.schema_geometry import (
    BallFile,
    BoxFile,
    CapsuleFile,
    Finite,
    HullFile,
    InertiaFile,
    NotNegative,
    PoseFile,
    Positive,
    Range,
    Vector,
)

MOST_JOINTS = 12  # of an arm


_Link: TypeAlias = Annotated[int, Field(ge=0, le=MOST_JOINTS)]  # 0 is the foot


class LinkCapsuleFile(CapsuleFile):
    """A capsule of one link."""

    link: _Link


class LinkHullFile(HullFile):
    """A hull of one link."""

    link: _Link


class LinkFrameFile(PoseFile):
    """The frame of a link as its URDF has it, on ours."""

    name: str


class JointFile(PoseFile):
    """A joint: its pose on the joint before it, and its limits."""

    name: str | None = None  # in its URDF
    kind: Literal["revolute", "continuous", "prismatic"] = "revolute"
    position: Range | None = None  # lower and upper, none of a continuous joint [rad, or m]
    speed: Positive  # [rad/s, or m/s]
    acceleration: Positive  # [rad/s^2, or m/s^2]
    torque: Positive  # of its motor [Nm, or N]

    @model_validator(mode="after")
    def _has_its_range(self) -> JointFile:
        if (self.position is None) != (self.kind == "continuous"):
            raise ValueError("a joint has a `position`, its range, unless it is continuous")
        return self

    @property
    def limits(self) -> tuple[float, float]:
        """Lower and upper position [rad, or m]."""
        return self.position or (-inf, inf)


class ArmFile(StrictModel):
    """A serial arm of j joints, each turning about its own z or sliding along it."""

    joints: Annotated[tuple[JointFile, ...], Field(min_length=1, max_length=MOST_JOINTS)]
    flange: PoseFile  # of the hand, on the last link
    ready: tuple[Finite, ...]  # posture named `ready` in tasks [rad, or m]
    lag: Positive  # time constant of the joint velocities [s]
    links: tuple[LinkFrameFile, ...] = ()  # of its URDF: the foot, and one a joint
    visual: str | None = None  # mesh that the viewer draws, if it is installed
    collision: tuple[LinkCapsuleFile, ...]
    hulls: tuple[LinkHullFile, ...] = ()  # more of the collision shapes
    may_touch: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]  # all of the first and second
    inertia: tuple[InertiaFile, ...] = ()
    """Of the foot and the links, each in its frame; only the physical world needs it."""

    @field_validator("ready")
    @classmethod
    def _is_within_limits(cls, ready: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        joints: tuple[JointFile, ...] = info.data.get("joints", ())  # missing if they are wrong
        if joints and len(ready) != len(joints):
            raise ValueError(f"write {counted(len(joints), 'position')}, one a joint")
        for number, (joint, q) in enumerate(zip(joints, ready, strict=False), start=1):
            low, high = joint.limits
            if not low <= q <= high:
                raise ValueError(f"joint {number} is outside of its limits {low} to {high} rad")
        return ready

    @field_validator("collision", "hulls", "may_touch", "inertia")
    @classmethod
    def _has_its_links(cls, value: Any, info: ValidationInfo) -> Any:
        links = [f"link{number}" for number in range(len(info.data.get("joints", ())) + 1)]
        if len(links) == 1:  # the joints are wrong themselves
            return value
        if info.field_name == "inertia":
            if value and len(value) != len(links):
                raise ValueError(f"give it for the foot and {counted(len(links) - 1, 'link')}")
            return value
        named = (
            [f"link{part.link}" for part in value]
            if info.field_name in ("collision", "hulls")
            else [name for pair in value for side in pair for name in side]
        )
        links += ["base", "floor", "hand", "camera"]
        for name in named:
            if name not in links:
                raise ValueError(f"no link is called `{name}`; {suggest(name, links)}")
        return value


class GripperFile(StrictModel):
    """A parallel gripper; finger and pad are those at +y, when the pads touch."""

    grasp_centre: PoseFile  # end effector on the flange
    opening: Positive  # [m]
    speed: Positive  # of the distance between the pads [m/s]
    palm: BoxFile
    finger: BoxFile
    pad: BoxFile
    ball: BallFile  # around palm and fingers at any opening
    collision: tuple[CapsuleFile, ...]  # on the flange
    hulls: tuple[HullFile, ...] = ()  # the same
    inertia: InertiaFile  # without the fingers, on the flange
    finger_mass: Positive  # of one finger [kg]
    visual: str | None = None  # mesh that the viewer draws, if it is installed
    grasps: bool = True  # false: a tool

    @field_validator("pad")
    @classmethod
    def _touches_the_other(cls, pad: BoxFile) -> BoxFile:
        if not isclose(pad.xyz[1], pad.size[1] / 2.0, abs_tol=1e-9):
            raise ValueError("the inner face of the pad lies in y = 0 when the pads touch")
        return pad

    @field_validator("ball")
    @classmethod
    def _is_around_the_hand(cls, ball: BallFile, info: ValidationInfo) -> BallFile:
        boxes = [info.data.get(key) for key in ("palm", "finger", "pad")]
        for box, wider in zip(boxes, (0.0, 0.5, 0.5), strict=True):
            if box is None or "opening" not in info.data:  # wrong themselves
                continue
            offset = np.abs(np.subtract(box.xyz, ball.xyz)) + np.divide(box.size, 2.0)
            offset[1] += wider * info.data["opening"]
            if np.linalg.norm(offset) > ball.radius:
                raise ValueError("palm and fingers, fully open, reach out of the ball")
        return ball


class IntrinsicsFile(StrictModel):
    """A pinhole camera [px]."""

    width: Annotated[int, Field(gt=0, le=4096)]
    height: Annotated[int, Field(gt=0, le=4096)]
    fx: Positive
    fy: Positive
    cx: Finite
    cy: Finite


class CameraFile(StrictModel):
    """A stereo depth camera."""

    intrinsics: IntrinsicsFile
    rate: Positive  # [Hz]
    depth_range: Range  # [m]
    baseline: Positive  # [m]
    body: BoxFile
    mass: Positive  # [kg]


class LaserFile(StrictModel):
    """A laser that scans a level plane."""

    field_of_view_deg: Annotated[float, Field(gt=0.0, le=360.0)]  # from the first beam to the last
    resolution_deg: Annotated[float, Field(ge=0.05, le=10.0)]  # between neighbouring beams
    max_range: Positive  # [m]
    rate: Positive  # scans per second [Hz]
    noise: NotNegative  # standard deviation of a range [m]


class LaserMountFile(StrictModel):
    """Where a level laser is on the base."""

    xyz: Vector  # its height is z [m]
    yaw_deg: Finite = 0.0  # direction of the middle beam


class BaseLimitsFile(StrictModel):
    """Limits of the base."""

    speed: tuple[NotNegative, NotNegative, NotNegative]  # along x and y, about z [m/s, m/s, rad/s]
    reverse: NotNegative  # along -x [m/s]
    acceleration: tuple[Positive, Positive, Positive]  # along x and y, about z [m/s^2, rad/s^2]
    emergency: tuple[Positive, Positive, Positive]  # deceleration [m/s^2, rad/s^2]

    @model_validator(mode="after")
    def _stops_no_slower(self) -> BaseLimitsFile:
        if any(e < a for e, a in zip(self.emergency, self.acceleration, strict=True)):
            raise ValueError("`emergency` must be at least `acceleration` along every axis")
        return self


class BaseFile(StrictModel):
    """A mobile base."""

    drive: Literal["differential", "omnidirectional"]
    size: tuple[Positive, Positive, Positive]  # footprint along x and y, height [m]
    lag: Positive  # time constant of its velocity [s]
    limits: BaseLimitsFile
    mass: Positive  # [kg]
    visual: str | None = None  # mesh that the viewer draws, if it is installed

    @model_validator(mode="after")
    def _drives_as_it_can(self) -> BaseFile:
        sideways = self.limits.speed[1]
        if self.drive == "differential" and sideways > 0.0:
            raise ValueError("a differential drive has no speed along y")
        return self


def _found(part: str, info: ValidationInfo) -> str:
    """The path of a part's file, by its name or path; the context holds the folders."""
    folders: tuple[Path, ...] = info.context  # type: ignore[assignment]
    for path in (folders[0] / part, *(folder / "parts" / f"{part}.yaml" for folder in folders)):
        if isfile(path):
            return str(path)
    names = {path.stem for folder in folders for path in (folder / "parts").glob("*.yaml")}
    raise ValueError(f"no part is called `{part}`; {suggest(part, names)}")


PartFile: TypeAlias = Annotated[str, AfterValidator(_found)]


class RobotFile(StrictModel):
    """One mobile manipulator; its parts are files of their own, by name or path."""

    base: BaseFile
    arm: PartFile
    arm_mount: PoseFile  # foot of the arm on the base
    gripper: PartFile
    camera: PartFile
    camera_mount: PoseFile  # camera on the end effector
    laser: PartFile | None = None
    laser_mount: LaserMountFile | None = None  # laser on the base

    @model_validator(mode="after")
    def _mounts_its_laser(self) -> RobotFile:
        if (self.laser is None) != (self.laser_mount is None):
            raise ValueError("`laser` and `laser_mount` belong together; give both or neither")
        return self
