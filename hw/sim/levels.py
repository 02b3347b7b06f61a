"""Levels: how wrong a simulated robot is about where it is, by name or from a YAML file."""

from collections.abc import Mapping
from os.path import isfile
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from config import suggest
from config.reader import ConfigError, StrictModel, read_config

Length: TypeAlias = Annotated[float, Field(ge=0.0, le=10.0)]
Degrees: TypeAlias = Annotated[float, Field(ge=0.0, le=90.0)]
Share: TypeAlias = Annotated[float, Field(ge=0.0, le=0.5)]
Shift: TypeAlias = Annotated[float, Field(ge=-1.0, le=1.0)]
Turn: TypeAlias = Annotated[float, Field(ge=-90.0, le=90.0)]
Seconds: TypeAlias = Annotated[float, Field(ge=0.1, le=1e5)]


class PoseError(StrictModel):
    """Deviations of the localised pose."""

    sigma: Length = 0.0  # along x and along y of the map [m]
    sigma_deg: Degrees = 0.0
    time_constant: Seconds = 5.0  # in which errors are forgotten, those of odometry too [s]
    process: Literal["gauss_markov", "bounded_walk"] = "gauss_markov"  # see `localisation_errors`


class Steps(StrictModel):
    """Relocalisations: the pose jumps, and the jump is forgotten with the time constant."""

    size: Length  # [m]
    interval: Seconds  # on average [s]


class Outages(StrictModel):
    """Times without a localised pose."""

    interval: Seconds  # on average, between their beginnings [s]
    duration: Seconds  # [s]


class Odometry(StrictModel):
    """Deviations of what odometry tells of a motion."""

    slip: Share = 0.0  # of a distance, as a share of it
    turn_slip: Share = 0.0  # of an angle, as a share of it
    drift_deg: Degrees = 0.0  # turning while driving straight on [deg/m]


class Misplacement(StrictModel):
    """Error of a mount, in an unknown direction."""

    offset: Length = 0.0  # [m]
    angle_deg: Degrees = 0.0


class Localisation(StrictModel):
    """How wrong a robot is about where it is: a level."""

    localisation: PoseError = PoseError()
    steps: Steps | None = None
    outages: Outages | None = None
    odometry: Odometry = Odometry()
    hand_eye: Misplacement = Misplacement()  # of the camera on the hand
    arm_mount: Misplacement = Misplacement()  # of the arm on the base
    depth_scale: Share = 0.0  # error of all depths, as a share of them
    moved: Mapping[str, tuple[Shift, Shift, Turn]] = {}  # off the map by x, y [m], a turn [deg]

    @property
    def exact(self) -> bool:
        """Whether nothing is wrong."""
        return self == Localisation()


LEVELS: Mapping[str, Localisation] = MappingProxyType(
    {
        "exact": Localisation(),
        "good": Localisation(
            localisation=PoseError(sigma=0.02, sigma_deg=0.5),
            steps=Steps(size=0.03, interval=60.0),
            odometry=Odometry(slip=0.03, turn_slip=0.03),
            hand_eye=Misplacement(offset=0.003, angle_deg=0.5),
            depth_scale=0.005,
        ),
        "poor": Localisation(
            localisation=PoseError(sigma=0.04, sigma_deg=1.5),
            steps=Steps(size=0.08, interval=60.0),
            odometry=Odometry(slip=0.05, turn_slip=0.05),
            hand_eye=Misplacement(offset=0.005, angle_deg=1.0),
            depth_scale=0.01,
        ),
    }
)
"""The shipped levels, by name."""


def load_localisation(level: str) -> Localisation:
    """A level by its name, or from a YAML file; ConfigError: there is none, or it has a mistake."""
    if level in LEVELS:
        return LEVELS[level]
    if isfile(level):
        return read_config(Path(level), Localisation)
    hint = suggest(level, LEVELS)
    raise ConfigError(f"no level of localisation is called `{level}`; {hint} (or give a file)")
