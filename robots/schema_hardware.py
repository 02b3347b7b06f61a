"""Schema of the file of a real robot: a description, its differences, and hardware addresses."""

from __future__ import annotations

import re
from collections.abc import Mapping
from ipaddress import ip_address
from os.path import isfile
from pathlib import Path
from typing import Annotated, Any, TypeAlias

from pydantic import AfterValidator, Field, ValidationInfo, create_model, model_validator

from config import Diagnostics, content, read_yaml, suggest
from config.reader import StrictModel, read_config
from robots.drivers import KINDS, SIMULATED, DriverOptions, options_model
from robots.schema import BaseLimitsFile
from robots.schema_geometry import PoseFile, Positive

Text: TypeAlias = Annotated[str, Field(min_length=1, max_length=200)]
Port: TypeAlias = Annotated[int, Field(ge=1, le=65535)]
Percent: TypeAlias = Annotated[float, Field(ge=1.0, le=100.0)]


_TOGETHER = (
    ("arm", "gripper", "a real one would hang on it"),
    ("arm", "camera", "a real one would hang on it"),
    ("gripper", "arm", "it holds what is simulated"),
    ("base", "laser", "a real one would stand on it"),
    ("laser", "base", "it does not see what a real one can hit"),
)
"""A part that is simulated, another that has to be then, and why."""


class NamedDriver(DriverOptions):
    """A part without the name of its driver."""

    driver: Text


class HardwareFile(StrictModel):
    """How the parts of one robot are reached; each has the options of its driver."""

    emulated: Port | None = None  # port of emulators, the camera's next; None: real
    speed_percent: Percent = 10.0  # of the speeds of the description
    base: DriverOptions
    arm: DriverOptions
    gripper: DriverOptions
    camera: DriverOptions
    laser: DriverOptions | None = None  # None: the driver of the base offers it, or nobody

    @model_validator(mode="after")
    def _emulators_are_here(self) -> HardwareFile:
        addresses = (str(getattr(one, "address", "")) for one in (self.base, self.arm))
        if self.emulated is not None and not all(map(_is_here, addresses)):
            raise ValueError("an emulated robot has addresses 127.x.y.z only")
        return self

    @model_validator(mode="after")
    def _simulated_parts_go_together(self) -> HardwareFile:
        for kind, other, why in _TOGETHER:
            one, two = getattr(self, kind), getattr(self, other)
            if one and two and one.driver == SIMULATED != two.driver:
                raise ValueError(f"a simulated {kind} needs a simulated {other}: {why}")
        return self


class CalibrationFile(StrictModel):
    """File written by `frankie-task calibrate`."""

    arm_mount: PoseFile | None = None
    camera_mount: PoseFile | None = None
    quality: Mapping[str, Any]  # for people


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


def read_real_robot(path: Path) -> RealRobotFile:
    """The file of a real robot, its parts with the options of their drivers; may be ConfigError."""
    return read_config(path, _with_options(path), context=path.parent)


def _with_options(path: Path) -> type[RealRobotFile]:
    """The schema for a file, by the drivers that it names."""
    read = read_yaml(Diagnostics(path))
    file = content(read[1]) if read else None
    hardware = file.get("hardware") if isinstance(file, dict) else None
    named = hardware if isinstance(hardware, dict) else {}
    parts: dict[str, Any] = {}
    for kind in KINDS:
        if isinstance(part := named.get(kind), dict):
            name = part.get("driver")
            options = options_model(kind, name) if isinstance(name, str) and name else NamedDriver
            parts[kind] = (options, ...)
    ours = create_model("HardwareFile", __base__=HardwareFile, **parts)
    return create_model("RealRobotFile", __base__=RealRobotFile, hardware=(ours, ...))


def _is_here(address: str) -> bool:
    try:
        return ip_address(address).is_loopback
    except ValueError:
        return address == "localhost"
