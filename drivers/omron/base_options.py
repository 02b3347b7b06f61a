"""Options of an Omron LD-60 below `hardware.base` in a robot file."""

from os.path import isfile
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo

from config.reader import StrictModel, read_config
from drivers.omron.site import Site, Velocity
from robots import DriverOptions, NotNegative, Port, Positive, SpeedRange, Text


class ArclOptions(StrictModel):
    """The text interface of the base, where MobilePlanner has a password for it."""

    password: str
    port: Port = 7171
    poll: Positive = 0.25  # polling interval of motors, faults and localisation score [s]
    patience: Positive = 1.5  # without any answer for this long the connection is lost [s]


def _site(value: Site | str, info: ValidationInfo) -> Site:
    """The values, or those of a file; the context is the folder of the robot file."""
    if not isinstance(value, str):
        return value
    path = Path(info.context or ".") / value
    if not isfile(path):
        raise ValueError(f"there is no file {path}; `frankie-task doctor --write-site` writes one")
    return read_config(path, Site)


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
    arcl: ArclOptions | None = None  # None: motors, stop and faults are not reported
    full_scale: Annotated[Site | str, AfterValidator(_site)] = Site()
    """Of the base, or the file by `doctor --write-site`."""
    pose_delay: NotNegative = 0.0  # age of a pose on arrival [s]
    laser_delay: NotNegative = 0.0  # age of a scan of the laser on arrival [s]
    localisation: SiteAccuracyFile = SiteAccuracyFile()
    silence: Positive = 1.0  # without a byte for this long the connection is lost [s]
    connect_patience: Positive = 3.0  # timeout of each step of connecting [s]
    lists_patience: Positive = 5.0  # timeout of the list of requests [s]
    least_score: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    """A lower one is a fault; None: only a lost one."""
    score_scale: Literal[100, 1000] | None = None
    """A full score in `getLocState` (sources disagree); None: unknown, the score is not used until
    one above 100 settles it."""

    @property
    def speeds(self) -> SpeedRange:
        """Full scale, and what is left of it outside the dead zones."""
        site = self.site
        ahead, back = (site.least(Velocity(way, 1.0)) for way in (1.0, -1.0))
        return SpeedRange(
            forward=site.forward,
            reverse=site.reverse,
            least_forward=ahead.v,
            least_reverse=back.v,
            least_turn=ahead.w,
        )

    @property
    def site(self) -> Site:
        """The values of `full_scale`, once the file is read."""
        assert isinstance(self.full_scale, Site)
        return self.full_scale
