"""An Omron LD-60 below `hardware` in a robot file: options and drivers of its base and laser."""

from math import radians
from os.path import isfile
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, Field, ValidationInfo

from config import StrictModel, read_config
from hw.drivers import DriverContext
from hw.omron.base import OmronBase
from hw.omron.laser import OmronLaser
from hw.omron.site import ArclSettings, OmronSettings, Site
from hw.robot import HardwareError
from robots import DriverOptions, NotNegative, Port, Positive, Text


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

    @property
    def site(self) -> Site:
        """The same in SI units."""

        def turn(degrees: float | None) -> float | None:
            return None if degrees is None else radians(degrees)

        return Site(
            forward=self.forward,
            reverse=self.reverse,
            turn=radians(self.turn_deg),
            turn_at_forward=turn(self.turn_at_forward_deg),
            turn_at_reverse=turn(self.turn_at_reverse_deg),
            dead_translation=self.dead_translation,
            dead_rotation=self.dead_rotation,
        )


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


class OmronOptions(DriverOptions):
    """An Omron LD-60."""

    address: Text
    port: Port = 7272
    user: Text
    password: str = ""
    arcl: ArclFile | None = None
    full_scale: ScaleFile = FullScaleFile()  # or the file by `doctor --write-site`
    pose_delay: NotNegative = 0.0  # age of a pose on arrival [s]
    laser_delay: NotNegative = 0.0  # age of a scan of the laser on arrival [s]
    localisation: SiteAccuracyFile = SiteAccuracyFile()
    least_score: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    score_scale: Literal[100, 1000] | None = None

    @property
    def scale(self) -> FullScaleFile:
        """The values of `full_scale`, once the file is read."""
        assert isinstance(self.full_scale, FullScaleFile)
        return self.full_scale


class LaserOptions(DriverOptions):
    """The laser of the same base, over its connection."""


def omron_base(options: OmronOptions, context: DriverContext) -> OmronBase:
    """The driver of the base."""
    limits, arcl = context.robot.limits, options.arcl
    settings = OmronSettings(
        host=options.address,
        port=options.port,
        user=options.user,
        password=options.password,
        arcl=None if arcl is None else ArclSettings(password=arcl.password, port=arcl.port),
        site=options.scale.site,
        acceleration=float(limits.base_acceleration[0]),
        turn_acceleration=float(limits.base_acceleration[2]),
        pose_delay=options.pose_delay,
        laser_delay=options.laser_delay,
        sigma=options.localisation.sigma,
        sigma_turn=radians(options.localisation.sigma_deg),
        least_score=options.least_score,
        score_scale=options.score_scale,
    )
    return OmronBase(settings, context.clock)


def omron_laser(options: LaserOptions, context: DriverContext) -> OmronLaser:
    """The driver of the laser."""
    drive, mount = context.parts["base"], context.robot.laser
    if not isinstance(drive, OmronBase) or mount is None:
        raise HardwareError("the laser of an Omron base needs that base, and a mount in its robot")
    return OmronLaser(lambda: drive.echoes, mount, context.clock)
