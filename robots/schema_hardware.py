"""Schema of the file of a real robot: a description, its differences, and hardware addresses."""

from __future__ import annotations

import re
from ipaddress import ip_address
from os.path import isfile
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, Field, ValidationInfo, model_validator

from config import StrictModel, read_config, suggest
from robots.schema import BaseLimitsFile
from robots.schema_geometry import NotNegative, PoseFile, Positive

Text: TypeAlias = Annotated[str, Field(min_length=1, max_length=200)]
Port: TypeAlias = Annotated[int, Field(ge=1, le=65535)]
Percent: TypeAlias = Annotated[float, Field(ge=1.0, le=100.0)]
Share: TypeAlias = Annotated[float, Field(ge=0.0, le=1.0)]
Six: TypeAlias = tuple[Positive, Positive, Positive, Positive, Positive, Positive]
SevenPositive: TypeAlias = tuple[
    Positive, Positive, Positive, Positive, Positive, Positive, Positive
]


class ArclFile(StrictModel):
    """The text interface of the base."""

    password: str
    port: Port = 7171


class FullScaleFile(StrictModel):
    """The "Teleop settings" of the base: speeds at 100 %, and dead zones."""

    forward: Positive = 1.0  # [m/s]
    reverse: Positive = 0.25  # [m/s]
    turn_deg: Positive = 50.0  # at rest [deg/s]
    turn_at_forward_deg: Positive | None = None
    turn_at_reverse_deg: Positive | None = None
    dead_translation: NotNegative = 10.0  # [%]
    dead_rotation: NotNegative = 5.0  # [%]


def _scale(value: FullScaleFile | str, info: ValidationInfo) -> FullScaleFile:
    """The values, or those of a file; the context is the folder of the robot file."""
    if not isinstance(value, str):
        return value
    path = Path(info.context or ".") / value
    if not isfile(path):
        raise ValueError(f"there is no file {path}; `frankie-task doctor --write-site` writes one")
    return read_config(path, FullScaleFile)


ScaleFile: TypeAlias = Annotated[FullScaleFile | str, AfterValidator(_scale)]


class SiteAccuracyFile(StrictModel):
    """Deviations of where a base takes itself to be on its map."""

    sigma: Positive = 0.02  # along x, and along y [m]
    sigma_deg: Positive = 0.5


class OmronFile(StrictModel):
    """An Omron LD-60."""

    driver: Literal["omron"]
    address: Text
    port: Port = 7272
    user: Text
    password: str = ""
    arcl: ArclFile | None = None
    full_scale: ScaleFile = FullScaleFile()  # or the file by `doctor --write-site`
    pose_delay: NotNegative = 0.0  # age of a pose on arrival [s]
    laser_delay: NotNegative = 0.0  # age of a scan of the laser on arrival [s]
    localisation: SiteAccuracyFile = SiteAccuracyFile()
    least_score: Share | None = None
    score_scale: Literal[100, 1000] | None = None

    @property
    def scale(self) -> FullScaleFile:
        """The values of `full_scale`, once the file is read."""
        assert isinstance(self.full_scale, FullScaleFile)
        return self.full_scale


class PandaFile(StrictModel):
    """A Franka Panda."""

    driver: Literal["panda"]
    address: Text
    torques: SevenPositive = (20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0)
    """Contact thresholds at which the arm stops [Nm]."""
    forces: Six = (20.0, 20.0, 20.0, 25.0, 25.0, 25.0)  # [N, Nm]
    lead: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0  # delay of the joints, compensated [s]


class HandFile(StrictModel):
    """A Franka Hand, at the address of the arm."""

    driver: Literal["franka_hand"]
    speed: Positive = 0.1  # [m/s]


class RealSenseFile(StrictModel):
    """An Intel RealSense D435."""

    driver: Literal["realsense"]
    serial: str = ""  # empty for the only camera
    rate: Literal[6, 15, 30, 60, 90] = 30  # [Hz]
    preset: str = "High Density"
    delay: NotNegative = 0.0  # age of an image at its stamp [s]


class HardwareFile(StrictModel):
    """How the parts of one robot are reached."""

    emulated: Port | None = None  # port of emulators, the camera's next; None: real
    speed_percent: Percent = 10.0  # of the speeds of the description
    base: OmronFile
    arm: PandaFile
    gripper: HandFile
    camera: RealSenseFile

    @model_validator(mode="after")
    def _emulators_are_here(self) -> HardwareFile:
        addresses = (self.base.address, self.arm.address)
        if self.emulated is not None and not all(map(_is_here, addresses)):
            raise ValueError("an emulated robot has addresses 127.x.y.z only")
        return self


class SpreadFile(StrictModel):
    """Uncertainty of a calibration."""

    mm: NotNegative
    deg: NotNegative
    views: int | None = None


class QualityFile(StrictModel):
    """Quality of a calibration."""

    views: int
    residual: NotNegative
    uncertainty: SpreadFile
    held_out: SpreadFile


class CalibrationFile(StrictModel):
    """File written by `frankie-task calibrate`."""

    arm_mount: PoseFile | None = None
    camera_mount: PoseFile | None = None
    quality: QualityFile


def _mount(value: PoseFile | str | None, info: ValidationInfo) -> PoseFile | None:
    """A pose, or that in a calibration file; the context is the folder of the robot file."""
    if not isinstance(value, str):
        return value
    path = Path(info.context or ".") / value
    if not isfile(path):
        raise ValueError(f"there is no file {path}; `frankie-task calibrate` writes one")
    name = info.field_name or ""
    pose: PoseFile | None = getattr(read_config(path, CalibrationFile), name)
    if pose is None:
        raise ValueError(f"{path} has no `{name}`; it is of another calibration")
    return pose


MountFile: TypeAlias = Annotated[PoseFile | str | None, AfterValidator(_mount)]
"""Once it is read, a pose or None."""


def _described(robot: str, info: ValidationInfo) -> str:
    """The path of a description: beside the robot file (in the context folder), or shipped."""
    shipped = Path(__file__).parent
    for path in (Path(info.context or ".") / robot, shipped / f"{robot}.yaml"):
        if isfile(path):
            if _HARDWARE.search(path.read_text(encoding="utf-8", errors="replace")):
                raise ValueError(f"`{robot}` is a real robot; name the description of one")
            return str(path)
    names = (path.stem for path in shipped.glob("*.yaml"))
    raise ValueError(f"no robot is called `{robot}`; {suggest(robot, names)}")


_HARDWARE = re.compile(r"^hardware:", re.MULTILINE)


class RealRobotFile(StrictModel):
    """One real robot."""

    robot: Annotated[Text, AfterValidator(_described)]
    """Its description: a shipped robot, or a robot file; the path of its file, once it is read."""
    hardware: HardwareFile
    arm_mount: MountFile = None  # foot of the arm on the base, or the file of its calibration
    camera_mount: MountFile = None  # camera on the end effector, or the file of its calibration
    base_limits: BaseLimitsFile | None = None
    base_lag: Positive | None = None  # time constant of its velocity [s]
    arm_lag: Positive | None = None  # time constant of the joint velocities [s]
    map: Text | None = None  # scene file with the surroundings


def _is_here(address: str) -> bool:
    try:
        return ip_address(address).is_loopback
    except ValueError:
        return address == "localhost"
